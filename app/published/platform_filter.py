"""Check source 003, chapter 4: recursive filter, innovations, NIS, figure 11.

As in the report the plant has ten states and the filter the eight of the balanced truncation. The report gives neither
a sampling period nor the noise of its figures: 1 kHz for 20 s and σ_v = 1 µm/s a sample are ours, the ground is its
(76).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..engine import Belief, KalmanFilter, Plant, Scenario, balanced_truncation, chi2_band, dlqe, innovation_test, lqe, nis, psd, simulate
from ..engine.filters import AdcNoise, InnovationTest, with_coloured_noise
from ..plants.platform import model
from ..plants.platform.lqg_weights import GROUND_UNIT, coils, ground
from .record import Published

SOURCE = "003 platform report"
OURS = "1 kHz, 20 s and σ_v = 1 µm/s are assumed"
DT, RUN_STEPS, RECORD_SEED = 1e-3, 20_001, 4
SENSOR_SIGMA = 1e-6  # m/s a sample
SINE_HZ, FORCE = 0.16, 0.01  # Hz, N: the known force of figure 11 on all three coils
ADC = AdcNoise(SENSOR_SIGMA, 5.0, 0.05, DT)
PRINTED_GAINS = (6.45e-12, -5.44e-10, -6.19e-12, -5.46e-10)  # equation (61): VL, HL, VR, HR
SIGMA_V, RUN_SAMPLES = 1e-9, 20_000  # equation (77); 20 s at 1 kHz


@lru_cache(maxsize=1)
def models() -> tuple[Plant, Plant, np.ndarray]:
    """Ten states, eight states, and T that takes the eight to the ten."""
    full = model.plant()
    small = balanced_truncation(full, 8)
    return full, small.plant, small.T


@lru_cache(maxsize=8)
def tuned(variance: float = SENSOR_SIGMA**2) -> KalmanFilter:
    """The filter with eight states for the ground of (76) and white sensor noise of that variance a sample."""
    small = models()[1]
    return KalmanFilter.from_plant(coils(small), GROUND_UNIT * np.eye(2), variance * DT * np.eye(4), dt=DT, G=ground(small))


@dataclass(frozen=True, eq=False)
class Record:
    """Outputs of the ten states without noise, the filter's, and the innovations with their covariance S."""

    clean: np.ndarray
    filtered: np.ndarray
    innovations: np.ndarray
    S: np.ndarray

    @property
    def test(self) -> InnovationTest:
        """Bias, whiteness and size of the innovations."""
        return innovation_test(self.innovations, self.S)


@lru_cache(maxsize=8)
def record(noise: str = "white", force: float = 0.0, seed: int = RECORD_SEED) -> Record:
    """Ten states moved by the ground and a known sine, watched by the filter with eight.

    noise: "white" sensors, the converter "taken for white" by the filter, or "carried" by it as states.
    """
    full, _, T = models()
    real = KalmanFilter.from_plant(coils(full), GROUND_UNIT * np.eye(2), SENSOR_SIGMA**2 * DT * np.eye(4), dt=DT, G=ground(full))
    kf = tuned() if noise == "white" else tuned(ADC.variance) if noise == "taken" else with_coloured_noise(tuned(), ADC)
    rng = np.random.default_rng([seed, 1])
    P = kf.steady.solution
    # the filter's own first error
    start = np.linalg.cholesky(P + 1e-12 * np.diag(np.diag(P))) @ rng.standard_normal(kf.n)
    u = np.outer(force * np.sin(2 * np.pi * SINE_HZ * DT * np.arange(RUN_STEPS)), np.ones(3))
    run = simulate(Scenario(Plant(real.A, real.B, real.C, dt=DT), x0=T @ start[:8], xhat0=np.zeros(10), reference=u,
                            horizon=DT * (RUN_STEPS - 1), dt=DT, W=real.Q, G=np.eye(10), seed=seed))
    clean = run.x @ real.C.T
    v = SENSOR_SIGMA * rng.standard_normal((RUN_STEPS, 4)) if noise == "white" else ADC.draw(RUN_STEPS, 4, rng)
    track = kf.run(Belief(np.zeros(kf.n), P), clean + v, u)
    return Record(clean, track.means[:, :8] @ kf.C[:, :8].T, track.innovations, track.schedule.S[-1])


def nis_mean(noise: str = "white") -> float:
    """Mean of NIS over the record."""
    r = record(noise)
    return nis(r.innovations, r.S).mean


def share_in_band() -> float:
    """Share of single NIS values inside the one-step band."""
    r = record()
    return nis(r.innovations, r.S).inside


def scores() -> float:
    """Largest mean of an innovation, in standard deviations of that mean."""
    return float(np.abs(record().test.scores).max())


def memory() -> float:
    """Largest correlation of innovations one sample apart."""
    return float(np.abs(record().test.whiteness.correlation[0]).max())


def colour(noise: str) -> float:
    """Density of the innovations below 2 Hz over that above 50 Hz, mean of the four sensors."""
    r = record(noise)
    seen = psd(r.innovations, 1 / DT, segment=4000)
    f, density = seen.frequency, seen.density.mean(axis=1)
    return float(density[(f > 0) & (f < 2)].mean() / density[f > 50].mean())


def innovation_over_R(variance: float) -> tuple[float, float]:
    """S/R for VL and HL of the settled filter, for that variance of the sensors' noise a sample."""
    kf = tuned(variance)
    S = kf.C @ kf.steady.solution @ kf.C.T + kf.R
    return float(S[0, 0] / variance), float(S[1, 1] / variance)


def printed_means() -> float:
    """The largest mean of (61) over σ_v/√N: how far from zero it is if the innovations were of size R, as is said
    there."""
    return float(np.max(np.abs(PRINTED_GAINS)) / (SIGMA_V / np.sqrt(RUN_SAMPLES)))


def both_horizontal() -> float:
    """Largest entry of HL + HR in C: what any motion can add to the sum of the two means."""
    C = models()[0].C
    return float(np.abs(C[1] + C[3]).max())


def recursion_and_riccati() -> tuple[float, float]:
    """Relative distance of the recursion's gain from the Riccati equation's after 300 s, and of M/dt from the LQE gain
    (73).

    The recursion steps every 20 ms from a P far too wide, the second filter every 0.1 ms; V = 1e-9 (m/s)² s in both.
    """
    small, W, V = models()[1], GROUND_UNIT * np.eye(2), 1e-9 * np.eye(4)
    coarse, fine = (KalmanFilter.from_plant(coils(small), W, V, dt=dt, G=ground(small)) for dt in (2e-2, 1e-4))
    goal = dlqe(coarse.A, np.eye(8), coarse.C, coarse.Q, coarse.R).filter_gain
    last = coarse.schedule(Belief(np.zeros(8), 1e3 * coarse.steady.solution), 15_000).gains[-1]
    slow = lqe(small.A, ground(small), small.C, W, V).gain
    return (float(np.abs(last - goal).max() / np.abs(goal).max()),
            float(np.abs(fine.steady.filter_gain / 1e-4 - slow).max() / np.abs(slow).max()))


def figure_eleven() -> tuple[float, float]:
    """dB by which the output error lies below the output at 0.16 Hz, and the error there with the force over
    without."""
    loud, quiet = record(force=FORCE), record()
    at = [psd(np.column_stack([r.clean[:, 0], r.clean[:, 0] - r.filtered[:, 0]]), 1 / DT,
              segment=18_750) for r in (loud, quiet)]
    near = int(np.argmin(np.abs(at[0].frequency - SINE_HZ)))
    return (float(10 * np.log10(at[0].density[near, 0] / at[0].density[near, 1])),
            float(at[0].density[near, 1] / at[1].density[near, 1]))


RECORDS = (
    Published(SOURCE, "chapter 4, NIS of one step, four sensors, 95 %", "", lambda: chi2_band(4), "beyond",
              "0.484, 11.143"),
    Published(SOURCE, "mean of 1000 NIS, 95 %", "", lambda: chi2_band(4, count=1000), "beyond", "3.827, 4.177",
              tolerance=6e-4),
    Published(SOURCE, "NIS tuned to the number of measurements", "near 4", nis_mean, right="4", tolerance=0.08,
              note=f"eight states watching ten; {OURS}"),
    Published(SOURCE, "share of single NIS in the one-step band", "", share_in_band, "beyond", "0.95", tolerance=0.006,
              note=OURS),
    Published(SOURCE, "innovation means, in σ of the mean", "zero mean", scores, right="0", tolerance=4.0, note=OURS),
    Published(SOURCE, "correlation of innovations one sample apart (70)", "white", memory, right="0", tolerance=0.03,
              note=OURS),
    Published(SOURCE, "innovation means (61) in σ_v/√N", "all close to 0", printed_means, "slip", "77", tolerance=0.5,
              note="5.46e-10 is 77 times the σ of a mean of 20 000 samples of 1e-9, if the innovations are of size R "
                   "as is said"),
    Published(SOURCE, "HL + HR of any motion", "means of HL and HR (61): both negative", both_horizontal, "slip", "0",
              note="HR = −HL, so means of one sign are no motion but offsets of the readings"),
    Published(SOURCE, "innovation covariance over R, σ_v = 1e-9 a sample (77)", "close to R",
              lambda: innovation_over_R(1e-18), "slip", "7.89e6, 1.59e6", relative=1e-3,
              note="it is S = CPCᵀ + R; VL and HL at 1 kHz"),
    Published(SOURCE, "the same for V = 1e-9 as in its figures", "close to R", lambda: innovation_over_R(1e-9 / DT),
              right="1.00, 1.00",
              note="close to R only where the sensors' noise drowns what the ground does in a step"),
    Published(SOURCE, "innovations below 2 Hz over above 50 Hz, converter taken for white",
              "shape of the converter's noise", lambda: colour("taken"), right="1.44", tolerance=0.15,
              note=f"figure 9; {OURS}"),
    Published(SOURCE, "the same with the converter's noise as states", "shape of the converter's noise",
              lambda: colour("carried"), "slip", "1.0", tolerance=0.15,
              note="the optimal filter's innovations are white whatever the noise"),
    Published(SOURCE, "recursion against (72), (73): discrete, continuous", "the same", recursion_and_riccati,
              right="0, 0", tolerance=1e-3),
    Published(SOURCE, "figure 11: error below output at 0.16 Hz in dB", "no peak", lambda: figure_eleven()[0],
              right="72", tolerance=3.0, note=f"a known force of 0.01 N; {OURS}"),
    Published(SOURCE, "figure 11: error at 0.16 Hz, with the force over without", "no peak", lambda: figure_eleven()[1],
              right="1", tolerance=0.01),
)
