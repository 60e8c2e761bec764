"""Make plants and their estimators under the field's names: from matrices, fractions, gains, noises."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..design.optimal import DiscreteFilter, Optimal, dlqe, lqe
from ..systems.arrays import as_checked, as_covariance
from ..systems.errors import EngineError, ShapeError
from ..systems.fractions import Fraction, realised_by_entries
from ..systems.gates.argument_checks import PERIOD, SECONDS, Sizes, choice, count, covariance, items, matrix, optional, takes, vector
from ..systems.gates.plant_gate import PLANT, plant_like
from ..systems.plant import Plant
from ..systems.sampling import continuous_of, discretise, from_tustin, tustin

if TYPE_CHECKING:
    import control  # imported where it is used: it takes a second to load

__all__ = ["c2d", "d2c", "estim", "kalman", "ss", "tf"]

Method = Literal["zoh", "tustin", "bilinear"]
_METHOD = choice("zoh", "tustin", "bilinear")
_VECTOR = vector()


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


def _is_matrix_of_vectors(value: object) -> bool:
    """Whether these are rows of entries that are rows of coefficients."""
    return isinstance(value, Sequence) and not isinstance(value, str) and bool(value) and all(
        isinstance(row, Sequence) and not isinstance(row, str) and bool(row) and all(np.ndim(entry) == 1 for entry in row) for row in value)


def _coefficients(value: Any, name: str, sizes: Sizes) -> object:
    """Coefficients of one polynomial, or rows of them."""
    if isinstance(value, np.ndarray) and value.ndim == 3:
        value = value.tolist()
    if isinstance(value, Sequence) and not isinstance(value, str) and any(isinstance(row, Sequence | np.ndarray) and len(row) and
                                                                          any(isinstance(v, Sequence | np.ndarray) for v in row)
                                                                          for row in value):
        if not _is_matrix_of_vectors(value) or len({len(row) for row in value}) != 1:
            raise ShapeError("{name} must be rows of one length, each entry the coefficients of a polynomial.", name=name)
        return tuple(tuple(_VECTOR(entry, name, {}) for entry in row) for row in value)
    return _VECTOR(value, name, {})


def _numerator(value: Any, name: str, sizes: Sizes) -> object:
    if isinstance(value, str) and value in ("s", "z"):
        return value
    return plant if (plant := plant_like(value)) is not None else _coefficients(value, name, sizes)


@takes(num=_numerator, den=_coefficients, dt=PERIOD)
def tf(num: object, den: object = None, dt: float = 0.0) -> Plant | control.TransferFunction:
    """A plant with the transfer function num / den, coefficients from the highest power down.

    A p×m matrix of fractions has rows of lists, `tf([[[1], [2]]], [[[1, 1], [1, 3]]])`; one den may serve them all. `tf("s")`, or
    `tf("z", dt=0.1)`, is python-control's letter to calculate with, and `tf(system)` the plant of what comes out.

    >>> s = tf("s")
    >>> tf(1 / ((s + 1) * (s + 2))).poles.real
    array([-2., -1.])
    """
    if isinstance(num, str):
        return _letter(num, den, dt)
    if isinstance(num, Plant):
        if den is not None:
            raise EngineError("tf takes a system, or num and den, not both.")
        return num
    if den is None:
        raise EngineError("tf needs num and den, \"s\", or a system.")
    return realised_by_entries(_entries(num, den), dt)


def _letter(letter: str, den: Any, dt: float) -> control.TransferFunction:
    """s or z as a transfer function; MATLAB's tf("z", 0.1) has its period where den stands."""
    from control import TransferFunction

    period = float(den[0]) if isinstance(den, np.ndarray) and den.size == 1 and not dt else dt
    if (letter == "z") != (period > 0) or (den is not None and period == dt):
        raise EngineError("Give \"s\" alone, or \"z\" with its sampling period, as in tf(\"z\", dt=0.1).")
    return TransferFunction([1, 0], [1], period)


def _entries(num: Any, den: Any) -> list[list[Fraction]]:
    """Fractions of a p×m transfer matrix from polynomials."""
    if not isinstance(num, tuple) and not isinstance(den, tuple):
        return [[(num, den)]]
    rows, columns = (len(num), len(num[0])) if isinstance(num, tuple) else (len(den), len(den[0]))
    tops, bottoms = ((given if isinstance(given, tuple) else ((given,) * columns,) * rows) for given in (num, den))
    if (len(bottoms), len(bottoms[0])) != (rows, columns):
        raise ShapeError("{name} must be {must}; it is {it_is}.", name="den", must=f"{rows}×{columns}",
                         it_is=f"{len(bottoms)}×{len(bottoms[0])}")
    return [list(zip(top, bottom, strict=True)) for top, bottom in zip(tops, bottoms, strict=True)]


@takes(plant=PLANT, Ts=SECONDS, method=_METHOD)
def c2d(plant: Plant, Ts: float, method: Method = "zoh") -> Plant:
    """The plant sampled every Ts seconds: "zoh", its input held, exactly; "tustin" (or "bilinear"), s = 2(z − 1)/(Ts (z + 1)).

    >>> np.round(c2d(ss([[-1]], [[1]], [[1]], 0), 1.0).A, 4)
    array([[0.3679]])
    """
    if plant.dt:
        raise EngineError("This plant is sampled already, every {dt:g} s.", dt=plant.dt)
    return discretise(plant, Ts) if method == "zoh" else tustin(plant, Ts)


@takes(plant=PLANT, method=_METHOD)
def d2c(plant: Plant, method: Method = "zoh") -> Plant:
    """The continuous plant that `c2d` with this method samples to the given one. Raises EngineError where there is none.

    >>> np.round(d2c(c2d(ss([[-1]], [[1]], [[1]], 0), 0.5), "zoh").A, 6)
    array([[-1.]])
    """
    if not plant.dt:
        raise EngineError("This plant is continuous already.")
    return continuous_of(plant) if method == "zoh" else from_tustin(plant)


@takes(plant=PLANT, L=matrix("n q"), sensors=optional(items(count())), known=optional(items(count())))
def estim(plant: Plant, L: object, sensors: Iterable[int] | None = None, known: Iterable[int] | None = None) -> Plant:
    """The estimator x̂̇ = A x̂ + B u + L (y − C x̂ − D u) from (u, y) to (ŷ, x̂); a sampled plant has x̂⁺ in place of x̂̇.

    `sensors` are the outputs that L (n×q) takes in, all if left out, and `known` the inputs that the estimator is given, none if left
    out; both count from 0. Raises ShapeError, EngineError where they do not fit the plant.

    >>> estim(Plant([[-1]], [[1]], [[1]]), [[2]], known=[0]).B
    array([[1., 2.]])
    """
    L, seen, given = as_checked(L), _picked(sensors, plant.p, "sensors", range(plant.p)), _picked(known, plant.m, "known", ())
    if L.shape[1] != len(seen):
        raise ShapeError("{name} must be {must}; it is {it_is}.", name="L", must=f"{plant.n}×{len(seen)}", it_is=f"{len(L)}×{L.shape[1]}")
    return _built(plant, L, np.zeros((plant.n, len(seen))), seen, given)


@takes(plant=PLANT, Qn=covariance(), Rn=covariance("p"), Nn=optional(matrix()), type=choice("current", "delayed"))
def kalman(plant: Plant, Qn: object, Rn: object, Nn: object = None,
           type: Literal["current", "delayed"] = "current") -> tuple[Plant, np.ndarray, np.ndarray]:
    """(kest, L, P): the steady Kalman filter of ẋ = A x + B u + G w, y = C x + D u + H w + v as a system, its gain and P.

    The last q inputs of the plant are w, for Qn q×q; the first are u. Qn, Rn (p×p) and Nn = E w vᵀ (q×p) are intensities, of a sampled
    plant covariances. kest goes from (u, y) to (ŷ, x̂). Of a sampled plant P and L belong to the prediction x̂[k|k−1], and kest
    gives x̂[k|k], or x̂[k|k−1] if "delayed". Raises as `lqe` does.

    >>> np.round(kalman(Plant([[-1]], [[1, 1]], [[1]]), [[3]], [[1]])[1], 6)
    array([[1.]])
    """
    q = as_checked(Qn).shape[0]
    if q > plant.m:
        raise ShapeError("Qn is {q}×{q} but the plant has {m} inputs; its last inputs are the noise.", q=q, m=plant.m)
    known, D = plant.m - q, np.asarray(plant.D)
    G, H, W = plant.B[:, known:], D[:, known:], as_covariance(Qn, "Qn", q)
    N = np.zeros((q, plant.p)) if Nn is None else as_checked(Nn)
    if N.shape != (q, plant.p):
        raise ShapeError("{name} must be {must}; it is {it_is}.", name="Nn", must=f"{q}×{plant.p}", it_is=f"{len(N)}×{N.shape[1]}")
    V = as_covariance(Rn, "Rn", plant.p) + H @ W @ H.T + H @ N + N.T @ H.T  # of the noise H w + v in a reading
    found: Optimal = (dlqe if plant.dt else lqe)(plant.A, G, plant.C, W, V, N + W @ H.T)
    M = found.filter_gain if isinstance(found, DiscreteFilter) and type == "current" else np.zeros((plant.n, plant.p))
    return _built(plant, found.gain, M, range(plant.p), range(known)), found.gain, found.solution


def _picked(given: object, most: int, name: str, otherwise: Iterable[int]) -> list[int]:
    """Places of signals, each once."""
    picked = list(otherwise) if given is None else [int(place) for place in np.asarray(given)]
    if len(set(picked)) != len(picked) or any(not 0 <= place < most for place in picked):
        raise EngineError("{name} must be different whole numbers from 0 to {most}.", name=name, most=most - 1)
    return picked


def _built(plant: Plant, L: np.ndarray, M: np.ndarray, seen: Iterable[int], given: Iterable[int]) -> Plant:
    """x̂⁺ or x̂̇ with the gain L; the outputs are of x̂ + M (y − C x̂ − D u)."""
    seen, given = list(seen), list(given)
    C, D, B = plant.C[seen], np.asarray(plant.D)[np.ix_(seen, given)], plant.B[:, given]
    outward = np.vstack([C, np.eye(plant.n)])
    direct = np.vstack([D, np.zeros((plant.n, len(given)))])
    return Plant(plant.A - L @ C, np.hstack([B - L @ D, L]), outward @ (np.eye(plant.n) - M @ C),
                 np.hstack([direct - outward @ M @ D, outward @ M]), plant.dt, tuple(f"{name}_hat" for name in plant.state_names),
                 tuple(plant.input_names[i] for i in given) + tuple(plant.output_names[i] for i in seen),
                 tuple(f"{plant.output_names[i]}_hat" for i in seen) + tuple(f"{name}_hat" for name in plant.state_names),
                 name=f"estimator of {plant.name}".strip())
