"""Draw the questions of lesson 7: a pole in fog, poles that move, the applied force, an exact start."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
from scipy.linalg import expm

from observer_lab.course.figures.records import Curve, Point
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_poles, question_over_time
from observer_lab.text import text

from .study import ANGLE, CART_PLANT

SHIFT = 1.4  # of a pole that moves
LATER = 1.6  # how much later the pole falls, in the option that says that the error becomes smaller
SOONER = 1.2  # how much faster the pole falls, in the option that says so
SHOWN_S, SHOWN_DEG = 2.5, 20.0  # s and degrees of the angle's plot


def _sorted(*poles: np.ndarray) -> list[complex]:
    return np.sort_complex(np.concatenate([np.asarray(each, dtype=complex) for each in poles])).tolist()


def _angle(x: np.ndarray) -> np.ndarray:
    """The pole's angle of states (n_t, 4) in degrees, held at the edge of the plot."""
    return np.clip(np.degrees(x[:, ANGLE]), -SHOWN_DEG, SHOWN_DEG)


def fog(asked: Asked) -> DrawnQuestion:
    """The angle of a hidden pole: falling without a force, upright with the estimate, or as it was."""
    shown = asked.entry.study.shown
    few = shown.t <= SHOWN_S
    t, start = shown.t[few], shown.x[0]
    falls = np.array([(expm(CART_PLANT.A * each) @ start)[ANGLE] for each in t])
    angles = falls, shown.x[few, ANGLE], np.full(len(t), start[ANGLE])
    lines = tuple(np.clip(np.degrees(each), -SHOWN_DEG, SHOWN_DEG) for each in angles)
    estimate = np.clip(np.degrees(shown.xhat[few, ANGLE]), -SHOWN_DEG, SHOWN_DEG)
    return question_over_time(text("angle of the pole"), t, (Curve(text("estimate"), estimate, "estimate", "dash"),), lines,
                              Curve(text("true"), lines[1]), "θ [°]")


def recall(asked: Asked) -> DrawnQuestion:
    """The loop's poles when one pair of the observer's moves: this pair alone, or all of them."""
    before = asked.entry.poles
    wanted = np.asarray(asked.entry.design["observer_poles"])
    lead = wanted.real == wanted.real.min()
    after = asked.at(observer_poles=tuple(np.where(lead, SHIFT * wanted, wanted).tolist())).poles
    known = _sorted(before["controller"], before["observer"])
    return question_of_poles(text("poles of the loop"), tuple(Point(s.real, s.imag, "muted", "circle") for s in known), (
        _sorted(before["controller"], np.where(lead, SHIFT * wanted, wanted)), [SHIFT * s for s in known]),
        _sorted(after["controller"], after["observer"]))


def predict(asked: Asked) -> DrawnQuestion:
    """The angle with the applied force: as now, falling a little later, as if x were known, or caught by this observer."""
    before, after = asked.entry.study.shown, asked.after.study.shown
    few = before.t <= SHOWN_S
    t, now = before.t[few], _angle(before.x[few])
    return question_over_time(text("angle of the pole"), t, (Curve(text("now"), now, "muted", "dot"),), (
        now, np.interp(t / LATER, t, now), _angle(asked.after.study.known[few]), _angle(after.x[few])),
        Curve(text("with the applied force"), _angle(after.x[few])), "θ [°]")


def surprise(asked: Asked) -> DrawnQuestion:
    """The angle from an exact start: as if x were known, falling sooner than now, or as from a smaller error."""
    before, after = asked.entry.study.shown, asked.after.study.shown
    few = before.t <= SHOWN_S
    t, now = before.t[few], _angle(before.x[few])
    return question_over_time(text("angle of the pole"), t, (Curve(text("now"), now, "muted", "dot"),), (
        _angle(asked.after.study.known[few]), np.interp(SOONER * t, t, now), _angle(asked.at(error0=3.0).study.shown.x[few])),
        Curve(text("without an error"), _angle(after.x[few])), "θ [°]")


def _until_it_falls(drawn: DrawnQuestion) -> DrawnQuestion:
    """The same, each angle up to where it leaves the plot."""
    def cut(part: Curve | Point) -> Curve | Point:
        if isinstance(part, Point) or part.x is None or not (out := np.flatnonzero(np.abs(part.y) >= SHOWN_DEG)).size:
            return part
        return replace(part, x=part.x[:out[0] + 1], y=part.y[:out[0] + 1])
    return replace(drawn, figure=replace(drawn.figure, curves=tuple(map(cut, drawn.figure.curves))),
                   options=tuple(tuple(map(cut, option)) for option in drawn.options), run=tuple(map(cut, drawn.run)))


QUESTIONS = MappingProxyType({
    "fog": lambda asked: _until_it_falls(fog(asked)), "recall": recall, "predict": lambda asked: _until_it_falls(predict(asked)),
    "surprise": lambda asked: _until_it_falls(surprise(asked))})
