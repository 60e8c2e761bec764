"""Draw the figures of lesson 15 for an own plant."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import Curve, LineFigure, PlaneFigure, Point, TableFigure, over_frequency
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Design, Outcome
from observer_lab.engine.observers import Existence, FunctionalObserver, criterion
from observer_lab.text import NO_WORDS, Text, format_number, same, text

from ..toolkit.latex import pole_words
from .figures import J_TAB, NO_VALUE, TIME_TAB
from .loop import Run, Setting, amplitudes
from .own_job import Story, inside
from .own_plant import Here
from .rank_conditions import ORDERS_TAB, missed, ranks

LOOP_TAB = text("Loop")
CHOSEN, RLO, MODEL = text("true plant"), text("true plant, RLO"), text(
    "model")


def figures(here: Here, setting: Setting, outcome: Outcome[Story]) -> FigureSet:
    """Time, criterion, loop: at most three in a tab."""
    story, design = outcome.study, outcome.design
    unit = here.unit(design)
    return FigureSet(
        tab_figures(TIME_TAB, lambda: (_error(dict(here.wanted)[design["wanted"]], unit, outcome), _signal(unit, story))),
        tab_figures(J_TAB, lambda: (_compared(outcome, story), ranks(setting, outcome, J_TAB, _ranks_told), _attempts(story))),
        tab_figures(ORDERS_TAB, lambda: (missed(setting, outcome),)),
        tab_figures(LOOP_TAB, lambda: (_gain(here, story), _plane(here, design, story))),
    )


def _ranks_told(design: Design, rung: Existence) -> Text:
    return text("Order 0 is the readings alone, My. As soon as the rank with K is no higher, an observer exists; rows of [T; C] beyond "
                "their rank leave M′ free. Each order has the poles of its own knob; an order without one has a pole more.")


def _error(name: Text, unit: str, outcome: Outcome[Story]) -> LineFigure:
    story = outcome.study
    late, size = outcome.metrics["late_error"], outcome.metrics["late_wanted"]
    ideal = story.model.late(story.model.e)
    curves = [Curve(CHOSEN, story.true.e, "error"), Curve(MODEL, story.model.e, "reference", "dash", 1.6)]
    said = text("In the last quarter up to {late:.2g} on the true plant, {ideal:.2g} on the model; wanted: up to "
                "{size:.2g}.",
                late=late, ideal=ideal, size=size)
    if story.found_run is not None:
        curves.append(Curve(RLO, story.found_run.e, "force", "dot"))
    return LineFigure("e_u", text("error of the estimate: {name}", name=name), story.true.t, tuple(curves),
                      f"e [{unit}]", caption=said, tab=TIME_TAB)


def _signal(unit: str, story: Story) -> LineFigure:
    run, fed = story.true, story.true.loop.drive.fed
    sign, push = (-1.0, run.v) if fed else (1.0, 0.0)
    title = text("input wanted and given") if fed else text("state and its estimate")
    names = (text("wanted, −Kx + v"), text("given")) if fed else (text("true"), text("estimate"))
    wanted, given = sign * run.wanted + push, sign * (run.wanted - run.e) + push
    return LineFigure("signal", title, run.t, (Curve(names[0], wanted, "plant"), Curve(names[1], given, "estimate", "dash"),
                                               Curve(same("v"), run.v, "muted", "dot", 1.4)), f"[{unit}]", tab=TIME_TAB,
                      caption=text("Largest difference: {e:.3g}.", e=np.abs(run.e).max()))


# --- criterion -----------------------------------------------------------------------------------------------------
def _parts(o: FunctionalObserver) -> tuple[str, ...]:
    """The three sums of J."""
    w, nothing = o.wrong, np.zeros
    T, L, M = nothing(o.T.shape), nothing(o.L.shape), nothing(o.M.shape)
    return tuple(format_number(criterion(*rows, w, norm=o.norm), ".4g") for rows in ((o.T, L, M), (T, o.L, M), (T, L, o.M)))


def _compared(outcome: Outcome[Story], story: Story) -> TableFigure:
    """The chosen observer beside that of RLO."""
    def column(o: FunctionalObserver, run: Run) -> tuple[Text | str, ...]:
        within = text("yes") if inside(o.poles, outcome.design) else text("no")
        return (str(o.order), pole_words(list(o.poles)), within, format_number(o.J, ".5g"),
                *_parts(o), format_number(o.condition, ".3g"), f"{o.output_residual:.1e}",
                format_number(run.late(run.e), ".3g"),
                format_number(run.poles.real.max(), ".3g"))
    ours = column(story.observer, story.true)
    found = story.found
    theirs = (column(found.observer, story.found_run) if found is not None and story.found_run is not None
              else (NO_VALUE,) * len(ours))
    names = (text("order"), text("poles"), text("in the region"), same("J"),
             same("α Σ‖TAᵢ‖"), same("β Σ‖LCᵢ‖"),
             same("γ Σ‖MCᵢ‖"), text("condition of [T; C]"), text(
                 "K missed by"),
             text("error at the end"),
             text("slowest pole of the loop"))
    if found is None:
        said = text("RLO has not run yet: press the button “Run algorithm RLO”.")
    elif found.observer.order != story.observer.order:
        said = text("The orders differ; compare J of observers of different order with care.")
    else:
        ratio = story.observer.J / max(found.value, 1e-300)
        said = text("The chosen J is {ratio:.3g} times that of RLO.", ratio=ratio)
    return TableFigure("compared", text("chosen and RLO"), (NO_WORDS, text("chosen"), same("RLO")),
                       tuple(zip(names, ours, theirs, strict=True)), caption=said, tab=J_TAB)


def _attempts(story: Story) -> TableFigure:
    """What RLO tried on its way."""
    rows: tuple[tuple[Text | str, ...], ...] = ((NO_VALUE, NO_VALUE, NO_VALUE, NO_VALUE),)
    if story.found is not None:
        rows = tuple((str(a.order), "✓" if a.feasible else "✗", format_number(a.gap, ".2g"),
                      format_number(a.J, ".5g") if np.isfinite(a.J) else NO_VALUE)
                     for a in story.found.attempts)
    said = (text("Algorithm RLO raises the order until the conditions can be met; it has not run yet.") if story.found is None else
            text("Share of K that is missed at best: where it is not zero the order is raised."))
    return TableFigure("attempts", text("algorithm RLO inside the region"),
                       (text("order"), text("exists"), text("K missed by"), text(
                           "least J")), rows,
                       caption=said, tab=J_TAB)


# --- loop ----------------------------------------------------------------------------------------------------------
def _gain(here: Here, story: Story) -> LineFigure:
    run, f = story.true, here.frequencies
    gain = amplitudes((run.loop,), f)[0]
    floor = 1e-8 * max(float(gain.max()), 1e-300)
    curves = [Curve(CHOSEN, np.maximum(gain, floor), "error")]
    if story.found_run is not None:
        curves.append(Curve(RLO, np.maximum(amplitudes((story.found_run.loop,), f)[0], floor), "force", "dot"))
    k = int(np.argmax(gain))
    said = (text("The loop is unstable, so the gain has no meaning over time.")
            if run.poles.real.max() >= 0 else
            text("Largest {gain:.3g}, near {f:.3g} Hz; on the model it would be zero.",
                 gain=gain[k], f=f[k]))
    return over_frequency("gain", text("from v to the error of the estimate"), f, tuple(curves), "|e/v|",
                           caption=said, tab=LOOP_TAB)


def _plane(here: Here, design: Design, story: Story) -> PlaneFigure:
    w = here.model.observer_window
    low, high = 1.6 * w.re_low, max(w.re_high, 0.3 * -w.re_low)
    tall = 1.2 * w.im_high
    points = [Point(float(np.clip(p.real, low, high)), float(np.clip(p.imag, -tall, tall)), role, mark)  # type: ignore[arg-type]
              for poles, role, mark in ((story.true.poles, "plant", "dot"), (story.observer.poles, "estimate", "cross")) for p in poles]
    if story.found is not None:
        points += [Point(float(np.clip(p.real, low, high)), float(np.clip(p.imag, -tall, tall)), "force", "circle")
                   for p in story.found.observer.poles]
    a, b, c = (design[name] for name in ("region_low", "region_high", "region_tall"))
    lines = (Curve(text("region of RLO"), np.array([-c, -c, c, c, -c]), "reference", "dot", 1.6, np.array([a, b, b, a, a])),)
    outside = int(np.count_nonzero((story.true.poles.real < low) | (np.abs(story.true.poles.imag) > tall)))
    return PlaneFigure("plane", text("poles of the loop and of the observer"), lines, tuple(points), "Re s", "Im s",
                       (low, high), (-tall, tall), unstable=True, tab=LOOP_TAB,
                       caption=text("Dots: loop with the true plant, {outside} of them on the edge. Crosses: "
                                    "observer. Circles: RLO.",
                                    outside=outside))
