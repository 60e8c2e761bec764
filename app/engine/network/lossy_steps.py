"""Step the covariance of a filter whose measurements arrive intermittently."""

from __future__ import annotations

import numpy as np

from ..systems.arrays import symmetric
from ..systems.errors import EngineError
from ..systems.gates.argument_checks import array, matrix, takes

__all__ = ["corrected_covariance", "riccati_path", "riccati_step"]


@takes(P=array("… n n"), C=matrix("p n"), R=matrix("p p"))
def corrected_covariance(P: np.ndarray, C: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Covariances after a measurement in Joseph's form (…, n, n), and the filter gains M = P Cᵀ(C P Cᵀ + R)⁻¹ (…, n, p)."""
    CP = C @ P
    S = CP @ C.T + R
    try:
        if len(C) == 1 and not S.all():
            raise np.linalg.LinAlgError
        M = np.swapaxes(CP / S if len(C) == 1 else np.linalg.solve(S, CP), -1, -2)
    except np.linalg.LinAlgError:
        raise EngineError("The covariance S of the innovation is singular: give every sensor some noise R.") from None
    keep = np.eye(P.shape[-1]) - M @ C
    return keep @ P @ np.swapaxes(keep, -1, -2) + M @ R @ np.swapaxes(M, -1, -2), M


@takes(P=array("… n n"), A=matrix("n n"), C=matrix("p n"), Q=matrix("n n"), R=matrix("p p"), heard=array())
def riccati_step(P: np.ndarray, A: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray, heard: object) -> np.ndarray:
    """P⁺ = A ((1 − h) P + h P|y) Aᵀ + Q for covariances P (…, n, n), P|y being that after the measurement.

    `heard` h (…): 1 where the measurement arrived, 0 where it was lost. In between it is the modified Riccati operator
    g_h(P) of Sinopoli et al., which bounds the mean from above.
    """
    h = np.asarray(heard, dtype=float)[..., None, None]
    mixed = P + h * (corrected_covariance(P, C, R)[0] - P)
    moved = A @ mixed @ A.T
    return symmetric(moved) + Q


def riccati_path(P: np.ndarray, A: np.ndarray, C: np.ndarray, Q: np.ndarray, R: np.ndarray, heard: np.ndarray) -> np.ndarray:
    """P (…, n, n) and what `riccati_step` makes of it, one step for each of `heard` (N, …): (N + 1, …, n, n)."""
    path = np.empty((len(heard) + 1, *np.shape(P)))
    path[0] = P
    for k, share in enumerate(heard):
        path[k + 1] = P = riccati_step(P, A, C, Q, R, share)
    return path
