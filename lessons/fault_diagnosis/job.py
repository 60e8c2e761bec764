"""The longer computation: many drawn runs, healthy ones for the false alarms and faulty ones for the verdicts."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import replace

import numpy as np

from app.lesson.lesson import Design, Job, Outcome
from app.text import text

from .bank import DT, NAMES
from .diagnosis import judge
from .runs import BLIND, SWITCH, Case, draw, simulate
from .study import Study, Trials, case_of, metrics_of, test_of

RUNS, AT_ONCE = 400, 4


def try_often(outcome: Outcome[Study]) -> Iterator[tuple[float, Trials]]:
    """Healthy runs for the false alarms and, where there is a fault, faulty ones for the verdicts."""
    s, seed = outcome.study, int(outcome.design["seed"])
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
            yield count / RUNS, Trials(count, windows, alarms, some, right, wrong, tuple(delays))


def healthy_case(case: Case) -> Case:
    """The same loop without fault or kick: all that false alarms depend on."""
    return Case(force=case.force, tone=case.tone, loop=BLIND if case.loop == SWITCH else case.loop, stiffer=case.stiffer)


def depends(design: Design) -> Hashable:
    """What counts rest on: the fault and the test; acting on a verdict and a kick do not touch them."""
    case = case_of(design)
    return test_of(design), healthy_case(case), replace(case, loop=BLIND, kick=-1.0), design["seed"]


def shown(outcome: Outcome[Study], found: Trials) -> Outcome[Study]:
    """The outcome with what many runs have shown."""
    study = replace(outcome.study, trials=found)
    return replace(outcome, study=study, metrics=metrics_of(study))


JOB = Job(text("Try {runs} runs", runs=RUNS), try_often, depends, shown, figure="rates")
