"""Fit lesson 9 to the user's own plant."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from observer_lab.course.knobs import Knob, Number
from observer_lab.course.lesson import Lesson
from observer_lab.plants import Model
from observer_lab.text import text

from ..toolkit.knobs import run_knobs
from .code import own_code
from .figures import figures
from .job import job_of
from .own_study import own_setting
from .study import compute

RIGHT_R = 1.0  # at the start only the assumed Q is wrong


def own_knobs(lesson: Lesson, model: Model) -> tuple[Knob, ...]:
    """Beliefs, true noises in the plant's own measures, and the step to look at."""
    return (
        lesson.knob("q"),
        replace(lesson.knob("r"), default=RIGHT_R),
        Number("w", r"\sigma_w", text("process noise, share of the natural input"), low=1e-3, high=10.0,
               default=0.1, scale="log", hint=text("How strongly an unknown input shakes the plant.")),
        Number("v", r"\sigma_v", text("sensor noise, share of the outputs"), low=1e-4, high=1.0,
               default=0.003,
               scale="log", hint=text("As a share of the outputs at the start.")),
        lesson.knob("k"),
        lesson.knob("phase"),
        *run_knobs(model.horizon),
    )


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, where a Kalman filter for it exists; report and converter stay with the deck."""
    here = own_setting(model)
    return replace(lesson, knobs=own_knobs(lesson, model), compute=partial(compute, here), figures=partial(figures, here), tasks=(),
                   code=own_code, job=job_of(here))
