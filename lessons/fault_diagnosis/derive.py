"""Compute the numbers in the derivation of lesson 17: innovation, χ² test, ignored coil."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .diagnosis import ENERGY
from .fault_pairs import PAIRS, pair_bank, rank_of
from .observer_bank import DT, MODEL, SENSOR_SIGMA, guard
from .results import Study
from .study import between

MICRO = 1e6  # mm²/s² in a m²/s²
SENSOR_COUNT = 4  # members that leave one out and read the others as they are


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Entry 11 of S and its parts, degrees of freedom, alarms an hour, the least lasting fault, and C b of the coil in question."""
    s = outcome.study
    column = 0 if s.column is None else s.column
    S, R = MICRO * float(guard().bank.members[column].S[0, 0]), MICRO * SENSOR_SIGMA**2
    N, coil = s.test.window, s.case.coil or 0
    Cb = MODEL.plant.C @ MODEL.plant.B[:, [coil]]
    known: dict[str, Value] = {
        "count": float(N if s.test.statistic == ENERGY else 1), "dof": float(s.test.dof), "alpha": s.test.rate, "N": float(N), "dt": DT,
        "side": N * DT / s.test.rate, "bank": between(s),
        "sooner": N * DT / s.test.rate / between(s), "needed": s.test.needed, "least": float(s.test.needed / N) ** 0.5,
        "inner": float((Cb.T @ Cb)[0, 0]), "size": float(np.linalg.norm(Cb)), "one": 1.0,
        "pairs": float(len(PAIRS)), "rank": float(rank_of(frozenset(s.pair or PAIRS[0]))), "left": float(pair_bank().dof)}
    if column < SENSOR_COUNT:
        known |= {"S": S, "R": R, "CPC": S - R}
    return known
