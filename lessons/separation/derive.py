"""Compute the numbers in the derivation of lesson 4: traces and determinants of the loop."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .study import Study


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Traces and determinants: those of the loop from its own coordinates (x, x̂), those of the blocks by themselves.

    Without numbers of the whole loop where the observer copies another plant: there the derivation does not hold.
    """
    belief, truth = outcome.study.driven.belief, outcome.study.driven.truth
    K, L = outcome.gains["K"], outcome.gains["L"]
    BK, LC = belief.B @ K, L @ belief.C
    known: dict[str, Value] = {
        "n": float(belief.n), "states": float(len(outcome.study.loop.A_xxhat)), "trace_A": float(np.trace(belief.A)),
        "trace_BK": float(np.trace(BK)), "trace_LC": float(np.trace(LC)),
        "trace_c": float(np.trace(belief.A - BK)), "trace_o": float(np.trace(belief.A - LC)),
        "det_c": float(np.linalg.det(belief.A - BK)), "det_o": float(np.linalg.det(belief.A - LC))}
    if np.array_equal(belief.A, truth.A) and np.array_equal(belief.B, truth.B):
        whole = outcome.study.loop.A_xxhat
        known |= {"trace_loop": float(np.trace(whole)), "det_loop": float(np.linalg.det(whole))}
    return known
