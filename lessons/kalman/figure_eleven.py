"""Draw figure 11 of the report: a filter of eight states follows the plant of ten."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, Figure, LineFigure, TableFigure, over_frequency
from observer_lab.course.lesson import Design
from observer_lab.engine import Belief, KalmanFilter, Plant, Scenario, balanced_truncation, psd, simulate
from observer_lab.plants.platform import model
from observer_lab.plants.platform.lqg_weights import GROUND_UNIT, coils, ground
from observer_lab.text import Text, format_number, same, text

ELEVEN_TAB = text("Figure 11")
ORDER, DT, SAMPLES = 8, 1e-3, 20_001  # states of the filter; s and samples: 20 s
SENSOR_SIGMA, SINE_HZ = 1e-6, 0.16  # m/s a sample; Hz of the known force
SEGMENT = 18_750  # samples of a spectrum: three periods of the force
BINS, MAX_HZ = 90, 100.0  # points of a drawn curve above the single lines of the spectrum, up to this frequency
PEAK = 2.0  # times the error without the force, above which 0.16 Hz has a peak
OUTPUTS, ROLES = ("VL", "HL", "VR", "HR"), ("estimate", "second", "disturbance", "plant")


@dataclass(frozen=True, eq=False)
class Eleven:
    """One-sided densities over f (n_f,) in (m/s)²/Hz, each (n_f, 4): outputs without noise, errors of the filter that is given the
    force, of the one that is not, and errors of a run without force."""

    f: np.ndarray
    outputs: np.ndarray
    errors: np.ndarray
    unaware: np.ndarray
    quiet: np.ndarray

    @property
    def at(self) -> int:
        """The place of 0.16 Hz."""
        return int(np.argmin(np.abs(self.f - SINE_HZ)))

    @property
    def below(self) -> np.ndarray:
        """Decibels by which each error lies below its output at 0.16 Hz, (4,)."""
        return np.asarray(10 * np.log10(self.outputs[self.at] / self.errors[self.at]))


@lru_cache(maxsize=4)
def eleven(q: float, r: float, force: float, seed: int) -> Eleven:
    """Records of 20 s at 1 kHz; the filter assumes q and r times the true noises."""
    with_force, unaware = _record(q, r, force, seed)
    quiet = _record(q, r, 0.0, seed)[0]
    found = psd(np.hstack([*with_force, unaware, quiet[1]]), 1 / DT, segment=SEGMENT)
    return Eleven(found.frequency[1:], *np.split(found.density[1:], 4, axis=1))


def _record(q: float, r: float, force: float, seed: int) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
    """Outputs and their error where the filter is given the force, and the error where it is not; each (n_t, 4)."""
    full = model.plant()
    real, kf = (_filter(plant, *share) for plant, share in ((full, (1.0, 1.0)), (_reduced(), (q, r))))
    u = force * np.outer(np.sin(2 * np.pi * SINE_HZ * DT * np.arange(SAMPLES)), (1.0, 1.0, 0.5))
    run = simulate(Scenario(Plant(real.A, real.B, real.C, dt=DT), x0=np.zeros(full.n), xhat0=np.zeros(full.n), reference=u,
                            horizon=DT * (SAMPLES - 1), dt=DT, W=real.Q, G=np.eye(full.n), seed=seed))
    clean = run.x @ real.C.T
    readings = clean + SENSOR_SIGMA * np.random.default_rng([seed, 11]).standard_normal(clean.shape)
    start = Belief(np.zeros(ORDER), kf.steady.solution)
    aware, unaware = (clean - kf.run(start, readings, given).means @ kf.C.T for given in (u, np.zeros_like(u)))
    return (clean, aware), unaware


@lru_cache(maxsize=1)
def _reduced() -> Plant:
    return balanced_truncation(model.plant(), ORDER).plant


def _filter(plant: Plant, q: float, r: float) -> KalmanFilter:
    return KalmanFilter.from_plant(coils(plant), q * GROUND_UNIT * np.eye(2), r * SENSOR_SIGMA**2 * DT * np.eye(4), dt=DT, G=ground(plant))


def eleven_figures(design: Design) -> tuple[Figure, ...]:
    """Errors above, outputs below, and 0.16 Hz in numbers."""
    found = eleven(design["q"], design["r"], design["force"], int(design["seed"]))
    f, density = _thinned(found.f, 1e12 * np.hstack([found.errors, found.outputs]))
    window = float(density[:, :4].min()), float(density.max())

    def spectra(id: str, title: Text, first: int, said: Text) -> LineFigure:
        curves = tuple(Curve(same(name), density[:, first + i], role, "dash" if i > 1 else "solid")
                       for i, (name, role) in enumerate(zip(OUTPUTS, ROLES, strict=True)))
        return over_frequency(id, title, f, curves, "[(µm/s)²/Hz]", said, ELEVEN_TAB, window)

    over = float(np.max(found.errors[found.at] / found.quiet[found.at]))
    return (spectra("eleven-errors", text("outputs 1–4: errors of the outputs"), 0, claim(
                text("The errors have no peak at 0.16 Hz."), over, below=PEAK, otherwise=text("The errors have a peak at 0.16 Hz."))),
            spectra("eleven-outputs", text("outputs 5–8: true outputs"), 4,
                    text("The known force acts at 0.16 Hz.") if design["force"] > 0 else text("No known force acts.")),
            _at_the_sine(found, design["force"]))


def _at_the_sine(found: Eleven, force: float) -> TableFigure:
    given, not_given = (each[found.at] / found.quiet[found.at] for each in (found.errors, found.unaware))
    rows = tuple((same(name), f"{format_number(below, '.3g')} dB", format_number(a, ".3g"), format_number(b, ".3g"))
                 for name, below, a, b in zip(OUTPUTS, found.below, given, not_given, strict=True))
    told = text("The filter is given the force, so the error has no peak, whatever Q and R are. A filter that is not given it has one.")
    quiet = (text("No known force acts.") if force == 0 else
             text("Here the filter follows its sensors so closely that a force that is not given leaves no peak."))
    return TableFigure("eleven", text("errors at 0.16 Hz"),
                       (text("output"), text("error below output"), text("with force / without"), text("the same, force not given")), rows,
                       claim(told, float(np.min(not_given)), above=PEAK, otherwise=quiet)
                       if given.max() < PEAK else text("The errors have a peak at 0.16 Hz."), ELEVEN_TAB)


def _thinned(f: np.ndarray, density: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means over bins of equal ratio; at low frequencies each line of the spectrum has its own."""
    edges = np.geomspace(f[0], MAX_HZ, BINS)
    place = np.digitize(f[f <= MAX_HZ], edges)
    groups = [np.flatnonzero(place == k) for k in np.unique(place)]
    return np.array([f[g].mean() for g in groups]), np.array([density[g].mean(axis=0) for g in groups])
