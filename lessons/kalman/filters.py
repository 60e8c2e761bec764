"""Simulate the true deck, build the filter from its assumptions, and update P in two ways."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from observer_lab.course.lazy import LazyValue
from observer_lab.engine import Belief, KalmanFilter, Plant, Scenario, simulate
from observer_lab.engine.design import DiscreteFilter
from observer_lab.engine.filters import AdcNoise, Schedule, Track, independent_errors, posterior_covariances, with_coloured_noise
from observer_lab.engine.systems import root
from observer_lab.plants.platform.model import deck_disturbance

from .knobs import CARRIED, COLOURED, DT, HORIZON, MODEL, SAMPLE_COUNT

UNTESTED_SAMPLES = 50  # samples at the start that no test looks at
GROUND_INTENSITY = 4e-10  # m² s, intensity of each ground motion
COUPLE = 3e-4  # N² s, intensity of an unknown draught that presses one side down and the other up
SENSOR_SIGMA = 1e-3  # m/s, white part of a reading
START_SIGMAS = np.array([1.5e-3, 2e-3, 9e-3, 1e-2, 1.4e-2, 7e-2])  # standard deviations of the start
SCALE = 1 / np.outer(START_SIGMAS, START_SIGMAS)
COVARIANCE_LIMIT = 1e6  # a covariance that has lost all sense is cut to this
SINE_HZ = 0.16  # Hz, of the report's figure 11
ADC = AdcNoise(SENSOR_SIGMA, 6.0, 0.9, DT)
COMPARED_STEPS = 25  # for the comparison of the two updates


@lru_cache(maxsize=1)
def tuned() -> KalmanFilter:
    """The filter that knows the deck, the disturbances and a white sensor noise of σ² as they are."""
    B, V = MODEL.plant.B, SENSOR_SIGMA**2 * DT * np.eye(4)
    G = np.column_stack([deck_disturbance(), B[:, 1] - B[:, 0]])
    return KalmanFilter.from_plant(MODEL.plant, np.diag([GROUND_INTENSITY, GROUND_INTENSITY, COUPLE]), V, dt=DT, G=G)


@dataclass(frozen=True, eq=False)
class Truth:
    """What happens, whoever watches, at t (n_t,): states (n_t, n), readings (n_t, p), inputs (n_t, m)."""

    t: np.ndarray
    x: np.ndarray
    y: np.ndarray
    u: np.ndarray


def draw(seed: int, coloured: bool, force: float, kick: float) -> Truth:
    """One run of the deck from a drawn start, the forces known, the ground and the sensors noisy."""
    kf = tuned()
    t = DT * np.arange(SAMPLE_COUNT)
    u = np.outer(force * np.sin(2 * np.pi * SINE_HZ * t), [1.0, 1.0, 0.5])
    rng = np.random.default_rng([seed, 7])
    x0 = START_SIGMAS * rng.standard_normal(6)
    kicks = ((DT * round(kick / DT), MODEL.kick),) if kick >= 0 else ()
    sampled = Plant(kf.A, kf.B, kf.C, dt=DT)
    run = simulate(Scenario(sampled, x0=x0, xhat0=np.zeros(6), horizon=HORIZON, dt=DT, reference=u, W=kf.Q, G=np.eye(6),
                            impulses=kicks, seed=seed))
    noise = ADC.draw(SAMPLE_COUNT, 4, rng) if coloured else SENSOR_SIGMA * rng.standard_normal((SAMPLE_COUNT, 4))
    return Truth(t, run.x, run.x @ kf.C.T + noise, u)


def drawn_jumps(seed: int) -> np.ndarray:
    """Jumps w of the state in such a run, (n_t, 6)."""
    for_w, _ = np.random.default_rng(seed).spawn(2)
    return for_w.standard_normal((SAMPLE_COUNT, 6)) @ root(tuned().Q).T


truth = lru_cache(maxsize=8)(draw)


@dataclass(frozen=True, eq=False)
class Watcher:
    """A filter with what it expects before any measurement: Riccati solution, schedule and start, and from which sample on it is tested.

    `independent`: how many independent samples the NEES from there on are worth, None where the record is to tell. `floor`: the share
    of each variance that is added before NEES, for a state known exactly has none.
    """

    filter: KalmanFilter
    steady: DiscreteFilter
    schedule: Schedule
    start: Belief
    first: int
    independent: LazyValue[float | None]
    floor: float = 0.0


@lru_cache(maxsize=8)
def watcher(noise: str, q: float, r: float, p0: float) -> Watcher:
    """The filter that believes q times the true Q, r times the true R and p0 times the true spread of the start."""
    kf = tuned()
    if noise == CARRIED:
        base = with_coloured_noise(kf, ADC)
        Q = base.Q.copy()
        Q[:6, :6] *= q
        kf = KalmanFilter(base.A, base.B, base.C, Q, r * base.R, dt=DT)
        steady = kf.steady
        P = steady.solution.copy()
        P[:6, :6], P[:6, 6:], P[6:, :6] = np.diag(p0 * START_SIGMAS**2), 0.0, 0.0
        P[6:, 6:] = np.kron(np.eye(4), ADC.relaxations[1] * np.eye(len(ADC.relaxations[0])))
        start = Belief(np.zeros(kf.n), P)
    else:
        kf, start = _believing(q, r * (ADC.variance / SENSOR_SIGMA**2 if noise == COLOURED else 1.0), p0)
        steady = kf.steady
    return Watcher(kf, steady, kf.schedule(start, SAMPLE_COUNT), start, UNTESTED_SAMPLES, LazyValue(lambda: independent_samples(kf)))


def independent_samples(kf: KalmanFilter) -> float:
    """How many independent samples the tested part of a record is worth to NEES, by the filter's own beliefs.

    Errors hang together from sample to sample by (I − M C) A, which the filter knows of itself.
    """
    steady = kf.steady
    Phi = (np.eye(kf.n) - steady.filter_gain @ kf.C) @ kf.A
    return independent_errors(Phi, steady.filtered, SAMPLE_COUNT - UNTESTED_SAMPLES, T=np.eye(6, kf.n))


def _believing(q: float, r: float, p0: float) -> tuple[KalmanFilter, Belief]:
    """The filter with six states and its belief before the first reading."""
    kf = tuned()
    return KalmanFilter(kf.A, kf.B, kf.C, q * kf.Q, r * kf.R, dt=DT), Belief(np.zeros(6), np.diag(p0 * START_SIGMAS**2))


def watch(who: Watcher, what: Truth) -> Track:
    """The record through the filter."""
    return who.filter.run(who.start, what.y, what.u, schedule=who.schedule)


@dataclass(frozen=True, eq=False)
class Forms:
    """Distances ‖P − P_ref‖/‖P_ref‖ (COMPARED_STEPS,) of Joseph's form and the short form, and their smallest eigenvalues.

    Eigenvalues are those of P with its variances brought to one, the least over the record.
    """

    joseph: np.ndarray
    short: np.ndarray
    least_joseph: float
    least_short: float


@lru_cache(maxsize=16)
def compare(q: float, r: float, p0: float, single: bool) -> Forms:
    """Both updates beside Joseph's in double precision: in single precision, or in double with the final gain all along."""
    kf, start = _believing(q, r, p0)
    final = None if single else kf.steady.filter_gain

    def along(form: str, single: bool) -> np.ndarray:
        record = posterior_covariances(kf.A, kf.C, kf.Q, kf.R, start.covariance, steps=COMPARED_STEPS, form=form, gain=final, single=single)
        return np.clip(record, -COVARIANCE_LIMIT, COVARIANCE_LIMIT)

    true = along("joseph", False)
    records = np.stack([along("joseph", True) if single else true, along("short", single)])
    gaps = np.abs((records - true) * SCALE).max(axis=(2, 3)) / np.abs(true * SCALE).max(axis=(1, 2))
    spread = np.sqrt(np.maximum(np.abs(np.diagonal(records, axis1=2, axis2=3)), 1e-30))
    even = (records + np.swapaxes(records, 2, 3)) / (2 * spread[..., None] * spread[..., None, :])
    least = np.clip(np.linalg.eigvalsh(even)[..., 0].min(axis=1), -1.0, 1.0)
    gaps = np.minimum(gaps, COVARIANCE_LIMIT)
    return Forms(gaps[0], gaps[1], float(least[0]), float(least[1]))
