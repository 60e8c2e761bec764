"""Run a clipped loop along its grid, compiled where ready, else in NumPy."""

from __future__ import annotations

from functools import partial

import numpy as np

from ..kernels import as_kernel_array, compiled_kernel, run_in_threads
from ..kernels.clipped import march
from .disturbance import Kicks
from .packed_modes import Packed
from .saturation import Switcher

MOST_INPUTS = 8  # 3⁸ ways to be clipped


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
