"""Compute the numbers in the derivation of lesson 6: common and relative motion apart."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .knobs import COMMON, RELATIVE, Case

ENTRY_ROUNDING = 1e-12


def derived(outcome: Outcome[Case]) -> Mapping[str, Value]:
    """A on the common motion, A − LC on the relative one, and their determinants; nothing where the sensor sees both."""
    plant, L = outcome.study.model.plant, outcome.gains["L"]
    N, M = np.sqrt(2) * COMMON.T, np.sqrt(2) * RELATIVE.T
    H = COMMON @ plant.A @ N / np.sqrt(2)
    if not outcome.study.unseen or np.abs(plant.C @ N).max() > ENTRY_ROUNDING or np.abs(plant.A @ N - N @ H).max() > ENTRY_ROUNDING:
        return {}
    F = plant.A - L @ plant.C
    F_rho = RELATIVE @ F @ M / np.sqrt(2)
    bolts = np.array(outcome.study.unseen)
    return {
        "N": N, "H": H, "FN": F @ N, "NH": N @ H, "F_rho": F_rho, "det_H": float(np.linalg.det(H)), "det_F": float(np.linalg.det(F_rho)),
        "det_all": float(np.linalg.det(F)), "trace_H": float(np.trace(H)), "rate_sum": float(bolts.sum().real),
        "rate_product": float(bolts.prod().real)}
