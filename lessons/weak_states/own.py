"""Fit lesson 12 to the user's own plant: ranks, Hankel values, a truncation and its error."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from observer_lab.course.exercises.derivation import no_numbers
from observer_lab.course.knobs import Knob, Number
from observer_lab.course.lazy import FigureSet, LazyMap, LazySequence, LazyValue, tab_figures
from observer_lab.course.lesson import Check, Design, Formula, Lesson, Outcome, Stage
from observer_lab.engine.design import typical_rate
from observer_lab.plants import Model
from observer_lab.text import Text, text

from ..toolkit.latex import number
from . import own_figures
from .figures import HANKEL_TAB, MOTION_TAB, RANK_TAB, ranks_over_tolerance, sizes
from .knobs import KNOBS, MODEL
from .own_code import own_code
from .own_system import OwnStudy, OwnSystem, system_of

CLOCK_DECADES = 3  # how far the unit of time goes to both sides of the plant's own


def compute(s: OwnSystem, design: Design) -> Outcome[OwnStudy]:
    """Ranks, Hankel values, the truncation with its error, and one blow on the plant and on its model."""
    study = OwnStudy(s, design["clock"], int(design["order"]))
    t, x, believed = study.blow
    metrics = LazyMap(lambda: _metrics(design, study))
    return Outcome(design, {}, LazyMap(lambda: {"plant": s.plant.poles, "model": study.cut.model.poles}), metrics,
                   LazySequence(lambda: _checks(study)), stage=Stage(s.model.body, t, x, believed),
                   formulas=LazySequence(lambda: _formulas(study)), words=LazyValue(lambda: _live(study)), study=study)


def _metrics(design: Design, study: OwnStudy) -> dict[str, float]:
    reached, seen = study.ranks.at(design["tolerance"], design["measure"])
    found = {"rank_controllability": float(reached), "rank_observability": float(seen), "error": study.cut.peak,
             "error_at": study.cut.where, "bound": study.cut.bound, "sharp": study.cut.sharp, "unstable": float(study.system.whole.kept),
             **{f"sigma{k + 1}": float(v) for k, v in enumerate(study.system.hankel)}}
    return {name: float(value) for name, value in found.items() if value is not None}


def _checks(study: OwnStudy) -> Iterator[Check]:
    c = study.cut
    yield Check("bound", text("the error keeps below 2Σσ"), c.peak <= c.bound * (1 + 1e-6) + own_figures.dust(study.system), c.peak)


def _formulas(study: OwnStudy) -> tuple[Formula, ...]:
    s, c = study.system, study.cut
    bound = (rf"\|G-G_{{{c.order}}}\|_\infty = {number(c.peak)} \le 2\sum_{{i>{c.order - s.whole.kept}}}\sigma_i = {number(c.bound)}"
             if c.order < s.most else rf"G_{{{s.most}}} = G")
    return (Formula("hankel", r"\sigma_i = \sqrt{\lambda_i(W_c W_o)}"), Formula("bound", bound))


def _live(study: OwnStudy) -> Text:
    s, c = study.system, study.cut
    if c.order == s.plant.n:
        return text("States kept: all {n}.", n=s.plant.n)
    if c.order == s.most:
        return text("States kept: {order} of {n}, all that take part between input and output.", order=c.order, n=s.plant.n)
    return text("States kept: {order} of {n}. The largest error is {error:.3g}, its bound 2Σσ {bound:.3g}.",
                order=c.order, n=s.plant.n, error=c.peak, bound=c.bound)


def figures(outcome: Outcome[OwnStudy]) -> FigureSet:
    """Ranks, Hankel values with the error, and the outputs after a blow."""
    d, study = outcome.design, outcome.study
    return FigureSet(
        tab_figures(RANK_TAB, lambda: (sizes(d, study.ranks), ranks_over_tolerance(d, study.ranks))),
        tab_figures(HANKEL_TAB, lambda: (own_figures.staircase(study), own_figures.error(study))),
        tab_figures(MOTION_TAB, lambda: (own_figures.outputs(study),)))


def own_knobs(s: OwnSystem) -> tuple[Knob, ...]:
    """The order between what must stay and what takes part, the unit of time about the plant's own, and what is asked everywhere."""
    given = {knob.name: knob for knob in KNOBS}
    own_time = 1 / typical_rate(s.plant)
    order = Number("order", "r", text("states kept"), low=s.least, high=s.most, default=s.good, scale="integer", group=MODEL,
                   hidden=s.least >= s.most,
                   hint=text("Order of the balanced truncation; unstable states always stay. The ghost is this model after the same blow."))
    clock = given["clock"]
    assert isinstance(clock, Number)
    wide = 10.0**CLOCK_DECADES
    return (order, replace(clock, low=min(1.0, own_time) / wide, high=max(1.0, own_time) * wide), given["tolerance"], given["measure"])


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant; tasks and closed forms are about the platform and stay with it."""
    s = system_of(model)
    return replace(lesson, knobs=own_knobs(s), compute=partial(compute, s), figures=figures, tasks=(), answering="error", code=own_code,
                   derived=no_numbers, key=("order", "clock", "tolerance"), aside=("measure",))
