"""Recover the loop step by step towards state feedback (LTR)."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Design, Job, Outcome
from observer_lab.engine import loop_margins, recover
from observer_lab.engine.design import typical_rate
from observer_lab.engine.feedback import state_feedback_margins
from observer_lab.plants import Model
from observer_lab.text import text

from ..toolkit.gains import by_hand
from .analyses import Margins, Refusal, attempt, margins, noises
from .study import RECOVERY_LEVELS, SAMPLED, Study, frequencies, largest


@dataclass(frozen=True, eq=False)
class Recovery:
    """What was recovered so far: steps (q, α, α with x known), σ_max(S) over frequency, and the margins of the loop with `L`."""

    steps: tuple[tuple[float, float, float], ...]
    sensitivity: np.ndarray
    L: np.ndarray
    margins: Margins | Refusal


def try_recovery(model: Model, outcome: Outcome[Study]) -> Iterator[tuple[float, Recovery]]:
    """The job: the loop recovered step by step towards what state feedback has, from the design's own K."""
    plant, K, L, design = model.plant, outcome.gains["K"], outcome.gains["L"], outcome.design
    if plant.dt:
        raise KnobError(SAMPLED)
    aim = state_feedback_margins(plant, K)
    if not aim.stable:
        raise KnobError(text("A − BK is not stable, so there is nothing to recover; move a controller pole."))
    G, W, V = noises(model, design["sensor"])
    size = np.sqrt(float(np.trace(G @ W @ G.T)) / max(float(np.trace(plant.B @ plant.B.T)), 1e-300))
    target = aim.input_disk.alpha
    own = attempt(lambda: margins(plant, K, L, True))
    grid, steps = frequencies(plant_rate=typical_rate(plant), dt=plant.dt), ()
    for k, q in enumerate(RECOVERY_LEVELS, start=1):
        found = recover(plant, K, W, V, float(q) * size, G=G)
        built = loop_margins(plant, found.compensator)
        steps = (*steps, (float(q), float(built.input_disk.alpha), float(target)))
        yield k / len(RECOVERY_LEVELS), Recovery(steps, largest(built.loop, grid), L, own)


def key(design: Design) -> Hashable:
    """What the recovery rests on: K and the noise."""
    chosen = design["controller_poles"] if by_hand(design) else (design["q"], design["r"])
    return design["method"], chosen, design["sensor"]


def shown(outcome: Outcome[Study], found: Recovery) -> Outcome[Study]:
    """The outcome with what was recovered, and the margins of its loop if they were worked out for it."""
    study = replace(outcome.study, steps=found.steps, recovered=found.sensitivity)
    if np.array_equal(found.L, outcome.gains["L"]):
        study = replace(study, patient=found.margins)
    return replace(outcome, study=study)


def job_on(model: Model) -> Job[Study, Recovery]:
    """The job for a plant."""
    return Job(text("Recover the margins"), partial(try_recovery, model), key, shown, figure="recovery")
