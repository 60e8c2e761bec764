"""Make plants under the field's names: from matrices, from fractions, sampled and back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..systems.arrays import as_checked
from ..systems.errors import EngineError, ShapeError
from ..systems.fractions import Fraction, realised_by_entries
from ..systems.gates.argument_checks import PERIOD, SECONDS, Sizes, choice, matrix, takes, vector
from ..systems.gates.plant_gate import PLANT, plant_like
from ..systems.plant import Plant
from ..systems.sampling import continuous_of, discretise, from_tustin, tustin

if TYPE_CHECKING:
    import control  # imported where it is used: it takes a second to load

__all__ = ["c2d", "d2c", "ss", "tf"]

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
