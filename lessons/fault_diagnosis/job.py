"""Count false alarms in many fault-free runs and diagnoses in many faulty runs."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from observer_lab.course.lesson import Design, Job, Outcome
from observer_lab.text import text

from .diagnosis import judged
from .observer_bank import DT, MEMBER_NAMES, SAMPLE_COUNT, gain, guard, truth
from .results import Study, Trials, named_by
from .runs import KEEP_LOOP_OPEN, NO_REACTION, SWITCH_LOOP, Case, Noise, draw, failed, known_force, stretches
from .study import case_of, metrics_of, test_of

RUN_COUNT, BATCH_RUNS = 400, 40


def try_often(outcome: Outcome[Study]) -> Iterator[tuple[float, Trials | None]]:
    """Healthy runs for the false alarms and, where there is a fault, faulty ones for the verdicts."""
    s, seed = outcome.study, int(outcome.design["seed"])
    healthy, faulty = healthy_case(s.case), replace(s.case, kick=-1.0, loop=NO_REACTION if s.case.loop == SWITCH_LOOP else s.case.loop)
    alarms, some, windows, right, wrong = np.zeros(len(MEMBER_NAMES), dtype=int), 0, 0, 0, 0
    false, full = 0, 0
    delays: list[float] = []
    seeds = np.random.SeedSequence([seed, 5]).generate_state(RUN_COUNT)
    for count in range(BATCH_RUNS, RUN_COUNT + 1, BATCH_RUNS):
        noises = [draw(int(drawn_seed)) for drawn_seed in seeds[count - BATCH_RUNS:count]]
        yield (count - 0.8 * BATCH_RUNS) / RUN_COUNT, None
        every = np.asarray(s.test.values(residuals_of(healthy, noises)) > s.test.threshold)
        more, longer = false_alarms(np.any(every, axis=2), s.test.window)
        false, full, over = false + more, full + longer, every[s.test.window - 1::s.test.window]
        alarms, some, windows = alarms + over.sum(axis=(0, 1)), some + int(over.any(axis=2).sum()), windows + over[..., 0].size
        yield (count - 0.5 * BATCH_RUNS) / RUN_COUNT, None
        ratios = s.test.values(residuals_of(faulty, noises)) / s.test.threshold if s.column is not None else np.empty((SAMPLE_COUNT, 0))
        for run in range(ratios.shape[1]):
            v = judged(s.test, ratios[:, run])
            named = named_by(v, s.case)
            if named is not None and v.decided is not None:
                right += 1
                delays.append(DT * (v.decided - named.start))
            elif v.who is not None:
                wrong += 1
        yield count / RUN_COUNT, Trials(count, windows, alarms, some, false, full, right, wrong, tuple(delays))


def false_alarms(over: np.ndarray, window: int) -> tuple[int, int]:
    """Alarms of over (SAMPLE_COUNT, runs), and samples with a full window; after each alarm the window is emptied and fills anew."""
    count, full = 0, 0
    last = np.full(over.shape[1], -1)
    for k, now in enumerate(over):
        filled = k - last >= window
        full += int(filled.sum())
        count += int((alarm := filled & now).sum())
        last[alarm] = k
    return count, full


def healthy_case(case: Case) -> Case:
    """The same loop without fault or kick: all that false alarms depend on."""
    return Case(force=case.force, tone=case.tone, loop=NO_REACTION if case.loop == SWITCH_LOOP else case.loop, stiffer=case.stiffer)


def depends(design: Design) -> Hashable:
    """What counts rest on: the fault and the test; acting on a verdict and a kick do not touch them."""
    case = case_of(design)
    return test_of(design), healthy_case(case), replace(case, loop=NO_REACTION, kick=-1.0), design["seed"]


def shown(outcome: Outcome[Study], found: Trials) -> Outcome[Study]:
    """The outcome with what many runs have shown."""
    study = replace(outcome.study, trials=found)
    return replace(outcome, study=study, metrics=metrics_of(study))


JOB = Job(text("Try {runs} runs", runs=RUN_COUNT), try_often, depends, shown, figure="rates", follows=True)


def residuals_of(case: Case, noises: Sequence[Noise]) -> np.ndarray:
    """Residuals of the bank (SAMPLE_COUNT, runs, 7, 3) in the runs of a case without a kick in which nobody notices, one for each noise."""
    w, v = (np.stack([getattr(noise, name) for noise in noises], axis=1) for name in "wv")
    y, asked = _loop(case, w, v, np.stack([noise.whole for noise in noises]))
    s = guard().bank.system
    known = np.concatenate([asked, y], axis=2)
    states = _scan(s.A, known[:-1] @ s.B.T, np.stack([noise.bank for noise in noises]))
    return (states @ s.C.T + known @ np.asarray(s.D).T).reshape(SAMPLE_COUNT, len(noises), len(guard().bank.members), -1)


def _loop(case: Case, w: np.ndarray, v: np.ndarray, whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the sensors say, (SAMPLE_COUNT, runs, 4), and what is asked of the coils, (SAMPLE_COUNT, runs, 3)."""
    o, (A, _) = guard().whole, truth(case.stiffer)
    K = gain() if case.loop != KEEP_LOOP_OPEN else np.zeros((3, 6))
    shape = known_force(case)[:, None]
    z = np.empty((SAMPLE_COUNT + 1, len(whole), 12))
    z[0], said = np.hstack([np.zeros((len(whole), 6)), whole]), np.empty((SAMPLE_COUNT, len(whole), 4))
    for begin, end in stretches(case, 0):
        deck = failed(case, v, z[:, :, :6], begin)
        step = np.block([[A, -deck.B @ K], [o.K @ deck.C, o.F - o.G @ K]])
        push = np.concatenate([shape[begin:end] @ deck.B.T + w[begin:end],
                               shape[begin:end] @ o.G.T + deck.extra[begin:end] @ o.K.T], axis=2)
        z[begin:end + 1] = _scan(step, push, z[begin])
        said[begin:end] = z[begin:end, :, :6] @ deck.C.T + deck.extra[begin:end]
    return said, shape - z[:SAMPLE_COUNT, :, 6:] @ K.T


def _scan(step: np.ndarray, push: np.ndarray, start: np.ndarray) -> np.ndarray:
    """z⁺ = step z + push for all runs: (steps + 1, runs, N) of push (steps, runs, N)."""
    z = np.empty((len(push) + 1, *start.shape))
    z[0], turned = start, np.ascontiguousarray(step.T)
    for k in range(len(push)):
        np.matmul(z[k], turned, out=z[k + 1])
        z[k + 1] += push[k]
    return z
