"""Define the tasks of lesson 16."""

from __future__ import annotations

import numpy as np

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.plants.bilinear import POLE
from observer_lab.text import format_number, text

from .input_signals import FILTERED_DERIVATIVE
from .paper_example import FATAL, NONE
from .problems import COMPUTED_GAIN, PAPER_PROBLEM, TYPED_GAIN
from .study import Study

TO_TYPE, AT_FIRST = 0.1, 0.05  # rad/s that the pole may be off, and |ε(0)|
NOISE_IS_ON = Verdict(False, text("Turn the sensors' noise off: this task is about the error that is left without it."))
MAX_ROW_NORM = 16.7  # of the row G − Y/p


def _number(value: float) -> str:
    return format_number(value, ".3g")


def _slip(outcome: Outcome[Study]) -> Verdict:
    line, pole = outcome.design["line"], outcome.metrics["pole"]
    if line == NONE:
        return Verdict(False, text("No line is in doubt yet; walk through the steps and compare."))
    if line != FATAL:
        return Verdict(False, text("That line is no worse than rounding: by itself it leaves the pole at −30 or "
                                   "next to it."))
    if outcome.design["problem"] != PAPER_PROBLEM or outcome.design["gain"] != TYPED_GAIN:
        return Verdict(False, text("That is the line. Now type what L₄ must be."))
    if abs(pole - POLE) > TO_TYPE:
        return Verdict(False, text("With L₄ = {typed:.2f} the pole is {pole}; −30 is wanted, within 0.1.",
                                   typed=outcome.design["l4"], pole=_number(pole)))
    return Verdict(True, text("With L₄ = {typed:.2f} the pole is {pole}; with the printed 2.29 it is +5.02.",
                              typed=outcome.design["l4"], pole=_number(pole)))


def _runaway(outcome: Outcome[Study]) -> Verdict:
    m = outcome.metrics
    peak, late = m["late_g"], m["late_error"]
    if outcome.design["noise"]:
        return NOISE_IS_ON
    if abs(peak - 1000) > 100:
        return Verdict(False, text("In the last tenth of the run |g| is at most {peak}; let it be 1000, within 10 %.",
                                   peak=_number(peak)))
    if late > 1e-6 or m["law_gap"] > 1e-6:
        return Verdict(False, text("|g| is near 1000, but ε does too much: {late:.1e} at the end. Take an observer "
                                   "whose pole is on the left and which needs no differentiator.",
                                   late=late))
    return Verdict(True, text("|g| reaches {peak} and ε is down to {late:.0e}: the input does not disturb the observer.",
                              peak=_number(peak), late=late))


def _lag(outcome: Outcome[Study]) -> Verdict:
    late = outcome.metrics["half_error"]
    if outcome.design["noise"]:
        return NOISE_IS_ON
    if outcome.design["form"] != FILTERED_DERIVATIVE:
        return Verdict(False, text("The ghost does not use the differentiator yet; choose that form."))
    if outcome.metrics["pole"] >= 0 or outcome.design["problem"] != PAPER_PROBLEM:
        return Verdict(False, text("Take the paper's problem and a pole on the left."))
    if late > 0.02:
        return Verdict(False, text("In the second half of the run |ε| is up to {late}; bring it to 0.02 or less.",
                                   late=_number(late)))
    if late < 0.018:
        return Verdict(False, text("|ε| stays below {late}: a slower differentiator, which passes less noise, would do.",
                                   late=_number(late)))
    return Verdict(True, text("|ε| stays below {late}. Without ẏ it is {plain_half:.0e} with nothing to tune.",
                              late=_number(late), plain_half=outcome.metrics["plain_half"]))


def _three(outcome: Outcome[Study]) -> Verdict:
    observer, m = outcome.study.observer, outcome.metrics
    if outcome.design["noise"]:
        return NOISE_IS_ON
    if observer.plant.m > 3:
        return Verdict(False, text("Four sensors are still in use; the task allows three."))
    if not observer.solved:
        return Verdict(False, text("With these three sensors this g has no such observer: (21) fails, look at the "
                                   "lights."))
    if m["law_gap"] > 1e-6:
        return Verdict(False, text("An observer exists, but the form in use does not follow its law; leave the "
                                   "differentiator."))
    if abs(m["first_error"]) > AT_FIRST:
        return Verdict(False, text("An observer, with the pole {pole}; but ĝ starts {first} from g. Start χ where ĝ is right.",
                                   pole=_number(m["pole"]), first=_number(m["first_error"])))
    return Verdict(True, text("Three sensors, one L and one pole, {pole}: case 2, and right from the start.", pole=_number(m["pole"])))


def _offsets(outcome: Outcome[Study]) -> Verdict:
    d, pole = outcome.design, outcome.metrics["pole"]
    if d["problem"] != PAPER_PROBLEM or d["gain"] != COMPUTED_GAIN or pole >= 0:
        return Verdict(False, text("Take the paper's problem with the computed gain, and a pole on the left."))
    plain = outcome.study.observer.forms(outcome.gains["L"])[1]
    long = float(np.linalg.norm(plain.G_y - plain.G_z @ np.linalg.solve(plain.A, plain.Y)))
    if long > MAX_ROW_NORM:
        return Verdict(False, text("At {pole} the row has the norm {long:.2f}; at most {most:g} is wanted.", pole=_number(pole), long=long,
                                   most=MAX_ROW_NORM))
    return Verdict(True, text("At {pole} the row has the norm {long:.2f}: fast enough, and not too sensitive to sensor errors.",
                              pole=_number(pole), long=long))


BLIND_INPUT = Typed("(1-g*b)/(g^2*f)", ("b", "f", "g"), slips=(
    ("(1-g*b)/(g*f)", text("The second row contains u through g, and the determinant multiplies it by g once more.")),
    ("1/(g^2*f)", text("That is without the friction b."))))

ENOUGH = Typed("((k+1)*n-r)/(k+2)", ("n", "k", "r"), slips=(
    ("(2*n-r)/3", text("That is for one input; each further one asks for an F_j T₂ and an F_j T₃ of its own.")),
    ("((k+1)*n)/(k+2)", text("A T₃ has n − m − r columns only: A T₂ stands in no condition, it makes the poles.")),
    ("k*(2*n-r)/(2*k+1)", text("A T₃ stands in Q once, however many inputs there are."))))

TASKS = (
    Task("slip", _slip, {"line": FATAL, "gain": TYPED_GAIN, "l4": 9.29}),
    Task("runaway", _runaway, {"input": "step", "amplitude": 2.5}),
    Task("lag", _lag, {"form": FILTERED_DERIVATIVE, "tau": 0.004}),
    Task("three-sensors", _three, {"problem": "three-fitting", "chi0": 4.5}),
    typed_task("blind-input", BLIND_INPUT),
    Task("offsets", _offsets, {"pole": (-8.4 + 0j,)}),
    typed_task("enough", ENOUGH),
)
