"""Fit lesson 4 to the user's own plant, in its own measures."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.knobs import Knob, Number, Switch
from observer_lab.course.lesson import Lesson, Task
from observer_lab.engine.design import typical_rate
from observer_lab.plants import Model
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import text

from ..toolkit.gains import sizes, sped
from ..toolkit.knobs import method_knobs, pole_knobs, run_knobs
from ..toolkit.tasks import keep_fair_tasks
from .command import Target
from .derive import derived
from .figures import figures
from .study import Setting, compute
from .tasks import fast_observer


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """The knobs for a person's own plant: the same, in its own measures."""
    return (
        *method_knobs(),
        *pole_knobs(model),
        Number("mismatch", r"\delta", text("the plant is faster than its model by"), "%", low=-30.0, high=30.0,
               default=0.0, step=1.0, hint=text("A and B of the real plant are this much larger than those of the model.")),
        Number("delay", r"\tau", text("input delay, steps of {dt:.3g} s", dt=model.dt), low=0, high=20,
               default=0, scale="integer", hint=text("The input acts later than the observer assumes.")),
        Switch("limited", "", text("limit the inputs"),
               hint=text("Clip every input; the observer still gets the commanded input.")),
        Number("u_max", r"u_{\max}", text("limit"), model.input_unit, low=0.05 * model.u_max, high=20 * model.u_max,
               default=model.u_max, scale="log", when=("limited", (True,)),
               hint=text("The largest input that is given, either way.")),
        Number("command", "r", text("command for {y}", y=signal_name(model.plant, model.plant.output_names[0])), "%",
               low=-200.0, high=200.0, default=0.0, step=5.0,
               hint=text("A step of the first output's command, as a share of its size at the start.")),
        Switch("integral", "", text("integral action"),
               hint=text("Integrate the difference between command and output, and add an input from it.")),
        Number("noise", r"\sigma_v", text("sensor noise"), "%", low=0.0, high=20.0, default=0.0, step=0.5,
               hint=text("Standard deviation of a sample, as a share of the outputs at the start.")),
        *run_knobs(model.horizon),
    )


def own_setting(model: Model) -> Setting:
    """A person's own plant: what it is believed to be is what was given, what really moves may be faster."""
    plant, unit = model.plant, sizes(model)
    u, y = signal_name(plant, plant.input_names[0]), signal_name(plant, plant.output_names[0])
    rate = typical_rate(plant) / (2 * np.pi)
    return Setting(
        model, lambda design: sped(plant, design["mismatch"]), lambda design: plant, lambda design: design["delay"] * model.dt,
        lambda design: None if design["noise"] == 0 else np.diag((design["noise"] / 100 * unit) ** 2) * model.dt,
        plant.B[:, :1], plant.C[:1],
        (text("from {u} (as a disturbance) to {y}", u=u, y=y),
         text("|{y} / {u}|", y=y, u=u)),
        np.geomspace(rate / 100, rate * 100, 300),
        Target(text("{y} [%]", y=y), "%", 100 / float(unit[0]),
               lambda plant: (plant.C[:1], np.asarray(plant.D)[:1]),
               lambda design: design["command"] / 100 * float(unit[0])))


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, which fits whatever it is."""
    here = own_setting(model)
    slow = max((p.real for p in model.controller_poles), default=-1.0)
    near = max((p.real for p in model.observer_poles), default=-1.0)
    quicker = tuple(complex(p.real + min(0.0, 3.2 * slow - near), p.imag) for p in model.observer_poles)
    return keep_fair_tasks(replace(lesson, knobs=own_knobs(model), compute=partial(compute, here), figures=partial(figures, here),
                        derived=partial(derived),  # another object than the lesson's: its numbers are those of any plant
                        tasks=(Task("fast-observer", fast_observer, {"method": "poles", "observer_poles": quicker}),)))
