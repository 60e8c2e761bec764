"""Fit lesson 15 to the user's own plant: a row of K or one state, every entry in error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.lesson import Board, Check, Design, Formula, Job, Lesson, Stage
from observer_lab.engine.observers import FunctionalObserver
from observer_lab.engine.systems import Poles
from observer_lab.plants import Model
from observer_lab.text import Text, joined, same, text

from ..toolkit.boards import bolts
from ..toolkit.latex import gain_words, number, pole_words
from .code import own_code
from .derive import derived
from .loop import CONDITION_RTOL, DIVERGENCE_FACTOR, Drive, Setting, compute
from .own_figures import figures
from .own_job import Story, key, search, shown
from .own_knobs import own_knobs
from .own_plant import Here, fitted, lengths

MAX_CONDITION = 1e8  # condition of [T; C] up to which the observer's state and y are taken for the whole state
WAVES = 3.0  # periods of v within the run


def own_setting(here: Here) -> Setting[Story]:
    """A person's own plant, which runs from its model's start with z(0) = 0."""
    model = here.model
    steps = round(model.horizon / model.dt)
    return Setting(
        model.horizon, model.dt, 0.75 * (steps * model.dt), np.inf, model.observer_window, here.rows, here.inner, here.orders,
        here.observer, here.errors, partial(_drive, model), lambda design: (model.x0, ()), _bounded,
        lambda design: f"poles_{int(design['order'])}", lambda design, plain: Story(plain.observer, plain.alone, plain.true),
        _told, _conditions, partial(_controller_board, model), partial(_stage, here), _formulas, _live, here.unit_rows)


def _drive(model: Model, design: Design) -> Drive:
    fed = design["wanted"][0] == "u"
    return Drive(design["push"], 2 * np.pi * WAVES / model.horizon, on=int(design["wanted"][1:]) - 1 if fed else 0, fed=fed)


def _bounded(states: np.ndarray) -> np.ndarray:
    """The states as they are, each held at a bound."""
    states = np.nan_to_num(states, nan=DIVERGENCE_FACTOR, posinf=DIVERGENCE_FACTOR, neginf=-DIVERGENCE_FACTOR)
    bound = DIVERGENCE_FACTOR * max(float(np.abs(states[0]).max()), 1.0)
    return np.clip(states, -bound, bound)


def _told(design: Design, story: Story) -> dict[str, float]:
    return {"late_wanted": story.true.late(story.true.wanted), "condition": float(min(story.observer.condition, 1e15))}


def _conditions(m: Mapping[str, float]) -> tuple[Check, ...]:
    return (Check("dynamics", same("T A − F T = L C"), m["dynamics_residual"] < CONDITION_RTOL, m["dynamics_residual"]),
            Check("output", same("K = N T + M C"), m["output_residual"] < CONDITION_RTOL, m["output_residual"]))


def _controller_board(model: Model, design: Design, loop: Poles) -> Board:
    c = model.controller_window
    return Board("controller", text("controller poles  eig(A − BK)"), design["controller_poles"],
                 "controller_poles" if model.controller_poles else None, bolts(model.controller, c), side="left", re_low=c.re_low,
                 re_high=c.re_high, im_high=c.im_high)


def _stage(here: Here, design: Design, story: Story) -> Stage:
    """The ghost is the state that z and y give together, where there are enough of them."""
    o, run, d, n = story.observer, story.true, here.scaled.unit, here.plant.n
    ghost = None
    if o.order == here.highest and o.condition < MAX_CONDITION:
        rows = np.vstack([here.unit_rows(o).T, here.plant.C]) * d
        length = lengths(rows)
        known = np.hstack([run.z, run.x @ run.loop.readings[:, :n].T]) / length
        ghost = np.linalg.lstsq(rows / length[:, None], known.T, rcond=1e-12)[0].T * d
    return Stage(here.model.body, run.t, run.x, ghost, run.u)


def _formulas(design: Design, o: FunctionalObserver) -> tuple[Formula, ...]:
    return (
        Formula("law", r"\dot z = Fz + L(y - Du) + TBu, \quad Kx \approx Nz + M(y - Du)"),
        Formula("conditions", rf"TA - FT = LC, \quad K = NT + MC, \quad \mathrm{{rel.}}\; "
                              rf"{number(o.dynamics_residual)}, \; {number(o.output_residual)}"),
        Formula("J", rf"J = \textstyle\sum_i \alpha\|TA_i\| + \beta\|LC_i\| + \gamma\|MC_i\|, \quad J = {number(o.J, 4)}"),
        *(Formula(name, gain_words(name, getattr(o, name))) for name in "FTLNMK"),
    )


def _live(design: Design, m: Mapping[str, float]) -> Text:
    poles = pole_words(list(design[f"poles_{int(design['order'])}"])[:4])
    start = text("Order {order:.0f}, poles {poles}: J = {j:.3g}.", order=m["order"], poles=poles, j=m["J"])
    return joined(start, text("With the true plant the loop is unstable.") if m["slowest_loop"] >= 0 else
                  text("At the end the estimate is off by up to {late_error:.2g}, what is wanted being up to {late_wanted:.2g}.",
                       late_error=m["late_error"], late_wanted=m["late_wanted"]))


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, where an observer of a part of its state exists; the tasks stay with the paper."""
    here = fitted(model)
    setting = own_setting(here)
    return replace(lesson, knobs=own_knobs(here), compute=partial(compute, setting), figures=partial(figures, here, setting), tasks=(),
                   code=partial(own_code, here), derived=partial(derived),
                   job=Job(text("Run algorithm RLO"), partial(search, here), key, partial(shown, setting), figure="found"))
