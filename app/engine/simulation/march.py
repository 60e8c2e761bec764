"""March along the grid: a continuous loop, one with a delay, or a sampled one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from ..systems.recursions import affine_scan, held_scan, step_matrices
from .disturbance import Disturbances
from .loop import Loop, error_loop, ramped
from .runner import Runner
from .saturation import Switcher
from .scenario import Scenario

__all__: list[str] = []


def plain(s: Scenario, loop: Loop, d: Disturbances, r: np.ndarray, bound: float) -> np.ndarray:
    """States (≤ n_t, N) of a loop without delay; a sampled loop only without limits."""
    if s.limited and len(d.z0):
        return Runner(Switcher(loop, s.u_min, s.u_max, s.dt)).run(d.z0, r[:-1], d.v[:-1], d.jumps, d.kicks, bound)
    free = np.ones(s.plant.m, dtype=bool)
    M = loop.closed(free)
    Phi, Phi1 = (M, np.eye(len(M))) if s.discrete else step_matrices(M, s.dt)
    inputs, ways = [], []
    if s.reference is not None:
        inputs, ways = [r[:-1]], [Phi1 @ (loop.Bs + loop.Bc)]
    if s.V is not None:
        inputs, ways = [*inputs, d.v[:-1]], [*ways, Phi1 @ loop.E]
    if inputs and d.jumps is None and not d.kicks:
        return cut(held_scan(Phi, np.hstack(ways), np.hstack(inputs), d.z0), bound)
    push = d.jumps
    if inputs:
        push = np.hstack(inputs) @ np.hstack(ways).T + (0.0 if push is None else push)
    return cut(affine_scan(Phi, with_kicks(push, d, M, s), d.z0, s.n_t - 1), bound)


def with_error(s: Scenario, d: Disturbances, r: np.ndarray, bound: float) -> tuple[np.ndarray, np.ndarray]:
    """z = (x, x̂) (≤ n_t, 2n) and e of a loop without limits and delay, run on (x, e): L costs no digits."""
    n = s.plant.n

    def moved(z: np.ndarray) -> np.ndarray:
        return np.concatenate([z[..., :n], z[..., :n] - z[..., n:]], axis=-1)

    kicks = {k: [(moment, moved(jump)) for moment, jump in found] for k, found in d.kicks.items()}
    own = replace(d, z0=moved(d.z0), jumps=None if d.jumps is None else moved(d.jumps), kicks=kicks)
    with np.errstate(over="ignore", invalid="ignore"):  # an overflow shows as inf and ends the run
        states = plain(s, error_loop(s), own, r, 2 * bound)
    z = cut(moved(states), bound)
    return z, states[:len(z), n:]


def in_parts(s: Scenario, loop: Loop, d: Disturbances, r: np.ndarray, ends: Iterable[int], diverged: float) -> Iterator[np.ndarray]:
    """The states of a continuous loop with limits and without delay, part by part, each from the last of the one before.

    A part that passes `diverged` times its start (or 1) ends there, and is the last.
    """
    runner, k, start = Runner(Switcher(loop, s.u_min, s.u_max, s.dt)), 0, d.z0
    for end in ends:
        kicks = {j - k: kicks for j, kicks in d.kicks.items() if k <= j < end}
        states = runner.run(start, r[k:end], d.v[k:end], None if d.jumps is None else d.jumps[k:end], kicks,
                            diverged * max(1.0, float(np.max(np.abs(start), initial=0.0))))
        yield states
        if len(states) <= end - k:
            return
        k, start = end, states[-1]


def with_kicks(push: np.ndarray | None, d: Disturbances, M: np.ndarray, s: Scenario) -> np.ndarray | None:
    """The forcing of a scan of ż = M z (z or its first entries) with each kick carried to the end of its step."""
    for k, kicks in d.kicks.items():
        push = np.zeros((s.n_t - 1, len(M))) if push is None else push
        for moment, jump in kicks:
            push[k] += step_matrices(M, s.dt - moment)[0] @ jump[:len(M)]
    return push


def cut(states: np.ndarray, bound: float) -> np.ndarray:
    """The states before the first that passes `bound` or is not finite; the start always."""
    with np.errstate(invalid="ignore"):
        if max(states.max(initial=-np.inf), -states.min(initial=np.inf)) < bound:  # false where there is a NaN
            return states
        small = np.abs(states).max(axis=1, initial=0.0) < bound
    return states[:max(1, int(np.argmin(small)))]


def sampled(s: Scenario, loop: Loop, d: Disturbances, r: np.ndarray, bound: float) -> tuple[np.ndarray, np.ndarray]:
    """States and delayed clipped inputs (n_t + lag, m) of a sampled loop with limits or delay, step by step."""
    steps, lag = s.n_t - 1, s.lag
    states, clipped = np.empty((steps + 1, len(d.z0))), np.zeros((steps + 1 + lag, s.plant.m))
    states[0] = z = d.z0
    wide = np.hstack([loop.A + loop.Bc @ loop.F, loop.Bs, loop.Bp] if lag else [loop.A + loop.Bc @ loop.F, loop.Bs])
    push = d.v @ loop.E.T + r @ loop.Bc.T
    if d.jumps is not None:
        push[:-1] += d.jumps
    F, low, high = loop.F, s.u_min, s.u_max
    for k in range(steps + 1):
        u = np.minimum(np.maximum(F @ z + r[k], low), high)
        clipped[k + lag] = u
        if k == steps:
            break
        z = wide @ np.concatenate([z, u, clipped[k]] if lag else [z, u]) + push[k]
        if not np.abs(z).max(initial=0.0) < bound:
            return states[:k + 1], clipped
        states[k + 1] = z
    return states, clipped


def delayed(s: Scenario, loop: Loop, d: Disturbances, r: np.ndarray, bound: float) -> tuple[np.ndarray, np.ndarray]:
    """Method of steps for a continuous loop: states and delayed clipped inputs (n_t + lag, m).

    For as long as the delay the input into the plant is known from before; within each grid step it runs straight
    between its values at the two ends, which errs by O(dt²). The input (p, ṗ) rides along as 2m states.
    """
    steps, m, lag, N, h = s.n_t - 1, s.plant.m, s.lag, len(d.z0), s.dt
    wide = ramped(loop)
    modal, free = s.limited and s.fed == "applied", np.ones(m, dtype=bool)
    limits = (s.u_min, s.u_max) if modal else (np.full(m, -np.inf), np.full(m, np.inf))
    runner = Runner(Switcher(wide, *limits, h)) if modal or d.kicks else None
    Phi, Phi1 = step_matrices(wide.closed(free), h)
    push = wide.forcing(free, np.zeros(m), r[:-1], d.v[:-1]) @ Phi1.T
    begin, end = np.zeros((steps + 1 + lag, m)), np.zeros((steps + 1 + lag, m))
    jumps = np.zeros((steps, N)) if d.jumps is None else d.jumps
    states = np.empty((steps + 1, N))
    states[0] = d.z0
    k = 0
    while k < steps:
        stop = min(k + lag, steps)
        ramp = np.hstack([begin[k:stop + 1], (end[k:stop + 1] - begin[k:stop + 1]) / h])
        left = np.hstack([end[k:stop], ramp[:-1, m:]])
        extra = np.hstack([jumps[k:stop], ramp[1:] - left])  # at the end of a step the next ramp begins
        start = np.concatenate([states[k], ramp[0]])
        inside = {j - k: [(t, np.pad(jump, (0, 2 * m))) for t, jump in kicks]
                  for j, kicks in d.kicks.items() if k <= j < stop}
        if runner is not None and (modal or inside):
            path = runner.run(start, r[k:stop], d.v[k:stop], extra, inside, bound)
        else:
            path = cut(affine_scan(Phi, push[k:stop] + extra, start, stop - k), bound)
        got = len(path) - 1
        states[k + 1:k + 1 + got] = path[1:, :N]
        if got < stop - k:
            return states[:k + 1 + got], begin
        u_begin = path[:-1] @ wide.F.T + r[k:stop]
        u_end = (path[1:] - extra) @ wide.F.T + r[k:stop]
        begin[k + lag:stop + lag] = np.clip(u_begin, s.u_min, s.u_max)
        end[k + lag:stop + lag] = np.clip(u_end, s.u_min, s.u_max)
        k = stop
    return states, begin
