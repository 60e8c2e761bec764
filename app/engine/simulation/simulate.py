"""Simulate a scenario exactly, linear between grid points and clipped between switchings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from ..systems.errors import EngineError
from ..systems.gates.argument_checks import FUNCTION, SERIES, instance, takes
from ..systems.recursions import affine_scan, step_matrices
from .disturbance import Disturbances, disturbances
from .loop import Loop, continuous_loop, discrete_loop
from .march import delayed, in_parts, plain, sampled, with_error, with_kicks
from .scenario import Run, Scenario

__all__ = ["autonomous_error", "separation_meter", "simulate", "simulate_until"]

DIVERGENCE_FACTOR = 1e9  # times the larger of 1 and the size of the start


@takes(scenario=instance(Scenario))
def simulate(scenario: Scenario) -> Run:
    """Run the loop of plant, observer and controller over the grid of the scenario.

    Without active limits the states are exact at the grid points (matrix exponentials and an affine scan); with
    them, exact between switching instants located to rounding; a continuous loop with a delay sees the delayed
    input as straight lines between grid points. Noise w has the exact covariance over a step (Van Loan), v is held
    over a step with covariance V/dt. Ends early, `diverged_at` set, where a state passes 1e9 times its start (or 1).
    Raises EngineError where the scenario cannot be simulated.

    >>> run = simulate(Scenario(Plant([[0]], [[1]], [[1]]), [[1]], [[2]], x0=[1.0], horizon=2.0, dt=0.01))
    >>> np.allclose(run.e[:, 0], np.exp(-2 * run.t))
    True
    """
    loop, d = _made_of(scenario)
    return _run(scenario, loop, d, *_states(scenario, loop, d))


@takes(scenario=instance(Scenario), looks=SERIES, enough=FUNCTION)
def simulate_until(scenario: Scenario, looks: Sequence[float], enough: Callable[[np.ndarray], bool]) -> Run:
    """The run of a scenario up to the first of the times `looks` where the states x (steps, n) since the one before are `enough`.

    A run that ends early has `diverged_at` set. All is prepared once; a clipped continuous loop without delay is not followed further.

    >>> s = Scenario(Plant([[1]], [[1]], [[1]]), [[2]], [[3]], x0=[1.0], horizon=2.0, dt=0.01, u_min=-0.5, u_max=0.5)
    >>> float(simulate_until(s, [0.5, 1.0, 1.5], lambda x: np.abs(x).max() > 1.5).t[-1])
    1.0
    """
    s, n = scenario, scenario.plant.n
    loop, d = _made_of(s)
    ends = sorted({*(min(max(round(look / s.dt), 1), s.n_t - 1) for look in looks), s.n_t - 1})
    if s.limited and n and not s.discrete and not s.lag:
        parts, late, e = [], None, None
        for states in in_parts(s, loop, d, _reference(s), ends, DIVERGENCE_FACTOR):
            parts.append(states)
            if enough(states[:, :n]):
                break
        z = np.concatenate([*(part[:-1] for part in parts[:-1]), parts[-1]])
    else:
        z, late, e = _states(s, loop, d)
        z = z[:1 + next((end for begin, end in pairwise([0, *ends]) if begin < len(z) and enough(z[begin:end + 1, :n])), s.n_t - 1)]
    return _run(s, loop, d, z, late, e)


def _states(s: Scenario, loop: Loop, d: Disturbances) -> tuple[np.ndarray, np.ndarray | None, np.ndarray | None]:
    """z (≤ n_t, N), the delayed clipped inputs of a loop with a delay, and e where it was run itself."""
    r, bound = _reference(s), DIVERGENCE_FACTOR * max(1.0, float(np.max(np.abs(d.z0), initial=0.0)))
    if s.lag or (s.discrete and s.limited):
        return *(sampled if s.discrete else delayed)(s, loop, d, r, bound), None
    if s.limited or s.model.n != s.plant.n:
        return plain(s, loop, d, r, bound), None, None
    z, e = with_error(s, d, r, bound)
    return z, None, e


def _reference(s: Scenario) -> np.ndarray:
    return np.zeros((s.n_t, s.plant.m)) if s.reference is None else s.reference


def loop_of(s: Scenario) -> Loop:
    """The scenario's loop, sampled or continuous."""
    return discrete_loop(s) if s.discrete else continuous_loop(s)


@takes(scenario=instance(Scenario))
def disturbances_of(scenario: Scenario) -> Disturbances:
    """The start, the noise of its seed and the impulses with which `simulate` runs a scenario.

    >>> plant = Plant([[-1.0]], [[1.0]], [[1.0]])
    >>> disturbances_of(Scenario(plant, K=[[0.0]], L=[[1.0]], horizon=1.0, dt=0.5, x0=[2.0])).z0
    array([2., 0.])
    """
    return _made_of(scenario)[1]


def _run(s: Scenario, loop: Loop, d: Disturbances, z: np.ndarray, late: np.ndarray | None, e: np.ndarray | None) -> Run:
    plant, model, count = s.plant, s.model, len(z)
    n, m, p = plant.n, plant.m, plant.p
    x, xhat = z[:, :n], z[:, n:]
    read = np.zeros((z.shape[1], m + 2 * p))  # u, C x and C x̂ from one product
    read[:, :m], read[:n, m:m + p], read[n:, m + p:] = loop.F.T, plant.C.T, model.C.T
    out = z @ read
    asked, y, yhat = out[:, :m], out[:, m:m + p], out[:, m + p:]
    if s.reference is not None:
        asked += s.reference[:count]
    clipped = np.clip(asked, s.u_min, s.u_max) if s.limited else asked
    applied = clipped if late is None else late[:count]
    w, v = d.w[:count], d.v[:count]
    if np.any(plant.D):
        y += applied @ np.asarray(plant.D).T
    if np.any(model.D):
        yhat += (clipped if s.fed == "applied" else asked) @ model.D.T
    if s.V is not None:
        y += v
    if e is None:
        e = x - xhat if x.shape == xhat.shape else np.zeros((count, 0))
    diverged_at = None if count == s.n_t else float(s.dt * count)
    return Run(s, s.t[:count], x, xhat, e[:count], asked, applied, y, yhat, w, v, diverged_at, bool(np.any(clipped != asked)),
               (loop, d))


def _made_of(s: Scenario) -> tuple[Loop, Disturbances]:
    loop = loop_of(s)
    return loop, disturbances(s, loop)


@takes(run=instance(Run))
def autonomous_error(run: Run) -> np.ndarray:
    """What e would be were it left to itself: ė = (Aₘ − L Cₘ) e + G w − L v from the run's own e(0), (n_t, n).

    Without noise and impulses this is expm((A − L C) t) e(0); impulses and the run's own noise are followed, since
    they do not break the separation. Aₘ, Cₘ are the designer's. Raises EngineError where e does not exist.

    >>> run = simulate(Scenario(Plant([[0]], [[1]], [[1]]), [[1]], [[2]], x0=[1.0], horizon=2.0, dt=0.01))
    >>> np.allclose(autonomous_error(run), run.e)
    True
    """
    s, n = run.scenario, run.scenario.plant.n
    if s.model.n != n:
        raise EngineError("Plant and model differ in order, so there is no error e = x − x̂ to compare.")
    loop, d = run.made_of or _made_of(s)
    M, L = loop.A[n:, n:], loop.E[n:]
    Phi, Phi1 = (M, np.eye(n)) if s.discrete else step_matrices(M, s.dt)
    push = None if s.V is None else -(d.v[:-1] @ L.T) @ Phi1.T
    if d.jumps is not None:
        push = d.jumps[:, :n] - d.jumps[:, n:] + (0.0 if push is None else push)
    push = with_kicks(push, d, M, s)
    count = len(run.t)
    return affine_scan(Phi, None if push is None else push[:count - 1], d.z0[:n] - d.z0[n:], count - 1)


@takes(run=instance(Run))
def separation_meter(run: Run) -> float:
    """How far e leaves the designer's promise: max‖e − e_autonomous‖ / max‖e_autonomous‖ (2-norms, over the run).

    Zero to rounding for a linear loop on a true model. Where e is promised to stay zero, max‖x‖ divides instead.
    """
    promised = autonomous_error(run)
    gap, size, state = (float(np.max(np.linalg.norm(a, axis=1))) for a in (run.e - promised, promised, run.x))
    size = size if size > 1e-12 * state else state
    return gap / size if size else 0.0
