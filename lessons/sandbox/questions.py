"""Draw the questions of lesson 19: free poles, rank, a filter that assumes more noise."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Curve, Point
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_of_poles, question_over_time
from observer_lab.engine import chi2_band, observer_gain
from observer_lab.text import text

from .analyses import UNTESTED_SAMPLES, Refusal, Trial

NEW_POLES = (-0.4 - 2.0j, -0.4 + 2.0j, -1.2 - 0.6j, -1.2 + 0.6j)  # about the plant's pace: some right of its poles, some complex
LEFT = 1.0  # of the plant's pace: how far left of its poles, in the option that allows no others
FAR_ABOVE = 2.0  # times the expected NIS
GROUP = 7  # samples of the record whose mean NIS is one dot


def recall(asked: Asked) -> DrawnQuestion:
    """Poles that an observer can have: left of the plant's alone, or anywhere."""
    plant = asked.entry.run.scenario.plant
    own = plant.poles
    pace = float(np.abs(own).max()) or 1.0
    wanted = np.resize(np.array(NEW_POLES) * pace / 2, plant.n) if plant.n % 2 == 0 else -pace * np.linspace(0.3, 1.0, plant.n)
    wanted = wanted * np.repeat(1 + 0.1 * np.arange((plant.n + 3) // 4), 4)[:plant.n]
    left = -(np.abs(own.real) + LEFT * pace) + 1j * own.imag
    placed = np.linalg.eigvals(plant.A - observer_gain(plant.A, plant.C, wanted).gain @ plant.C)
    known = tuple(Point(complex(s).real, complex(s).imag, "plant", "cross") for s in own)
    return question_of_poles(text("the plant's poles ×, and those of an observer"), known, (left, wanted), placed)


def predict(asked: Asked) -> DrawnQuestion:
    """Rank and largest entry of L for faster poles: both as before, a larger gain, or a rank that says nothing."""
    gains = [float(np.abs(each.gains["L"]).max()) for each in (asked.entry, asked.after)]
    paces = [float(np.abs(each.poles["observer"].real).sum()) for each in (asked.entry, asked.after)]
    found = [each.study.structure.seen for each in (asked.entry, asked.after)]
    ranks = [0 if isinstance(each, Refusal) else len(each.modes) - len(each.unobservable) for each in found]
    return question_of_bar_groups(text("rank, and largest entry of L, with a faster pair"), "", (),
                                  (text("rank"), text("largest entry of L")),
                                  ((ranks[0], gains[0]), (ranks[0], gains[0] * (paces[1] / paces[0]) ** 2), (0.0, gains[0])),
                                  (ranks[1], gains[1]), "second", level=(text("now"), (ranks[0], gains[0])))


def grouped(trial: Trial | Refusal) -> tuple[np.ndarray, np.ndarray]:
    """Mean times, and means of NIS over the expected one, of groups of samples, without the first ones that no test looks at."""
    if isinstance(trial, Refusal):
        return np.linspace(0.0, 1.0, 2), np.ones(2)
    count = (len(trial.values) - UNTESTED_SAMPLES) // GROUP
    t, values = (each[UNTESTED_SAMPLES:UNTESTED_SAMPLES + count * GROUP].reshape(count, GROUP).mean(axis=1)
                 for each in (trial.t, trial.values))
    return t, values / trial.test.dof


def surprise(asked: Asked) -> DrawnQuestion:
    """NIS over time with a filter that assumes too much noise: less by the same factor, a quarter, or far above the expected."""
    (t, now), (_, after) = (grouped(each.study.trial) for each in (asked.entry, asked.after))
    factor = asked.after.design["belief"] / asked.entry.design["belief"]
    outputs = asked.entry.run.scenario.plant.p
    edges = [edge / outputs for edge in chi2_band(outputs, count=GROUP)]
    known = (Curve(text("as tuned"), now, "muted"), Curve(text("expected"), np.ones(len(t)), "reference"),
             *(Curve(name, np.full(len(t), edge), "muted", "dot", 1.4)
               for name, edge in zip((text("lower edge"), text("95 % band")), edges, strict=True)))
    drawn = question_over_time(text("NIS in this record, means of {count} samples", count=GROUP), t, known,
                               (now / factor, now / 4, now * FAR_ABOVE / now.mean()), Curve(text("1000 times the noise"), after, "error"),
                               text("times the expected value"), log_y=True)

    def dots(values: np.ndarray, role: str) -> tuple[Point, ...]:
        return tuple(Point(float(at), float(np.log10(max(value, 1e-9))), role, "dot") for at, value in zip(t, values, strict=True))
    return replace(drawn, figure=replace(drawn.figure, points=dots(now, "muted")), run=(*drawn.run, *dots(after, "error")))


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise})
