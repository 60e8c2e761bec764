"""Compute the numbers in the derivation of lesson 19: weakest mode and the gain to move it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .study import Study

HIDDEN_MODE_RTOL = 1e-12  # of the largest singular value: below it a mode counts as hidden and has no price


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Both parts of the least singular vector at that mode, what A − LC makes of it, and the size of L."""
    run, L = outcome.run, outcome.gains["L"]
    assert run is not None
    A, C = run.scenario.plant.A, run.scenario.plant.C
    eye = np.eye(len(A))
    stacks = [np.vstack([A - mode * eye, C]) for mode in np.linalg.eigvals(A)]
    k = int(np.argmin([np.linalg.svd(stack, compute_uv=False)[-1] for stack in stacks]))
    _, values, right = np.linalg.svd(stacks[k])
    v, d = right[-1].conj(), float(values[-1])
    parts = stacks[k] @ v
    left = np.hstack([eye, -L])
    moved = left @ stacks[k]
    delta, normL = float(np.linalg.svd(moved, compute_uv=False)[-1]), float(np.linalg.norm(L, 2))
    known: dict[str, Value] = {
        "up": float(np.linalg.norm(parts[:len(A)])), "down": float(np.linalg.norm(parts[len(A):])), "d": d,
        "moved": float(np.linalg.norm(moved @ v)), "factor": float(np.linalg.norm(left, 2)), "normL": normL,
        "most": d * float(np.linalg.norm(left, 2)), "delta": delta}
    return known | {"ratio": delta / d} if d > HIDDEN_MODE_RTOL * values[0] else known
