"""Everything that one design leads to: the run, the verdict, what was to be expected, and what many runs found."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from app.engine.observers import Decoupling, binomial_band, decoupling
from app.lesson.lesson import Design

from .bank import DT, MODEL, NAMES, PLACES
from .diagnosis import Forecast, Rule, Verdict, forecast, judge
from .runs import BIAS, BLIND, NONE, SWITCH, Case, Record, draw, drawn, quiet, simulate, switched

RUNS, AT_ONCE = 400, 4
LEVEL = 0.99  # of the binomial band


@dataclass(frozen=True, eq=False)
class Trials:
    """What many drawn runs gave: alarms of windows that do not overlap, and, with a fault, who was accused.

    alarms (7,) and `any` over `windows` windows of healthy runs; right, wrong, nobody: verdicts of `runs` runs with the
    fault; delays in s of the right ones.
    """

    runs: int
    windows: int
    alarms: np.ndarray
    any: int
    right: int
    wrong: int
    delays: tuple[float, ...]

    @property
    def nobody(self) -> int:
        """Runs in which nobody was accused."""
        return self.runs - self.right - self.wrong

    def band(self, rate: float) -> tuple[float, float]:
        """Where the share of alarms of one member is to lie."""
        return binomial_band(self.windows, rate, LEVEL)


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
        return None if self.case.place == NONE else PLACES.index(self.case.place)

    @property
    def right(self) -> bool:
        """Whether the verdict is the truth and came after the fault."""
        v = self.verdict
        return v.who == self.case.place and v.decided is not None and v.decided >= self.case.start

    @property
    def delay(self) -> float | None:
        """Seconds from the fault to the verdict."""
        d = self.verdict.decided
        return None if d is None or self.case.place == NONE else DT * (d - self.case.start)


def case_of(d: Design) -> Case:
    """What a design simulates; knobs that do not matter are left at their defaults, so that equal runs are equal cases."""
    place, kind = d["place"], d["kind"]
    common = {"force": d["force"], "tone": d["tone"], "loop": d["loop"], "stiffer": d["stiffer"] / 100, "kick": d["kick"]}
    if place == NONE:
        return Case(**common)
    if place.startswith("u"):
        return Case(place, BIAS, d["loss"] / 100, d["at"], **common)
    size = {"bias": d["bias"], "drift": d["drift"]}.get(kind, 0.0)
    return Case(place, kind, size, d["at"], **common)


def test_of(d: Design) -> Rule:
    """How a design judges."""
    return Rule(d["statistic"], int(d["window"]), d["rate"])


def study(d: Design) -> Study:
    """One design, worked out."""
    case, test = case_of(d), test_of(d)
    blind = simulate(case, drawn(int(d["seed"])))
    verdict = judge(test, blind)
    record = blind
    if case.loop == SWITCH and verdict.decided is not None and verdict.who is not None:
        record = switched(case, drawn(int(d["seed"])), blind, verdict.decided, verdict.who)
        later = judge(test, record)
        verdict = replace(later, decided=verdict.decided, who=verdict.who, first=verdict.first)
    silent = quiet(case)
    column = None if case.place == NONE else PLACES.index(case.place)
    expected = forecast(test, silent, column, case.start)
    return Study(case, test, record, blind, verdict, silent, expected, _calm(case, silent, expected))


def _calm(case: Case, silent: Record, expected: Forecast) -> float:
    """The largest pitch in rad after the fault, without noise, where the loop acts when the verdict is due."""
    if case.loop == SWITCH and expected.delay is not None:
        silent = switched(replace(case, kick=-1.0), drawn(-1), silent, case.start + expected.delay, case.place)
    return float(np.abs(silent.x[0 if case.place == NONE else case.start:, 2]).max())


@lru_cache(maxsize=3)
def unknown_coil(coil: int) -> Decoupling:
    """Whether an observer of the whole deck could ignore this coil, in continuous time."""
    return decoupling(MODEL.plant, MODEL.plant.B[:, [coil]])


# --- many runs ----------------------------------------------------------------------------------------------------------
def try_often(s: Study, seed: int) -> Iterator[tuple[float, Study]]:
    """Healthy runs for the false alarms and, where there is a fault, faulty ones for the verdicts."""
    healthy, faulty = healthy_case(s.case), replace(s.case, kick=-1.0, loop=BLIND if s.case.loop == SWITCH else s.case.loop)
    alarms, some, windows, right, wrong = np.zeros(len(NAMES), dtype=int), 0, 0, 0, 0
    delays: list[float] = []
    for count, drawn_seed in enumerate(np.random.SeedSequence([seed, 5]).generate_state(RUNS), start=1):
        noise = draw(int(drawn_seed))
        over = s.test.values(simulate(healthy, noise).residuals)[s.test.window - 1::s.test.window] > s.test.threshold
        alarms, some, windows = alarms + over.sum(axis=0), some + int(over.any(axis=1).sum()), windows + len(over)
        if s.column is not None:
            v = judge(s.test, simulate(faulty, noise))
            if v.who == s.case.place and v.decided is not None and v.decided >= s.case.start:
                right += 1
                delays.append(DT * (v.decided - s.case.start))
            elif v.who is not None:
                wrong += 1
        if count % AT_ONCE == 0:
            s = replace(s, trials=Trials(count, windows, alarms, some, right, wrong, tuple(delays)))
            yield count / RUNS, s


def healthy_case(case: Case) -> Case:
    """The same loop without fault or kick: all that false alarms depend on."""
    return Case(force=case.force, tone=case.tone, loop=BLIND if case.loop == SWITCH else case.loop, stiffer=case.stiffer)
