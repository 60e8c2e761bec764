"""Compute the numbers in the derivation of lesson 20: inertia, torque, det(A − LC)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome
from observer_lab.plants.arm import ANGLE_INDEX, LOAD_INDEX, MOTOR_DATA, PARAMETERS

from .loop import ARM_PLANT, gains
from .study import Study


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Of the observer with a state for the load alone: without it there is nothing that finds the load."""
    p, m, design = PARAMETERS, MOTOR_DATA, outcome.design
    known: dict[str, Value] = {"Ja": p.arm, "N": p.ratio, "Jr": m.rotor, "J": p.inertia, "Nk": p.torque, "k": m.torque_constant}
    if not design["load_state"]:
        return known
    L = outcome.gains["L"]
    K, _ = gains(design.with_values(cancel=True))
    error = ARM_PLANT.A - L @ ARM_PLANT.C
    poles = np.linalg.eigvals(error)
    return known | {
        "trace": float(np.trace(error)),
        "trace_A": float(np.trace(ARM_PLANT.A)),
        "l3": float(L[ANGLE_INDEX, 0]),
        "l4": float(L[LOAD_INDEX, 0]),
        "R": m.resistance,
        "Lm": m.inductance,
        "det": float(np.linalg.det(error)),
        "product": float(np.prod(poles).real),
        "K1": float(K[0, 0]),
        "K4": float(K[0, LOAD_INDEX]),
        "tau": float(design["load"]),
        "u": float(m.resistance * design["load"] / p.torque),
        "i": float(design["load"] / p.torque),
    }
