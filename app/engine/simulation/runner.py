"""Run a clipped loop along its grid, compiled where ready, else in NumPy."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ..kernels import as_kernel_array, compiled_kernel, run_in_threads
from ..kernels.clipped import march
from .disturbance import Kicks
from .saturation import LIMIT_ROUNDING, TERMS, Mode, Switcher

MOST_INPUTS = 8  # 3⁸ ways to be clipped
FIRST_CAPACITY = 32  # modes kept before the arrays grow


class Runner:
    """Runs of a switcher along its grid: by the compiled march where that is ready, else by the switcher itself."""

    def __init__(self, switcher: Switcher) -> None:
        self.switcher = switcher
        self.march = compiled_kernel(march) if len(switcher.loop.F) <= MOST_INPUTS else None
        self.packed = None if self.march is None else Packed(switcher)

    def run(self, z0: np.ndarray, r: np.ndarray, v: np.ndarray, jumps: np.ndarray | None, kicks: Kicks,
            bound: float) -> np.ndarray:
        """As `Switcher.run`."""
        if self.packed is None:
            return self.switcher.run(z0, r, v, jumps, kicks, bound)
        steps, N = len(r), len(z0)
        states = np.empty((steps + 1, 1, N))
        states[0, 0] = z0
        q, k, judge = beside(r, v), 0, np.array([0.0, np.inf, np.inf, np.inf, bound])
        for stop in [*sorted(kicks), steps]:
            at, lost = self.along(states[k].copy(), k, stop, states, q, jumps, judge)
            if lost[0]:
                return states[:at[0] + 1, 0]
            if stop < steps:
                with np.errstate(over="ignore", invalid="ignore"):
                    after = self.switcher.careful(states[stop, 0], r[stop], v[stop], kicks[stop])
                states[stop + 1, 0] = after if jumps is None else after + jumps[stop]
                if not np.abs(states[stop + 1]).max() < bound:
                    return states[:stop + 1, 0]
            k = stop + 1
        return states[:, 0]

    def along(self, Z: np.ndarray, k: int, end: int, out: np.ndarray, q: np.ndarray, jumps: np.ndarray | None,
              judge: np.ndarray, last: np.ndarray | None = None, lost: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """All runs Z (runs, N) from step k to step `end`, in place: where each stopped, and which are lost; see `march`."""
        assert self.march is not None and self.packed is not None
        runs, N = Z.shape
        at = np.full(runs, k)
        last = np.full(runs, -1) if last is None else last
        lost = np.zeros(runs, dtype=bool) if lost is None else lost
        push = np.zeros((0, N)) if jumps is None else as_kernel_array(jumps)
        while True:
            work = partial(self.march, Z, at, end, out, q, push, judge, last, lost, *self.packed.given())
            missing = run_in_threads(work, runs, end - k) - {-1}
            if not missing:
                return at, lost
            for code in missing:
                self.packed.add(code)


def beside(r: np.ndarray, v: np.ndarray) -> np.ndarray:
    """q = (1, r, v) of each step, or a single row where neither acts."""
    if not (r.any() or v.any()):
        return np.eye(1, 1 + r.shape[1] + v.shape[1])
    return np.hstack([np.ones((len(r), 1)), r, v])


@dataclass
class Packed:
    """The modes of a switcher met so far, in arrays that grow: what `kernels.clipped.march` wants from `slot` on.

    q = (1, r, v) acts beside the states z (N,): `force` (N, 1 + m + p) is its way into ż.
    """

    switcher: Switcher
    slot: np.ndarray = field(init=False)
    limits: np.ndarray = field(init=False)
    arrays: list[np.ndarray] = field(init=False)  # within, counts, flow, read, rate, taylor, short
    met: int = 0

    def __post_init__(self) -> None:
        w, (m, N) = self.switcher, self.switcher.loop.F.shape
        nq, free = 1 + m + w.loop.E.shape[1], w.mode_of(np.zeros(m, dtype=np.int8))
        self.slot = np.full(3**m, -1)
        self.limits = np.array([w.u_min, w.u_max, w.slack, LIMIT_ROUNDING * np.abs(w.loop.F).sum(axis=1)])
        flow = len(free.flow), N + nq, _padded(N + 2 * m)
        shapes = (2, m), (3,), flow, (N + nq, _padded(2 * m)), (N + nq, N), (N, TERMS * N), ()
        self.arrays = [np.zeros((min(FIRST_CAPACITY, 3**m), *shape), dtype=int if i == 1 else float) for i, shape in enumerate(shapes)]
        self.add((len(self.slot) - 1) // 2)

    def add(self, code: int) -> None:
        """Make room for the mode of this code, Σ (sign + 1) 3ⁱ, and fill it in."""
        w, m, s = self.switcher, len(self.limits[0]), self.met
        mode = w.mode_of((code // 3**np.arange(m) % 3 - 1).astype(np.int8))
        if s == len(self.arrays[0]):
            self.arrays = [np.concatenate([part, np.zeros_like(part)]) for part in self.arrays]
        flow = self.arrays[2]
        if flow.shape[1] < len(mode.flow):
            more = np.zeros((len(flow), len(mode.flow) - flow.shape[1], *flow.shape[2:]))
            self.arrays[2] = np.concatenate([flow, more], axis=1)
        with np.errstate(over="ignore", invalid="ignore"):  # an overflow shows as inf and ends the run
            self._fill(s, mode)
        self.slot[code] = s
        self.met += 1

    def _fill(self, s: int, mode: Mode) -> None:
        loop, slack = self.switcher.loop, self.switcher.slack
        within, counts, flow, read, rate, taylor, short = self.arrays
        (m, N), p = loop.F.shape, loop.E.shape[1]
        force = np.empty((N, 1 + m + p))
        force[:, 0] = np.where(mode.free, 0.0, mode.held) @ loop.Bs.T
        force[:, 1:1 + m] = loop.Bc + loop.Bs * mode.free
        force[:, 1 + m:] = loop.E
        now = np.zeros((2 * m, N + 1 + m + p))  # w → u, u̇
        now[:m, :N], now[m:, :N], now[m:, N:] = loop.F, mode.FM, loop.F @ force
        now[:m, N + 1:N + 1 + m] = np.eye(m)
        within[s], counts[s], short[s] = (mode.low - slack, mode.high + slack), (len(mode.flow), mode.first, mode.looks), mode.short
        read[s, :, :2 * m] = now.T
        rate[s, :N], rate[s, N:], taylor[s] = mode.M.T, force.T, mode.taylor.T
        for level, (Phi, Phi1) in enumerate(mode.flow):
            later = flow[s, level]
            later[:N, :N], later[N:, :N] = Phi.T, (Phi1 @ force).T
            later[:, N:N + 2 * m] = later[:, :N] @ now[:, :N].T
            later[N:, N:N + 2 * m] += now[:, N:].T

    def given(self) -> tuple[object, ...]:
        """The last arguments of `march`."""
        return self.slot, self.limits, np.ascontiguousarray(self.switcher.loop.F), *self.arrays, self.switcher.h


def _padded(count: int) -> int:
    return -(-count // 8) * 8
