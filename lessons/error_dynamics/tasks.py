"""Define the tasks of lesson 2."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps

import numpy as np

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import format_number, text

from ..toolkit.knobs import untouched
from .knobs import AS_PRINTED, BY_NUMBERS, BY_POLES, NO_FORCE
from .notes_page import FIRST_LINE, GAIN_LINE, MATRIX_LINE, NONE, PLANT, RIGHT_GAIN, signed
from .study import Study

SETTLING_BAND_S, MAX_SPEED_M_S = (2.1, 2.25), 0.7  # s and m/s


def _gain_words(outcome: Outcome[Study]) -> str:
    l1, l2 = outcome.gains["L"][:, 0]
    return f"({format_number(l1, '.4g')}, {format_number(l2, '.4g')})"


def _measured_position(verdict: Callable[[Outcome[Study]], Verdict]) -> Callable[[Outcome[Study]], Verdict]:
    """A task about the sensor of the notes."""
    @wraps(verdict)
    def judged(outcome: Outcome[Study]) -> Verdict:
        if outcome.study.plant is not PLANT:
            return Verdict(False, text("This task is about the position: choose it as what is measured."))
        return verdict(outcome)
    return judged


@_measured_position
def double_pole(outcome: Outcome[Study]) -> Verdict:
    """Both observer poles at −1: λ² + 2λ + 1, compared by coefficients, which are exact where a double pole is not."""
    error = outcome.study.error
    damping, square = -float(np.trace(error)), float(np.linalg.det(error))
    words = _gain_words(outcome)
    if outcome.design["method"] == AS_PRINTED:
        return Verdict(False, text("This is the pair from the notes; choose the poles or the gain yourself."))
    if abs(damping - 2) <= 0.02 and abs(square - 1) <= 0.02:
        return Verdict(True, text("Both poles are at −1, and L = {words}.", words=words))
    return Verdict(False, text("The polynomial is λ² {damping}λ {square}; it should be λ² + 2λ + 1.",
                               damping=signed(damping), square=signed(square)))


@_measured_position
def first_slip(outcome: Outcome[Study]) -> Verdict:
    """The line where the notes first go wrong, and the gain that follows once it is mended."""
    line, words = outcome.design["line"], _gain_words(outcome)
    if outcome.design["method"] == AS_PRINTED or not np.allclose(outcome.gains["L"], RIGHT_GAIN, rtol=0, atol=1e-6):
        return Verdict(False, text("The gain is {words}; find the one that puts both poles at −1 exactly.",
                                   words=words))
    if line == FIRST_LINE:
        return Verdict(True, text("With L = {words} the sum of the poles asks l₁ + 0.5 = 2; the notes print l₁ − "
                                  "0.5 = 2.",
                                  words=words))
    if line == NONE:
        return Verdict(False, text("L = {words} is right. Now choose the first line of the notes that is wrong.",
                                   words=words))
    if line in (GAIN_LINE, MATRIX_LINE):
        return Verdict(False, text("That line is wrong indeed, but it only inherits the slip from an earlier line."))
    return Verdict(False, text("That line holds with the right gain; look at the others in the tab Notes."))


@_measured_position
def mixed_matrix(outcome: Outcome[Study]) -> Verdict:
    """The gain to which the printed matrix belongs: l₁ of the slip with the true l₂."""
    words = _gain_words(outcome)
    if outcome.design["method"] != AS_PRINTED and np.allclose(outcome.gains["L"][:, 0], (2.5, -0.75), rtol=0, atol=1e-6):
        p = outcome.poles["observer"]
        reached = f"{p[0].real:.5f}, {p[1].real:.5f}".replace("-", "−")
        return Verdict(True, text("L = {words}: l₁ from the slip, l₂ from the right gain. The poles are {reached}.",
                                  words=words, reached=reached))
    return Verdict(False, text("With L = {words} the matrix is not the printed one; compare the last row of the "
                               "page, with the gain typed by yourself.",
                               words=words))


@_measured_position
def calm_speed(outcome: Outcome[Study]) -> Verdict:
    """Settled within a band of time, the velocity's error kept small; the force does not matter."""
    d, after = outcome.design, outcome.metrics["settled_after"]
    if d["method"] == AS_PRINTED or d["guess_q"] or d["guess_v"] or not untouched(d):
        return Verdict(False, text("Choose poles or gain yourself, with both guesses at 0 and no kick or pull."))
    peak = float(np.max(np.abs(outcome.run.e[:, 1]))) if outcome.run is not None else np.inf
    if np.isinf(after):
        return Verdict(False, text("The error does not stay below 2 % of its peak in this run."))
    if not SETTLING_BAND_S[0] <= after <= SETTLING_BAND_S[1]:
        return Verdict(False, text("Below 2 % of its peak after {after:.2f} s; it should be after {low:g} to {high:g} s.", after=after,
                                   low=SETTLING_BAND_S[0], high=SETTLING_BAND_S[1]))
    if peak > MAX_SPEED_M_S:
        return Verdict(False, text("Below 2 % after {after:.2f} s, but the velocity's error reaches {peak:.3g} m/s; at most {most:g} m/s.",
                                   after=after, peak=peak, most=MAX_SPEED_M_S))
    return Verdict(True, text("Below 2 % after {after:.2f} s, and the velocity's error never exceeds {peak:.3g} m/s.", after=after,
                              peak=peak))


@_measured_position
def confused(outcome: Outcome[Study]) -> Verdict:
    """An input that moves the error: only possible if the matrix in the computer is not A − LC."""
    moved = outcome.metrics["error_moved"]
    if outcome.design["input"] == NO_FORCE:
        return Verdict(False, text("There is no input; choose one."))
    left_alone = outcome.checks[0].holds  # an unstable observer may carry rounding far
    if moved >= 0.1 and not left_alone:
        return Verdict(True, text("The input moves the error by up to {moved:.2g}: this pair is no observer of "
                                  "this plant.",
                                  moved=moved))
    return Verdict(False, text("The input moves the error by {moved:.0e}; look for a way to 0.1.", moved=moved))


UNKNOWN_PUSH = Typed("(2*p-b)*d/p^2", ("p", "b", "d"), slips=(
    ("d/p^2", text("That is the error of the position; ask the first row for that of the velocity.")),
    ("2*d/p", text("You left out the damper: l₁ = 2 p − b."))))

REST_WITHOUT_INPUT = Typed("-(b*l1+l2)*u/(k*(1-l2))", ("b", "k", "l1", "l2", "u"), slips=(
    ("(b*l1+l2)*u/(k*(1-l2))", text("The sign: the error follows −L D u, not + L D u.")),
    ("l1*u/(1-l2)", text("That is the error of the velocity; ask the first entry of A⁻¹ L."))))


TASKS = (
    Task("double-pole", double_pole, {"method": BY_POLES, "observer_poles": (-1.0, -1.0)}),
    Task("first-slip", first_slip, {"method": BY_NUMBERS, "l1": 1.5, "l2": -0.75, "line": FIRST_LINE}),
    Task("mixed-matrix", mixed_matrix, {"method": BY_NUMBERS, "l1": 2.5, "l2": -0.75, "line": "matrix"}),
    Task("confused", confused, {"method": AS_PRINTED, "input": "step"}, Typed(lambda _: 2 / 3)),
    Task("calm-speed", calm_speed, {"observer_poles": (-2 - 1.3j, -2 + 1.3j)}),
    typed_task("unknown-push", UNKNOWN_PUSH),
    typed_task("direct", REST_WITHOUT_INPUT),
)
