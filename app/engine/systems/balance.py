"""Scale states, inputs and outputs so that no tolerance depends on the units.

A plant in millimetres and volts is the plant in metres and kilovolts, so no decision may depend on which. What a change
of units leaves alone are the strengths of paths: from input k to state i, from state j to state i, to output l. The
scales here are read from those alone.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.linalg import LinAlgError
from scipy.linalg.lapack import dgebal, dgeev  # pyright: ignore[reportAttributeAccessIssue]

from .arrays import frozen
from .errors import ShapeError
from .gates.argument_checks import matrix, optional, takes
from .records import record

__all__ = ["MIN_RATE", "UNLIKE", "Balance", "balance", "natural_scale", "plain_scale", "state_scale", "without_dust"]

ROUNDING_ENTRY_RTOL = 1e-14  # an entry this small beside its row and its column is rounding: it must not steer the scales
REAL_ENTRY_RTOL = 1e-7  # what looked like rounding is none where it is this large in the units that the rest tells
UNLIKE = 2.0**12  # states whose natural units are further apart than this are not in like units
CANCELLED = 1e-14
MIN_RATE = 1e-200  # a rate below this is none
WIDEST = 400.0  # log₂ of the largest scale


@record()
class Balance:
    """x = states ∘ x_b, u = inputs ∘ u_b, y = outputs ∘ y_b, all scales powers of two, so that nothing is rounded.

    `rate` (1/s; a number where sampled) is the spectral radius of |A|, which no unit of a state changes. In balanced
    quantities no entry of A is (much) larger than `rate`, and B/rate and C have columns and rows of about unit size.
    """

    states: np.ndarray
    inputs: np.ndarray
    outputs: np.ndarray
    rate: float
    unrounded: np.ndarray

    def A(self, A: np.ndarray) -> np.ndarray:
        """A in balanced states."""
        return A * self.states / self.states[:, None]

    def B(self, B: np.ndarray) -> np.ndarray:
        """B between balanced inputs and states."""
        return B * self.inputs / self.states[:, None]

    def C(self, C: np.ndarray) -> np.ndarray:
        """C between balanced states and outputs."""
        return C * self.states / self.outputs[:, None]

    def D(self, D: np.ndarray) -> np.ndarray:
        """D between balanced inputs and outputs."""
        return D * self.inputs / self.outputs[:, None]


@takes(A=matrix("n n"), B=optional(matrix("n m")), C=optional(matrix("p n")), D=optional(matrix("p m")))
def balance(A: np.ndarray, B: np.ndarray | None = None, C: np.ndarray | None = None,
            D: np.ndarray | None = None) -> Balance:
    """The scales of states (n,), inputs (m,) and outputs (p,) for A n×n, B n×m, C p×n, D p×m; parts may be left out.

    log scales δ are the least squares of log L_ij + δ_j − δ_i over the strongest paths L_ij from j to i (edges |A|/rate,
    |B|/rate, |C|, |D|), then moved so that no path is stronger than one. This is done for the states with A alone, and then for
    inputs, outputs and what A does not couple. It is what balancing a matrix does; but states that only feed or are only fed get
    their scale too, and what lies far from an input or an output keeps its own. Source of the least squares: Curtis and
    Reid, "On the automatic scaling of matrices for Gaussian elimination" (1972).
    """
    n = len(A)
    B = np.zeros((n, 0)) if B is None else B
    C = np.zeros((0, n)) if C is None else C
    D = np.zeros((len(C), B.shape[1])) if D is None else D
    if D.shape != (len(C), B.shape[1]):
        raise ShapeError("D must be {rows}×{columns}; it is {rows2}×{columns2}.",
                         rows=len(C), columns=B.shape[1], rows2=D.shape[0], columns2=D.shape[1])
    parts = tuple(np.ascontiguousarray(M, dtype=float) for M in (A, B, C, D))
    return _balance(*(part.tobytes() for part in parts), n, B.shape[1], len(C))


@lru_cache(maxsize=256)
def _balance(a: bytes, b: bytes, c: bytes, d: bytes, n: int, m: int, p: int) -> Balance:
    A, B, C, D = _sizes(a, b, c, d, n, m, p)
    rate = _rate(A)
    delta = np.clip(_scales(_paths(A, B, C, D, np.log2(rate)), _members(A)), -WIDEST, WIDEST)
    scale, exact = frozen(2.0 ** np.round(delta)), frozen(2.0 ** delta)
    return Balance(scale[:n], scale[n:n + m], scale[n + m:], rate, exact)


@lru_cache(maxsize=256)
def _weighed(a: bytes, b: bytes, c: bytes, n: int, m: int, p: int) -> np.ndarray:
    A, B, C, D = _sizes(a, b, c, bytes(8 * m * p), n, m, p)
    L = _paths(A, B, C, D, np.log2(_rate(A)))
    direct = np.zeros(L.shape, dtype=bool)
    direct[:n, :n], direct[:n, n:n + m], direct[n + m:, :n] = True, B > 0, C > 0
    delta = np.clip(_fitted(np.where(direct, L, -np.inf), L), -WIDEST, WIDEST)
    return frozen(2.0 ** np.round(delta[:n]))


def _sizes(a: bytes, b: bytes, c: bytes, d: bytes, n: int, m: int, p: int) -> tuple[np.ndarray, ...]:
    """|A|, |B|, |C|, |D| without what is rounding: not in the units given, which may be unlike, but in those that the rest tells."""
    A, B, C, D = (np.abs(np.frombuffer(data)).reshape(shape)
                  for data, shape in ((a, (n, n)), (b, (n, m)), (c, (p, n)), (d, (p, m))))
    found = _clear(A, B, C)
    if sum(map(np.count_nonzero, found)) < sum(map(np.count_nonzero, (A, B, C))):
        delta = _scales(_paths(*found, D, np.log2(_rate(found[0]))), _members(found[0]))
        x, u, y = np.split(2.0 ** np.clip(delta, -WIDEST, WIDEST), [n, n + m])
        clear = _clear(A * x / x[:, None], B * u / x[:, None], C * x / y[:, None], REAL_ENTRY_RTOL)
        found = tuple(np.where((kept > 0) | (first > 0), M, 0.0) for kept, first, M in zip(clear, found, (A, B, C), strict=True))
    return *found, D


def _clear(A: np.ndarray, B: np.ndarray, C: np.ndarray, rtol: float = ROUNDING_ENTRY_RTOL) -> tuple[np.ndarray, ...]:
    A = np.where(rtol * np.minimum(_largest(A, 1), _largest(A, 0)) < A, A, 0.0)
    return A, *(np.where(rtol * _largest(M, axis) < M, M, 0.0) for M, axis in ((B, 0), (C, 1)))


def _rate(A: np.ndarray) -> float:
    return _radius(A.tobytes(), len(A)) if A.size else 1.0


@lru_cache(maxsize=64)
def _radius(a: bytes, n: int) -> float:
    """The spectral radius of |A|, which scales by A alone and those with B and C both ask for; 1 where it is none."""
    real, imaginary, *_, failed = dgeev(np.frombuffer(a).reshape(n, n), compute_vl=0, compute_vr=0)
    if failed:
        raise LinAlgError("the eigenvalues of |A| did not converge")
    rate = float(np.hypot(real, imaginary).max())
    return rate if rate > MIN_RATE else 1.0


def _largest(M: np.ndarray, axis: int) -> np.ndarray:
    return M.max(axis=axis, keepdims=True, initial=0.0)


def _paths(A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray, rate: float) -> np.ndarray:
    """log₂ of the strongest path to node i from node j, nodes being states, inputs, outputs; −∞ where there is none."""
    n, m, p = len(A), B.shape[1], len(C)
    L = np.zeros((n + m + p, n + m + p))
    L[:n, :n], L[:n, n:n + m], L[n + m:, :n], L[n + m:, n:n + m] = A, B, C, D
    with np.errstate(divide="ignore"):
        L = np.log2(L)
    L[:n, :n + m] -= rate
    for k in range(n):
        np.maximum(L, L[:, k:k + 1] + L[k], out=L)
    np.fill_diagonal(L, -np.inf)
    return L


def _members(A: np.ndarray) -> list[np.ndarray]:
    """The states in parts between which A has no entry."""
    if A.all():
        return [np.arange(len(A))] if A.size else []
    linked = (A != 0) | (A != 0).T
    left, parts = np.ones(len(A), dtype=bool), []
    while left.any():
        part = new = np.arange(len(A)) == left.argmax()
        while new.any():
            new = linked[new].any(axis=0) & ~part
            part = part | new
        parts.append(np.flatnonzero(part))
        left &= ~part
    return parts


def _scales(L: np.ndarray, parts: list[np.ndarray]) -> np.ndarray:
    """log₂ of the scales of all nodes from the strongest paths between them.

    States of one part first, by the paths within A alone; then the parts, inputs and outputs beside each other.
    """
    n = sum(map(len, parts))
    nodes = [*parts, *np.arange(n, len(L))[:, None]]
    delta = np.zeros(len(L))
    for part in parts:
        delta[part] = _fitted(L[part[:, None], part])
    if len(nodes) > 1:
        order, sizes = np.concatenate(nodes), np.array([len(node) for node in nodes])
        starts = np.cumsum(sizes) - sizes
        moved = (L + delta - delta[:, None])[order[:, None], order]
        between = np.maximum.reduceat(np.maximum.reduceat(moved, starts, axis=0), starts, axis=1)
        np.fill_diagonal(between, -np.inf)
        delta[order] += np.repeat(_fitted(between), sizes)
    return delta


def _fitted(edges: np.ndarray, L: np.ndarray | None = None) -> np.ndarray:
    """δ that brings these of L_ij + δ_j − δ_i to zero by least squares, then all of L (by default the same) below zero."""
    L = edges if L is None else L
    known = np.isfinite(edges)
    count, n = np.count_nonzero(known), len(L)
    if not count:
        return np.zeros(n)
    values = np.where(known, edges, 0.0)
    excess = values.sum(axis=1) - values.sum(axis=0)
    if count == n * (n - 1):  # a path between any two
        delta = excess / (2 * n)
    else:
        both = known.astype(float) + known.T
        delta = np.linalg.lstsq(np.diag(both.sum(axis=1)) - both, excess, rcond=1e-10)[0]
    ahead = np.maximum(delta, (L + delta).max(axis=1))
    back = np.maximum(-delta, (L - delta[:, None]).max(axis=0))
    return (ahead - back) / 2


@takes(A=matrix("n n"), B=optional(matrix("n m")), C=optional(matrix("p n")))
def state_scale(A: np.ndarray, B: np.ndarray | None = None, C: np.ndarray | None = None) -> np.ndarray:
    """Powers of two d (n,) such that diag(1/d) A diag(d) is balanced: the `states` of `balance`."""
    return balance(A, B, C).states


def weighed_scale(A: np.ndarray, B: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Powers of two (n,) for states that B n×m drives and C p×n weighs: entries of B and C count as those of A do, each beside the
    states that it stands for and no others."""
    A, B, C = (np.ascontiguousarray(M, dtype=float) for M in (A, B, C))
    return _weighed(A.tobytes(), B.tobytes(), C.tobytes(), len(A), B.shape[1], len(C))


@takes(A=matrix("n n"), B=optional(matrix("n m")), C=optional(matrix("p n")))
def natural_scale(A: np.ndarray, B: np.ndarray | None = None, C: np.ndarray | None = None) -> np.ndarray:
    """States (n,) in which a design is begun: A balanced as LAPACK does it where the units given are like, so that they
    still say what matters; else the scales of `balance`, not rounded, so that the design follows units exactly."""
    own = balance(A, B, C)
    if A.size and own.states.max() <= UNLIKE * own.states.min():
        return plain_scale(A)
    return own.unrounded[:len(A)]


def plain_scale(A: np.ndarray) -> np.ndarray:
    """Powers of two (n,) that bring rows and columns of A to like norms, as LAPACK does: for one matrix by itself."""
    if not A.size:
        return np.ones(0)
    A = np.ascontiguousarray(A, dtype=float)
    return _plain(A.tobytes(), len(A))


@lru_cache(maxsize=256)
def _plain(a: bytes, n: int) -> np.ndarray:
    A = np.frombuffer(a).reshape(n, n)
    own = state_scale(A)
    clean = np.where(np.abs(A) > CANCELLED * np.abs(A).max(), A, 0.0)
    if np.count_nonzero(clean) < np.count_nonzero(A):  # what is small is judged in balanced states, not in the units given
        clean = without_dust(A, own)
    return frozen(dgebal(clean, scale=1, permute=0)[3])


def without_dust(M: np.ndarray, states: np.ndarray) -> np.ndarray:
    """A product M (n×n) with what cancellation left of its zeros set to zero: entries below 1e-14 of the largest in
    balanced states, which would else steer the scales of what is built on it."""
    size = np.abs(M * states / states[:, None])
    return np.where(size > CANCELLED * size.max(initial=0.0), M, 0.0)
