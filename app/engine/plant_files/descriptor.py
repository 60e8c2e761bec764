"""Solve a descriptor plant E ẋ = A x + B u for its derivative, where E is regular."""

from __future__ import annotations

import numpy as np

from ..systems.errors import EngineError, Phrase, ShapeError
from .notes import note

__all__ = ["solved"]

WORST_CONDITION = 1e12  # of E, beyond which E⁻¹ is rounding


def solved(E: np.ndarray, A: np.ndarray, others: list[np.ndarray], key: str) -> tuple[np.ndarray, list[np.ndarray], tuple[Phrase, ...]]:
    """E⁻¹A, E⁻¹M for each other M, and the note that says so; no note where E = I.

    E and A n×n. Raises EngineError where E is singular or too near to it, ShapeError where it does not fit A.
    """
    if E.shape != A.shape:
        raise ShapeError("{name} must be {n}×{n}, as A is; it is {rows}×{columns}.", name=key, n=len(A), rows=E.shape[0],
                         columns=E.shape[1])
    if not np.isfinite(E).all():
        raise EngineError("{name} must hold finite numbers only.", name=key)
    if np.array_equal(E, np.eye(len(E))):
        return A, others, ()
    rows = np.abs(E).max(axis=1, initial=0.0)
    scaled = E / np.where(rows > 0, rows, 1.0)[:, None]  # the unit of an equation decides nothing
    columns = np.abs(scaled).max(axis=0, initial=0.0)
    condition = float(np.linalg.cond(scaled / np.where(columns > 0, columns, 1.0)))
    if not condition < WORST_CONDITION:
        raise EngineError("{name} is singular: some equations of this plant have no derivative; eliminate them and leave out {name}.",
                          name=key)
    return np.linalg.solve(E, A), [np.linalg.solve(E, M) for M in others], (note("descriptor", condition=condition),)
