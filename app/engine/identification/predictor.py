"""Predict a record one step ahead with given gains; B, D and the start by least squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..systems.errors import EngineError
from ..systems.recursions import affine_scan
from .windows import segments_of

__all__ = ["Pieces", "fitted_inputs", "gapped_pieces", "pieces_of", "prediction_errors", "responses"]

MAX_FIT_ROWS = 20_000  # rows that B, D, Q and R are fitted to
MAX_GAPPED_ROWS = 2_000  # of them where a gain belongs to each row


@dataclass(frozen=True, eq=False)
class Pieces:
    """Stretches of a record as pairs (u, y); `rows` counts what was measured in them, p readings a row, `left_out` what was not taken.

    `seen` (N, p) says which readings of the only stretch came; None where all did. A reading that did not is zero in y.
    """

    pairs: tuple[tuple[np.ndarray, np.ndarray], ...]
    rows: int
    left_out: int
    seen: np.ndarray | None = None

    @property
    def readings(self) -> int:
        """Number of readings that came."""
        return sum(y.size for _, y in self.pairs) if self.seen is None else int(self.seen.sum())

    def kept(self, table: np.ndarray) -> np.ndarray:
        """The same (N, p, …) with zeros where no reading came."""
        if self.seen is None:
            return table
        return np.where(self.seen.reshape(*self.seen.shape, *(1,) * (table.ndim - 2)), table, 0.0)


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


def gapped_pieces(u: np.ndarray, y: np.ndarray) -> Pieces:
    """The first rows as one stretch; of each row the readings that came are used."""
    u, y = u[:MAX_GAPPED_ROWS], y[:MAX_GAPPED_ROWS]
    seen = np.isfinite(y)
    rows = round(seen.sum() / y.shape[1])
    return Pieces(((u, np.where(seen, y, 0.0)),), rows, len(y) - rows, seen)


def prediction_errors(A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray, K: np.ndarray, starts: np.ndarray,
                      pieces: Pieces) -> np.ndarray:
    """e = y − C x̂ − D u with x̂⁺ = A x̂ + B u + K e, from one start x̂₀ for each piece (pieces, n): (rows, p).

    K (n, p), or (N, n, p) with a gain for each row of the one piece, zero for readings that did not come; so is their e.
    """
    out = []
    for (u, y), start in zip(pieces.pairs, starts, strict=True):
        forcing = u @ B.T + np.einsum("np,tp->tn" if K.ndim == 2 else "tnp,tp->tn", K, y - u @ D.T)
        x = responses(A - K @ C, forcing[:, :, None], start[:, None])[:, :, 0]
        out.append(pieces.kept(y - x @ C.T - u @ D.T))
    return np.vstack(out)


def fitted_inputs(A: np.ndarray, C: np.ndarray, K: np.ndarray, pieces: Pieces,
                  S: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """B (n×m), D (p×m), the starts (pieces, n) and the errors e (rows, p) that make Σ eᵀ S⁻¹ e least.

    e is linear in all three where the gain is given: one column of the least squares is the prediction of each entry alone. K as in
    `prediction_errors`; S (p, p), or one for each row, that of `gains_of`.
    """
    n, p = len(A), len(C)
    m = pieces.pairs[0][0].shape[1]
    root = np.linalg.cholesky(S)
    inputs, count = n * m + p * m, n * m + p * m + n * len(pieces.pairs)
    rows, right = [], []
    for k, (u, y) in enumerate(pieces.pairs):
        own = slice(inputs + k * n, inputs + (k + 1) * n)
        forcing, begin, at_once = np.zeros((len(y), n, count + 1)), np.zeros((n, count + 1)), np.zeros((len(y), p, count + 1))
        for j in range(m):
            for i in range(n):
                forcing[:, i, j * n + i] = u[:, j]
            for l in range(p):
                at = n * m + j * p + l
                forcing[:, :, at] = -u[:, [j]] * K[..., l]
                at_once[:, l, at] = u[:, j]
        begin[:, own] = np.eye(n)
        forcing[:, :, count] = np.einsum("np,tp->tn" if K.ndim == 2 else "tnp,tp->tn", K, y)
        table = pieces.kept(np.einsum("pn,tnc->tpc", C, responses(A - K @ C, forcing, begin)) + at_once)
        table[:, :, count] -= pieces.kept(y)
        if S.ndim == 2:
            white = np.linalg.solve(root, table.transpose(1, 0, 2).reshape(p, -1)).reshape(p, -1, count + 1).transpose(1, 0, 2)
        else:
            white = np.linalg.solve(root, table)
        rows.append(white[:, :, :count].reshape(-1, count))
        right.append(-white[:, :, count].reshape(-1))
    left, wanted = np.vstack(rows), np.concatenate(right)
    size = np.sqrt((left**2).sum(axis=0))
    size[size == 0] = 1.0
    found = np.linalg.lstsq(left / size, wanted, rcond=1e-10)[0]
    e = np.einsum("pq,tq->tp" if S.ndim == 2 else "tpq,tq->tp", root, (wanted - left / size @ found).reshape(-1, p))
    found = found / size
    return (found[:n * m].reshape(m, n).T, found[n * m:inputs].reshape(m, p).T, found[inputs:].reshape(-1, n), e)


def responses(steady: np.ndarray, forcing: np.ndarray, start: np.ndarray) -> np.ndarray:
    """x⁺ = F x + f for several columns at once: F (n, n) or one for each row, f (N, n, c), x₀ (n, c) → (N, n, c)."""
    if steady.ndim == 2:
        return np.stack([affine_scan(steady, forcing[:, :, c], start[:, c], len(forcing))[:-1] for c in range(start.shape[1])], axis=2)
    out, x = np.empty_like(forcing), start
    for k, (F, f) in enumerate(zip(steady, forcing, strict=True)):
        out[k] = x
        x = F @ x + f
    return out
