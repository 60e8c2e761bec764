"""Split many runs over threads, one for each core."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numpy as np

__all__ = ["run_in_threads"]

WORTH = 20_000  # steps of all runs together that more than one thread shares
MAX_THREADS = 4  # threads


def run_in_threads(work: Callable[[int, int], int], runs: int, steps: int) -> set[int]:
    """What work(begin, stop) says of its share of the runs, each of so many steps."""
    shares = _threads() if runs * steps >= WORTH else 1
    edges = np.linspace(0, runs, shares + 1).astype(int).tolist()
    each = map if shares == 1 else _pool().map
    return set(each(work, edges[:-1], edges[1:]))


def _threads() -> int:
    return min(MAX_THREADS, os.cpu_count() or 1)


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(_threads(), thread_name_prefix="runs")
