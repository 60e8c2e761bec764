"""Fit lesson 7 to the user's own plant: recovery map over x(0) and e(0) under a limit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.figures.records import Figure, LineFigure
from observer_lab.course.knobs import Choice, Knob, KnobError, Number
from observer_lab.course.lesson import Design, Lesson, Outcome
from observer_lab.engine import Plant, Scenario, simulate
from observer_lab.engine.simulation import Run
from observer_lab.plants import Model
from observer_lab.text import text

from ..toolkit.boards import stage
from ..toolkit.figures import within
from ..toolkit.knobs import pole_knobs, run_knobs
from .derive import derived_own
from .figures import CATEGORIES, Look, figures
from .job import job_of, pick
from .knobs import APPLIED, COMMANDED
from .study import Sayings, Setting, Study, compute

START_GRID = np.linspace(-3.0, 3.0, 25)  # starts and errors, in units of the plant's own start
LAW_RTOL = 1e-8  # of the error's peak: how well ė = (A − LC)e must hold to count as exact
RECOVERED_SIZE, LOST_SIZE = 0.1, 100.0  # of the start's size: come home below the one at the end, lost beyond the other
MAP_RUN_STEPS = 200  # of a run on the map


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """The lesson's knobs in the plant's own measures."""
    return (
        Choice("fed", "", text("input of the observer"), default=COMMANDED,
               options=((COMMANDED, text("the commanded input")), (APPLIED, text("the applied input"))),
               hint=text("The commanded input, or the applied input.")),
        Number("u_max", r"u_{\max}", text("limit of every input"), model.input_unit, low=0.02 * model.u_max,
               high=20 * model.u_max, default=model.u_max, scale="log",
               hint=text("The largest input that is given, either way.")),
        Number("start", r"x(0)", text("start, times its usual size"), low=-3.0, high=3.0, default=1.0, step=0.05,
               hint=text("How far off rest the plant starts.")),
        Number("error0", r"e(0)", text("error of its estimate, likewise"), low=-3.0, high=3.0,
               default=1.0, step=0.05,
               hint=text("The observer starts from the true start minus this share of it.")),
        *(replace(knob, when=None) for knob in pole_knobs(model)),
        *run_knobs(model.horizon),
    )


def own_setting(model: Model) -> Setting:
    """A person's own plant: starts and errors are shares of its usual start."""
    def start(design: Design) -> tuple[Sequence[float], Sequence[float]]:
        usual = np.array(model.x0)
        x0 = design["start"] * usual
        return x0, x0 - design["error0"] * usual
    return Setting(
        True, model, start, _march, lambda run: (run, None), LAW_RTOL, lambda *_: {}, lambda run, design: stage(model, run, design),
        Sayings(
            text("This start recovers."), text("This start does not recover."),
            lambda long: text("Whether this start recovers is not decided within {long:.3g} s.", long=long),
            lambda clipped: text("An input is clipped for {clipped:.3g} s.", clipped=clipped), text("No input is ever clipped."),
            lambda meter: text("Separation meter {separation_meter}.", separation_meter=meter),
            text("the compensator is stable while the input is clipped"),
            text("A pole is not in the left half plane, so no start recovers; drag it to the left if it can be moved.")),
        ("start", "error0"), START_GRID, START_GRID, 0, partial(turned, model), model.horizon / MAP_RUN_STEPS, (RECOVERED_SIZE, LOST_SIZE))


def _march(scenario: Scenario) -> Run:
    run = simulate(scenario)
    if len(run.t) < 2:
        raise KnobError(text("Under this limit the plant grows without bound at once; raise it."))
    return run


def turned(model: Model, scenario: Scenario) -> Scenario:
    """The loop in coordinates whose first is how much of the usual start is in a state, all in typical sizes."""
    plant, s = model.plant, np.array([abs(v) or 1.0 for v in model.x0])
    along = np.array(model.x0) / s
    Q = np.linalg.qr(np.column_stack([along, np.eye(plant.n)]))[0]
    Q = Q * np.sign(float(Q[:, 0] @ along))
    T = s[:, None] * Q * float(np.linalg.norm(along))
    inverse = np.linalg.inv(T)
    new = Plant(inverse @ plant.A @ T, inverse @ plant.B, plant.C @ T, plant.D)
    return replace(scenario, plant=new, model=None, K=scenario.K @ T, L=inverse @ scenario.L)


def _drawn(outcome: Outcome[Study], lines: list[LineFigure]) -> Sequence[Figure]:
    """The four lines; what is asked beyond eight times the limit is drawn there."""
    return *lines[:-1], within(lines[-1], 8 * outcome.design["u_max"] * outcome.study.here.model.input_scale)


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, which fits whatever it is; the tasks speak of the pole and stay with it."""
    here, look = own_setting(model), Look(_drawn, CATEGORIES[:2], ("x(0)", "e(0)"))
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, here), figures=partial(figures, look), tasks=(),
                   job=job_of(here), pick=partial(pick, here), derived=derived_own)
