"""Fit lesson 2 to the user's own plant, without the notes."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.knobs import Choice, Knob, Number, Poles, Track
from observer_lab.course.lesson import Lesson
from observer_lab.engine.design import typical_rate
from observer_lab.plants import Model
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import text

from ..toolkit.gains import injection
from ..toolkit.knobs import run_knobs
from .derive import derived
from .figures import figures
from .knobs import BY_POLES, KNOBS
from .study import Setting, compute


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """Input, observer poles and first guess in the plant's own measures."""
    window, pace, size = model.observer_window, typical_rate(model.plant) / (2 * np.pi), model.u_max
    name = model.plant.input_names[0]
    return (
        Choice("input", "u", text("input {name}", name=signal_name(model.plant, name)), default="sine",
               options=KNOBS[0].options,  # type: ignore[attr-defined]
               hint=text("The plant and the observer get the same input.")),
        Number("amplitude", r"u_0", text("amplitude"), model.input_unit, low=0.0, high=5 * size, default=size,
               when=("input", ("step", "sine", "square", "random")),
               hint=text("How strong the input is.")),
        Number("frequency", "f", text("frequency"), "Hz", low=pace / 30, high=pace * 30, default=pace / 2, scale="log",
               when=("input", ("sine", "square")), hint=text("How quickly the input turns round.")),
        Number("seed", r"s_0", text("random seed"), low=0, high=9999, default=1, scale="integer",
               when=("input", ("random",)), hint=text("The same seed gives the same input.")),
        Track("hand", "u", text("input by hand"), model.input_unit, low=-2 * size, high=2 * size,
              when=("input", ("hand",)), hint=text("Press play and move this: your hand is recorded.")),
        Choice("method", "L", text("gain by"), default=BY_POLES, options=((BY_POLES, text("dragging poles")),),
               hidden=True),
        Poles("observer_poles", "q", text("Observer poles"), "rad/s", default=model.observer_poles,
              re_low=window.re_low, re_high=window.re_high, im_high=window.im_high, role="estimate",
              hidden=not model.observer_poles,
              hint=text("Eigenvalues of A − LC that can be moved; the engine finds L.")),
        Number("guess", r"\gamma", text("first guess, share of the true start"), low=-1.0, high=2.0,
               default=0.0,
               step=0.05, hint=text("0: the observer starts at rest; 1: exactly where the plant is.")),
        run_knobs(model.horizon)[1],
    )


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, which fits whatever it is; the notes stay with their own."""
    plant = model.plant
    parts = tuple((text("e: {name}", name=s.name), s.unit) for s in model.watched[:2])
    here = Setting(
        model, lambda design: plant, model.horizon, model.dt, lambda design: plant,
        lambda design: injection(plant, design["observer_poles"], model),
        lambda design: tuple(design["guess"] * v for v in model.x0), parts, text("the plant's own poles  eig(A)"))
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, here), figures=partial(figures, here), tasks=(),
                   derived=partial(derived, here))
