"""Compute lesson 15 on the user's own plant: observer, conditions, J, two runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Board, Check, Design, Formula, Job, Lesson, Outcome, Stage
from observer_lab.course.script_record import Code
from observer_lab.engine.observers import FunctionalObserver
from observer_lab.plants import Model
from observer_lab.text import Text, joined, same, text

from ..toolkit.boards import bolts
from ..toolkit.latex import gain_words, number, pole_words
from .code import own_code
from .derive import derived
from .own_figures import figures
from .own_job import key, search, shown
from .own_knobs import own_knobs
from .own_loop import Run, Story, errors, lengths, observer_of, run_of, wanted_of
from .own_plant import Here, fitted
from .study import CONDITION_RTOL

MAX_CONDITION = 1e8  # condition of [T; C] up to which the observer's state and y are taken for the whole state


def compute(here: Here, design: Design) -> Outcome[Story]:
    """The observer, its conditions and J, and one run each on the model and on the true plant. Raises KnobError, EngineError."""
    o = observer_of(here, design)
    dA, dC = errors(here, design)
    model, true = LazyValue(lambda: run_of(here, design, o, 0 * dA, 0 * dC)), run_of(here, design, o, dA, dC)
    story = Story(o, model, true, design["wanted"][0] == "u", dict(here.wanted)[design["wanted"]], here.model.observer_window,
                  _unit(here, design))
    poles = np.array(design[f"poles_{o.order}"])
    known = {"J": o.J, "order": float(o.order), "slowest_loop": float(true.poles.real.max()), "error_start": float(true.e[0]),
             "late_error": true.late(true.e), "late_wanted": true.late(true.wanted)}
    metrics = LazyMap(lambda: {**known, "dynamics_residual": o.dynamics_residual, "output_residual": o.output_residual,
                                "condition": float(min(o.condition, 1e15))}, known)
    return Outcome(design, {"F": o.F, "T": o.T, "L": o.L, "N": o.N, "M": o.M, "K": o.K}, {"observer": poles, "loop": true.poles}, metrics,
                   LazySequence(lambda: _checks(metrics)), None, _boards(here, design, o.order), _stage(here, o, true, dC),
                   LazySequence(lambda: _formulas(o)), LazyValue(lambda: _live(metrics, poles)), story)


def _checks(m: Mapping[str, float]) -> tuple[Check, ...]:
    return (
        Check("dynamics", same("T A − F T = L C"), m["dynamics_residual"] < CONDITION_RTOL, m["dynamics_residual"]),
        Check("output", same("K = N T + M C"), m["output_residual"] < CONDITION_RTOL, m["output_residual"]),
        Check("stable", text("the loop with the true plant is stable"), m["slowest_loop"] < 0, m["slowest_loop"]),
    )


def _unit(here: Here, design: Design) -> str:
    names = here.plant.input_names if design["wanted"][0] == "u" else here.plant.state_names
    return here.plant.unit(names[int(design["wanted"][1:]) - 1])


def _boards(here: Here, design: Design, order: int) -> tuple[Board, Board]:
    model, c, o = here.model, here.model.controller_window, here.model.observer_window
    return (
        Board("controller", text("controller poles  eig(A − BK)"), design["controller_poles"],
              "controller_poles" if model.controller_poles else None, bolts(model.controller, c), side="left", re_low=c.re_low,
              re_high=c.re_high, im_high=c.im_high),
        Board("observer", text("observer poles  eig F"), design[f"poles_{order}"], f"poles_{order}", role="estimate",
              side="right", re_low=o.re_low, re_high=o.re_high, im_high=o.im_high),
    )


def _stage(here: Here, o: FunctionalObserver, run: Run, dC: np.ndarray) -> Stage:
    """The ghost is the state that z and y give together, where there are enough of them."""
    plant, d = here.plant, here.scaled.unit
    ghost = None
    if o.order == here.highest and o.condition < MAX_CONDITION:
        rows = np.vstack([o.T / lengths(o.T * d)[:, None], plant.C]) * d
        length = lengths(rows)
        known = np.hstack([run.z, run.x @ (plant.C + dC).T]) / length
        ghost = np.linalg.lstsq(rows / length[:, None], known.T, rcond=1e-12)[0].T * d
    return Stage(here.model.body, run.t, run.x, ghost, run.u)


def _formulas(o: FunctionalObserver) -> tuple[Formula, ...]:
    return (
        Formula("law", r"\dot z = Fz + L(y - Du) + TBu, \quad Kx \approx Nz + M(y - Du)"),
        Formula("conditions", rf"TA - FT = LC, \quad K = NT + MC, \quad \mathrm{{rel.}}\; "
                              rf"{number(o.dynamics_residual)}, \; {number(o.output_residual)}"),
        Formula("J", rf"J = \textstyle\sum_i \alpha\|TA_i\| + \beta\|LC_i\| + \gamma\|MC_i\|, \quad J = {number(o.J, 4)}"),
        *(Formula(name, gain_words(name, getattr(o, name))) for name in "FTLNMK"),
    )


def _live(m: Mapping[str, float], poles: np.ndarray) -> Text:
    start = text("Order {order:.0f}, poles {poles}: J = {j:.3g}.",
                 order=m["order"], poles=pole_words(list(poles)[:4]), j=m["J"])
    if m["slowest_loop"] >= 0:
        end = text("With the true plant the loop is unstable.")
    else:
        end = text("At the end the estimate is off by up to {late_error:.2g}, what is wanted being up to "
                   "{late_wanted:.2g}.",
                   late_error=m["late_error"], late_wanted=m["late_wanted"])
    return joined(start, end)


def _code(here: Here, outcome: Outcome[Story]) -> Code:
    """What the script of a design starts from and finds again."""
    return own_code(here.scaled, outcome, wanted_of(here, outcome.design)[0], *errors(here, outcome.design))


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, where an observer of a part of its state exists; the tasks stay with the paper."""
    here = fitted(model)
    return replace(lesson, knobs=own_knobs(here), compute=partial(compute, here), figures=partial(figures, here), tasks=(),
                   code=partial(_code, here), derived=partial(derived),
                   job=Job(text("Run algorithm RLO"), partial(search, here), key, partial(shown, here), figure="found"))
