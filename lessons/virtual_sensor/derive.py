"""Compute the numbers in the derivation of lesson 1: matrices of the assumed plant, gain."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .study import Study


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Entries, trace and determinant of the model's A and of A − LC, and L at full trust."""
    belief, L, full = outcome.study.here.belief, outcome.gains["L"], outcome.study.here.full
    A, F, poles = belief.A, belief.A - L @ belief.C, np.asarray(outcome.design["observer_poles"])
    return {
        **derived_own(outcome), "a11": float(A[0, 0]), "a12": float(A[0, 1]), "a21": float(A[1, 0]), "a22": float(A[1, 1]),
        "l1": float(L[0, 0]), "l2": float(L[1, 0]), "c1": float(-np.trace(F)), "c0": float(np.linalg.det(F)),
        "sum": float(poles.sum().real), "product": float(poles.prod().real), "full1": float(full[0, 0]), "full2": float(full[1, 0])}


def derived_own(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """A, LC and A − LC of any plant; the pace of the copy where it has two states and real poles."""
    belief, L = outcome.study.here.belief, outcome.gains["L"]
    known: dict[str, Value] = {"A": belief.A, "LC": L @ belief.C, "F": belief.A - L @ belief.C}
    trace, det = float(np.trace(belief.A)), float(np.linalg.det(belief.A))
    if belief.n == 2 and trace**2 >= 4 * det:
        known |= {"trace": trace, "det": det, "slow": float(np.real(belief.poles).max())}
    return known
