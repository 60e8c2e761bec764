"""Fit lesson 5 to the user's own plant: Riccati equations, Gramians, poles."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.knobs import Choice, Knob, KnobError, Number, Poles
from observer_lab.course.lesson import Lesson
from observer_lab.engine import controllability, observability
from observer_lab.plants import Model, Window
from observer_lab.plants.signal_names import with_unit
from observer_lab.text import text

from ..toolkit.gains import sizes
from ..toolkit.knobs import BY_POLES, BY_WEIGHTS, run_knobs
from .derive import derived
from .dual_quantities import Setting
from .figures import figures
from .knobs import KNOBS, TERMINAL
from .study import compute

BY_HAND = 6  # most states for which Ackermann's formula, the observer's own, is trusted


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant. Raises KnobError unless both sides can stabilise all of it."""
    plant = model.plant
    seen, reached = observability(plant), controllability(plant)
    if not (seen.observable and reached.controllable):
        raise KnobError(text("Both sides of this lesson move every pole, so the plant must be observable and "
                             "controllable; the lesson on hidden modes takes any."))
    here = setting_of(model)
    hand = plant.p == 1 and plant.n <= BY_HAND and len(model.controller_poles) == plant.n
    return replace(lesson, knobs=own_knobs(model, here.window, hand), compute=partial(compute, here),
                   figures=partial(figures, here), derived=partial(derived, here), tasks=())


def setting_of(model: Model) -> Setting:
    """Weights in units of the start, the outputs near it and the natural input; the ellipses of the first two states."""
    plant = model.plant
    size = np.array([abs(v) or 1.0 for v in model.x0])
    axes = [with_unit(plant, name) for name in plant.state_names]
    pair = (0, min(1, plant.n - 1))
    c, o = model.controller_window, model.observer_window
    window = Window(min(c.re_low, o.re_low), max(c.re_high, o.re_high), max(c.im_high, o.im_high))
    return Setting(model, lambda design: plant, np.diag(1 / size**2), np.eye(plant.m) / model.u_max**2, np.diag(size**2),
                   np.diag(sizes(model) ** 2), pair, (axes[pair[0]], axes[pair[1]]), window)


def own_knobs(model: Model, window: Window, hand: bool) -> tuple[Knob, ...]:
    """The lesson's knobs without its sensor to turn; poles by hand where the observer's own formula can be trusted."""
    methods = (((BY_POLES, text("dragging poles")),) if hand else ()) + ((BY_WEIGHTS, text(
        "Q/R weights")),)
    method = Choice("method", "", text("gains by"), default=methods[0][0], options=methods, hidden=not hand,
                    hint=text("Drag one set of poles for both boards, or let the two Riccati equations choose."))
    poles = Poles("poles", "p", text("Poles of both boards"), "rad/s", default=model.controller_poles,
                  re_low=window.re_low, re_high=window.re_high, im_high=window.im_high, when=("method", (BY_POLES,)),
                  hint=text("Drag a cross on either board: both boards hold the same poles."))
    span = Number("window", "T", text("length T of the window"), "s", low=model.horizon / 30, high=model.horizon,
                  default=model.horizon / 3, hint=text(
                      "How long the input acts, and how long the output is measured."))
    weights = [k for k in KNOBS if k.name in ("q", "r", "mirror", "w", "v")]
    return (method, *((poles,) if hand else ()), span, TERMINAL, *weights, *run_knobs(model.horizon))
