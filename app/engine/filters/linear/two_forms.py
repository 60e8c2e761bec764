"""Compute covariances by Joseph's or the short form, in double or single precision."""

from __future__ import annotations

import numpy as np

from ...systems.gates.argument_checks import BOOLEAN, choice, count, matrix, optional, takes
from .kalman import joseph, short_form

__all__ = ["FORMS", "posterior_covariances"]

FORMS = ("joseph", "short")


@takes(A=matrix("n n"), C=matrix("p n"), Q=matrix("n n"), R=matrix("p p"), P=matrix("n n"), steps=count(1, 1_000_000),
       form=choice(*FORMS), gain=optional(matrix("n p")), single=BOOLEAN)
def posterior_covariances(A: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray, P: np.ndarray, *, steps: int = 1,
                          form: str = "joseph", gain: np.ndarray | None = None, single: bool = False) -> np.ndarray:
    """P[k|k] (steps, n, n) from P[0|−1] = P by P[k|k] = (I − M C) P[k|k−1] (…)ᵀ + M R Mᵀ, or (I − M C) P[k|k−1], and
    P[k+1|k] = A P[k|k] Aᵀ + Q, all of it in single precision if asked; report on the platform, equations (55)–(59).

    A, Q, P n×n, C p×n, R p×p in the units that the filter has. M is the optimal gain of each step or one `gain` (n×p) for
    all. What rounding leaves uneven stays so. Raises ShapeError, EngineError.

    >>> one = np.eye(1)
    >>> posterior_covariances(one, one, 0 * one, one, one, steps=3)[:, 0, 0].round(4)
    array([0.5   , 0.3333, 0.25  ])
    """
    size = np.float32 if single else np.float64
    A, C, Q, R, P = (np.asarray(M, dtype=size) for M in (A, C, Q, R, P))
    record = np.empty((steps, len(A), len(A)))
    for k in range(steps):
        M = _best(P, C, R) if gain is None else gain
        P = joseph(P, C, R, M) if form == "joseph" else short_form(P, C, M)
        record[k] = P
        P = A @ P @ A.T + Q
    return record


def _best(P: np.ndarray, C: np.ndarray, R: np.ndarray) -> np.ndarray:
    CP = C @ P
    S = CP @ C.T + R
    try:
        return np.linalg.solve(S, CP).T
    except np.linalg.LinAlgError:  # single precision may lose R beside C P Cᵀ
        return (np.linalg.pinv(S) @ CP).T
