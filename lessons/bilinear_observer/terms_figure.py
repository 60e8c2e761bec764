"""Draw the sizes of the unknown terms, without L and with it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, PlaneFigure, Point
from observer_lab.text import same, text

from .problems import PROBLEMS, TERMS, nearest_gain, unknown_terms

TERMS_TAB = text("Unknown terms")
BESIDE, BAR_PX = 0.17, 26.0  # from the middle of a pair to each bar; its thickness
NOTHING = 1e-9  # of the largest: less is rounding


def terms_left(problem: str) -> np.ndarray:
    """Sizes (2, 3) of the unknown terms without L and with it; the nearest L where none satisfies (21)."""
    o = PROBLEMS[problem].solved
    return unknown_terms(o, o.L if o.L is not None else nearest_gain(o))


@lru_cache(maxsize=8)
def terms_figure(problem: str) -> PlaneFigure:
    """A blue bar for each term without L; beside it what L leaves of it, a circle where nothing is left."""
    sizes = terms_left(problem)
    least, top = NOTHING * float(sizes.max()), round_up_nicely(1.1 * float(sizes.max()))
    curves, points = list[Curve](), list[Point]()
    for k, (alone, left) in enumerate(sizes.T):
        curves.append(Curve(text("without L"), np.array([0.0, alone]), "plant", "solid", BAR_PX, np.full(2, k - BESIDE)))
        if left > least:
            curves.append(Curve(text("with L"), np.array([0.0, left]), "error", "solid", BAR_PX, np.full(2, k + BESIDE)))
        else:
            points.append(Point(k + BESIDE, 0.02 * top, "right", "circle", same("0")))
    gone = len(points)
    return PlaneFigure("terms", text("size of the unknown terms"), tuple(curves), tuple(points), "",
                       text("‖V₂ · term‖, ‖(V₂ − LV₁) · term‖"),
                       (-0.6, len(TERMS) - 0.4), (0.0, top), tab=TERMS_TAB,
                       names=tuple((float(k), same(name)) for k, name in enumerate(TERMS)),
                       caption=text("Blue: without L. Circles: L leaves nothing. Terms removed: {gone} of {count}.",
                                    gone=gone, count=len(TERMS)))
