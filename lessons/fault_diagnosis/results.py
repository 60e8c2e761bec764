"""Define the results of one design: run, diagnosis, expected values, many-run counts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from observer_lab.engine.observers import binomial_band

from .diagnosis import Forecast, Rule, Verdict
from .fault_pairs import Pair
from .observer_bank import DT, FAULT_PLACES
from .runs import NONE, Case, Fault, Record

BAND_PROBABILITY = 0.99  # of the binomial band


def named_by(v: Verdict, case: Case) -> Fault | None:
    """The fault that a verdict names after it began, None where it names none of them."""
    return next((f for f in case.faults if f.place == v.who and v.decided is not None and v.decided >= f.start), None)


@dataclass(frozen=True, eq=False)
class Trials:
    """What many drawn runs gave: false alarms of healthy runs and, with a fault, who was accused.

    alarms (7,) and `any` over `windows` windows that do not overlap; `false`: alarms of the bank that tests at every sample and
    empties its windows after each, in `full` samples with full windows; right, wrong, nobody: verdicts of `runs` runs with the
    fault; delays in s of the right ones.
    """

    runs: int
    windows: int
    alarms: np.ndarray
    any: int
    false: int
    full: int
    right: int
    wrong: int
    delays: tuple[float, ...]

    @property
    def nobody(self) -> int:
        """Runs in which nobody was accused."""
        return self.runs - self.right - self.wrong

    def between(self, window: int) -> float:
        """Mean time in s between two false alarms of the bank in the healthy runs; infinite where there was none."""
        return DT * (window - 1 + self.full / self.false) if self.false else math.inf

    def band(self, rate: float) -> tuple[float, float]:
        """Where the share of alarms of one member is to lie."""
        return binomial_band(self.windows, rate, level=BAND_PROBABILITY)


@dataclass(frozen=True, eq=False)
class Study:
    """`record` is the run that is shown; `blind` the one in which nobody acts (the same object if nobody does)."""

    case: Case
    test: Rule
    record: Record
    blind: Record
    verdict: Verdict
    silent: Record
    forecast: Forecast
    calm: float
    trials: Trials | None = None

    @property
    def column(self) -> int | None:
        """The column of the true fault, if there is one."""
        return None if self.case.place == NONE else FAULT_PLACES.index(self.case.place)

    @property
    def accused(self) -> Fault | None:
        """The fault that is accused after it began, if there is one."""
        return named_by(self.verdict, self.case)

    @property
    def right(self) -> bool:
        """Whether the verdict is a truth and came after the fault."""
        return self.accused is not None

    @property
    def delay(self) -> float | None:
        """Seconds from the fault, that which is accused or else the first, to the verdict."""
        d = self.verdict.decided
        return None if d is None or self.case.place == NONE else DT * (d - (self.accused or self.case).start)

    @property
    def pair(self) -> Pair | None:
        """The columns of both faults in ascending order, if there are two."""
        if self.case.also is None:
            return None
        one, other = sorted((FAULT_PLACES.index(self.case.place), FAULT_PLACES.index(self.case.also.place)))
        return one, other
