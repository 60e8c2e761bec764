"""Rank of the controllability and observability matrices: how it hangs on a tolerance and on the unit of time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from app.engine import controllability, observability
from app.plants.platform import in_time_units
from app.text.words import Text

from .system import System

RELATIVE, ABSOLUTE = "relative", "absolute"
MEASURES = ((RELATIVE, Text("of the largest", "相对最大值")), (ABSOLUTE, Text("as they are", "绝对值")))
REPORT = (1e-12, 1e-6)  # tolerances that the report names


@dataclass(frozen=True, eq=False)
class Ranks:
    """Singular values (10,) of both matrices, time counted in units of `clock` seconds."""

    clock: float
    reached: np.ndarray
    seen: np.ndarray

    def at(self, tolerance: float, measure: str) -> tuple[int, int]:
        """Rank of both matrices: singular values above the tolerance, or above the tolerance times the largest."""
        return _count(self.reached, tolerance, measure), _count(self.seen, tolerance, measure)


@lru_cache(maxsize=64)
def ranks(s: System, clock: float) -> Ranks:
    """Singular values with time in units of `clock` seconds; metres, radians and newtons stay."""
    counted = in_time_units(s.plant, clock)
    return Ranks(clock, controllability(counted).singular_values, observability(counted).singular_values)


def _count(values: np.ndarray, tolerance: float, measure: str) -> int:
    return int(np.count_nonzero(values > tolerance * (values[0] if measure == RELATIVE else 1.0)))
