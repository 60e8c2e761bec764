"""Compute the numbers in the derivation of lesson 2: error matrix, solution, polynomial."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import expm

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .knobs import AS_PRINTED
from .notes_page import PLANT
from .study import Setting, Study

COMPARISON_RUN_SHARE = 0.1  # of the run: when the solution is compared with it


def derived(here: Setting, outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Matrices, start and solution; the polynomial of a plant of two states with one output.

    Nothing where the observer runs the matrix of the notes or leaves D u out: there it copies another plant.
    """
    run, plant, L = outcome.run, outcome.study.plant, outcome.gains["L"]
    if run is None or outcome.design["method"] == AS_PRINTED or outcome.study.forgets:
        return {}
    F = plant.A - L @ plant.C
    known: dict[str, Value] = {
        "A": plant.A, "B": plant.B, "C": plant.C, "D": plant.D, "L": L, "LC": L @ plant.C, "LD": L @ plant.D, "BLD": plant.B - L @ plant.D,
        "F": F, "x0": run.x[:1].T, "xhat0": run.xhat[:1].T, "e0": run.e[:1].T}
    index = round(COMPARISON_RUN_SHARE * here.horizon / here.dt)
    if not run.scenario.impulses and index < len(run.t):
        time = float(run.t[index])
        known |= {"time": time, "Phi": expm(F * time), "e_run": run.e[index:index + 1].T}
    if here.notes and plant is PLANT:
        l1, l2 = (float(v) for v in L[:, 0])
        poles = outcome.poles["observer"]
        known |= {"l1": l1, "l2": l2, "c1": float(-np.trace(F)), "c0": float(np.linalg.det(F)),
                  "phi": float(np.real(poles.prod())) * np.eye(2) + float(-np.real(poles.sum())) * plant.A + plant.A @ plant.A,
                  "Oinv": np.linalg.inv(np.vstack([plant.C, plant.C @ plant.A])), "last": np.array([[0.0], [1.0]]),
                  "sum": float(np.real(poles.sum())), "product": float(np.real(poles.prod()))}
    return known
