"""Compute the numbers in the derivation of lesson 7: force at start, compensator, ceiling."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .knobs import APPLIED
from .study import ANGLE, CART_PLANT, Study, ceiling, start_state


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """The force asked for and given at t = 0, traces, and the unstable mode with its angle beyond which nothing helps."""
    design, K = outcome.design, outcome.gains["K"]
    A, B, limit = CART_PLANT.A, CART_PLANT.B, design["u_max"]
    xhat0 = np.array(start_state(design["angle0"], design["error0"])[1])
    asked = float(-(K @ xhat0)[0])
    given = float(np.clip(asked, -limit, limit))
    told = given if design["fed"] == APPLIED else asked
    values, vectors = np.linalg.eig(A.T)
    unstable = int(np.argmax(np.real(values)))
    q = np.real(vectors[:, unstable] / vectors[ANGLE, unstable])[None]
    rate, qB = float(values[unstable].real), float((q @ B)[0, 0])
    highest = ceiling(CART_PLANT, limit)
    return {
        "K_theta": float(K[0, ANGLE]), "theta": float(xhat0[ANGLE]), "asked": asked,
        "given": given, "missing": given - asked, "told": told, "leak": given - told,
        **derived_own(outcome), "qA": float((q @ A)[0, ANGLE]), "rate": rate,
        "qB": qB, "q3": float(q[0, 2]), "q4": float(q[0, 3]), "B3": float(B[2, 0]), "B4": float(B[3, 0]),
        "size": abs(qB), "u_max": limit, "ceiling_rad": float(np.radians(highest)), "degrees": float(np.degrees(1.0)),
        "per_newton": highest / limit}


def derived_own(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """The compensator left to itself on any plant where no input reaches an output at once."""
    plant, K, L = outcome.study.here.model.plant, outcome.gains["K"], outcome.gains["L"]
    A, B, C = plant.A, plant.B, plant.C
    if np.any(plant.D):
        return {}
    alone = A - B @ K - L @ C
    return {"trace_o": float(np.trace(A - L @ C)), "trace_BK": float(np.trace(B @ K)), "trace_c": float(np.trace(alone)),
            "windup": float(max(np.linalg.eigvals(alone).real))}
