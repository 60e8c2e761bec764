"""Results typed in: what is read, what is right, and how a wrong one is refuted."""

from __future__ import annotations

import contextlib
import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from laws import each

from observer_lab.course.exercises.typed_answers import MAX_TYPED_CHARACTERS, Typed, UnreadableInput, evaluate_typed
from observer_lab.course.lesson import NO_STUDY, Design, Outcome, typed_task
from observer_lab.lessons import LESSONS
from observer_lab.text import text

BLANK = Outcome(Design("none", ()), study=NO_STUDY)
GAIN = Typed("p^2 - k - b*(2*p - b)", ("p", "k", "b"), slips=(("p^2 - k", text("You left out the damper.")),))


@each("said, value", [
    ("1.25", 1.25), ("5/4", 1.25), (" -3 ", -3.0), ("−3", -3.0), ("2p", 4.0), ("2(p+1)", 6.0), ("l = p²", 4.0), ("√(p+2)", 2.0),
    ("p^3", 8.0), ("e^0", 1.0), ("ln(e)", 1.0), ("2·p×3", 12.0), ("1e-3", 1e-3), ("(p)(p)", 4.0), ("-p^2", -4.0), ("2e", 2 * math.e),
    ("0,5p", 1.0), ("p⁻¹", 0.5), ("√p", 2**0.5), ("3p²（p＋1）", 36.0), ("1,25p + 0，5", 3.0)])
def test_an_expression_is_read_as_it_is_written_on_paper(said: str, value: float) -> None:
    assert evaluate_typed(said, {"p": 2.0}) == pytest.approx(value, rel=1e-12)


@each("said", ["", "=", "q", "p +", "1/0", "ln(0-1)", "9^9^9^9", "p.real", "__import__('os')", "p if p else 1", "[1]", "True", "abs", "1j",
               "(" * 300, "1" * (MAX_TYPED_CHARACTERS + 1), "lambda: 1", "ln(p, 2)", "(-8)^(1/3)"])
def test_what_is_no_number_is_refused_in_a_sentence(said: str) -> None:
    with pytest.raises(UnreadableInput):
        evaluate_typed(said, {"p": 2.0})
    solved, why = GAIN.judge(BLANK, said)
    assert not solved and why("en").endswith(".") and why("zh") != why("en")


@pytest.mark.slow
@given(st.text(max_size=60))
def test_whatever_is_typed_is_a_number_or_unreadable(said: str) -> None:
    with contextlib.suppress(UnreadableInput):
        assert math.isfinite(evaluate_typed(said, {"p": 2.0}))


@each("said", ["p^2 - k - 2*b*p + b^2", "(p-b)^2 - k", "l2 = -k + b² + p² − 2 p*b"])
def test_the_same_expression_in_another_form_is_right(said: str) -> None:
    assert GAIN.judge(BLANK, said)[0]


def test_a_usual_slip_is_refuted_by_its_own_sentence_and_another_by_numbers() -> None:
    assert GAIN.judge(BLANK, "p*p - k")[1]("en") == "You left out the damper."
    solved, why = GAIN.judge(BLANK, "p^2")
    assert not solved and "yours gives" in why("en")


def test_an_answer_nearly_right_is_told_what_is_wrong_with_it() -> None:
    """The sign, too few digits, thousands or decimals, a root of something negative: each has its sentence, in both languages."""
    number, signs = Typed(lambda _: -1.25), Typed("a - b", ("a", "b"))
    said = [number.judge(BLANK, "1,25"), number.judge(BLANK, "-1.2"), number.judge(BLANK, "-3"), number.judge(BLANK, "-1,250"),
            number.judge(BLANK, "-1.25 m"), signs.judge(BLANK, "b - a"), signs.judge(BLANK, "sqrt(a-b)^2"), signs.judge(BLANK, "ab")]
    assert not any(solved for solved, _ in said) and number.judge(BLANK, "−1,25")[0]
    for (_, why), words in zip(said, ("sign is not", "three digits", "is not it", "two numbers", "without a unit", "sign is not",
                                      "no real value", "between any two"), strict=True):
        assert words in why("en") and why("zh") != why("en"), words


def test_the_sentence_of_what_can_be_typed_names_every_function_that_an_answer_needs() -> None:
    for lesson in LESSONS.values():
        for typed in (task.typed for task in lesson.tasks if task.typed is not None):
            if typed.letters:
                told = typed.judge(BLANK, "?")[1]("en")
                assert all(name in told for name in (*typed.letters, *re.findall(r"[a-z]{2,}", typed.right(BLANK)))), (lesson.id, told)


def test_a_number_is_right_to_the_digits_that_are_asked() -> None:
    third = Typed(lambda _: 1 / 3)
    assert third.judge(BLANK, "0.333")[0] and third.judge(BLANK, "1/3")[0]
    assert not third.judge(BLANK, "0.34")[0] and not third.judge(BLANK, "")[0]


def test_a_pencil_task_is_solved_by_what_is_typed_alone() -> None:
    task = typed_task("gain", GAIN)
    assert not task.judge(BLANK).solved and task.judge(BLANK, GAIN.right(BLANK)).solved
