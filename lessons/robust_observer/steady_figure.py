"""Draw the error that stays over the pole of the observer."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, PlaneFigure, Point
from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Outcome
from observer_lab.engine import EngineError
from observer_lab.text import Text, text

from .loop import loop_of
from .study import EXAMPLE_CASES, PAPER, Story, observer_of

SLOWEST = np.linspace(-12.0, -0.2, 60)  # rad/s, real part of the slowest pole of each observer that is drawn
MOST_TIMES = 6.0  # how many times the least error the axis reaches, or the present one


def errors_that_stay(outcome: Outcome[Story]) -> tuple[np.ndarray, np.ndarray]:
    """Real part of the slowest pole and amplitude of e_u under v, where all poles move by the same amount."""
    design = outcome.design
    knob = EXAMPLE_CASES[design["example"]].poles
    now, errors = design[knob], PAPER.errors(design)
    slowest = max(pole.real for pole in now)
    found = []
    for at in np.union1d(SLOWEST, [slowest]):
        try:
            observer = observer_of(design.with_values(**{knob: tuple(pole + (at - slowest) for pole in now)}))
        except (KnobError, EngineError):
            continue  # no observer with these poles
        left = loop_of(PAPER, design, observer, errors).steady()
        if np.isfinite(left):
            found.append((float(at), left))
    return (np.array([at for at, _ in found]), np.array([left for _, left in found]))


def steady_figure(outcome: Outcome[Story], tab: Text) -> PlaneFigure:
    """The curve, its least value and where the observer is now."""
    x, left = errors_that_stay(outcome)
    now, slowest = outcome.study.true.loop.steady(), float(outcome.poles["observer"].real.max())
    title, axes = text("error of û that stays"), (text("Re s of the slowest pole [rad/s]"), text("amplitude of û − u"))
    if not len(x):
        return PlaneFigure("steady", title, (), (), *axes, (-12.0, 0.0), (0.0, 1.0), tab=tab,
                           caption=text("The loop with the true plant is unstable at all of these poles."))
    k = int(np.argmin(left))
    top = round_up_nicely(min(float(left.max()) * 1.1, MOST_TIMES * max(float(left[k]), now if np.isfinite(now) else 0.0)) or 1.0)
    points = [Point(float(x[k]), float(left[k]), "right", "circle", text("least"))]
    if np.isfinite(now) and slowest >= SLOWEST[0]:
        points.append(Point(slowest, min(now, top), "error", "cross", text("now")))
    return PlaneFigure("steady", title, (Curve(text("with these model errors"), np.minimum(left, 1.5 * top), "error", width=2.4, x=x),),
                       tuple(points), *axes, (-12.0, 0.0), (0.0, top), tab=tab,
                       caption=text("The error is least with the slowest pole at {s:.2g} rad/s: {least:.2g}. "
                                    "At {edge:.2g} it is {fast:.2g}.",
                                    s=x[k], least=left[k], edge=x[0], fast=left[0]))
