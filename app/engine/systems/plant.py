"""Define the plant: ẋ = A x + B u + G w, y = C x + D u + v."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

import numpy as np

from ..plotting import with_plot
from .arrays import as_matrix
from .errors import EngineError, ShapeError, phrase
from .pole_sets import sorted_poles
from .records import record

__all__ = ["Plant", "as_matrix"]


def _names(given: Sequence[str] | None, letter: str, count: int, what: str) -> tuple[str, ...]:
    if isinstance(given, str) or (given is not None and not isinstance(given, Iterable)):
        raise EngineError("{name} must be a list.", name=phrase("Names"))
    given = None if given is None else tuple(given)
    if given and (isinstance(given, set) or not all(isinstance(word, str) for word in given)):
        raise EngineError("The names must be a list of texts.")
    if not given:
        return tuple(f"{letter}{i + 1}" for i in range(count))
    if len(given) != count:
        raise ShapeError("There are {count} {what}s but {count2} {what} names; give one name each.",
                         count=count, what=what, count2=len(given))
    return tuple(str(name) for name in given)


def _units(given: object) -> tuple[tuple[str, str], ...]:
    pairs = given.items() if isinstance(given, Mapping) else given
    listed = tuple(pairs) if isinstance(pairs, Iterable) and not isinstance(pairs, str) else (None,)
    if any(not isinstance(pair, tuple | list) or len(pair) != 2 for pair in listed):
        raise EngineError("The units must be pairs of a signal's name and its unit.")
    return tuple((str(name), str(unit)) for name, unit in listed)  # type: ignore[misc]


def _notes(given: object) -> tuple[str, ...]:
    notes = tuple(given) if isinstance(given, list | tuple) else (None,)
    if not all(isinstance(note, str) for note in notes):
        raise EngineError("The notes must be a list of texts.")
    return notes  # type: ignore[return-value]


@record()
class Plant:
    """A linear time-invariant plant ẋ = A x + B u, y = C x + D u (dt > 0: x⁺ = A x + B u).

    A is n×n, B n×m, C p×n, D p×m (zero if left out). `units` maps a signal name to its SI unit; `notes` are sentences on
    what was done to it when it was read, which make no difference between two plants.
    Raises ShapeError where the shapes disagree, EngineError where an entry is not finite.

    >>> Plant([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]]).n
    2
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray = None  # type: ignore[assignment]  # zero if left out; always an array after construction
    dt: float = 0.0
    state_names: tuple[str, ...] = ()
    input_names: tuple[str, ...] = ()
    output_names: tuple[str, ...] = ()
    units: tuple[tuple[str, str], ...] = ()
    name: str = ""
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        A, B, C = (as_matrix(getattr(self, k), k) for k in "ABC")
        n = A.shape[0]
        if A.shape[1] != n:
            raise ShapeError("A must be square; it is {rows}×{columns}.", rows=A.shape[0], columns=A.shape[1])
        if B.shape[0] != n:
            raise ShapeError("B must have {n} rows, as A has; it is {rows}×{columns}.",
                             n=n, rows=B.shape[0], columns=B.shape[1])
        if C.shape[1] != n:
            raise ShapeError("C must have {n} columns, as A has; it is {rows}×{columns}.",
                             n=n, rows=C.shape[0], columns=C.shape[1])
        D = as_matrix(np.zeros((C.shape[0], B.shape[1])) if self.D is None else self.D, "D")
        if D.shape != (C.shape[0], B.shape[1]):
            raise ShapeError("D must be {rows}×{columns}; it is {rows2}×{columns2}.",
                             rows=C.shape[0], columns=B.shape[1], rows2=D.shape[0], columns2=D.shape[1])
        try:
            dt = np.nan if isinstance(self.dt, bool | np.bool_) else float(self.dt)
        except (TypeError, ValueError, OverflowError):
            dt = np.nan
        if not np.isfinite(dt) or dt < 0:
            raise EngineError("dt must be 0 (continuous time) or a positive sampling period in seconds.")
        units = _units(self.units)
        if not isinstance(self.name, str):
            raise EngineError("{name} must be text.", name="name")
        for key, value in {
            "A": A, "B": B, "C": C, "D": D, "dt": dt,
            "state_names": _names(self.state_names, "x", n, phrase("state")),
            "input_names": _names(self.input_names, "u", B.shape[1], phrase("input")),
            "output_names": _names(self.output_names, "y", C.shape[0], phrase("output")),
            "units": units,
            "notes": _notes(self.notes),
        }.items():
            object.__setattr__(self, key, value)

    @property
    def n(self) -> int:
        """Number of states."""
        return self.A.shape[0]

    @property
    def m(self) -> int:
        """Number of inputs."""
        return self.B.shape[1]

    @property
    def p(self) -> int:
        """Number of outputs."""
        return self.C.shape[0]

    @cached_property
    def poles(self) -> np.ndarray:
        """eig(A), sorted by (real, imag)."""
        return with_plot(sorted_poles(self.A))

    @cached_property
    def key(self) -> tuple:
        """What makes two plants equal: the matrices, the period and the names."""
        return (*(m.tobytes() for m in (self.A, self.B, self.C, self.D)), self.A.shape, self.B.shape, self.C.shape,
                self.dt, self.state_names, self.input_names, self.output_names, self.name)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Plant) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    def dual(self) -> Plant:
        """The dual plant (Aᵀ, Cᵀ, Bᵀ, Dᵀ): its controller is our observer, L = K_dᵀ."""
        return Plant(self.A.T, self.C.T, self.B.T, self.D.T, self.dt, name=f"dual of {self.name}".strip())

    def unit(self, name: str) -> str:
        """SI unit of a signal, or an empty string."""
        return dict(self.units).get(name, "")
