"""Compress the past and future windows of a record to a triangular factor for each block of rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr

from ..systems.errors import EngineError

__all__ = ["Factors", "factors_of", "segments_of", "triangle_of"]

CHUNK = 20_000  # rows of windows in memory at one time
BLOCKS = 20  # parts of the record; leaving each out gives the spread of an estimate
RANK = 1e-7  # of the largest diagonal entry: below it the inputs do not excite the plant


@dataclass(frozen=True, eq=False)
class Factors:
    """Triangular factors R_b of the windows of a record, one for each block b; the Gram matrix is the sum of R_bᵀ R_b.

    A row of windows is [future inputs, past inputs and outputs, future outputs]. `past` and `future` are numbers of steps,
    m and p the numbers of inputs and outputs, `count` the number of windows without a missing value.
    """

    blocks: tuple[np.ndarray, ...]
    past: int
    future: int
    m: int
    p: int
    count: int

    @property
    def sizes(self) -> tuple[int, int, int]:
        """Numbers of columns: future inputs, past inputs and outputs, future outputs."""
        return self.future * self.m, self.past * (self.m + self.p), self.future * self.p

    def whole(self) -> np.ndarray:
        """Return the lower factor L of the whole record, with L Lᵀ its Gram matrix.

        Raises EngineError if the inputs do not excite the plant.
        """
        L = triangle_of(np.vstack(self.blocks)).T
        known = sum(self.sizes[:2])
        size = np.abs(np.diag(L))[:known]
        if self.m and (size[:self.sizes[0]] < RANK * size.max()).any():
            raise EngineError("The inputs of this record do not excite the plant enough; it needs inputs that change often, as steps "
                              "at random times.")
        return L

    def left_out(self) -> list[np.ndarray]:
        """Return the lower factor of the record without block b, for each block b."""
        grams = np.array([R.T @ R for R in self.blocks])
        total = grams.sum(axis=0)
        tiny = 1e-14 * np.diag(np.diag(total))
        return [np.linalg.cholesky(total - each + tiny) for each in grams]


def triangle_of(rows: np.ndarray) -> np.ndarray:
    """Return the upper factor R of a table of rows, with RᵀR its Gram matrix."""
    R: np.ndarray = qr(rows, mode="r", check_finite=False)[0]
    return R[:rows.shape[1]]


def segments_of(y: np.ndarray, shortest: int) -> list[tuple[int, int]]:
    """Return (first, last + 1) of each stretch of rows of y that has no missing value and at least `shortest` rows."""
    seen = np.concatenate([[False], np.isfinite(y).all(axis=1), [False]])
    edges = np.flatnonzero(np.diff(seen.astype(int)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2) if b - a >= shortest]


def factors_of(u: np.ndarray, y: np.ndarray, past: int, future: int) -> Factors:
    """Return the factors of inputs u (n_t, m) and outputs y (n_t, p); a missing output is NaN.

    Raises EngineError if the record is too short.
    """
    m, p = u.shape[1], y.shape[1]
    width = future * (m + p) + past * (m + p)
    starts = np.concatenate([np.arange(a, b - past - future + 1) for a, b in segments_of(y, past + future)] or [np.zeros(0, dtype=int)])
    if len(starts) < 2 * width:
        raise EngineError("This fit needs {least} complete windows of {length} steps, and the record has {count}; "
                          "give more rows or a lower order.", count=len(starts), length=past + future, least=2 * width)
    blocks = tuple(_factor(u, y, each, past, future) for each in np.array_split(starts, min(BLOCKS, len(starts) // past)))
    return Factors(blocks, past, future, m, p, len(starts))


def _factor(u: np.ndarray, y: np.ndarray, starts: np.ndarray, past: int, future: int) -> np.ndarray:
    """Return the factor R of the windows that begin at these rows, computed chunk by chunk."""
    R = np.zeros((0, future * (u.shape[1] + y.shape[1]) + past * (u.shape[1] + y.shape[1])))
    back, ahead = np.arange(past), past + np.arange(future)
    for chunk in np.array_split(starts, -(-len(starts) // CHUNK)):
        at = chunk[:, None]
        parts = u[at + ahead], y[at + back], u[at + back], y[at + ahead]
        rows = np.hstack([part.reshape(len(chunk), -1) for part in parts])
        R = triangle_of(np.vstack([R, rows]))
    return R


