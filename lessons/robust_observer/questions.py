"""Draw the questions of lesson 15: a wrong model, the best pole, a repaired sensor."""

from __future__ import annotations

from types import MappingProxyType

from observer_lab.course.figures.records import Curve
from observer_lab.course.guiding.questions import Asked, DrawnQuestion, question_of_bars, question_over_time
from observer_lab.engine import observer_gain
from observer_lab.text import text

from ..toolkit.questions import driven, size
from .study import EXAMPLE_CASES, errors

POLES_OF_A_WHOLE_OBSERVER = (-2.0, -2.5)  # rad/s, of the observer that the recalled question is about
SLOWER = 2.0  # how much more error a slow pole leaves, in the option that calls the fast one best
FARTHER = 2.0  # how much larger J is in the option that calls poles farther out worse
SHARE_LEFT = 0.5  # of two errors of about one size, in the option that takes one away


def recall(asked: Asked) -> DrawnQuestion:
    """The error of an observer of the whole state: as with the right model, or driven by ΔA x."""
    run, plant = asked.entry.study.true, EXAMPLE_CASES[asked.entry.design["example"]].example.plant
    A, e0 = plant.A - observer_gain(plant.A, plant.C, POLES_OF_A_WHOLE_OBSERVER).gain @ plant.C, run.x[0]
    alone = size(driven(A, e0, run.t))
    pushed = size(driven(A, e0, run.t, asked.after.study.true.x @ errors(asked.after.design)[0].T))
    return question_over_time(text("size of the error e"), run.t, (Curve(text("with the exact model"), alone, "muted"),), (alone, pushed),
                              Curve(text("the real plant"), pushed, "error"), "‖e‖", log_y=True, span=(-4.0, 1.0))


def predict(asked: Asked) -> DrawnQuestion:
    """The error left at the end with a slower pole: more, as much, or less in proportion to the pole."""
    before, after = asked.entry.metrics["late_error"], asked.after.metrics["late_error"]
    fast, slow = (each.design["pole"][0].real for each in (asked.entry, asked.after))
    return question_of_bars(text("error of û at the end of the run"), "|û − u|", ((text("pole {pole:.3g}", pole=fast), before),),
                            text("pole {pole:.3g}", pole=slow), (SLOWER * before, before, before * slow / fast), after, "error")


def surprise(asked: Asked) -> DrawnQuestion:
    """The error left when the sensor is exact: the two errors had opposite signs, they had added, or it was all."""
    before = asked.entry.metrics["late_error"]
    return question_of_bars(text("error of û at the end of the run"), "|û − u|",
                            ((text("δ of the sensor {delta:.3g}", delta=asked.entry.design["c"]), before),), text("exact sensor"),
                            (before / (1 - SHARE_LEFT / 2), SHARE_LEFT * before, 0.0), asked.after.metrics["late_error"], "error")


def blind(asked: Asked) -> DrawnQuestion:
    """J with a larger imaginary part: in proportion to |s|², unchanged, or less, since the path of the tachometer shrinks."""
    before, after = (each.design["pair"][-1] for each in (asked.entry, asked.after))
    J = asked.entry.metrics["J"]
    return question_of_bars(text("criterion J of the carts"), "J",
                            ((text("pair {re:.2g} ± {im:.2g}j", re=before.real, im=abs(before.imag)), J),),
                            text("pair {re:.2g} ± {im:.2g}j", re=after.real, im=abs(after.imag)),
                            (FARTHER * J, J, asked.after.metrics["J"]), asked.after.metrics["J"], "plant")


QUESTIONS = MappingProxyType({"recall": recall, "predict": predict, "surprise": surprise, "blind": blind})
