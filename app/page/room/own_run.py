"""Draw a follower's own run: the error of their seed beside what P predicts for it."""

from __future__ import annotations

import html

import numpy as np

from ...classroom.class_runs import ClassRuns, OwnRun
from ...course.figures.records import Curve, PlaneFigure
from ...text import same
from ..charts.svg import draw
from ..words import phrases

LEAST_HALF, MARGIN = 1e-12, 1.15  # of the range of the errors that is shown
STARTED = 0.25  # the part of the run after which its errors set that range: the start may lie beyond it


def own_run_html(runs: ClassRuns, run: OwnRun, language: str) -> str:
    """The course of the error between ±2σ, and whether it ends in the ellipse of P. Nothing tells whose run it is."""
    t, e, band = np.array(runs.times), np.array(run.path), 2 * np.array(run.sigma)
    late = slice(int(STARTED * len(t)), None)
    half = MARGIN * max(float(np.abs(e[late]).max()), float(band[late].max()), LEAST_HALF)
    figure = PlaneFigure(
        "own-run", phrases.OWN_RUN,
        (Curve(phrases.OWN_ERROR, e, "error", x=t), Curve(same("+ 2σ"), band, "muted", "dot", 1.4, t),
         Curve(same("− 2σ"), -band, "muted", "dot", 1.4, t)),
        x_label="t [s]", y_label=runs.name.get(language, next(iter(runs.name.values()))), x_range=(float(t[0]), float(t[-1])),
        y_range=(-half, half))
    said = html.escape((phrases.OWN_INSIDE if run.inside else phrases.OWN_OUTSIDE)(language))
    return f'<section class="ol-own-run">{draw(figure, language)}<p class="ol-note" role="status">{said}</p></section>'
