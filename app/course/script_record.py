"""Describe a lesson's run as code: given numbers, equations, numbers to find again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

__all__ = ["Code", "GivenValue", "ShownValue"]

Value: TypeAlias = "np.ndarray | Sequence[float] | Sequence[Sequence[float]] | float | int | bool | str"


@dataclass(frozen=True, eq=False)
class GivenValue:
    """A number, matrix or word that the equations start from, under its name in the script."""

    name: str
    value: Value
    note: str = ""


@dataclass(frozen=True, eq=False)
class ShownValue:
    """A number of the page that the script finds again under `name`, to 1e-6 of `size` (None: of its largest entry).

    `poles`: a set without order, compared by its polynomial.
    """

    name: str
    value: Value
    size: float | None = None
    poles: bool = False


@dataclass(frozen=True, eq=False)
class Code:
    """`parts` name the equations, in order, from what is `given` to what is `shown`; `unsaid` is what they leave out.

    `drawn`: what Python draws from the seed, for a language whose generator gives other numbers.
    `period`: of a plant A, B, C that is given at its samples, in s.
    """

    parts: tuple[str, ...]
    given: tuple[GivenValue, ...]
    shown: tuple[ShownValue, ...]
    unsaid: str = ""
    drawn: tuple[GivenValue, ...] = ()
    period: float = 0.0
