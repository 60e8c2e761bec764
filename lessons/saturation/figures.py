"""Draw the figures of lesson 7: angle, position, error, force, recovery map."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.diagram import DiagramFigure
from observer_lab.course.figures.records import Curve, Figure, MapFigure
from observer_lab.course.lesson import Outcome
from observer_lab.text import NO_WORDS, Text, joined, text

from ..toolkit.diagram import Limit, Press, loop
from ..toolkit.figures import error_figure, input_figure, state_figures, within
from ..toolkit.knobs import untouched
from .ending import map_span
from .knobs import HORIZON, MODEL
from .study import ERROR_LAW_RTOL, NOT_COMPUTED, START_GRID_DEG, Starts, Study, amount, ends

APPLIED_FORCE, ASKED_FORCE, LIMIT = text("applied"), text("asked for"), text("limit")
EDGES = MappingProxyType({"state0": 49.0, "state1": 1.95, "error": 90.0, "input": 24.5})  # values beyond are drawn at the edge
CATEGORIES = (
    (text("recovers"), "plant"),
    (text("does not"), "disturbance"),
    (text("no controller could"), "muted"),
)


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Angle and position, error and force, and the map of starts."""
    story, design, metrics = outcome.study, outcome.design, outcome.metrics
    angle, position = state_figures(MODEL, story.shown, 2)
    known = Curve(text("had x been known"), MODEL.watched[0].of(story.known), "reference", "dot", 1.6)
    angle = replace(angle, curves=(*angle.curves, known, *_limits(metrics["ceiling"], len(angle.x))), caption=_angle_words(outcome),
                    window=(-20.0, 20.0))
    if design["fog"]:
        angle = replace(angle, curves=tuple(c for c in angle.curves if c.role == "estimate"), caption=text(
            "Fog hides the pole: only its estimate is drawn."))
    error = replace(error_figure(story.shown, story.promised), caption=_error_words(outcome), window=(1e-6, 10.0))
    force = replace(input_figure(story.shown, MODEL, design["u_max"]), window=(-10.0, 10.0), caption=text(
        "Largest force asked for: {largest_asked} N; the motor gives at most {u_max:.3g} N.",
        largest_asked=amount(metrics["largest_asked"]), u_max=design["u_max"]))
    asked = (ASKED_FORCE,) if len(force.curves) == 4 else ()
    names = (APPLIED_FORCE, *asked, LIMIT, LIMIT)
    force = replace(force, curves=tuple(replace(c, name=name) for c, name in zip(force.curves, names, strict=True)))
    lines = (angle, replace(position, window=(-0.5, 0.5), caption=_position_words(outcome)), error, force)
    return (*(within(figure, EDGES[figure.id]) for figure in lines),
            _loop(outcome), starts_figure(story.starts, metrics["ceiling"], design["angle0"], design["error0"], not untouched(design),
                                          _span(outcome)))


def _limits(ceiling: float, count: int) -> tuple[Curve, ...]:
    """The largest angles that any controller recovers from rest, to both sides."""
    return tuple(Curve(text("limit from rest"), np.full(count, side * ceiling), "disturbance", "dash", 1.6) for side in (-1.0, 1.0))


def _loop(outcome: Outcome[Study]) -> DiagramFigure:
    """The loop with its limit; a press on the limit gives the observer the other force."""
    run, applied = outcome.study.shown, outcome.design["fed"] == "applied"
    words = text("Give the observer the commanded force") if applied else text("Give the observer the applied force")
    return loop(MODEL.plant, run, outcome.gains["L"], outcome.gains["K"],
                Press("limit", {"fed": "commanded" if applied else "applied"}, words), Limit(run.u_asked, applied))


def _angle_words(outcome: Outcome[Study]) -> Text:
    story = outcome.study
    end = (text("Fallen after {stopped:.2f} s; the run stops there and the curves are held.", stopped=story.stopped)
           if story.stopped is not None else ends(story))
    known = (text("With x known, the same start recovers.") if story.known_end.home else
             text("Even with x known, this start does not recover.") if story.known_end.decided else NO_WORDS)
    return joined(end, known)


def _position_words(outcome: Outcome[Study]) -> Text:
    gap = float(np.max(np.abs(outcome.run.e[:, 0]))) if outcome.run is not None else 0.0
    return text("The position is measured. Largest error of its estimate: {gap} m.", gap=amount(gap))


def _error_words(outcome: Outcome[Study]) -> Text:
    meter, clipped = outcome.metrics["separation_meter"], outcome.metrics["clipped_for"]
    kept = (text("The force is clipped, and the error still follows ė = (A − LC)e.") if clipped > 0 else
            text("Nothing is clipped, so the error follows ė = (A − LC)e."))
    return claim(kept, meter, below=ERROR_LAW_RTOL, otherwise=text("The error departs from ė = (A − LC)e; separation meter {meter}.",
                                                          meter=amount(meter)))


def starts_figure(starts: Starts | None, limit: float, angle: float, error: float, kicked: bool, span: float) -> MapFigure:
    """The map with the present start marked; what is not known for this design stays blank."""
    values = np.full((len(START_GRID_DEG), len(START_GRID_DEG)), NOT_COMPUTED) if starts is None else starts.values
    return MapFigure("starts", text("starts that recover"), START_GRID_DEG, START_GRID_DEG, values, CATEGORIES,
                     "θ(0) [°]", "θ(0) − θ̂(0) [°]", (angle, error), _caption(starts, limit, kicked, span),
                     text("Map"))


def _span(outcome: Outcome[Study]) -> float:
    plant = MODEL.plant
    return map_span(HORIZON, plant.A, plant.B, plant.C, outcome.gains["K"], outcome.gains["L"])


def _caption(starts: Starts | None, limit: float, kicked: bool, span: float) -> Text:
    if starts is None:
        return text("Not computed for this design yet: press the button under the knobs.")
    if starts.rough:
        return text("A rough map while you drag, from every third start; let go for the whole.")
    share, part = 100 * starts.home, 100 * starts.done
    known = (text("{share:.1f} % of these starts recover.", share=share) if starts.done == 1 else
             text("{part:.0f} % of the map is known; blank starts have not been run.", part=part))
    edge = (text("Beyond {limit:.1f}° no controller could.", limit=limit)
            if limit < START_GRID_DEG[-1] else NO_WORDS)
    kick = text("The map is drawn without the kick or pull.") if kicked else NO_WORDS
    click = text("The circle runs now; click another start.")
    return joined(known, text("Each start is run for {span:.3g} s.", span=span), edge, click, kick)
