"""Record equations as a list of steps, and run it for many states at once.

A map of columns x (n, 1), u (m, 1) is called once with symbols in place of numbers; what it does to them is its tape. Step i of a
tape is (operation, place, place) with a number beside it, and writes place n + m + i; x and u stand before.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

__all__ = ["Tape", "flow_lanes", "recorded", "run_lanes"]

ADD, LESS, TIMES, OVER, SCALED, SHIFTED, EXP, SIN, COS, ROOT, NUMBER = range(11)
MAX_TAPE_STEPS = 2000  # steps of a tape; what is longer is NumPy's
UNFIT = (TypeError, AttributeError, ValueError, ArithmeticError, IndexError)  # of a map that does what a tape cannot


# --- recording -----------------------------------------------------------------------------------------------------------
class Tape(NamedTuple):
    """steps (k, 3) whole numbers, numbers (k,); ends (rows,): the places of the results."""

    steps: np.ndarray
    numbers: np.ndarray
    ends: np.ndarray


class _Keeper:
    """Takes down the steps; `first` places are taken already."""

    def __init__(self, first: int) -> None:
        self.first = first
        self.steps: list[tuple[int, int, int]] = []
        self.numbers: list[float] = []

    def took(self, operation: int, a: int = 0, b: int = 0, number: float = 0.0) -> _Symbol:
        self.steps.append((operation, a, b))
        self.numbers.append(number)
        return _Symbol(self, self.first + len(self.steps) - 1)


class _Symbol:
    """A number that is not known yet, at its place of a tape; or one that is known, and has no place."""

    __slots__ = ("keeper", "number", "place")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, keeper: _Keeper, place: int, number: float = 0.0) -> None:
        self.keeper, self.place, self.number = keeper, place, number

    @property
    def known(self) -> bool:
        return self.place < 0

    def at(self) -> int:
        """Its place; a known number gets one."""
        return self.keeper.took(NUMBER, number=self.number).place if self.known else self.place

    def is_(self, number: float) -> _Symbol:
        return _Symbol(self.keeper, -1, number)

    def beside(self, other: object) -> _Symbol | None:
        """Another number as a symbol."""
        return other if isinstance(other, _Symbol) else self.is_(float(other)) if isinstance(other, (int, float)) else None

    def __bool__(self) -> bool:
        raise TypeError("what is not known yet decides nothing")

    def __eq__(self, other: object) -> bool:
        raise TypeError("what is not known yet is equal to nothing")

    def __neg__(self) -> _Symbol:
        return self.is_(-self.number) if self.known else self.keeper.took(SCALED, self.place, number=-1.0)

    def __pos__(self) -> _Symbol:
        return self

    def __add__(self, other: object) -> Any:
        that = self.beside(other)
        if that is None:
            return NotImplemented
        if self.known and that.known:
            return self.is_(self.number + that.number)
        if self.known or that.known:
            known, open_ = (self, that) if self.known else (that, self)
            return open_ if known.number == 0 else self.keeper.took(SHIFTED, open_.place, number=known.number)
        return self.keeper.took(ADD, self.place, that.place)

    __radd__ = __add__

    def __sub__(self, other: object) -> Any:
        that = self.beside(other)
        if that is None:
            return NotImplemented
        return self + -that if self.known or that.known else self.keeper.took(LESS, self.place, that.place)

    def __rsub__(self, other: object) -> Any:
        that = self.beside(other)
        return NotImplemented if that is None else that - self

    def __mul__(self, other: object) -> Any:
        that = self.beside(other)
        if that is None:
            return NotImplemented
        if self.known and that.known:
            return self.is_(self.number * that.number)
        if self.known or that.known:
            known, open_ = (self, that) if self.known else (that, self)
            if known.number == 0:
                return self.is_(0.0)
            return open_ if known.number == 1 else self.keeper.took(SCALED, open_.place, number=known.number)
        return self.keeper.took(TIMES, self.place, that.place)

    __rmul__ = __mul__

    def __truediv__(self, other: object) -> Any:
        that = self.beside(other)
        if that is None:
            return NotImplemented
        if that.known:
            return self * (1 / that.number)
        return self.keeper.took(OVER, self.at(), that.place)

    def __rtruediv__(self, other: object) -> Any:
        that = self.beside(other)
        return NotImplemented if that is None else that / self

    def __pow__(self, other: object) -> Any:
        if other == 2:
            return self * self
        if other == 3:
            return self * self * self
        return NotImplemented

    def _through(self, operation: int, plain: Callable[[float], float]) -> _Symbol:
        return self.is_(plain(self.number)) if self.known else self.keeper.took(operation, self.place)

    def exp(self) -> _Symbol:
        return self._through(EXP, math.exp)

    def sin(self) -> _Symbol:
        return self._through(SIN, math.sin)

    def cos(self) -> _Symbol:
        return self._through(COS, math.cos)

    def sqrt(self) -> _Symbol:
        return self._through(ROOT, math.sqrt)


@lru_cache(maxsize=32)
def recorded(f: Callable[[np.ndarray, np.ndarray], np.ndarray], n: int, m: int, rows: int) -> Tape | None:
    """The tape of f(x, u) with n states, m inputs and so many rows; None where f does what a tape cannot."""
    keeper = _Keeper(n + m)
    x, u = np.empty((n, 1), dtype=object), np.empty((m, 1), dtype=object)
    x[:, 0], u[:, 0] = [_Symbol(keeper, i) for i in range(n)], [_Symbol(keeper, n + j) for j in range(m)]
    try:
        found = np.asarray(f(x, u))
        if found.shape != (rows, 1) or len(keeper.steps) > MAX_TAPE_STEPS:
            return None
        nothing = _Symbol(keeper, -1)
        ends = [(nothing + value).at() for value in found[:, 0].tolist()]
    except UNFIT:
        return None
    steps = np.array(keeper.steps, dtype=np.int64).reshape(-1, 3)
    return Tape(steps, np.array(keeper.numbers, dtype=float), np.array(ends, dtype=np.int64))


# --- running -------------------------------------------------------------------------------------------------------------
def run_lanes(steps, numbers, first, X, plain):
    """Fill the places of X (places, lanes) from `first` on, a state in each lane; lanes from `plain` on hold slopes of lane 0."""
    lanes = X.shape[1]
    for i in range(len(steps)):
        operation, a, b, to, c = steps[i, 0], steps[i, 1], steps[i, 2], first + i, numbers[i]
        if operation == SCALED:
            for l in range(lanes):
                X[to, l] = c * X[a, l]
        elif operation == ADD:
            for l in range(lanes):
                X[to, l] = X[a, l] + X[b, l]
        elif operation == LESS:
            for l in range(lanes):
                X[to, l] = X[a, l] - X[b, l]
        elif operation == SHIFTED:
            for l in range(plain):
                X[to, l] = X[a, l] + c
            for l in range(plain, lanes):
                X[to, l] = X[a, l]
        elif operation == TIMES:
            p, q = X[a, 0], X[b, 0]
            for l in range(plain):
                X[to, l] = X[a, l] * X[b, l]
            for l in range(plain, lanes):
                X[to, l] = q * X[a, l] + p * X[b, l]
        elif operation == OVER:
            for l in range(plain):
                X[to, l] = X[a, l] / X[b, l]
            p, q = X[to, 0], X[b, 0]
            for l in range(plain, lanes):
                X[to, l] = (X[a, l] - p * X[b, l]) / q
        elif operation == NUMBER:
            for l in range(lanes):
                X[to, l] = c if l < plain else 0.0
        else:
            p = 0.0
            if operation == EXP:
                for l in range(plain):
                    X[to, l] = np.exp(X[a, l])
                p = X[to, 0]
            elif operation == SIN:
                for l in range(plain):
                    X[to, l] = np.sin(X[a, l])
                p = np.cos(X[a, 0])
            elif operation == COS:
                for l in range(plain):
                    X[to, l] = np.cos(X[a, l])
                p = -np.sin(X[a, 0])
            else:
                for l in range(plain):
                    X[to, l] = np.sqrt(X[a, l])
                p = 0.5 / X[to, 0]
            for l in range(plain, lanes):
                X[to, l] = p * X[a, l]


def flow_lanes(f, first, X, plain, h, parts, Y, K, total):
    """Take the lanes of Y (n, lanes) along tape f in `parts` steps of length h of Runge and Kutta; u stands in X, K and total are as Y."""
    n, lanes = Y.shape
    for _ in range(parts):
        for i in range(n):
            for l in range(lanes):
                X[i, l] = Y[i, l]
        for stage in range(4):
            run_lanes(f.steps, f.numbers, first, X, plain)
            for i in range(n):
                for l in range(lanes):
                    K[i, l] = X[f.ends[i], l]
            weight, reach = 1.0 if stage == 0 or stage == 3 else 2.0, h if stage == 2 else 0.5 * h
            for i in range(n):
                for l in range(lanes):
                    total[i, l] = K[i, l] if stage == 0 else total[i, l] + weight * K[i, l]
                    X[i, l] = Y[i, l] + reach * K[i, l]
        for i in range(n):
            for l in range(lanes):
                Y[i, l] += h / 6 * total[i, l]
