"""Compute the numbers in the derivation of lesson 11: A E + B F = Φ of the horizontal loop."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome
from observer_lab.engine import EngineError
from observer_lab.engine.design import polynomial_roots
from observer_lab.plants.platform import model
from observer_lab.plants.platform import siso_loops as siso

from .loops import lower_of
from .study import Study

ZERO_POLE_RAD_S = 1e-6  # rad/s: the zero at s = 0


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Values of the polynomials of the controller that the boards ask for, used now or not; nothing where there is none."""
    design, S = outcome.design, outcome.gains["S"]
    try:
        placed = siso.horizontal_by_poles(design["control_poles"], design["observer_poles"], S,
                                          model.Parameters(lower=lower_of(design)))
    except EngineError:
        return {}
    A, B, E, F, poles = placed.A, placed.B, placed.E, placed.F, (*design["control_poles"], *design["observer_poles"])
    zeros = polynomial_roots(B)
    zero = max(zeros, key=lambda z: (abs(z) > ZERO_POLE_RAD_S, z.imag))
    p = poles[0]

    def size(polynomial: np.ndarray, s: complex) -> float:
        return float(abs(np.polyval(polynomial, s)))
    return {
        "deg_A": float(len(A) - 1), "deg_E": float(len(E) - 1), "deg_Phi": float(len(poles)), "unknowns": float(len(E) - 1 + 4),
        "A_0": float(A[-1]), "E_0": float(E[-1]), "B_0": float(B[-1]), "F_0": float(F[-1]), "Phi_0": float(np.real(np.prod(poles))),
        "Phi_z": float(abs(np.prod(zero - np.array(poles)))), "A_z": size(A, zero), "E_z": size(E, zero),
        "F_p": size(F, p), "B_p": size(B, p), "E_p": size(E, p), "A_p": size(A, p), "loop_p": 1.0}
