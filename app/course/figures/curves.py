"""Define the curves and points of figures, and which of them lie on one another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...text import NO_WORDS, Text

Dash = Literal["solid", "dash", "dot", "pin1", "pin2", "pin3", "pin4"]
PIN_DASHES: tuple[Dash, ...] = ("pin1", "pin2", "pin3", "pin4")
THIN, UNDER = 1.1, 6.0  # width of a pinned curve, of one on which another lies
SAME_CURVE_RTOL = 1e-9  # of its largest value: a pinned curve that differs by less lies under the present one


@dataclass(frozen=True, eq=False)
class Curve:
    """One line: y over the figure's common x (or over its own `x` in a plane).

    One with a `pin` belongs to the pinned design of that name; it alone may hold NaN, where its run does not reach.
    """

    name: Text
    y: np.ndarray
    role: str = "plant"
    dash: Dash = "solid"
    width: float = 2.0
    x: np.ndarray | None = None
    pin: Text = NO_WORDS

    def called(self, language: str) -> str:
        """Its name, with that of its pin: "true · A"."""
        return " · ".join(each for each in (self.name(language), self.pin(language)) if each)

    @property
    def key(self) -> tuple[Text, str, str]:
        """What tells it apart in a key: a pin has one entry there, whatever its curves are."""
        return (self.pin, "", self.dash) if self.pin.id else (self.name, self.role, self.dash)

    def entry(self, language: str) -> str:
        """Its name in a key."""
        return (self.pin if self.pin.id else self.name)(language)

    @property
    def drawn(self) -> np.ndarray:
        """Its values fit to draw."""
        return np.asarray(self.y, dtype=float) if self.pin.id else finite(self.y)

    @property
    def xs(self) -> np.ndarray:
        """Where it lies in a plane: its own x, or the numbers of its values."""
        return np.arange(len(self.y), dtype=float) if self.x is None else self.x

    def of_pin(self, place: int, pin: Text, y: np.ndarray, x: np.ndarray | None) -> Curve:
        """The thin curve of a pinned design, whose place among the pins gives its dashes."""
        return Curve(self.name, y, self.role, PIN_DASHES[place], THIN, x, pin)

    def lies_on(self, others: Sequence[Curve]) -> bool:
        """Whether one of the others of its role lies where it does."""
        return any(other.role == self.role and _alike(self.y, other.y) and _alike(self.x, other.x) for other in others)


@dataclass(frozen=True, eq=False)
class Point:
    """A mark in a plane: a cross (pole), a circle (zero, start), a ring around other marks, a bolt (a mode that cannot move),
    hollow (of a pin), up (beyond the upper edge)."""

    x: float
    y: float
    role: str = "plant"
    mark: Literal["cross", "circle", "ring", "bolt", "dot", "hollow", "up"] = "cross"
    name: Text = NO_WORDS

    @property
    def key(self) -> tuple[str, str, str, str]:
        """What it is and where it stands, to nine digits."""
        return self.role, self.mark, f"{self.x + 0.0:.9g}", f"{self.y + 0.0:.9g}"

    def called(self, language: str) -> str:
        """Its name, else its role and mark."""
        return self.name(language) or f"{self.role} {self.mark}"


def finite(values: np.ndarray, bound: float = 1e12) -> np.ndarray:
    """Values fit to draw: NaN becomes 0, and what exceeds ±bound is clipped."""
    return np.clip(np.nan_to_num(np.asarray(values, dtype=float), nan=0.0, posinf=bound, neginf=-bound), -bound, bound)


def thin_samples(t: np.ndarray, *series: np.ndarray, points: int = 500) -> tuple[np.ndarray, ...]:
    """Every k-th sample, the last one kept, so that a curve has at most `points` + 1 points on the screen."""
    step = max(1, math.ceil(len(t) / points))
    index = np.unique(np.append(np.arange(0, len(t), step), len(t) - 1))
    return (t[index], *(s[index] for s in series))


def _alike(one: np.ndarray | None, other: np.ndarray | None) -> bool:
    """Whether two records differ by at most SAME_CURVE_RTOL of the largest value; most others differ at the first or the middle one."""
    if one is None or other is None:
        return one is other
    a, b = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    if a.shape != b.shape:
        return False
    near = SAME_CURVE_RTOL * float(np.abs(finite(b)).max(initial=0.0))
    return all(abs(a[k] - b[k]) <= near for k in (0, len(a) // 2) if k < len(a)) and bool(np.all(np.abs(a - b) <= near))
