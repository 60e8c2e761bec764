"""Compute the covariances of a linear filter by a compiled kernel, where one is ready."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...kernels import as_kernel_array, compiled_kernel
from ...kernels.recursion import Schedule, Target

FIRST_ROOM = 512  # steps stored before the arrays grow
BUFFER_GROWTH = 32

Goal = tuple[np.ndarray, np.ndarray] | None


def quick_schedule(function: Callable[..., int], fixed: tuple[np.ndarray, ...], spread: np.ndarray, sizes: tuple[int, int, int],
                   seen: np.ndarray | None, goal: Goal, every: int) -> tuple[np.ndarray, ...] | None:
    """P[k|k−1], P[k|k], S and M of the `steps` of sizes = (steps, n, p), or fewer where it settles at its goal.

    None where the kernel is not ready, or where it met what the plain way has to judge.
    """
    work = compiled_kernel(function)
    if work is None:
        return None
    steps, n, p = sizes
    shapes = (n, n), (n, n), (p, p), (n, p)
    heard = np.zeros((0, p), dtype=bool) if seen is None else np.ascontiguousarray(seen)
    wanted = (np.zeros((n, n)), np.zeros((n, n)), 0) if goal is None else (as_kernel_array(goal[0]), as_kernel_array(goal[1]), every)
    fixed, spread = tuple(map(as_kernel_array, fixed)), np.array(spread, dtype=float, order="C")
    room, k = min(steps, FIRST_ROOM), 0
    stored = tuple(np.empty((room, *shape)) for shape in shapes)
    while k < steps:
        if k == room:
            room = min(steps, BUFFER_GROWTH * room)
            stored = tuple(np.concatenate([part, np.empty((room - k, *part.shape[1:]))]) for part in stored)
        done = work(*fixed, spread, heard[k:room], Target(*wanted), Schedule(*(part[k:] for part in stored)))
        if done < 0:
            return None
        k += done
        if k < room:
            break
    return stored if k == steps else tuple(part[:k].copy() for part in stored)
