"""Fit lesson 12 to the user's own plant: ranks, Hankel values, a truncation and its error."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from observer_lab.course.exercises.derivation import no_numbers
from observer_lab.course.knobs import Knob, Number
from observer_lab.course.lesson import Lesson
from observer_lab.engine.design import typical_rate
from observer_lab.plants import Model
from observer_lab.text import text

from .code import own_code
from .figures import figures
from .knobs import MODEL
from .own_system import OwnSystem, own_setting, system_of
from .study import compute

CLOCK_DECADES = 3  # how far the unit of time goes to both sides of the plant's own


def own_knobs(lesson: Lesson, s: OwnSystem) -> tuple[Knob, ...]:
    """The order between what must stay and what takes part, the unit of time about the plant's own, and what is asked everywhere."""
    own_time = 1 / typical_rate(s.plant)
    order = Number("order", "r", text("states kept"), low=s.least, high=s.most, default=s.good, scale="integer", group=MODEL,
                   hidden=s.least >= s.most,
                   hint=text("Order of the balanced truncation; unstable states always stay. The ghost is this model after the same blow."))
    clock = lesson.knob("clock")
    assert isinstance(clock, Number)
    wide = 10.0**CLOCK_DECADES
    return (order, replace(clock, low=min(1.0, own_time) / wide, high=max(1.0, own_time) * wide), lesson.knob("tolerance"),
            lesson.knob("measure"))


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant; tasks and closed forms are about the platform and stay with it."""
    s = system_of(model)
    here = own_setting(s)
    return replace(lesson, knobs=own_knobs(lesson, s), compute=partial(compute, here), figures=partial(figures, here), tasks=(),
                   answering="error", code=own_code, derived=no_numbers, key=("order", "clock", "tolerance"), aside=("measure",))
