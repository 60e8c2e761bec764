"""Check source 003, chapter 5: LQG on the platform, tuning rules, levels."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..engine import Belief, KalmanFilter, Plant, balanced_truncation, closed_loop, compensator, dlqr, lqe, lqr, noisy_loop, sampled_lqg
from ..engine.feedback import NoisyLoop
from ..plants.platform import model
from ..plants.platform.channels import T_y
from ..plants.platform.lqg_weights import FIGURE_V, FIGURE_WEIGHTS, LITERAL, LITERAL_V, LOOSE_V, S_Y, Weights, coils, ground, lqg
from .record import Published

SOURCE = "003 platform report"
OURS = "on the reconstructed plant; vertical, rotation, horizontal"
FREQUENCY = np.unique(np.concatenate([np.geomspace(0.01, 100, 400), np.linspace(0.9, 1.6, 1500)]))
DT = 1e-3
SUPPRESSION_TABLE = ((1e-18, "110, 96, 113"), (1e-12, "61, 61, 57"), (1e-10, "41, 26, 37"), (1e-9, "31, 11, 27"),
         (1e-8, "21, 3, 17"), (1e-6, "3.6, 0.0, 1.8"))


@lru_cache(maxsize=1)
def whole() -> Plant:
    """Ten states, coils and ground."""
    return model.plant()


@lru_cache(maxsize=16)
def loop(V: float | None, sensor: float = LITERAL_V) -> NoisyLoop:
    """The loop designed for V (None: no control) under the report's ground and sensor noise of intensity `sensor`."""
    p = whole()
    return noisy_loop(coils(p), None if V is None else lqg(p, Weights(v0=V)).controller, ground(p), FIGURE_WEIGHTS.W, V=sensor)


def suppression(closed: NoisyLoop) -> np.ndarray:
    """Decibels by which the highest peak of each channel comes down."""
    free = loop(None)
    return 10 * np.log10(free.psd(FREQUENCY, free.outputs(T_y[:3])).max(axis=0)
                         / closed.psd(FREQUENCY, closed.outputs(T_y[:3])).max(axis=0))


def at(frequency: float, V: float) -> np.ndarray:
    """Decibels gained at one frequency."""
    free, closed = loop(None), loop(V)
    return 10 * np.log10(free.psd(frequency, free.outputs(T_y[:3]))[0] /
                         closed.psd(frequency, closed.outputs(T_y[:3]))[0])


def noise_in_input(V: float) -> float:
    """Rms of what the sensors' noise makes the coils do."""
    z = loop(V).only(disturbances=0.0)
    return float(np.sqrt(z.variance(z.inputs()).sum()))


def filter_speed(beta_q: float) -> float:
    """−Σ Re of the filter's poles."""
    p = whole()
    return -float(lqe(p.A, ground(p), p.C, beta_q * FIGURE_WEIGHTS.W, FIGURE_WEIGHTS.V).poles.real.sum())


def union() -> float:
    """Distance of the loop's poles from eig(A − BK) and eig(A − LC) together, relative to the largest."""
    p, d = whole(), lqg(whole())
    return closed_loop(coils(p), d.K, d.L).union_error


def regulator_poles() -> tuple[float, float]:
    """The fastest and the slowest pole of A − BK."""
    poles = lqg(whole(), LITERAL).regulator.poles
    return float(poles.real.min()), float(poles.real.max())


def late_computer() -> np.ndarray:
    """Suppression of the literal design at 1 kHz, weights taken per step, the answer one sample late."""
    p = whole()
    s = sampled_lqg(coils(p), LITERAL.Q(p), LITERAL.R, LITERAL.W, LITERAL.V, DT, G=ground(p))
    K = dlqr(s.plant.A, s.plant.B, LITERAL.Q(p), LITERAL.R).gain
    return suppression(noisy_loop(s.plant, compensator(s.plant, K, s.filter.steady.predictor_gain), np.eye(10),
                                  s.filter.Q, V=s.filter.R))


def recursive_against_steady() -> float:
    """Largest relative distance of the channels' densities between the loop with the recursive filter's gain after
    120 s at 200 Hz and the loop with the Riccati gain."""
    p = whole()
    w = Weights(v0=1e-10)
    s = sampled_lqg(coils(p), w.Q(p), w.R, w.W, w.V, 5 * DT, G=ground(p))
    belief, kf = Belief(np.zeros(10), loop(None).covariance), s.filter
    M = _gain_after(kf, belief, 24)
    f = np.geomspace(0.05, 50, 60)
    densities = []
    for built in (s.controller, s.controller_with(M)):
        z = noisy_loop(s.plant, built, np.eye(10), kf.Q, V=kf.R)
        densities.append(z.psd(f, z.outputs(T_y[:3])))
    return float(np.abs(densities[1] / densities[0] - 1).max())


def _gain_after(kf: KalmanFilter, belief: Belief, thousands: int) -> np.ndarray:
    plan = kf.schedule(belief, 1000)
    for _ in range(thousands - 1):
        belief = kf.predict(Belief(belief.mean, plan.posterior[-1]))
        plan = kf.schedule(belief, 1000)
    return plan.gains[-1]


def eight_states() -> float:
    """Largest difference in dB between the loop designed on ten states and the one designed on eight."""
    p = whole()
    d = lqg(balanced_truncation(p, 8).plant)
    return float(np.abs(suppression(noisy_loop(coils(p), d.controller, ground(p), FIGURE_WEIGHTS.W, V=LITERAL_V))
                        - suppression(loop(FIGURE_V))).max())


def velocity_outputs() -> float:
    """How many times the outputs are positions differentiated: 1 if C looks at velocities alone and D is zero."""
    p = whole()
    return 1.0 if not np.any(p.C[:, :5]) and not np.any(p.D) else 0.0


def riccati_of_the_appendix() -> float:
    """‖Q − S B R⁻¹ Bᵀ S + S A + AᵀS‖ over ‖Q‖ for the report's weights scaled to one."""
    p = whole()
    c = coils(p)
    Q = FIGURE_WEIGHTS.Q(p) / FIGURE_WEIGHTS.alpha_q / 1e10
    S = lqr(c.A, c.B, Q, np.eye(3)).solution
    return float(np.linalg.norm(Q - S @ c.B @ c.B.T @ S + S @ c.A + c.A.T @ S) / np.linalg.norm(Q))


def input_rolls_off() -> float:
    """Density of u1 at 100 Hz over its largest, in dB, at V = 1e-9."""
    z = loop(FIGURE_V)
    S = z.psd(np.append(FREQUENCY, 100.0), z.inputs())[:, 0]
    return float(10 * np.log10(S[-1] / S.max()))


def horizontal_peak() -> float:
    """Hz of the highest peak of the horizontal channel without control."""
    free = loop(None)
    return float(FREQUENCY[free.psd(FREQUENCY, free.outputs(T_y[2:3]))[:, 0].argmax()])


RECORDS = (
    Published(SOURCE, "(75), (76): W = σ_w²", "1e-12, 1e-12", lambda: np.diag(FIGURE_WEIGHTS.W), relative=1e-9),
    Published(SOURCE, "(77): log₁₀ of R_v = σ_v² for σ_v = 1e-9", "-9, -6", lambda: 2 * np.log10(1e-9), "slip", "-18",
              tolerance=1e-9,
              note="the figures are labelled V = 1e-9 and V = 1e-6: an intensity was called a standard deviation"),
    Published(SOURCE, "(80)–(85): diagonal of W_y", "1e8, 1e10, 1e8, 1e10",
              lambda: np.square(S_Y), relative=1e-9),
    Published(SOURCE, "(88), (89): poles of the loop against both sets", "their union",
              union, right="0", tolerance=1e-9),
    Published(SOURCE, "appendix A, algebraic Riccati equation: residual", "", riccati_of_the_appendix, "beyond", "0",
              tolerance=1e-8, note="A.2 is headed (LQG); it is the LQR"),
    *(Published(SOURCE, f"LQG, V = {V:g}: peaks lowered by dB", "", lambda V=V: suppression(loop(V)), "beyond", text,
                tolerance=0.55, note=OURS) for V, text in SUPPRESSION_TABLE),
    Published(SOURCE, "least V of 1e-9, 1e-10 with ≥ 20 dB in every channel: least dB", "20–40 dB",
              lambda: [suppression(loop(V)).min() for V in (1e-9, 1e-10)], "beyond", "11.0, 25.5",
              note="its 20 to 40 dB mean V between 1e-9 and 1e-10, not 1e-18"),
    Published(SOURCE, "figures 13–15: dB more at V = 1e-9 than at 1e-6", "better at V = 1e-9",
              lambda: suppression(loop(FIGURE_V)) - suppression(loop(LOOSE_V)), "beyond", "27.5, 11.0, 25.3", note=OURS,
              tolerance=0.1),
    Published(SOURCE, "figure 14: vertical peak lowered by dB", "20–30 dB", lambda: suppression(loop(FIGURE_V))[0],
              "beyond", "31.2"),
    Published(SOURCE, "V = 1e-9: dB gained at 0.1 Hz", "10–30 dB over 0.1–10 Hz", lambda: at(0.1, FIGURE_V), "beyond",
              "0.0, -31.1, 0.0", tolerance=0.1, note="off resonance nothing is gained, and pitch is amplified"),
    Published(SOURCE, "figure 13: horizontal peak without control, Hz", "1e-1", horizontal_peak, "beyond", "0.995",
              tolerance=0.002, note="the report says so of figure 13, and 1 Hz of figures 14 and 20"),
    Published(SOURCE, "rule 2, β_R ×10: sensor noise in the input ×", "noise suppressed less",
              lambda: noise_in_input(1e-8) / noise_in_input(1e-9), "slip", "0.287",
              note="reversed: a larger V trusts the model more and suppresses noise more, as section 5.2 itself says "
                   "before"),
    Published(SOURCE, "rule 2, β_Q ×10: sum of the filter's poles ×", "faster",
              lambda: filter_speed(10.0) / filter_speed(1.0), "beyond", "1.495"),
    Published(SOURCE, "chapter 5: y is position differentiated … times", "(m/s²)²/Hz", velocity_outputs, "slip", "1",
              note="the outputs are velocities: (m/s)²/Hz, as chapter 2 has it"),
    Published(SOURCE, "figure 16: input at 100 Hz against its largest, dB", "falls quickly", input_rolls_off, "beyond",
              "-44.05"),
    Published(SOURCE, "section 5.3.2: recursive against steady, relative", "nearly the same", recursive_against_steady,
              right="0", tolerance=1e-5),
    Published(SOURCE, "LQG on eight states against ten, dB", "", eight_states, "beyond", "0", tolerance=0.1),
    Published(SOURCE, "V = 1e-18: fastest and slowest pole of A − BK", "", regulator_poles, "beyond",
              "-3.77e5, -1.064e-4", relative=2e-3, note="velocity sensors alone leave a drift"),
    Published(SOURCE, "V = 1e-18 at 1 kHz, one sample late: dB", "", late_computer, "beyond", "73, 87, 76",
              tolerance=0.6, note=OURS),
)
