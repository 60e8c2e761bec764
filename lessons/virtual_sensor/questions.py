"""Draw the questions of lesson 1: the copy's error, and how high the estimate climbs."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve, Point
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_over_time
from observer_lab.text import text

CLAIMED_PEAK_K = 90.0  # K: as high as the option says that the estimate climbs
SHOWN_S = 5.0  # s of the climb


def predict(asked: Asked) -> DrawnQuestion:
    """The copy's error: it decays as the chip cools, stays as at the start, or decays as fast as the observer's."""
    t, error = asked.after.run.t, np.abs(asked.after.study.copy.e[:, 0])
    cools = error[0] * np.exp(asked.after.metrics["slowest_copy"] * t)
    observer = np.abs(asked.at(trust=1.0).run.e[:, 0])
    now = Curve(text("true core"), asked.entry.run.x[:, 0], "muted")
    drawn = question_over_time(text("error of the core"), t, (now,), (cools, np.full(len(t), error[0]), observer),
                               Curve(text("the copy's error"), error, "second"), "T₁, |e₁| [K]")
    start = Point(float(t[0]), float(error[0]), "error", "dot", text("error at the start"))
    return replace(drawn, figure=replace(drawn.figure, points=(start,)))


def surprise(asked: Asked) -> DrawnQuestion:
    """The estimate of the core: as high as before but sooner, far above the true value, or never above it."""
    before, after = asked.entry.run, asked.after.run
    t, estimate, true = before.t, before.xhat[:, 0], before.x[:, 0]
    pace = -max(pole.real for pole in asked.after.design["observer_poles"])
    rise = 1 - np.exp(-pace * t)
    pulse = t * np.exp(1 - pace * t) * pace  # 1 at its peak
    above = rise * true + (CLAIMED_PEAK_K - float((rise * true)[np.argmax(pulse)])) * pulse
    seen = t <= SHOWN_S
    known = (Curve(text("true core"), true[seen]), Curve(text("estimate now"), estimate[seen], "estimate", "dot"))
    return question_over_time(text("core temperature"), t[seen], known,
                              (np.interp(np.minimum(2 * t, t[-1]), t, estimate)[seen], above[seen], (rise * true)[seen]),
                              Curve(text("estimate then"), after.xhat[seen, 0], "estimate"), "T₁ [K]")


QUESTIONS = MappingProxyType({"predict": predict, "surprise": surprise})
