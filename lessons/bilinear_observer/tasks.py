"""Tasks of the lesson and its exam item: the slip, the plant that runs away, no derivative, three sensors."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text import text

from .page import FATAL, NONE
from .problems import PAPER, PRINTED
from .study import FILTERED, Study


def _number(value: float) -> str:
    return f"{value:.3g}".replace("-", "−")


def _slip(outcome: Outcome[Study]) -> Verdict:
    line, pole = outcome.design["line"], outcome.metrics["pole"]
    if line == NONE:
        return Verdict(False, text("No line is in doubt yet; walk through the steps and compare."))
    if line != FATAL:
        return Verdict(False, text("That line is no worse than rounding: by itself it leaves the pole at −30 or "
                                   "next to it."))
    if outcome.design["problem"] != PAPER or outcome.design["gain"] != PRINTED:
        return Verdict(False, text("That is the line. Now run the gain as printed and see what it does."))
    return Verdict(True, text("L₄ must be π = 9.29. As printed the pole is +{pole}, and the error at the end of "
                              "the run is {late_error:.1e}.",
                              pole=_number(pole), late_error=outcome.metrics["late_error"]))


def _runaway(outcome: Outcome[Study]) -> Verdict:
    m = outcome.metrics
    peak, late = m["late_g"], m["late_error"]
    if peak < 1000:
        return Verdict(False, text("In the last tenth of the run |g| is at most {peak}; drive it beyond 1000.",
                                   peak=_number(peak)))
    if late > 1e-6 or m["law_gap"] > 1e-6:
        return Verdict(False, text("|g| passes 1000, but ε does too much: {late:.1e} at the end. Take an observer "
                                   "whose pole is on the left and which needs no differentiator.",
                                   late=late))
    return Verdict(True, text("|g| reaches {peak} and ε is down to {late:.0e}: the observer does not notice.",
                              peak=_number(peak), late=late))


def _lag(outcome: Outcome[Study]) -> Verdict:
    late = outcome.metrics["half_error"]
    if outcome.design["form"] != FILTERED:
        return Verdict(False, text("The ghost does not use the differentiator yet; choose that form."))
    if outcome.metrics["pole"] >= 0 or outcome.design["problem"] != PAPER:
        return Verdict(False, text("Take the paper's problem and a pole on the left."))
    if late > 0.02:
        return Verdict(False, text("In the second half of the run |ε| is up to {late}; bring it to 0.02 or less.",
                                   late=_number(late)))
    return Verdict(True, text("|ε| stays below {late}. Without ẏ it is {plain_half:.0e} with nothing to tune.",
                              late=_number(late), plain_half=outcome.metrics["plain_half"]))


def _three(outcome: Outcome[Study]) -> Verdict:
    observer, m = outcome.study.observer, outcome.metrics
    if observer.plant.m > 3:
        return Verdict(False, text("Four sensors are still in use; the task allows three."))
    if not observer.solved:
        return Verdict(False, text("With these three sensors this g has no such observer: (21) fails, look at the "
                                   "lights."))
    if m["law_gap"] > 1e-6:
        return Verdict(False, text("An observer exists, but the form in use does not follow its law; leave the "
                                   "differentiator."))
    return Verdict(True, text("Three sensors, one L and one pole, {pole}: case 2.", pole=_number(m["pole"])))


TASKS = (
    Task("slip", _slip, {"line": FATAL, "gain": PRINTED}),
    Task("runaway", _runaway, {"input": "step", "amplitude": 3.0}),
    Task("lag", _lag, {"form": FILTERED, "tau": 0.003}),
    Task("three-sensors", _three, {"problem": "three-fitting"}),
)


def exam(seed: int) -> ExamItem:
    """Scalar A*, B* and a pole p: π = (A* − p)/B*."""
    rng = np.random.default_rng(seed)
    a, b, p = -float(rng.integers(10, 90)) / 10, float(rng.integers(11, 49)) / 10, -float(rng.integers(12, 45))
    return ExamItem({"a": f"{a:g}", "b": f"{b:g}", "p": f"{p:g}"}, (a - p) / b, 0.006)
