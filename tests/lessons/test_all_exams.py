"""Exams: draws, digits and typed numbers; and every exam of every lesson over a few seeds (`all_exams.py` tries hundreds)."""

from __future__ import annotations

import re

import pytest
from all_exams import printed_leads, wrong
from exam_oracles import ORACLES
from laws import each
from lesson_checks import CJK, check_markdown, every_lesson, without_math

from observer_lab.course.exercises.derivation import fill_placeholders
from observer_lab.course.exercises.exam import WHOLE_NUMBER, Digits, Exam, ExamItem, SeededDraws, decimals, number_of, seed_of, significant
from observer_lab.course.exercises.typed_answers import UnreadableInput
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.text import languages

SEEDS = range(5)
MOST_ASKED, MOST_DERIVED = 70, 110  # words of a statement and of a derivation
MOST_ASKED_ZH, MOST_DERIVED_ZH = 150, 220  # and their characters in Chinese
KINDS = (WHOLE_NUMBER, decimals(0), decimals(1), decimals(2), significant(2), significant(3))


# --- the mechanism -----------------------------------------------------------------------------------------------------
@each("digits", KINDS)
def test_what_is_rounded_as_asked_passes_and_a_slip_of_the_last_digit_fails(digits: Digits) -> None:
    lot = SeededDraws("digits")
    answers = [sign * lot.whole(1, 10**6) / 10 ** lot.whole(0, 8) for sign in (-1, 1) for _ in range(400)] + [999.6, 0.09996, 10.0]
    fair = [float(round(a)) if digits is WHOLE_NUMBER else a for a in answers if digits is WHOLE_NUMBER or digits.fair(a)]
    assert len(fair) > 600
    for answer in fair:
        said, unit = digits.written(answer), digits.unit(answer)
        assert digits.accepts(answer, number_of(said)) and digits.accepts(answer, answer), (answer, said)
        assert not any(digits.accepts(answer, number_of(said) + slip * unit) for slip in (-1, 1)), (answer, said)
    assert not digits.accepts(2.0, float("nan")) and not digits.fair(float("inf")) and not digits.fair(float("nan"))


@each("digits, answer, said", [(decimals(2), -1.204, "-1.20"), (decimals(0), 58.4, "58"), (WHOLE_NUMBER, 7.0, "7"),
                               (significant(3), 1234.4, "1230"),
                               (significant(3), 0.0123449, "0.0123"), (significant(2), 9.96, "10"), (decimals(1), -0.04, "0.0")])
def test_an_answer_is_written_with_the_digits_asked_for(digits: Digits, answer: float, said: str) -> None:
    assert digits.written(answer) == said


@each("said, value", [("0.05", 0.05), ("5e-2", 0.05), ("1/3", 1 / 3), ("−1.2", -1.2), ("0,05", 0.05), ("0，5", 0.5), (" +3 ", 3.0),
                      ("5·10⁻²", 0.05), ("10⁻³", 1e-3), ("2·10^3", 2000.0), ("√2", 2**0.5), ("x = 4", 4.0),
                      ("-(1+2)/4", -0.75), ("2²", 4.0), ("1e3", 1e3), ("3/7", 3 / 7), ("０．５", 0.5), ("≈ 3", 3.0), ("2√2", 8**0.5)])
def test_a_number_is_read_as_a_person_writes_it(said: str, value: float) -> None:
    assert number_of(said) == pytest.approx(value, rel=1e-15)


@each("said", ["", "four", "1,234", "4 m", "1 2", "--", "1/0", "x", "∞", "1，250", "-1,250", "50 %"])
def test_what_is_no_number_is_refused(said: str) -> None:
    with pytest.raises(UnreadableInput):
        number_of(said)


def test_an_answer_of_one_digit_tells_too_little() -> None:
    assert decimals(2).telling(-0.10) and decimals(2).telling(0.0951) and not decimals(2).telling(0.09)
    assert decimals(0).telling(3.2) and WHOLE_NUMBER.telling(3.0) and significant(3).telling(1e-9)


@each("line, follows", [(r"K=\frac{1.3}{1.058-1}=22.4", True), (r"K=\frac{1.3}{1.058-1}=22.5", False), (r"0.8\cdot19.33=15.47", False),
                        (r"0.8\cdot19.3333=15.47", True)])
def test_the_printed_numbers_lead_to_what_is_printed_last(line: str, follows: bool) -> None:
    assert printed_leads(line, line.rpartition("=")[2], 0.1 if "K" in line else 0.01) is follows


def test_draws_are_the_same_on_every_machine_and_evenly_spread() -> None:
    lot = SeededDraws(7)
    assert [lot.whole(1, 100) for _ in range(5)] == list(map(SeededDraws(7).whole, [1] * 5, [100] * 5))
    counts = [sum(value == face for value in map(SeededDraws(1).whole, [1] * 3000, [6] * 3000)) for face in range(1, 7)]
    assert sum(counts) == 3000 and all(420 < count < 580 for count in counts), counts
    assert sorted(SeededDraws(3).some("abcd", 4)) == list("abcd") and SeededDraws(3).one([5]) == 5 and SeededDraws(3).part(3, 3) == 0.3
    assert seed_of("Li Wei", "kalman", "step", 1) .startswith("67af07efefc9")  # for ever


def test_an_exam_draws_again_what_is_unfit() -> None:
    drawn: list[float | None] = [None, float("nan"), 0.125, 0.0, 3.0, 4.0]
    exam = Exam("x", decimals(2), lambda lot: None if (a := drawn[lot.whole(0, 5)]) is None else ExamItem({"a": 3.0}, a))
    assert {exam.item(seed).answer for seed in range(40)} == {4.0}
    never = Exam("x", decimals(2), lambda lot: ExamItem({"a": 3.0}, -3.0))
    with pytest.raises(RuntimeError, match="draws nothing fit"):
        never.item(1)


# --- every exam ----------------------------------------------------------------------------------------------------------
@every_lesson
def test_the_exams_of_a_lesson(lesson: Lesson) -> None:
    """Four ideas; answers as independent code finds them; nothing degenerate, nothing given away; derivations that are true."""
    assert len(lesson.exams) == 4 == len({exam.id for exam in lesson.exams})
    assert not [line for exam in lesson.exams for line in wrong(lesson, exam, SEEDS)]


def test_there_is_an_oracle_for_every_exam_and_none_left_over() -> None:
    assert set(ORACLES) == {(lesson.id, exam.id) for lesson in LESSONS.values() for exam in lesson.exams}


@every_lesson
@pytest.mark.parametrize("language", languages())
def test_exams_are_told_shortly_and_drawn(lesson: Lesson, language: str) -> None:
    words = lesson.words[language].exams
    assert list(words) == [exam.id for exam in lesson.exams]
    for exam in lesson.exams:
        told, item = words[exam.id], exam.item(1)
        for text in (told.title, told.statement):
            assert bool(CJK.search(text)) == (language == "zh"), text
        assert "$" not in told.title and exam.digits.asked(language)
        for text in (fill_placeholders(told.statement, item.given), exam.derived(told.derivation, item)):
            check_markdown(text, f"exam {exam.id} {language}")
        size = _words if language == "en" else _signs
        most = (MOST_ASKED, MOST_DERIVED) if language == "en" else (MOST_ASKED_ZH, MOST_DERIVED_ZH)
        assert size(told.statement) <= most[0] and size(told.derivation) <= most[1], exam.id


def _words(text: str) -> int:
    return len(without_math(text).split())


def _signs(text: str) -> int:
    return len(re.sub(r"\s", "", without_math(text)))
