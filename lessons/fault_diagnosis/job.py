"""The longer computation: many drawn runs, healthy ones for the false alarms and faulty ones for the verdicts."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import replace

import numpy as np

from app.lesson.lesson import Design, Job, Outcome
from app.text import text

from .bank import COUNT, DT, NAMES
from .diagnosis import judged
from .many import residuals_of
from .record import Study, Trials, named_by
from .runs import BLIND, SWITCH, Case, draw
from .study import case_of, metrics_of, test_of

RUNS, AT_ONCE = 400, 40


def try_often(outcome: Outcome[Study]) -> Iterator[tuple[float, Trials | None]]:
    """Healthy runs for the false alarms and, where there is a fault, faulty ones for the verdicts."""
    s, seed = outcome.study, int(outcome.design["seed"])
    healthy, faulty = healthy_case(s.case), replace(s.case, kick=-1.0, loop=BLIND if s.case.loop == SWITCH else s.case.loop)
    alarms, some, windows, right, wrong = np.zeros(len(NAMES), dtype=int), 0, 0, 0, 0
    delays: list[float] = []
    seeds = np.random.SeedSequence([seed, 5]).generate_state(RUNS)
    for count in range(AT_ONCE, RUNS + 1, AT_ONCE):
        noises = [draw(int(drawn_seed)) for drawn_seed in seeds[count - AT_ONCE:count]]
        yield (count - 0.8 * AT_ONCE) / RUNS, None
        over = s.test.values(residuals_of(healthy, noises))[s.test.window - 1::s.test.window] > s.test.threshold
        alarms, some, windows = alarms + over.sum(axis=(0, 1)), some + int(over.any(axis=2).sum()), windows + over[..., 0].size
        yield (count - 0.5 * AT_ONCE) / RUNS, None
        ratios = s.test.values(residuals_of(faulty, noises)) / s.test.threshold if s.column is not None else np.empty((COUNT, 0))
        for run in range(ratios.shape[1]):
            v = judged(s.test, ratios[:, run])
            named = named_by(v, s.case)
            if named is not None and v.decided is not None:
                right += 1
                delays.append(DT * (v.decided - named.start))
            elif v.who is not None:
                wrong += 1
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


JOB = Job(text("Try {runs} runs", runs=RUNS), try_often, depends, shown, figure="rates", follows=True)
