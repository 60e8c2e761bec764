"""Give the derivation's numbers: from gain and innovations of a settled filter back to R."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .study import Study


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """S, C P Cᵀ and R of the settled filter, and C A⁻¹ K and C M by two ways; of the first output."""
    if outcome.study.found.fitted.biases:
        return {}
    kf = outcome.study.found.fitted.kalman(factor=outcome.study.factor)
    P = kf.steady.solution
    S = kf.C @ P @ kf.C.T + kf.R
    if len(S) > 1:
        return {}
    M = np.linalg.solve(S, kf.C @ P).T
    K = kf.A @ M
    back = float((kf.C @ np.linalg.solve(kf.A, K)).item())
    state = float((kf.C @ P @ kf.C.T).item())
    return {"S": float(S.item()), "seen": state, "R": float(kf.R.item()), "CM": float((kf.C @ M).item()), "CAK": back}
