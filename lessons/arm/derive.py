"""The numbers that stand now in the derivation of lesson 20: inertia and torque, the determinant of A − LC, what cancels the load."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.lesson.derivation import Value
from app.lesson.lesson import Outcome
from app.plants.arm import ANGLE, LOAD, PARAMETERS, SHEET

from .study import Study
from .system import PLANT, gains


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Of the observer with a state for the load alone: without it there is nothing that finds the load."""
    p, m, design = PARAMETERS, SHEET, outcome.design
    known: dict[str, Value] = {"Ja": p.arm, "N": p.ratio, "Jr": m.rotor, "J": p.inertia, "Nk": p.torque, "k": m.torque_constant}
    if not design["load_state"]:
        return known
    L = outcome.gains["L"]
    K, _ = gains(design.with_values(cancel=True))
    error = PLANT.A - L @ PLANT.C
    poles = np.linalg.eigvals(error)
    return known | {
        "trace": float(np.trace(error)), "trace_A": float(np.trace(PLANT.A)), "l3": float(L[ANGLE, 0]), "l4": float(L[LOAD, 0]),
        "R": m.resistance, "Lm": m.inductance, "det": float(np.linalg.det(error)), "product": float(np.prod(poles).real),
        "K1": float(K[0, 0]), "K4": float(K[0, LOAD]), "tau": float(design["load"]),
        "u": float(m.resistance * design["load"] / p.torque), "i": float(design["load"] / p.torque)}
