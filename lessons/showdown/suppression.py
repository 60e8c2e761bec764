"""Draw the suppression of all controllers as bars, beside what is asked."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, PlaneFigure, Point
from observer_lab.course.lesson import Outcome
from observer_lab.text import NO_WORDS, Text, joined, listed, text

from .controllers import CONTROLLER_NAMES, SHORT_NAMES
from .curve_styles import CURVE_STYLES
from .race import leaders
from .score_tables import HEADS, SCORE_TAB
from .study import Study, as_predicted

WANTED_SUPPRESSION_DB = 20.0  # dB in every channel
TIED = 0.05  # dB: less is no lead
BAR_WIDTH_PX, BAR_STEP = 17.0, 0.2  # px; from one bar of a channel to the next, in channels


def suppression(outcome: Outcome[Study]) -> PlaneFigure:
    """A group of bars a channel, a bar a controller; a dot for the highest peak, a cross at zero for a loop that is not stable."""
    m, bars, marks = outcome.study, [], []
    stable = np.array([s.stable for s in m.spectra])
    for i in range(1, 5):
        role, name = CURVE_STYLES[i][0], CONTROLLER_NAMES[i]
        for j in range(3):
            at = j + BAR_STEP * (i - 2.5)
            if not stable[i]:
                marks.append(Point(at, 0.0, role, "cross"))
                continue
            bars.append(Curve(name, np.array([0.0, m.band_db[i, j]]), role, "solid", BAR_WIDTH_PX, np.full(2, at)))
            marks.append(Point(at, float(m.peak_db[i, j]), role, "dot"))
        if not stable[i]:
            bars.append(Curve(text("{name}: unstable", name=name), np.zeros(2), role, "solid", 0.0, np.full(2, BAR_STEP * (i - 2.5))))
    asked = Curve(text("asked: {wanted:g} dB", wanted=WANTED_SUPPRESSION_DB), np.full(2, WANTED_SUPPRESSION_DB), "force", "dash", 2.4,
                  np.array([-0.6, 2.6]))
    heights = [float(y) for curve in bars for y in curve.y] + [mark.y for mark in marks]
    low, high = min(0.0, *heights), max(1.25 * WANTED_SUPPRESSION_DB, *heights)
    gains = np.where(stable[:, None], m.band_db, -np.inf)
    said = joined(as_predicted(outcome.design, best_words(gains[1:]) if stable[1:].any() else
                               text("Unstable with these settings: {names}.", names=listed(SHORT_NAMES[1:]))),
                  NO_WORDS if m.trials is None or m.trials.raced is None else leaders(m.trials.raced.rms))
    title = text("suppression, 0.5–3 Hz: of the area, dots: of the highest peak")
    span = -round_up_nicely(-1.05 * low) if low < 0 else 0.0, round_up_nicely(1.05 * high)
    return PlaneFigure("suppression", title, (*bars, asked), tuple(marks), "", "dB", (-0.6, 2.6), span, caption=said, tab=SCORE_TAB,
                       names=tuple((float(j), head) for j, head in enumerate(HEADS)))


def best_words(gains: np.ndarray) -> Text:
    """Which controllers reduce the area most in each channel (4, 3) in dB: those that tie, or none where none reduces it."""
    def named(j: int) -> Text:
        most = float(np.nanmax(gains[:, j]))
        if most <= TIED:
            return SHORT_NAMES[0]
        return listed(SHORT_NAMES[1 + int(i)] for i in np.flatnonzero(gains[:, j] >= most - TIED))
    return text("Best by area: {short} vertically, {short2} in rotation, {short3} horizontally.", short=named(0), short2=named(1),
                short3=named(2))
