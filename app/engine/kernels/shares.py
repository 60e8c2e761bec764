"""Many runs on as many threads as there are cores: kernels let go of Python's lock."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np

__all__ = ["in_shares"]

WORTH = 20_000  # steps of all runs together that more than one thread shares
MOST = 4  # threads


def in_shares(work: Callable[[int, int], int], runs: int, steps: int) -> set[int]:
    """What work(begin, stop) says of its share of the runs, each of so many steps."""
    shares = _threads() if runs * steps >= WORTH else 1
    edges = np.linspace(0, runs, shares + 1).astype(int).tolist()
    each = map if shares == 1 else _pool().map
    return set(each(work, edges[:-1], edges[1:]))


def _threads() -> int:
    return min(MOST, os.cpu_count() or 1)


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(_threads(), thread_name_prefix="runs")
