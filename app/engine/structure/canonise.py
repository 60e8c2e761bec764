"""Canonise a matrix: compute its zero divisors and unit divisors on both sides."""

from __future__ import annotations

import numpy as np

from ..systems.arrays import frozen
from ..systems.gates.argument_checks import matrix, takes
from ..systems.records import record

__all__ = ["Canonisation", "canonise", "canonise_right"]

ZERO_RTOL = 1e-10  # what is left of the matrix counts as zero below this, relative to its largest entry
TIMID = 1e-3  # a pivot this much smaller than the largest entry left is not used


@record()
class Canonisation:
    """[unit_left; zero_left] M [unit_right, zero_right] = [I 0; 0 0], I of size `rank`.

    For M p×q of rank ρ: unit_left ρ×p, zero_left (p−ρ)×p, unit_right q×ρ, zero_right q×(q−ρ); any of them may be
    empty. `summary` = unit_right unit_left (q×p) solves M X M = M. `singular_values` of M say how safe ρ is.
    """

    unit_left: np.ndarray
    zero_left: np.ndarray
    unit_right: np.ndarray
    zero_right: np.ndarray
    singular_values: np.ndarray

    @property
    def rank(self) -> int:
        """ρ."""
        return self.unit_left.shape[0]

    @property
    def summary(self) -> np.ndarray:
        """M̃ = M̃ᴿ M̃ᴸ, the summary canoniser (q×p)."""
        return self.unit_right @ self.unit_left

    @property
    def left(self) -> np.ndarray:
        """[unit_left; zero_left] (p×p)."""
        return np.vstack([self.unit_left, self.zero_left])

    @property
    def right(self) -> np.ndarray:
        """[unit_right, zero_right] (q×q)."""
        return np.hstack([self.unit_right, self.zero_right])

    def flipped(self) -> Canonisation:
        """The canonisation of Mᵀ, which has left and right exchanged."""
        return Canonisation(frozen(self.unit_right.T), frozen(self.zero_right.T), frozen(self.unit_left.T),
                            frozen(self.zero_left.T), self.singular_values)


@takes(M=matrix())
def canonise(M: np.ndarray) -> Canonisation:
    """Divisors of zero and of one of M (p×q) by elimination, the scale of the pivots in the left divisors.

    The pivots are taken along the diagonal, as one does by hand, unless one is smaller than a thousandth of the
    largest entry left; then the largest is taken. Rank: what is left lies below 1e-10 of the largest entry of M.
    Source: method of canonisation as used in the bilinear functional observer (Avtometriya 53, 2017, no. 4).
    """
    left, right, work = np.eye(M.shape[0]), np.eye(M.shape[1]), np.array(M, dtype=float)
    floor = ZERO_RTOL * np.max(np.abs(work), initial=0.0)
    rank = 0
    while rank < min(work.shape):
        row, column = _pivot(work[rank:, rank:])
        if not abs(work[rank + row, rank + column]) > floor:
            break
        for table in (work, left):
            table[[rank, rank + row]] = table[[rank + row, rank]]
        for table in (work, right):
            table[:, [rank, rank + column]] = table[:, [rank + column, rank]]
        pivot = work[rank, rank]
        below, beside = work[rank + 1:, rank] / pivot, work[rank, rank + 1:] / pivot
        left[rank + 1:] -= np.outer(below, left[rank])
        work[rank + 1:] -= np.outer(below, work[rank])
        right[:, rank + 1:] -= np.outer(right[:, rank], beside)
        work[rank, rank + 1:] = 0.0
        left[rank] /= pivot
        rank += 1
    return Canonisation(frozen(left[:rank]), frozen(left[rank:]), frozen(right[:, :rank]), frozen(right[:, rank:]),
                        frozen(singular_values(M)))


def singular_values(M: np.ndarray) -> np.ndarray:
    """Those of M, none of an empty one."""
    return np.linalg.svd(M, compute_uv=False) if min(M.shape) else np.zeros(0)


@takes(M=matrix())
def canonise_right(M: np.ndarray) -> Canonisation:
    """As `canonise`, with the scale of the pivots in the right divisors: [5 6] becomes 1·[5 6]·[0.2 −1.2; 0 1]."""
    return canonise(M.T).flipped()


def _pivot(rest: np.ndarray) -> tuple[int, int]:
    size = np.abs(rest)
    if size[0, 0] >= TIMID * size.max():
        return 0, 0
    row, column = np.unravel_index(int(size.argmax()), size.shape)
    return int(row), int(column)
