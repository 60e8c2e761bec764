"""Compute the loop of a design: gains, noisy loop, costs, one run; all cached."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from observer_lab.course.lesson import Design
from observer_lab.engine import Belief, KalmanFilter, Plant, Scenario, compensator, lqe, lqr, noisy_loop, sampled_lqg, simulate
from observer_lab.engine.design import Optimal
from observer_lab.engine.feedback import NoisyLoop
from observer_lab.engine.filters import Schedule
from observer_lab.engine.sampled import SampledLqg
from observer_lab.engine.systems import symmetric

from .cases import Case, Factors

RUN_STATE_LIMIT = 1e9  # a state beyond this ends the run
SLACK = 0.1  # of the largest first error, the least standard deviation that the recursive filter begins with


@dataclass(frozen=True)
class Setting:
    """What of a design shapes the loop: the case's factors, the recovery in decades, the true gain of the inputs."""

    factors: Factors
    recovery: float
    gain: float

    def plain(self) -> Setting:
        """The same without recovery."""
        return Setting(self.factors, 0.0, self.gain)


def setting_of(case: Case, design: Design) -> Setting:
    """The loop's part of a design."""
    return Setting(case.factors(design), design["recovery"], design["gain"])


@lru_cache(maxsize=32)
def regulator(case: Case, alpha_q: float, alpha_r: float) -> Optimal:
    """LQR for α_Q Q and α_R R."""
    return lqr(case.plant.A, case.plant.B, alpha_q * case.Q, alpha_r * case.R)


@lru_cache(maxsize=64)
def estimator(case: Case, beta_q: float, beta_r: float, recovery: float) -> Optimal:
    """LQE for the noise believed, β_Q G W Gᵀ + μ² B Bᵀ and β_R V, with μ² = (10^recovery − 1) μ₀² β_Q."""
    return lqe(case.plant.A, np.eye(case.plant.n), case.plant.C, believed(case, beta_q, recovery), beta_r * case.V)


def believed(case: Case, beta_q: float, recovery: float) -> np.ndarray:
    """The intensity of process noise that the filter is told, n×n."""
    noise = case.G @ case.W @ case.G.T + (10.0**recovery - 1) * case.recovery_unit * case.plant.B @ case.plant.B.T
    return beta_q * symmetric(noise)


def gains(case: Case, setting: Setting) -> tuple[Optimal, Optimal]:
    """Regulator and estimator."""
    f = setting.factors
    return regulator(case, f.alpha_q, f.alpha_r), estimator(case, f.beta_q, f.beta_r, setting.recovery)


@lru_cache(maxsize=64)
def loop(case: Case, setting: Setting) -> NoisyLoop:
    """The loop of the true plant, its inputs `gain` times as strong, under the true noise."""
    return loop_with(case, setting, regulator(case, setting.factors.alpha_q, setting.factors.alpha_r).gain)


def loop_with(case: Case, setting: Setting, K: np.ndarray) -> NoisyLoop:
    """The same loop with another feedback gain K."""
    f = setting.factors
    L = estimator(case, f.beta_q, f.beta_r, setting.recovery).gain
    real = Plant(case.plant.A, setting.gain * case.plant.B, case.plant.C, setting.gain * np.asarray(case.plant.D))
    return noisy_loop(real, compensator(case.plant, K, L), case.G, case.true_disturbance(f) * case.W,
                      V=f.sensor * case.V).watching(case.rows)


def measured_loop(case: Case, setting: Setting) -> NoisyLoop:
    """The regulator alone, u = −K x: C is replaced by I, and no sensor is noisy."""
    n, f = case.plant.n, setting.factors
    K = regulator(case, f.alpha_q, f.alpha_r).gain
    real = Plant(case.plant.A, setting.gain * case.plant.B, np.eye(n))
    feedback = Plant(np.zeros((0, 0)), np.zeros((0, n)), np.zeros((len(K), 0)), -K)
    return noisy_loop(real, feedback, case.G, case.true_disturbance(f) * case.W, V=np.zeros((n, n))).watching(case.rows)


# --- cost ------------------------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Cost:
    """Averages of xᵀQx + uᵀRu. state + input = total of this loop; known: what a regulator knowing x and the true gain pays; least:
    of the best LQG for the true noise and the true gain; idle: without control (∞ where there is none). sensors: rms of each input
    that the sensors' noise causes, ground: that the disturbances cause."""

    state: float
    input: float
    known: float
    least: float
    idle: float
    sensors: tuple[float, ...]
    ground: tuple[float, ...]

    @property
    def total(self) -> float:
        """state + input."""
        return self.state + self.input


@lru_cache(maxsize=64)
def cost(case: Case, setting: Setting) -> Cost:
    """The costs of a setting, ∞ where its loop is unstable."""
    f, z = setting.factors, loop(case, setting)
    Q, R, asked_for = f.alpha_q * case.Q, f.alpha_r * case.R, f.alpha_r / setting.gain**2  # m u costs R/m² where u costs R
    reg = regulator(case, f.alpha_q, asked_for)
    true = case.true_disturbance(f)
    known = float(np.trace(reg.solution @ case.G @ case.W @ case.G.T)) * true
    best = estimator(case, true, f.sensor, 0.0)
    least = known + float(np.sum((reg.gain.T @ (asked_for * case.R) @ reg.gain) * best.solution))
    open_loop = case.open_loop
    idle = true * float(np.sum(Q * open_loop.covariance)) if open_loop.stable else np.inf
    if not z.stable:
        endless = (np.inf,) * case.plant.m
        return Cost(np.inf, np.inf, known, least, idle, endless, endless)
    state, asked = z.cost(Q, R)
    whole = z.variance(z.inputs())
    sensors = np.minimum(z.only(disturbances=0.0).variance(z.inputs()), whole)
    return Cost(state, asked, known, least, idle, tuple(np.sqrt(sensors).tolist()), tuple(np.sqrt(whole - sensors).tolist()))


@lru_cache(maxsize=64)
def sensor_input(case: Case, setting: Setting) -> float:
    """Rms over all inputs of what the sensors' noise alone makes them do, ∞ for an unstable loop."""
    z = loop(case, setting)
    return float(np.sqrt(z.only(disturbances=0.0).variance(z.inputs()).sum())) if z.stable else np.inf


# --- one run ---------------------------------------------------------------------------------------------------------
@dataclass(frozen=True, eq=False)
class Trace:
    """A run without noise from a wrong first belief: t (n_t,), x, xhat (n_t, n), u (n_t, m)."""

    t: np.ndarray
    x: np.ndarray
    xhat: np.ndarray
    u: np.ndarray

    def error(self, case: Case) -> np.ndarray:
        """‖e‖ (n_t,) over the first three watched signals, each over its largest true value in the run."""
        parts = []
        for signal in case.model.watched[:3]:
            true, guess = signal.of(self.x), signal.of(self.xhat)
            parts.append((true - guess) / max(float(np.abs(true).max()), 1e-12))
        return np.linalg.norm(parts, axis=0)


@lru_cache(maxsize=8)
def computer(case: Case, factors: Factors, recovery: float, dt: float) -> SampledLqg:
    """The design sampled every dt seconds."""
    f = factors
    return sampled_lqg(case.plant, f.alpha_q * case.Q, f.alpha_r * case.R, believed(case, f.beta_q, recovery), f.beta_r * case.V, dt,
                       G=np.eye(case.plant.n))


@lru_cache(maxsize=8)
def first_belief(case: Case) -> np.ndarray:
    """The covariance that the recursive filter begins with in the run: the squares of its first errors, none too small."""
    e = np.abs(np.asarray(case.model.x0) - np.asarray(case.model.guess))
    return np.diag(np.maximum(e, SLACK * max(e.max(), 1e-9)) ** 2)


@lru_cache(maxsize=8)
def schedule(case: Case, beta_q: float, beta_r: float, recovery: float, steps: int) -> Schedule:
    """Gains of the recursive filter in the run; no reading and no weight of the regulator changes them."""
    kf = KalmanFilter.from_plant(case.plant, believed(case, beta_q, recovery), beta_r * case.V, dt=case.dt, G=np.eye(case.plant.n))
    return kf.schedule(Belief(np.zeros(case.plant.n), first_belief(case)), steps)


def trace(case: Case, setting: Setting, kick: float, recursive: bool, held: bool = True) -> Trace:
    """The run of a design: the continuous loop with the steady filter, or the sampled one with the recursive filter.

    Not `held`: the steady filter watches the plant that is left alone.
    """
    steps = round(case.horizon / case.dt) + 1
    kicks = ((case.dt * round(kick / case.dt), case.model.kick),) if kick >= 0 else ()
    if not recursive:
        reg, est = gains(case, setting)
        p = case.plant
        real_plant = Plant(p.A, setting.gain * p.B, p.C, setting.gain * np.asarray(p.D))
        run = simulate(Scenario(real_plant, reg.gain if held else None, est.gain, x0=case.model.x0, xhat0=case.model.guess, dt=case.dt,
                                horizon=case.dt * (steps - 1), model=p, impulses=kicks))
        return _long_enough(Trace(run.t, run.x, run.xhat, run.u_applied), case.dt)
    f = setting.factors
    sampled = computer(case, replace(f, sensor=1.0), setting.recovery, case.dt)
    w, v = np.zeros((steps, case.plant.n)), np.zeros((steps, case.plant.p))
    for time, jump in kicks:
        w[max(round(time / case.dt) - 1, 0)] += np.asarray(jump)
    s = sampled.plant
    with np.errstate(over="ignore", invalid="ignore"):
        found = sampled.run(case.model.x0, w, v, gains=schedule(case, f.beta_q, f.beta_r, setting.recovery, steps),
                            xhat0=case.model.guess, truth=Plant(s.A, setting.gain * s.B, s.C, s.D, s.dt))
    good = int(np.argmin(np.append(np.isfinite(found.x).all(axis=1) & (np.abs(found.x).max(axis=1) < RUN_STATE_LIMIT), False)))
    keep = slice(0, max(good, 1))
    return _long_enough(
        Trace(found.t[keep], found.x[keep], found.xhat[keep], np.clip(np.nan_to_num(found.u[keep]), -RUN_STATE_LIMIT, RUN_STATE_LIMIT)),
        case.dt,
    )


def _long_enough(found: Trace, dt: float) -> Trace:
    """A run that ended at its first instant, held for one step, so that there is something to draw."""
    if len(found.t) > 1:
        return found
    return Trace(np.array([0.0, dt]), *(np.repeat(part[:1], 2, axis=0) for part in (found.x, found.xhat, found.u)))
