"""Fit lesson 3 to the user's own plant: outputs on and off, states in typical sizes."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.knobs import Knob, KnobError, Number, Switch
from observer_lab.course.lesson import Design, Lesson
from observer_lab.plants import Model
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import text

from ..toolkit.gains import sizes
from .cases import Case, sensed_by
from .derive import derived
from .knobs import KNOBS
from .study import Setting, compute

SWITCHES = 6  # outputs with a switch; what a plant has beyond these stays on
OBSERVED_INSTANTS, FEW_INSTANTS = 120, 50  # instants, for few states and for many
MAX_GROWTH_EXPONENT = 5.0  # how many times e a run may grow
SHARED = ("tolerance", "reading", "noise", "criterion", "apart", "seed")  # knobs taken from the lesson as they are


def case_of(model: Model) -> Case:
    """The plant before its sensors. Raises KnobError for a single state, which no ellipse can show."""
    plant, n = model.plant, model.plant.n
    if n < 2:
        raise KnobError(text("With a single state there is nothing to distinguish; this lesson needs two states at "
                             "least."))
    fastest = float(np.real(plant.poles).max())
    horizon = min(model.horizon, MAX_GROWTH_EXPONENT / fastest) if fastest > 0 else model.horizon
    scale = tuple(abs(v) or 1.0 for v in model.x0)
    start = tuple((0.75, -0.6, 0.5, -0.4, 0.7)[i % 5] for i in range(n))
    return Case(
        "own",
        model.label,
        plant.state_names,
        scale,
        start,
        horizon,
        OBSERVED_INSTANTS if n <= 12 else FEW_INSTANTS,
        (0, 2 if n > 2 else None, 1),
        (0, 1),
        tuple(plant.unit(name) for name in plant.state_names),
        labels=tuple(signal_name(plant, name) for name in plant.state_names),
    )


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """A switch for each output, rows of O, and what the lesson asks everywhere."""
    names = model.plant.output_names[:SWITCHES]
    return (
        *(Switch(f"on{i}", "", text("sensor {name}", name=signal_name(model.plant, name)), default=True,
                 hint=text("On or off.")) for i, name in enumerate(names)),
        Number("rows", "k", text("block rows of O"), low=1, high=model.plant.n, default=1, scale="integer",
               hint=text("One step adds the next row C Aᵏ, that is, one more derivative of y.")),
        *(knob for knob in KNOBS if knob.name in SHARED),
    )


def own_setting(model: Model, case: Case, design: Design) -> Setting:
    """The plant with the outputs that are on, states and readings in typical sizes."""
    plant, scale = model.plant, np.array(case.scale)
    on = [i for i in range(plant.p) if i >= SWITCHES or design[f"on{i}"]]
    C = plant.C[on] * scale / sizes(model)[on][:, None] if on else np.zeros((1, plant.n))
    A = plant.A * scale / scale[:, None]
    return Setting(case, sensed_by(case, plant.n, np.ascontiguousarray(A).tobytes(), np.ascontiguousarray(C).tobytes()),
                   int(design["rows"]))


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant; the tasks turn sensors of the lesson's plants and stay with them."""
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, partial(own_setting, model, case_of(model))), tasks=(),
                   derived=partial(derived))
