"""Common names of the field with python-control's meaning: ss, tf, ctrb, acker, care, gram, …"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

from .design.optimal import dlqr, lqr
from .design.placement import Placement, place
from .structure.analysis import controllability_matrix, observability_matrix
from .structure.gramian import gramians, hankel_singular_values
from .systems.arrays import as_checked
from .systems.errors import EngineError
from .systems.fractions import realised_by_entries
from .systems.gates.argument_checks import PERIOD, POLES, SECONDS, Sizes, choice, matrix, optional, takes, vector
from .systems.gates.plant_gate import DRIVEN, PLANT, SEEN
from .systems.gates.room_gates import with_gates
from .systems.plant import Plant
from .systems.sampling import discretise
from .systems.zeros import transmission_zeros

__all__ = ["acker", "c2d", "care", "ctrb", "dare", "dlyap", "gram", "hsvd", "lyap", "obsv", "poles", "ss", "tf", "zeros"]


def _feedthrough(value: object, name: str, sizes: Sizes) -> np.ndarray | None:
    """D; the number zero stands for a matrix of zeros."""
    return None if isinstance(value, int | float) and value == 0 else matrix("p m")(value, name, sizes)


@takes(A=matrix("n n"), B=matrix("n m"), C=matrix("p n"), D=_feedthrough, dt=PERIOD)
def ss(A: object, B: object, C: object, D: object = None, dt: float = 0.0) -> Plant:
    """The plant of its matrices, D zero if left out; `ss(system)` takes one of python-control or SciPy.

    >>> ss([[-1]], [[1]], [[1]], 0).n
    1
    """
    return Plant(as_checked(A), as_checked(B), as_checked(C), None if D is None else as_checked(D), dt)  # type: ignore[arg-type]


@takes(num=vector(), den=vector(), dt=PERIOD)
def tf(num: object, den: object, dt: float = 0.0) -> Plant:
    """A plant with the transfer function num / den, coefficients from the highest power down; scalar.

    >>> tf([1], [1, 3, 2]).poles.real
    array([-2., -1.])
    """
    top, bottom = as_checked(num), as_checked(den)
    return realised_by_entries([[(top, bottom)]], dt)


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


@takes(A=matrix("n n"), Q=matrix("n n"))
def lyap(A: object, Q: object) -> np.ndarray:
    """X of AX + XAᵀ + Q = 0. Raises EngineError where two poles of A add up to zero.

    >>> lyap([[-1]], [[2]])
    array([[1.]])
    """
    poles = np.linalg.eigvals(as_checked(A))
    if np.abs(poles[:, None] + poles).min(initial=np.inf) <= 1e-14 * np.abs(poles).max(initial=0.0):
        raise _no_unique()
    return solve_continuous_lyapunov(as_checked(A), -as_checked(Q))


@takes(A=matrix("n n"), Q=matrix("n n"))
def dlyap(A: object, Q: object) -> np.ndarray:
    """X of AXAᵀ − X + Q = 0. Raises EngineError where two poles of A multiply to one.

    >>> np.round(dlyap([[0.5]], [[3]]), 6)
    array([[4.]])
    """
    poles = np.linalg.eigvals(as_checked(A))
    if np.abs(poles[:, None] * poles - 1).min(initial=np.inf) <= 1e-14:
        raise _no_unique()
    F, forcing = as_checked(A), as_checked(Q)
    X = solve_discrete_lyapunov(F, forcing)
    return X + solve_discrete_lyapunov(F, F @ X @ F.T - X + forcing)  # one step of Newton gives back what the direct solver loses


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


@takes(plant=PLANT, Ts=SECONDS)
def c2d(plant: Plant, Ts: float) -> Plant:
    """The plant sampled every Ts seconds with its input held, exactly.

    >>> np.round(c2d(ss([[-1]], [[1]], [[1]], 0), 1.0).A, 4)
    array([[0.3679]])
    """
    if plant.dt:
        raise EngineError("This plant is sampled already, every {dt:g} s.", dt=plant.dt)
    return discretise(plant, Ts)


with_gates(globals())
