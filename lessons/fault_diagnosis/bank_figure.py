"""Draw the seven test values of one sample as bars beside the threshold."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import Curve, PlaneFigure, Point
from observer_lab.text import same, text

from .observer_bank import DT, MEMBER_NAMES, PLACE_NAMES
from .results import Study

VERDICT_TAB = text("Verdict")
BAR_WIDTH, HIGHEST = 26.0, 3.0  # px; of the threshold: a bar beyond it ends there with an arrow


def bank(s: Study, at: int) -> PlaneFigure:
    """A bar for each observer: its test value over the threshold at a sample."""
    values = s.verdict.values[at]
    bars = tuple(Curve(text("alarm") if value > 1 else text("no alarm"), np.array([0.0, min(value, HIGHEST)]),
                       "error" if value > 1 else "plant", "solid", BAR_WIDTH, np.full(2, float(k))) for k, value in enumerate(values))
    line = Curve(text("threshold"), np.ones(3), "reference", "dash", 1.8,
                 np.linspace(-0.6, len(values) - 0.4, 3))
    quiet = [k for k, value in enumerate(values) if value <= 1]
    fits = text("Only the observer that ignores {place} stays below the threshold.", place=PLACE_NAMES[quiet[0]]) if len(quiet) == 1 else (
        text("No observer is above the threshold.") if len(quiet) == len(values) else
        text("Observers above the threshold: {count} of {all}.", count=len(values) - len(quiet), all=len(values)))
    return PlaneFigure("bank", text("test value of each observer at {at:.2f} s", at=DT * at), (*bars, line),
                       tuple(Point(float(k), HIGHEST, "error", "up") for k, value in enumerate(values) if value > HIGHEST),
                       text("the part that the observer ignores"), "T / χ²", (-0.6, len(values) - 0.4), (0.0, 1.05 * HIGHEST),
                       tab=VERDICT_TAB, names=tuple((float(k), same(name[1:])) for k, name in enumerate(MEMBER_NAMES)),
                       caption=fits)
