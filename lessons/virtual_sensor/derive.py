"""Compute the numbers in the derivation of lesson 1: matrices of the assumed chip, gain."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome
from observer_lab.engine import observer_gain
from observer_lab.plants import Model

from .study import Study, believed


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Entries, trace and determinant of the model's A and of A − LC, and L at full trust."""
    design, L = outcome.design, outcome.gains["L"]
    belief = believed(design["plant"], design["air_error"])
    A, F = belief.A, belief.A - L @ belief.C
    poles = np.asarray(design["observer_poles"])
    full = observer_gain(A, belief.C, design["observer_poles"]).gain
    return {
        "A": A, "LC": L @ belief.C, "F": F, "trace": float(np.trace(A)), "det": float(np.linalg.det(A)),
        "slow": float(np.real(belief.poles).max()), "a11": float(A[0, 0]), "a12": float(A[0, 1]), "a21": float(A[1, 0]),
        "a22": float(A[1, 1]),
        "l1": float(L[0, 0]), "l2": float(L[1, 0]), "c1": float(-np.trace(F)), "c0": float(np.linalg.det(F)),
        "sum": float(poles.sum().real), "product": float(poles.prod().real), "full1": float(full[0, 0]), "full2": float(full[1, 0])}


def derived_own(model: Model, outcome: Outcome[object]) -> Mapping[str, Value]:
    """A, LC and A − LC of a person's own plant; the pace of the copy where it has two states and real poles."""
    A, C, L = model.plant.A, model.plant.C, outcome.gains["L"]
    known: dict[str, Value] = {"A": A, "LC": L @ C, "F": A - L @ C}
    trace, det = float(np.trace(A)), float(np.linalg.det(A))
    if model.plant.n == 2 and trace**2 >= 4 * det:
        known |= {"trace": trace, "det": det, "slow": float(np.real(model.plant.poles).max())}
    return known
