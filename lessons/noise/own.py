"""Fit lesson 8 to the user's own plant: the assumed process noise takes the place of speed."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from observer_lab.course.knobs import Choice, Knob, Number, Poles
from observer_lab.course.lesson import Lesson
from observer_lab.plants import Model
from observer_lab.text import text

from ..toolkit.knobs import run_knobs
from .figures import figures
from .knobs import BY_POLES
from .own_study import BELIEF, judged, own_setting
from .study import compute


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """The lesson's knobs in the plant's own measures."""
    window, (one, two) = model.observer_window, judged(model)
    return (
        Choice("method", "", text("observer by"), default=BELIEF,
               options=((BELIEF, text("belief in the process noise")), (BY_POLES, text(
                   "dragging poles"))),
               hint=text("A Kalman filter that assumes b times the process noise, or poles of your own.")),
        Number("belief", "b", text("assumed / true process noise"), low=1e-3, high=1e3, default=100.0,
               scale="log",
               when=("method", (BELIEF,)), hint=text("Above 1 the observer is too fast, below 1 too slow.")),
        Poles("observer_poles", "q", text("Observer poles"), "rad/s", default=model.observer_poles, re_low=window.re_low,
              re_high=window.re_high, im_high=window.im_high, role="estimate", when=("method", (BY_POLES,)),
              hidden=not model.observer_poles, hint=text("eig(A − LC): farther left is faster.")),
        Number("w", r"\sigma_w", text("process noise, share of the natural input"), low=1e-3, high=10.0,
               default=0.1, scale="log", hint=text("An unknown input, as strong as this share of the natural one.")),
        Number("v", r"\sigma_v", text("sensor noise, share of the outputs"), low=1e-4, high=1.0,
               default=0.01,
               scale="log", hint=text("As a share of the outputs at the start.")),
        Number("start", r"\epsilon", text("error at the start"), low=0.0, high=2.0, default=0.3, step=0.05,
               hint=text("At 1 the observer starts from rest although the plant does not.")),
        Choice("watch", "", text("judge by the error in"), default="second",
               options=(("first", one.name), ("second", two.name)), hint=text("Which error the curves show.")),
        *run_knobs(model.horizon),
    )


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, where a Kalman filter for it exists; the tasks stay with the block."""
    here = own_setting(model)
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, here), figures=partial(figures, here), tasks=())
