"""Compute what the report's tuning rules 1, 2 and 4 lead to on the present loop, section 5.2."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ParamSpec

import numpy as np

from observer_lab.engine import EngineError
from observer_lab.engine.feedback import NoisyLoop
from observer_lab.plants.platform.channels import T_u
from observer_lab.plants.platform.model import MASS_STATES

from .cases import Case
from .loops import Setting, estimator, loop, loop_with, measured_loop, regulator, sensor_input
from .study import peak_reductions

INPUT_WEIGHTS = tuple(10.0**k for k in range(-4, 5))  # α_R of rule 1: the whole knob
SENSOR_NOISES = tuple(10.0**k for k in range(-3, 13))  # β_R of rule 2: the whole knob
STEP = 10.0  # by which rule 2 raises a factor
OWN_STATES = (("z", "pL+pR"), ("theta", "pR-pL"), ("x",))  # of the channels: vertical, rotation, horizontal

P = ParamSpec("P")


@dataclass(frozen=True, eq=False)
class Reached:
    """What a loop reaches: E xᵀQ₀x, and peak reductions in dB (k,) or None. Variances are of the channels (k,) and the inputs (m,)."""

    motion: float
    reductions: np.ndarray | None
    channels: np.ndarray
    inputs: np.ndarray


@dataclass(frozen=True)
class FilterStep:
    """How the filter changes where one factor is raised tenfold, as multiples: ‖L‖, sum of its poles, input from sensor noise."""

    gain: float
    speed: float
    noise: float


@dataclass(frozen=True, eq=False)
class Structure:
    """The loop with all of K and with the gains inside the channels alone, None where unstable; cost and couple of each.

    couple: rms in N of (u1 − u2)/2; crossing: of it what gains from the other channels' states ask for, with all of K.
    """

    full: NoisyLoop
    sparse: NoisyLoop
    cost: tuple[float, float]
    couple: tuple[float, float]
    crossing: float


# --- rule 1 ----------------------------------------------------------------------------------------------------------
@lru_cache(maxsize=64)
def reached(case: Case, setting: Setting, measured: bool) -> Reached | None:
    """What a setting reaches with the state measured, or with its filter; None for an unstable loop."""
    z = measured_loop(case, setting) if measured else loop(case, setting)
    if not z.stable:
        return None
    true = case.true_disturbance(setting.factors)
    return Reached(_motion(case, z), peak_reductions(case, true, z.psd(case.frequency))[0], z.variance(), z.variance(z.inputs()))


def motion_by_input_weight(case: Case, setting: Setting) -> tuple[np.ndarray, np.ndarray]:
    """√(E xᵀQ₀x) at each α_R of the knob, with the state measured and with the filter; ∞ for an unstable loop, nan where not found."""
    return _motions(case, replace(setting, factors=replace(setting.factors, alpha_r=1.0)))


@lru_cache(maxsize=16)
def _motions(case: Case, setting: Setting) -> tuple[np.ndarray, np.ndarray]:
    settings = [replace(setting, factors=replace(setting.factors, alpha_r=alpha)) for alpha in INPUT_WEIGHTS]
    found = [[_found(_motion_of, make, case, each) for each in settings] for make in (measured_loop, loop)]
    return np.sqrt(found[0]), np.sqrt(found[1])


def _found(compute: Callable[P, float], *args: P.args, **kwargs: P.kwargs) -> float:
    """A number of one point of a sweep, nan where its Riccati equation is too stiff to be solved."""
    try:
        return compute(*args, **kwargs)
    except EngineError:
        return np.nan


def _motion_of(make: Callable[[Case, Setting], NoisyLoop], case: Case, setting: Setting) -> float:
    return _motion(case, make(case, setting))


def _motion(case: Case, z: NoisyLoop) -> float:
    """E xᵀQ₀x, the weighted motion for α_Q = 1; ∞ for an unstable loop."""
    if not z.stable:
        return np.inf
    n = case.plant.n
    return float(np.sum(case.Q * z.covariance[:n, :n]))


# --- rule 2 ----------------------------------------------------------------------------------------------------------
def with_noise(setting: Setting, beta_q: float = 1.0, beta_r: float = 1.0) -> Setting:
    """The same setting with multiples of the noises that the filter assumes; K stays."""
    f = setting.factors
    return replace(setting, factors=replace(f, beta_q=f.beta_q * beta_q, beta_r=f.beta_r * beta_r))


@lru_cache(maxsize=32)
def filter_step(case: Case, setting: Setting, beta_q: float, beta_r: float) -> FilterStep:
    """The changes where β_Q and β_R are multiplied; nan where there is nothing to compare with."""
    after = with_noise(setting, beta_q, beta_r)
    try:
        old, new = (estimator(case, s.factors.beta_q, s.factors.beta_r, s.recovery) for s in (setting, after))
    except EngineError:
        return FilterStep(np.nan, np.nan, np.nan)
    return FilterStep(_ratio(float(np.linalg.norm(new.gain)), float(np.linalg.norm(old.gain))),
                      _ratio(-float(np.sum(new.poles.real)), -float(np.sum(old.poles.real))),
                      _ratio(sensor_input(case, after), sensor_input(case, setting)))


def _ratio(after: float, before: float) -> float:
    """after/before, nan where there is nothing to compare with."""
    return after / before if 0 < before < np.inf else np.nan


def filter_by_sensor_noise(case: Case, setting: Setting) -> tuple[np.ndarray, np.ndarray]:
    """Input from sensor noise and sum of the filter's poles at each β_R of the knob, K held; nan where not found."""
    return _filters(case, replace(setting, factors=replace(setting.factors, beta_r=1.0)))


@lru_cache(maxsize=16)
def _filters(case: Case, setting: Setting) -> tuple[np.ndarray, np.ndarray]:
    settings = [replace(setting, factors=replace(setting.factors, beta_r=beta)) for beta in SENSOR_NOISES]
    noise, speed = ([_found(make, case, each) for each in settings] for make in (sensor_input, _speed))
    return np.array(noise), np.array(speed)


def _speed(case: Case, setting: Setting) -> float:
    f = setting.factors
    return -float(np.sum(estimator(case, f.beta_q, f.beta_r, setting.recovery).poles.real))


# --- rule 4 ----------------------------------------------------------------------------------------------------------
def sparse_gain(K: np.ndarray) -> np.ndarray:
    """K (3×10) with the gains from each channel's states to its own coils alone: Σ T_u eᵢeᵢᵀ T_u⁻¹ K Πᵢ."""
    rows = np.linalg.solve(T_u, K)
    return np.asarray(T_u @ np.vstack([row @ _own_states(i) for i, row in enumerate(rows)]))


def _own_states(channel: int) -> np.ndarray:
    """Πᵢ (10×10): the part of the state that belongs to a channel of the symmetric deck."""
    at = {name: k for k, name in enumerate(MASS_STATES)}
    n = len(MASS_STATES) // 2
    basis = []
    for name in OWN_STATES[channel]:
        v = np.zeros(n)
        if name in at:
            v[at[name]] = 1.0
        else:
            v[at["pL"]], v[at["pR"]] = np.array([1.0 if "+" in name else -1.0, 1.0]) / np.sqrt(2)
        basis.append(v)
    return np.kron(np.eye(2), sum(np.outer(v, v) for v in basis))


@lru_cache(maxsize=16)
def structure(case: Case, setting: Setting) -> Structure:
    """Both gains in the same loop with the same filter; on the platform with its ten states."""
    f = setting.factors
    K = regulator(case, f.alpha_q, f.alpha_r).gain
    sparse = sparse_gain(K)
    loops = tuple(loop_with(case, setting, each) for each in (K, sparse))
    Q, R, pair = f.alpha_q * case.Q, f.alpha_r * case.R, np.array([[0.5, -0.5, 0.0]])
    costs = tuple(float(sum(z.cost(Q, R))) if z.stable else np.inf for z in loops)
    couples = tuple(float(np.sqrt(z.variance(z.inputs(pair))[0])) if z.stable else np.inf for z in loops)
    full, n = loops[0], case.plant.n
    cross = pair @ (K - sparse)
    crossing = float(np.sqrt(max((cross @ full.covariance[n:, n:] @ cross.T)[0, 0], 0.0))) if full.stable else np.inf
    return Structure(full, loops[1], (costs[0], costs[1]), (couples[0], couples[1]), crossing)


def channel_reductions(case: Case, setting: Setting, z: NoisyLoop) -> np.ndarray | None:
    """Peak reductions of the channels in dB, (k,)."""
    return peak_reductions(case, case.true_disturbance(setting.factors), z.psd(case.frequency))[0] if z.stable else None
