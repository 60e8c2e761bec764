"""Simulate a scenario: exact at the grid points while linear, exact between located switchings when clipped."""

from __future__ import annotations

import numpy as np

from .errors import EngineError
from .loop import Loop, continuous_loop, discrete_loop, ramped
from .noise import process_noise, root
from .saturation import Switcher
from .scan import affine_scan, step_matrices
from .scenario import Run, Scenario

__all__ = ["autonomous_error", "separation_meter", "simulate"]

DIVERGED = 1e9  # times the larger of 1 and the size of the start

Kicks = dict[int, list[tuple[float, np.ndarray]]]


def simulate(scenario: Scenario) -> Run:
    """Run the loop of plant, observer and controller over the grid of the scenario.

    Without active limits the states are exact at the grid points (matrix exponentials and an affine scan); with
    them, exact between switching instants located to rounding; a continuous loop with a delay sees the delayed
    input as straight lines between grid points. Noise w has the exact covariance over a step (Van Loan), v is held
    over a step with covariance V/dt. Ends early, `diverged_at` set, where a state passes 1e9.
    Raises EngineError where the scenario cannot be simulated.
    """
    s = scenario
    loop = discrete_loop(s) if s.discrete else continuous_loop(s)
    r = np.zeros((s.n_t, s.plant.m)) if s.reference is None else s.reference
    w, v, jumps = _noise(s, loop)
    kicks, jumps, z0 = _impulses(s, loop, jumps)
    bound = DIVERGED * max(1.0, float(np.max(np.abs(z0))))
    if s.discrete and (s.limited or s.lag):
        z, delayed = _sampled(s, loop, z0, r, v, jumps, bound)
    elif s.lag:
        z, delayed = _delayed(s, loop, z0, r, v, jumps, kicks, bound)
    else:
        z, delayed = _plain(s, loop, z0, r, v, jumps, kicks, bound), None
    return _run(s, loop, z, r, w, v, delayed)


def _noise(s: Scenario, loop: Loop) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """w (n_t, q), v (n_t, p) and the jumps of z over the steps (n_t − 1, N) or None."""
    plant = s.plant
    for_w, for_v = np.random.default_rng(s.seed).spawn(2)
    v = np.zeros((s.n_t, plant.p))
    if s.V is not None:
        v = for_v.standard_normal((s.n_t, plant.p)) @ root(s.V if plant.dt else s.V / s.dt).T
    if s.W is None or s.G is None:
        return np.zeros((s.n_t, 0 if s.G is None else s.G.shape[1])), v, None
    N, q = len(loop.A), s.G.shape[1]
    if plant.dt:
        w = for_w.standard_normal((s.n_t, q)) @ root(s.W).T
        jumps = w @ s.G.T
    elif s.discrete:
        w, jumps = process_noise(plant.A, s.G, s.W, s.dt, s.n_t, for_w)
    else:
        free = np.ones(plant.m, dtype=bool)
        return (*_swap(process_noise(loop.closed(free), np.vstack([s.G, np.zeros((N - plant.n, q))]),
                                     s.W, s.dt, s.n_t, for_w), v),)
    wide = np.zeros((s.n_t - 1, N))
    wide[:, :plant.n] = jumps[:-1]
    return w, v, wide


def _swap(drawn: tuple[np.ndarray, np.ndarray], v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return drawn[0], v, drawn[1][:-1]


def _impulses(s: Scenario, loop: Loop, jumps: np.ndarray | None) -> tuple[Kicks, np.ndarray | None, np.ndarray]:
    """Impulses on the grid join the jumps (or the start); those between grid points become kicks, by step.

    A sampled loop feels a kick at the next sample as e^{A (h − τ)} dx, whatever the held input.
    """
    n, N = s.plant.n, len(loop.A)
    kicks: Kicks = {}
    z0 = np.concatenate([s.x0, s.xhat0])
    for time, dx in sorted(s.impulses, key=lambda impulse: impulse[0]):
        k = round(time / s.dt)
        if k > s.n_t - 1 or time > s.horizon * (1 + 1e-12):
            continue
        dz = np.zeros(N)
        dz[:n] = dx
        if abs(time / s.dt - k) > 1e-9:
            k = int(time / s.dt)
            if not s.discrete:
                kicks.setdefault(k, []).append((time - k * s.dt, dz))
                continue
            if s.plant.dt:
                raise EngineError("A sampled plant has no time between samples: give impulses at multiples of dt.")
            dz[:n] = step_matrices(s.plant.A, (k + 1) * s.dt - time)[0] @ dz[:n]
            k += 1
        if k == 0:
            z0 = z0 + dz
        elif k <= s.n_t - 1:
            jumps = np.zeros((s.n_t - 1, N)) if jumps is None else jumps
            jumps[k - 1] += dz
    return kicks, jumps, z0


def _plain(s: Scenario, loop: Loop, z0: np.ndarray, r: np.ndarray, v: np.ndarray, jumps: np.ndarray | None,
           kicks: Kicks, bound: float) -> np.ndarray:
    if s.limited:
        return Switcher(loop, s.u_min, s.u_max, s.dt).run(z0, r[:-1], v[:-1], jumps, kicks, bound)
    free = np.ones(s.plant.m, dtype=bool)
    M = loop.closed(free)
    Phi, Phi1 = (M, np.eye(len(M))) if s.discrete else step_matrices(M, s.dt)
    push = jumps
    if s.reference is not None or s.V is not None:
        push = loop.forcing(free, np.zeros(s.plant.m), r[:-1], v[:-1]) @ Phi1.T + (0.0 if jumps is None else jumps)
    for k, list_of in kicks.items():
        push = np.zeros((s.n_t - 1, len(z0))) if push is None else push
        for moment, jump in list_of:
            push[k] += step_matrices(M, s.dt - moment)[0] @ jump
    return _cut(affine_scan(Phi, push, z0, s.n_t - 1), bound)


def _cut(states: np.ndarray, bound: float) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        small = np.abs(states).max(axis=1) < bound
    return states if small.all() else states[:max(1, int(np.argmin(small)))]


def _sampled(s: Scenario, loop: Loop, z0: np.ndarray, r: np.ndarray, v: np.ndarray, jumps: np.ndarray | None,
             bound: float) -> tuple[np.ndarray, np.ndarray]:
    steps, m, lag = s.n_t - 1, s.plant.m, s.lag
    states, clipped = np.empty((steps + 1, len(z0))), np.zeros((steps + 1 + lag, m))
    states[0] = z = z0
    side = v @ loop.E.T
    if jumps is not None:
        side[:-1] += jumps
    both = np.hstack([loop.A + loop.Bc @ loop.F, loop.Bs] + ([loop.Bp] if lag else []))
    side += r @ loop.Bc.T
    for k in range(steps + 1):
        u = np.minimum(np.maximum(loop.F @ z + r[k], s.u_min), s.u_max)
        clipped[k + lag] = u
        if k == steps:
            break
        z = both @ np.concatenate([z, u, clipped[k]] if lag else [z, u]) + side[k]
        if not np.abs(z).max() < bound:
            return states[:k + 1], clipped
        states[k + 1] = z
    return states, clipped


def _delayed(s: Scenario, loop: Loop, z0: np.ndarray, r: np.ndarray, v: np.ndarray, jumps: np.ndarray | None,
             kicks: Kicks, bound: float) -> tuple[np.ndarray, np.ndarray]:
    """Method of steps: over a step the delayed input runs straight between its values at the two ends."""
    steps, m, lag, N, h = s.n_t - 1, s.plant.m, s.lag, len(z0), s.dt
    wide = ramped(loop)
    switcher = Switcher(wide, s.u_min, s.u_max, h)
    free = np.ones(m, dtype=bool)
    Phi, Phi1 = step_matrices(wide.closed(free), h)
    push = wide.forcing(free, np.zeros(m), r, v) @ Phi1.T
    states, start, end = np.empty((steps + 1, N)), np.zeros((steps + 1 + lag, m)), np.zeros((steps + 1 + lag, m))
    states[0] = z0
    modal = s.limited and s.fed == "applied"
    tail = np.zeros(2 * m)
    for k in range(steps + 1):
        z = states[k]
        start[k + lag] = np.clip(loop.F @ z + r[k], s.u_min, s.u_max)
        if k == steps:
            break
        wide_z = np.concatenate([z, start[k], (end[k] - start[k]) / h])
        if modal or k in kicks:
            extra = [(moment, np.concatenate([jump, tail])) for moment, jump in kicks.get(k, [])]
            z = switcher.careful(wide_z, r[k], v[k], extra)[:N]
        else:
            z = (Phi @ wide_z + push[k])[:N]
        end[k + lag] = np.clip(loop.F @ z + r[k], s.u_min, s.u_max)
        if jumps is not None:
            z = z + jumps[k]
        if not np.abs(z).max() < bound:
            return states[:k + 1], start
        states[k + 1] = z
    return states, start


def _run(s: Scenario, loop: Loop, z: np.ndarray, r: np.ndarray, w: np.ndarray, v: np.ndarray,
         delayed: np.ndarray | None) -> Run:
    plant, model, count = s.plant, s.model, len(z)
    r, w, v, t = r[:count], w[:count], v[:count], s.t[:count]
    x, xhat = z[:, :plant.n], z[:, plant.n:]
    asked = z @ loop.F.T + r
    clipped = np.clip(asked, s.u_min, s.u_max) if s.limited else asked
    applied = clipped if delayed is None else delayed[:count]
    y = x @ plant.C.T + applied @ plant.D.T + v
    fed = clipped if s.fed == "applied" else asked
    yhat = xhat @ model.C.T + fed @ model.D.T
    e = x - xhat if x.shape == xhat.shape else np.zeros((count, 0))
    diverged = None if count == s.n_t else float(s.dt * count)
    return Run(s, t, x, xhat, e, asked, applied, y, yhat, w, v, diverged, bool(np.any(clipped != asked)))


def autonomous_error(run: Run) -> np.ndarray:
    """What e would be were it left to itself: ė = (Aₘ − L Cₘ) e + G w − L v from the run's own e(0), (n_t, n).

    Without noise and impulses this is expm((A − L C) t) e(0); impulses and the run's own noise are followed, since
    they do not break the separation. Aₘ, Cₘ are the designer's. Raises EngineError where e does not exist.
    """
    s, n = run.scenario, run.scenario.plant.n
    model = s.model
    if model.n != n:
        raise EngineError("Plant and model differ in order, so there is no error e = x − x̂ to compare.")
    loop = discrete_loop(s) if s.discrete else continuous_loop(s)
    _, v, jumps = _noise(s, loop)
    kicks, jumps, z0 = _impulses(s, loop, jumps)
    count = len(run.t)
    if s.discrete:
        L = loop.E[n:]
        Phi, Phi1 = loop.A[n:, n:], np.eye(n)
    else:
        L = s.L
        M = model.A - L @ model.C
        Phi, Phi1 = step_matrices(M, s.dt)
    push = None if s.V is None else -(v[:-1] @ L.T) @ Phi1.T
    if jumps is not None:
        push = jumps[:, :n] - jumps[:, n:] + (0.0 if push is None else push)
    for k, list_of in kicks.items():
        push = np.zeros((s.n_t - 1, n)) if push is None else push
        for moment, jump in list_of:
            push[k] += step_matrices(M, s.dt - moment)[0] @ jump[:n]
    return affine_scan(Phi, None if push is None else push[:count - 1], z0[:n] - z0[n:], count - 1)


def separation_meter(run: Run) -> float:
    """How far the loop's errors leave the designer's promise: max ‖e − e_autonomous‖ / max(‖e_autonomous‖).

    Zero to rounding for a linear loop on a true model; where e starts at zero the largest ‖x‖ divides instead.
    """
    promised = autonomous_error(run)
    gap = float(np.max(np.linalg.norm(run.e - promised, axis=1)))
    size = float(np.max(np.linalg.norm(promised, axis=1)))
    floor = float(np.max(np.linalg.norm(run.x, axis=1)))
    if size <= 1e-12 * max(floor, 1e-300):
        size = floor
    return gap / size if size else 0.0
