"""Draw the figures of lesson 7: two signals, error, input, recovery map."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.diagram import DiagramFigure
from observer_lab.course.figures.records import Curve, Figure, LineFigure, MapFigure
from observer_lab.course.lesson import Outcome
from observer_lab.text import NO_WORDS, Text, joined, text

from ..toolkit.diagram import Limit, Press, loop
from ..toolkit.figures import error_figure, input_figure, state_figures, within
from ..toolkit.knobs import untouched
from .ending import map_span
from .knobs import MODEL
from .study import ERROR_LAW_RTOL, NOT_COMPUTED, Setting, Study, amount, ends

APPLIED_FORCE, ASKED_FORCE, LIMIT = text("applied"), text("asked for"), text("limit")
EDGES = MappingProxyType({"state0": 49.0, "state1": 1.95, "error": 90.0, "input": 24.5})  # values beyond are drawn at the edge
CATEGORIES = (
    (text("recovers"), "plant"),
    (text("does not"), "disturbance"),
    (text("no controller could"), "muted"),
)


@dataclass(frozen=True, eq=False)
class Look:
    """How the figures show a plant: the four lines as they are drawn, what belongs beside them, categories and axes of the map."""

    drawn: Callable[[Outcome[Study], list[LineFigure]], Sequence[Figure]]
    categories: tuple[tuple[Text, str], ...]
    axes: tuple[str, str]


def figures(look: Look, outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Two signals, error and input, and the map of starts."""
    story, design, model = outcome.study, outcome.design, outcome.study.here.model
    first, second = state_figures(model, story.shown, 2)
    count = min(len(first.x), len(story.known))
    known = Curve(text("had x been known"), model.watched[0].of(story.known[:count]), "reference", "dot", 1.6)
    first = replace(first, x=first.x[:count], curves=(*(replace(c, y=c.y[:count]) for c in first.curves), known))
    lines = [first, second, error_figure(story.shown, story.promised), input_figure(story.shown, model, design["u_max"])]
    return (*look.drawn(outcome, lines), _starts(look, outcome))


def _starts(look: Look, outcome: Outcome[Study]) -> MapFigure:
    """The map with the present start marked; what is not known for this design stays blank."""
    starts, here, (x, y) = outcome.study.starts, outcome.study.here, outcome.study.here.axes
    values = np.full((len(here.grid), len(here.grid)), NOT_COMPUTED) if starts is None else starts.values
    return MapFigure("starts", text("starts that recover"), here.grid, here.grid, values, look.categories, *look.axes,
                     (outcome.design[x], outcome.design[y]), _caption(here, outcome), text("Map"))


def _caption(here: Setting, outcome: Outcome[Study]) -> Text:
    starts, limit, plant = outcome.study.starts, here.ceiling(outcome.design), here.model.plant
    if starts is None:
        return text("Not computed for this design yet: press the button under the knobs.")
    if starts.rough:
        return text("A rough map while you drag, from every third start; let go for the whole.")
    share, part = 100 * starts.home, 100 * starts.done
    known = (text("{share:.1f} % of these starts recover.", share=share) if starts.done == 1 else
             text("{part:.0f} % of the map is known; blank starts have not been run.", part=part))
    edge = (text("Beyond {limit:.1f}° no controller could.", limit=limit)
            if limit < here.grid[-1] else NO_WORDS)
    kick = NO_WORDS if untouched(outcome.design) else text("The map is drawn without the kick or pull.")
    click = text("The circle runs now; click another start.")
    span = map_span(here.model.horizon, plant.A, plant.B, plant.C, outcome.gains["K"], outcome.gains["L"])
    return joined(known, text("Each start is run for {span:.3g} s.", span=span), edge, click, kick)


# --- the cart --------------------------------------------------------------------------------------------------------
def _cart_drawn(outcome: Outcome[Study], lines: list[LineFigure]) -> tuple[Figure, ...]:
    """Angle, position, error and force in the words of the cart, and the loop."""
    design, metrics = outcome.design, outcome.metrics
    angle, position, error, force = lines
    angle = replace(angle, curves=(*angle.curves, *_limits(metrics["ceiling"], len(angle.x))), caption=_angle_words(outcome),
                    window=(-20.0, 20.0))
    if design["fog"]:
        angle = replace(angle, curves=tuple(c for c in angle.curves if c.role == "estimate"), caption=text(
            "Fog hides the pole: only its estimate is drawn."))
    error = replace(error, caption=_error_words(outcome), window=(1e-6, 10.0))
    asked = (ASKED_FORCE,) if len(force.curves) == 4 else ()
    names = (APPLIED_FORCE, *asked, LIMIT, LIMIT)
    force = replace(force, window=(-10.0, 10.0), curves=tuple(replace(c, name=name) for c, name in zip(force.curves, names, strict=True)),
                    caption=text("Largest force asked for: {largest_asked} N; the motor gives at most {u_max:.3g} N.",
                                 largest_asked=amount(metrics["largest_asked"]), u_max=design["u_max"]))
    drawn = (angle, replace(position, window=(-0.5, 0.5), caption=_position_words(outcome)), error, force)
    return (*(within(figure, EDGES[figure.id]) for figure in drawn), _loop(outcome))


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


CART_LOOK = Look(_cart_drawn, CATEGORIES, ("θ(0) [°]", "θ(0) − θ̂(0) [°]"))
