"""Answer under the field's names with python-control's meaning: ctrb, acker, care, lyap, gram, …"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.linalg import schur, solve_sylvester, solve_triangular

from ..design.optimal import dlqr, lqr
from ..design.placement import Placement, place
from ..structure.analysis import controllability_matrix, observability_matrix
from ..structure.gramian import gramians, hankel_singular_values
from ..systems.arrays import as_checked
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import POLES, choice, matrix, optional, takes
from ..systems.gates.plant_gate import DRIVEN, PLANT, SEEN
from ..systems.lyapunov import lyapunov_solution
from ..systems.plant import Plant
from ..systems.zeros import transmission_zeros

__all__ = ["acker", "care", "ctrb", "dare", "dlyap", "gram", "hsvd", "lyap", "obsv", "poles", "sampled_sylvester", "sylvester", "zeros"]

APART = 1e-14  # relative distance from a pole of the other matrix below which no solution is unique


@takes(plant=DRIVEN)
def ctrb(plant: Plant) -> np.ndarray:
    """[B, AB, …, Aⁿ⁻¹B] (n×nm) of a plant, or of A and B.

    >>> ctrb([[0, 1], [0, 0]], [[0], [1]])
    array([[0., 1.],
           [1., 0.]])
    """
    return controllability_matrix(plant)


@takes(plant=SEEN)
def obsv(plant: Plant) -> np.ndarray:
    """[C; CA; …; CAⁿ⁻¹] (pn×n) of a plant, or of A and C.

    >>> obsv([[0, 1], [0, 0]], [[1, 0]])
    array([[1., 0.],
           [0., 1.]])
    """
    return observability_matrix(plant)


@takes(A=matrix("n n"), B=matrix("n 1"), poles=POLES)
def acker(A: object, B: object, poles: Iterable[complex]) -> Placement:
    """`place` for one input.

    >>> np.round(acker([[0, 1], [0, 0]], [[0], [1]], [-1, -2]), 6)
    array([[2., 3.]])
    """
    return place(A, B, poles)


@takes(A=matrix("n n"), B=matrix("n m"), Q=matrix("n n"), R=optional(matrix("m m")), S=optional(matrix("n m")))
def care(A: object, B: object, Q: object, R: object | None = None, S: object | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(X, poles of A − BG, G = R⁻¹(BᵀX + Sᵀ)) of AᵀX + XA − (XB + S)R⁻¹(BᵀX + Sᵀ) + Q = 0; R is I if left out.

    >>> np.round(care([[0]], [[1]], [[4]])[0], 6)
    array([[2.]])
    """
    found = lqr(A, B, Q, np.eye(as_checked(B).shape[1]) if R is None else R, N=S)
    return found.solution, found.poles, found.gain


@takes(A=matrix("n n"), B=matrix("n m"), Q=matrix("n n"), R=optional(matrix("m m")), S=optional(matrix("n m")))
def dare(A: object, B: object, Q: object, R: object, S: object | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(X, poles of A − BG, G) of X = AᵀXA − (AᵀXB + S)(R + BᵀXB)⁻¹(BᵀXA + Sᵀ) + Q.

    >>> np.round(dare([[1]], [[1]], [[1]], [[1]])[0], 4)
    array([[1.618]])
    """
    found = dlqr(A, B, Q, R, N=S)
    return found.solution, found.poles, found.gain


def _no_unique() -> EngineError:
    return EngineError("The Lyapunov equation has no unique solution: two poles mirror each other at the stability boundary.")


@takes(A=matrix("n n"), Q=matrix("k k"), C=optional(matrix("n k")), E=optional(matrix("n n")))
def lyap(A: object, Q: object, C: object = None, E: object = None) -> np.ndarray:
    """X of AX + XAᵀ + Q = 0, of AX + XQ + C = 0 with C, of AXEᵀ + EXAᵀ + Q = 0 with E.

    Raises EngineError where two poles of A (of A and Q, of E⁻¹A) add up to zero, and for a singular E.

    >>> lyap([[-1]], [[2]])
    array([[1.]])
    """
    if C is not None:
        return sylvester(*_alone(A, Q, C, E))
    F, forcing = _without_descriptor(A, Q, E)
    poles = np.linalg.eigvals(F)
    if np.abs(poles[:, None] + poles).min(initial=np.inf) <= 1e-14 * np.abs(poles).max(initial=0.0):
        raise _no_unique()
    return _unique(F, forcing, 0.0)


@takes(A=matrix("n n"), Q=matrix("k k"), C=optional(matrix("n k")), E=optional(matrix("n n")))
def dlyap(A: object, Q: object, C: object = None, E: object = None) -> np.ndarray:
    """X of AXAᵀ − X + Q = 0, of AXQ − X + C = 0 with C, of AXAᵀ − EXEᵀ + Q = 0 with E.

    Raises EngineError where two poles of A (of A and Q, of E⁻¹A) multiply to one, and for a singular E.

    >>> np.round(dlyap([[0.5]], [[3]]), 6)
    array([[4.]])
    """
    if C is not None:
        return sampled_sylvester(*_alone(A, Q, C, E))
    F, forcing = _without_descriptor(A, Q, E)
    poles = np.linalg.eigvals(F)
    if np.abs(poles[:, None] * poles - 1).min(initial=np.inf) <= 1e-14:
        raise _no_unique()
    return _unique(F, forcing, 1.0)


def _unique(A: np.ndarray, Q: np.ndarray, dt: float) -> np.ndarray:
    try:
        return lyapunov_solution(A, Q, dt)
    except np.linalg.LinAlgError as problem:
        raise _no_unique() from problem


def _alone(A: object, Q: object, C: object, E: object) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    if E is not None:
        raise EngineError("Give C or E, not both: no equation here has the two.")
    return as_checked(A), as_checked(Q), as_checked(C)


def _without_descriptor(A: object, Q: object, E: object) -> tuple[np.ndarray, np.ndarray]:
    """E⁻¹A and E⁻¹QE⁻ᵀ, A and Q themselves without E."""
    A, Q = as_checked(A), as_checked(Q)
    if A.shape != Q.shape:
        raise ShapeError("{name} must be {must}; it is {it_is}.", name="Q", must=f"{len(A)}×{len(A)}", it_is=f"{len(Q)}×{len(Q)}")
    if E is None:
        return A, Q
    try:
        return np.linalg.solve(as_checked(E), A), np.linalg.solve(as_checked(E), np.linalg.solve(as_checked(E), Q).T).T
    except np.linalg.LinAlgError as problem:
        raise EngineError("E is singular; this equation needs an E with an inverse.") from problem


@takes(plant=PLANT, type=choice("c", "o"))
def gram(plant: Plant, type: str) -> np.ndarray:
    """The controllability Gramian "c" or the observability Gramian "o" of a stable plant.

    >>> gram(ss([[-1]], [[1]], [[1]], 0), "c")
    array([[0.5]])
    """
    found = gramians(plant)
    return found.controllability if type == "c" else found.observability


@takes(plant=PLANT)
def hsvd(plant: Plant) -> np.ndarray:
    """The Hankel singular values of a stable plant, largest first.

    >>> hsvd(ss([[-1]], [[1]], [[1]], 0))
    array([0.5])
    """
    return hankel_singular_values(plant)


@takes(plant=PLANT)
def poles(plant: Plant) -> np.ndarray:
    """The poles of a plant, sorted by (real, imag).

    >>> poles(ss([[-1]], [[1]], [[1]], 0)).real
    array([-1.])
    """
    return plant.poles


@takes(plant=PLANT)
def zeros(plant: Plant) -> np.ndarray:
    """The transmission zeros of a plant.

    >>> np.round(zeros(tf([1, 3], [1, 3, 2])).real, 6)
    array([-3.])
    """
    return transmission_zeros(plant)


def sylvester(A: np.ndarray, Q: np.ndarray, C: np.ndarray) -> np.ndarray:
    """X (n×k) of AX + XQ + C = 0, by Bartels and Stewart."""
    first, second = np.linalg.eigvals(A), np.linalg.eigvals(Q)
    sums, size = np.abs(first[:, None] + second), max(np.abs(first).max(initial=0.0), np.abs(second).max(initial=0.0))
    if sums.min(initial=np.inf) <= APART * size:
        raise EngineError("The Sylvester equation has no unique solution: a pole of A is minus one of Q.")
    return np.asarray(solve_sylvester(A, Q, -C)) if C.size else np.zeros(C.shape)


def sampled_sylvester(A: np.ndarray, Q: np.ndarray, C: np.ndarray) -> np.ndarray:
    """X (n×k) of AXQ − X + C = 0: with Schur forms A = U S Uᴴ, Q = V T Vᴴ one column of UᴴXV after the other."""
    first, second = np.linalg.eigvals(A), np.linalg.eigvals(Q)
    if np.abs(first[:, None] * second - 1).min(initial=np.inf) <= APART:
        raise EngineError("The Sylvester equation has no unique solution: a pole of A is the inverse of one of Q.")
    if not C.size:
        return np.zeros(C.shape)
    (S, U), (T, V) = schur(A, output="complex"), schur(Q, output="complex")
    right, Y = U.conj().T @ C @ V, np.zeros(C.shape, dtype=complex)
    for k in range(C.shape[1]):
        Y[:, k] = solve_triangular(np.eye(len(S)) - T[k, k] * S, right[:, k] + S @ (Y[:, :k] @ T[:k, k]))
    return np.real(U @ Y @ V.conj().T)
