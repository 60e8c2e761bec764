"""Draw the questions of lesson 19: free poles, rank, a filter that assumes more noise."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Point
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bar_groups, question_of_poles
from observer_lab.engine import observer_gain
from observer_lab.text import text

from ..toolkit.questions import question_of_decades
from .analyses import Refusal

NEW_POLES = (-0.4 - 2.0j, -0.4 + 2.0j, -1.2 - 0.6j, -1.2 + 0.6j)  # about the plant's pace: some right of its poles, some complex
LEFT = 1.0  # of the plant's pace: how far left of its poles, in the option that allows no others
FAR_ABOVE = 2.0  # times the expected NIS


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
    """Rank and gain for faster poles, over those now: both as before, a larger gain, or a rank that says nothing."""
    gains = [float(np.abs(each.gains["L"]).max()) for each in (asked.entry, asked.after)]
    paces = [float(np.abs(each.poles["observer"].real).sum()) for each in (asked.entry, asked.after)]
    found = [each.study.structure.seen for each in (asked.entry, asked.after)]
    ranks = [0 if isinstance(each, Refusal) else len(each.modes) - len(each.unobservable) for each in found]
    return question_of_bar_groups(text("rank, and largest entry of L, with a faster pair"), text("times the value now"), (),
                                  (text("rank"), text("largest entry of L")),
                                  ((1.0, 1.0), (1.0, (paces[1] / paces[0]) ** 2), (0.0, 1.0)),
                                  (ranks[1] / max(ranks[0], 1), gains[1] / gains[0]), "estimate", level=(text("now"), (1.0, 1.0)))


def surprise(asked: Asked) -> DrawnQuestion:
    """Mean NIS of a filter that assumes too much noise: less by the same factor, a quarter, or far above the expected."""
    now, after = asked.entry.metrics["nis_mean"], asked.after.metrics["nis_mean"]
    factor = asked.after.design["belief"] / asked.entry.design["belief"]
    test = asked.entry.study.trial
    expected = 1.0 if isinstance(test, Refusal) else float(test.test.dof)
    return question_of_decades(text("mean NIS in this record"), text("times the expected value"), ((text("as tuned"), now / expected),),
                               (text("1000 times the noise"),),
                               tuple((value / expected,) for value in (now / factor, now / 4, FAR_ABOVE * expected)), (after / expected,),
                               "estimate")


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise})
