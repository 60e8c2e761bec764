"""Draw Nyquist's curves close to the critical point."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, PlaneFigure, Point
from observer_lab.course.lesson import Outcome
from observer_lab.text import format_number, same, text

from .recovery_figure import both_halves
from .study import Study

CLOSEST_TAB = text("Near −1")
TIMES = 2.5  # how many times the distance the window reaches to either side
MOST_HALF = 1.0  # half the window's height is no more, where the curve is far away


def closest_figure(outcome: Outcome[Study]) -> PlaneFigure:
    """The curves of LQG and LQR in a window about −1 that the distance fills."""
    s = outcome.study
    near = s.real.margins.nearest
    half = max(min(round_up_nicely(TIMES * near), MOST_HALF), 1.05 * near)
    gap = s.real.curve[int(np.argmin(np.abs(1 + s.real.curve)))] + 1
    gap = gap / max(abs(gap), 1e-300) * near
    ideal, real = both_halves(s.ideal.curve), both_halves(s.real.curve)
    return PlaneFigure(
        "closest", text("Nyquist near −1: distance {near}", near=format_number(near, ".3g")),
        (Curve(same("LQR"), ideal[1], "plant", "dash", 2.0, ideal[0]), Curve(same("LQG"), real[1], "estimate", "solid", 2.4, real[0]),
         Curve(text("distance"), np.array([0.0, gap.imag]), "error", "solid", 5.0, np.array([-1.0, gap.real - 1]))),
        (Point(-1.0, 0.0, "reference", "cross", same("−1")),), "Re ℓ", "Im ℓ", (-1 - half, -1 + half), (-half, half), equal=True,
        tab=CLOSEST_TAB, caption=text("The curve passes −1 at a distance of {near}, that of LQR at {ideal}.",
                                      near=format_number(near, ".2g"), ideal=format_number(s.ideal.margins.nearest, ".2g")))
