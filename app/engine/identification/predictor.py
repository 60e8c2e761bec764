"""Predict a record one step ahead with a constant gain; B, D and the start by least squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..systems.errors import EngineError
from ..systems.recursions import affine_scan
from .windows import segments_of

__all__ = ["Pieces", "filled_pieces", "fitted_inputs", "pieces_of", "prediction_errors"]

MAX_FIT_ROWS = 20_000  # rows that B, D, Q and R are fitted to
SETTLING = 2  # rows behind a gap that do not count


@dataclass(frozen=True, eq=False)
class Pieces:
    """Stretches of a record without a gap, as pairs (u, y); `rows` counts all of their rows, `left_out` what was not taken.

    `counted` says for each stretch which rows count: those that were measured, where gaps are filled; None where all count.
    """

    pairs: tuple[tuple[np.ndarray, np.ndarray], ...]
    rows: int
    left_out: int
    counted: tuple[np.ndarray, ...] | None = None

    def kept(self, piece: int, rows: np.ndarray) -> np.ndarray:
        """Of the rows of a piece those that count."""
        return rows if self.counted is None else rows[self.counted[piece]]


def pieces_of(u: np.ndarray, y: np.ndarray, shortest: int) -> Pieces:
    """The longest stretches of at least `shortest` rows, up to 20 000 rows together. Raises EngineError where there is none."""
    found = sorted(segments_of(y, shortest), key=lambda piece: piece[0] - piece[1])
    taken, rows = [], 0
    for a, b in found[:8]:
        b = min(b, a + MAX_FIT_ROWS - rows)
        if b - a >= shortest:
            taken.append((u[a:b], y[a:b]))
            rows += b - a
    if not taken:
        raise EngineError("No stretch of {length} rows is without a gap; Q and R cannot be fitted to this record.", length=shortest)
    return Pieces(tuple(taken), rows, len(y) - rows)


def filled_pieces(u: np.ndarray, y: np.ndarray, seen: np.ndarray) -> Pieces:
    """One stretch whose gaps are filled: a row counts if it was measured and so were the two rows before it.

    The constant gain of the fit is that of a filter without gaps; behind a gap the true one is larger for a few rows.
    """
    u, y, seen = u[:MAX_FIT_ROWS], y[:MAX_FIT_ROWS], seen[:MAX_FIT_ROWS]
    settled = seen.copy()
    for lag in range(1, 1 + SETTLING):
        settled[lag:] &= seen[:-lag]
    counted = settled if settled.sum() >= 0.3 * seen.sum() else seen
    return Pieces(((u, y),), int(counted.sum()), len(seen) - int(counted.sum()), (counted,))


def prediction_errors(A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray, K: np.ndarray, starts: np.ndarray,
                      pieces: Pieces) -> np.ndarray:
    """e = y − C x̂ − D u with x̂⁺ = A x̂ + B u + K e, from one start x̂₀ for each piece (pieces, n): (rows, p)."""
    out = []
    for k, ((u, y), start) in enumerate(zip(pieces.pairs, starts, strict=True)):
        x = affine_scan(A - K @ C, u @ (B - K @ D).T + y @ K.T, start, len(y))[:-1]
        out.append(pieces.kept(k, y - x @ C.T - u @ D.T))
    return np.vstack(out)


def fitted_inputs(A: np.ndarray, C: np.ndarray, K: np.ndarray, pieces: Pieces,
                  S: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """B (n×m), D (p×m), the starts (pieces, n) and the errors e (rows, p) that make Σ eᵀ S⁻¹ e least.

    e is linear in all three where the gain K is given: one column of the least squares is the prediction of each entry alone.
    """
    n, p = len(A), len(C)
    m = pieces.pairs[0][0].shape[1]
    white = np.linalg.inv(np.linalg.cholesky(S)).T
    steady, eye = A - K @ C, np.eye(n)
    count = n * m + p * m + n * len(pieces.pairs)
    rows, right = [], []
    for k, (u, y) in enumerate(pieces.pairs):
        table = np.zeros((len(y), p, count))
        at = 0
        for j in range(m):
            for i in range(n):
                table[:, :, at] = affine_scan(steady, np.outer(u[:, j], eye[i]), np.zeros(n), len(y))[:-1] @ C.T
                at += 1
        for j in range(m):
            for l in range(p):
                table[:, :, at] = affine_scan(steady, -np.outer(u[:, j], K[:, l]), np.zeros(n), len(y))[:-1] @ C.T
                table[:, l, at] += u[:, j]
                at += 1
        for i in range(n):
            table[:, :, at + k * n + i] = affine_scan(steady, None, eye[i], len(y))[:-1] @ C.T
        rows.append(np.einsum("tpc,pq->tqc", pieces.kept(k, table), white).reshape(-1, count))
        past = affine_scan(steady, y @ K.T, np.zeros(n), len(y))[:-1]
        right.append((pieces.kept(k, y - past @ C.T) @ white).reshape(-1))
    left, wanted = np.vstack(rows), np.concatenate(right)
    size = np.sqrt((left**2).sum(axis=0))
    size[size == 0] = 1.0
    found = np.linalg.lstsq(left / size, wanted, rcond=1e-10)[0]
    e = (wanted - left / size @ found).reshape(-1, p) @ np.linalg.inv(white)
    found = found / size
    return (found[:n * m].reshape(m, n).T, found[n * m:n * m + p * m].reshape(m, p).T, found[n * m + p * m:].reshape(-1, n), e)
