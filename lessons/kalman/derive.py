"""Compute the numbers in the derivation of lesson 9: the variance of v_z through one step."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .knobs import VZ_INDEX
from .study import Study

MICRO = 1e6  # mm²/s² in a m²/s²


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Variances of v_z in mm²/s² before and after the sample k, the gain from VL to v_z by both ways, and the next variance."""
    who, k = outcome.study.watcher, int(outcome.design["k"])
    at, kf, schedule = int(who.schedule.index[k]), who.filter, who.schedule
    P, M, S, eye = schedule.prior[at], schedule.gains[at], schedule.S[at], np.eye(who.filter.n)
    keep = eye - M @ kf.C
    scale = np.sqrt(np.diag(P))  # inverses are taken of a correlation: the states' units are decades apart
    inside = np.linalg.inv(P / np.outer(scale, scale)) + (kf.C * scale).T @ np.linalg.solve(kf.R, kf.C * scale)
    posterior = np.linalg.inv(inside) * np.outer(scale, scale)

    def of(matrix: np.ndarray) -> float:
        return MICRO * float(matrix[VZ_INDEX, VZ_INDEX])
    known: dict[str, Value] = {
        "before": of(P), "after": of(schedule.posterior[at]), "kept": of(keep @ P @ keep.T), "noise": of(M @ kf.R @ M.T),
        "gained": of(M @ S @ M.T), "short": of(M @ kf.C @ P), "information": of(posterior), "M": float(M[VZ_INDEX, 0]),
        "M_information": float((posterior @ np.linalg.solve(kf.R, kf.C).T)[VZ_INDEX, 0]),
        "moved": of(kf.A @ schedule.posterior[at] @ kf.A.T), "Q": of(kf.Q)}
    if at + 1 < len(schedule.prior):
        known["next"] = of(schedule.prior[at + 1])
    return known
