"""Simulate many starts of one scenario at once, with located switchings."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..systems.errors import ShapeError, phrase
from ..systems.gates.argument_checks import array, instance, takes
from .disturbance import disturbances
from .loop import Loop, ramped
from .runner import Runner, beside
from .saturation import LIMIT_ROUNDING, MAX_STEP_PIECES, TERMS, Mode, Switcher
from .scenario import Scenario
from .simulate import loop_of

__all__ = ["simulate_starts"]

MAX_NEWTON_STEPS = 60
CHUNK_NUMBERS = 500_000  # numbers that the compiled march finds at once
NO_JUDGEMENT = np.array([0.0, np.inf, np.inf, np.inf, np.inf])  # to judge


@takes(scenario=instance(Scenario), starts=array("k N"))
def simulate_starts(scenario: Scenario, starts: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the states z = (x, x̂) of every start, (n_runs, N), at grid points 0, 1, … n_t − 1.

    The scenario's own x0 and xhat0 are not used; its noise and impulses are the same for all starts. A yielded
    array belongs to the caller; a row set to zero by the caller runs on from zero.

    >>> s = Scenario(Plant([[0]], [[1]], [[1]]), [[1]], [[2]], horizon=1.0, dt=0.5)
    >>> [float(Z[0, 0].round(4)) for Z in simulate_starts(s, np.array([[1.0, 1.0]]))]
    [1.0, 0.6065, 0.3679]
    """
    s = scenario
    if starts.shape[1] != s.plant.n + s.model.n:
        raise ShapeError("{name} must have {length} entries; it has {vector_size}.",
                         name=phrase("A start"), length=s.plant.n + s.model.n, vector_size=starts.shape[1])
    herd = RunBatch(s)
    Z, k = herd.started(starts), 0
    yield Z
    while k < herd.steps:
        if (count := herd.compiled(k, max(1, CHUNK_NUMBERS // max(1, Z.size)))) == 0:
            Z, k = herd.step(Z, k), k + 1
            yield Z
            continue
        out = np.empty((count + 1, *Z.shape))
        herd.along(Z.copy(), k, count, out)
        for i in range(1, count + 1):
            gone = np.flatnonzero(Z[:, 0] == 0)
            if len(gone) and len(gone := gone[np.abs(Z[gone]).max(axis=1) == 0]):  # rows that the caller has set to zero
                again = np.empty((count + 2 - i, len(gone), Z.shape[1]))
                herd.along(Z[gone], k + i - 1, count + 1 - i, again)
                out[i:, gone] = again[1:]
            Z = out[i]
            yield Z
        k += count


class RunBatch:
    """Many runs of a scenario, together: what disturbs them all, and their way from grid point to grid point."""

    def __init__(self, s: Scenario) -> None:
        self.s, self.steps, loop = s, s.n_t - 1, loop_of(s)
        self.d = d = disturbances(s, loop)
        self.r = np.zeros((s.n_t, s.plant.m)) if s.reference is None else s.reference
        self.stepper = _Sampled(s, loop, []) if s.discrete else _Continuous(s, loop, [])
        self.runner = None if isinstance(self.stepper, _Sampled) or s.lag else Runner(self.stepper.switcher)
        self.q = beside(self.r[:-1], d.v[:-1])
        self.stops = np.array([*sorted(d.kicks), self.steps])

    def started(self, starts: np.ndarray) -> np.ndarray:
        """The runs at t = 0, impulses there included."""
        return starts + (self.d.z0 - np.concatenate([self.s.x0, self.s.xhat0]))

    def step(self, Z: np.ndarray, k: int) -> np.ndarray:
        """One grid step of all runs, the plain way."""
        Z = self.stepper.step(Z, self.r[k], self.d.v[k], self.d.kicks.get(k, []))
        return Z if self.d.jumps is None else Z + self.d.jumps[k]

    def compiled(self, k: int, most: int) -> int:
        """How many steps from k on the compiled march may take, `most` at most; 0 where it is not ready or a kick falls."""
        if self.runner is None or self.runner.march is None:
            return 0
        return min(most, int(self.stops[np.searchsorted(self.stops, k)]) - k)

    def along(self, Z: np.ndarray, k: int, count: int, out: np.ndarray, judge: np.ndarray = NO_JUDGEMENT,
              last: np.ndarray | None = None, lost: np.ndarray | None = None) -> None:
        """All runs Z over `count` steps from k on, in place, the states in out (count + 1, runs, N) unless it is empty.

        last and lost (runs,) follow `judge` as in `kernels.clipped.march`.
        """
        assert self.runner is not None
        q = self.q if len(self.q) == 1 else self.q[k:k + count]
        jumps = None if self.d.jumps is None else self.d.jumps[k:k + count]
        since = np.full(len(Z), -1)
        self.runner.along(Z, 0, count, out, q, jumps, judge, since, lost)
        if last is not None:
            np.copyto(last, since + k, where=since >= 0)


class _Sampled:
    def __init__(self, s: Scenario, loop: Loop, late: list[np.ndarray]) -> None:
        self.s, self.loop, self.late = s, loop, late

    def step(self, Z: np.ndarray, r: np.ndarray, v: np.ndarray, kicks: list) -> np.ndarray:
        loop, s = self.loop, self.s
        u = Z @ loop.F.T + r
        clipped = np.minimum(np.maximum(u, s.u_min), s.u_max)
        after = Z @ loop.A.T + clipped @ loop.Bs.T + u @ loop.Bc.T + loop.E @ v
        if s.lag:
            self.late.append(clipped)
            if len(self.late) > s.lag:
                after += self.late.pop(0) @ loop.Bp.T
        return after


class _Continuous:
    """One grid step for all runs; with a delay the clipped input of `lag` steps ago rides along as a ramp."""

    def __init__(self, s: Scenario, loop: Loop, late: list[np.ndarray]) -> None:
        self.s, self.loop, self.late = s, loop, late
        modal = s.limited and (not s.lag or s.fed == "applied")
        free = np.full(s.plant.m, np.inf)
        self.switcher = Switcher(ramped(loop) if s.lag else loop, s.u_min if modal else -free,
                                 s.u_max if modal else free, s.dt)

    def step(self, Z: np.ndarray, r: np.ndarray, v: np.ndarray, kicks: list[tuple[float, np.ndarray]]) -> np.ndarray:
        s, m, wide = self.s, self.s.plant.m, Z
        if s.lag:
            ramp = np.zeros((len(Z), 2 * m))
            if len(self.late) >= 2 * s.lag:
                begin, end = self.late.pop(0), self.late.pop(0)
                ramp = np.hstack([begin, (end - begin) / s.dt])
            wide = np.hstack([Z, ramp])
        after = self._through(wide, r, v, kicks)[:, :Z.shape[1]]
        if s.lag:
            self.late += [np.clip(state @ self.loop.F.T + r, s.u_min, s.u_max) for state in (Z, after)]
        return after

    def _through(self, Z: np.ndarray, r: np.ndarray, v: np.ndarray,
                 kicks: list[tuple[float, np.ndarray]]) -> np.ndarray:
        if not kicks:
            return grid_step(self.switcher, Z, r, v)
        now = 0.0
        for moment, jump in kicks:
            Z = part_step(self.switcher, Z, r, v, np.full(len(Z), moment - now))
            Z[:, :len(jump)] += jump
            now = moment
        return part_step(self.switcher, Z, r, v, np.full(len(Z), self.s.dt - now))


def _groups(w: Switcher, Z: np.ndarray, r: np.ndarray, v: np.ndarray) -> list[tuple[Mode, np.ndarray, np.ndarray]]:
    """The runs by the mode they are in: (mode, their rows, its forcing); on a limit the slope of u decides."""
    u = Z @ w.loop.F.T + r
    sign = (u > w.u_max).astype(np.int8) - (u < w.u_min).astype(np.int8)
    slack = np.maximum(w.slack, LIMIT_ROUNDING * (np.abs(Z) @ np.abs(w.loop.F).T))
    upper, lower = np.abs(u - w.u_max) <= slack, np.abs(u - w.u_min) <= slack
    near = np.flatnonzero((upper | lower).any(axis=1))
    for mode, rows, force in _by_sign(w, sign[near], r, v):
        rows = near[rows]
        slope = Z[rows] @ mode.FM.T + w.loop.F @ force
        sign[rows] = np.where(upper[rows], slope > 0, np.where(lower[rows], -(slope < 0).astype(np.int8), sign[rows]))
    return _by_sign(w, sign, r, v)


def _by_sign(w: Switcher, sign: np.ndarray, r: np.ndarray, v: np.ndarray) -> list[tuple[Mode, np.ndarray, np.ndarray]]:
    codes = sign @ (3 ** np.arange(sign.shape[1]))
    found = []
    for code in np.unique(codes):
        rows = np.flatnonzero(codes == code)
        mode = w.mode_of(sign[rows[0]])
        found.append((mode, rows, w.loop.forcing(mode.free, mode.held, r, v)))
    return found


def grid_step(w: Switcher, Z: np.ndarray, r: np.ndarray, v: np.ndarray) -> np.ndarray:
    """All runs over one whole grid step: those that keep their mode in one product, the others through switchings."""
    after = np.empty_like(Z)
    for mode, rows, force in _groups(w, Z, r, v):
        if mode.first:
            after[rows] = part_step(w, Z[rows], r, v, np.full(len(rows), w.h))
            continue
        Phi, Phi1 = mode.flow[0]
        now = Z if len(rows) == len(Z) else Z[rows]
        then = now @ Phi.T + Phi1 @ force
        leaves = ~w.keeps(mode, now, then, force, r)
        after[rows] = then
        if leaves.any():
            gone = rows[leaves]
            after[gone] = part_step(w, Z[gone], r, v, np.full(len(gone), w.h))
    return after


def part_step(w: Switcher, Z: np.ndarray, r: np.ndarray, v: np.ndarray, left: np.ndarray) -> np.ndarray:
    """All runs over their own durations `left` ≤ h, piece by Taylor piece from switching to switching."""
    Z, left = Z.copy(), left.copy()
    span = np.abs(w.loop.F).T, w.u_max - w.u_min
    for _ in range(MAX_STEP_PIECES):
        blurred = (LIMIT_ROUNDING * (np.abs(Z) @ span[0]) > span[1]).any(axis=1)
        active = np.flatnonzero((left > 1e-14 * w.h) & ~blurred)
        if not len(active):
            break
        for mode, rows, force in _groups(w, Z[active], r, v):
            rows = active[rows]
            change = ((Z[rows] @ mode.M.T + force) @ mode.taylor.T).reshape(len(rows), TERMS, -1)
            line = np.concatenate([(Z[rows] @ w.loop.F.T + r)[:, None], change @ w.loop.F.T], axis=1)
            piece = np.minimum(1.0, left[rows] / mode.short)
            leave = _first_exits(line, mode.low - w.slack, mode.high + w.slack, piece)
            powers = leave[:, None] ** np.arange(1, TERMS + 1)
            Z[rows] += (powers[:, None] @ change)[:, 0]
            left[rows] = np.where(leave >= left[rows] / mode.short * (1 - 1e-14), 0.0, left[rows] - leave * mode.short)
    Z[left > 1e-14 * w.h] = np.inf  # not to be followed
    return Z


def _first_exits(line: np.ndarray, low: np.ndarray, high: np.ndarray, end: np.ndarray) -> np.ndarray:
    """The first s in (0, end] (n_runs,) where a polynomial (n_runs, terms, m) leaves [low, high], or end."""
    first = end.copy()
    samples = np.linspace(0.0, 1.0, 9)[:, None] * end  # (9, n_runs)
    values = _horner(line, samples)  # (9, n_runs, m)
    for i in range(line.shape[2]):
        for limit, side in ((high[i], 1.0), (low[i], -1.0)):
            over = side * (values[1:, :, i] - limit) > 0
            rows = np.flatnonzero(over.any(axis=0)) if np.isfinite(limit) else np.array([], dtype=int)
            if len(rows):
                j = np.argmax(over[:, rows], axis=0)
                root = _roots(line[rows, :, i], limit, side, samples[j, rows], samples[j + 1, rows])
                first[rows] = np.minimum(first[rows], root)
    return first


def _horner(line: np.ndarray, s: np.ndarray) -> np.ndarray:
    value: np.ndarray = np.zeros((*s.shape, line.shape[2]))
    for term in range(line.shape[1] - 1, -1, -1):
        value = value * s[..., None] + line[:, term]
    return value


def _roots(line: np.ndarray, limit: float, side: float, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Newton on side·(polynomial − limit) for all rows, each kept in its bracket (a, b] by bisection."""
    s: np.ndarray = (a + b) / 2
    value: np.ndarray
    slope: np.ndarray
    for _ in range(MAX_NEWTON_STEPS):
        value, slope = np.zeros_like(s), np.zeros_like(s)
        for term in range(line.shape[1] - 1, -1, -1):
            slope = slope * s + value
            value = value * s + line[:, term]
        value = value - limit
        a, b = np.where(side * value > 0, a, s), np.where(side * value > 0, s, b)
        trial = s - value / np.where(slope == 0, np.inf, slope)
        new = np.where((trial >= a) & (trial <= b), trial, (a + b) / 2)
        done = np.all(np.abs(new - s) <= 4e-16 * np.abs(b) + 1e-300)
        s = new
        if done:
            break
    return s
