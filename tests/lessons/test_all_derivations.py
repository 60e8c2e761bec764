"""Derivations: a step is short, both languages have the same equations and places, and the numbers put in obey the equation."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).resolve().parents[1])]

from attack import outcome_of, random_designs
from laws import each
from lesson_checks import CJK, check_markdown, check_mathml, every_lesson, without_math
from put_in import Reader, sides

from observer_lab.course.exercises.derivation import DerivationStep, derived_step, insert_numbers
from observer_lab.course.lesson import Lesson, Outcome
from observer_lab.lessons import LESSONS
from observer_lab.page.column.derivation_panel import numbers_of_step
from observer_lab.page.words import phrases
from observer_lab.page.words.prose import mathml
from observer_lab.plants.examples import example
from observer_lab.plants.own_plant import canonical_text, plant_of
from observer_lab.text import languages

MOST_WORDS, MOST_CHARACTERS = 120, 260  # of a step with its why, in English and in Chinese
RANDOM = 6  # designs of a lesson tried here; `python tests/lessons/test_all_derivations.py` tries two hundred
CLOSE = 1e-6  # relative to the largest number in the line
PRINTED = 2e-3  # relative: a few factors of four digits
SUM = re.compile(r"(?<=[\d)}])\s*[-+]")


@every_lesson
def test_a_lesson_has_a_derivation_of_three_steps(lesson: Lesson) -> None:
    assert len(lesson.words["en"].derivation) >= 3


@every_lesson
def test_steps_are_whole_short_and_drawn(lesson: Lesson) -> None:
    for language in languages():
        for step in lesson.words[language].derivation:
            said = f"{step.text} {step.why}"
            assert step.equation and step.text and step.why and step.places, step.heading
            for line in step.equation.split("\n"):
                check_mathml(mathml(line, True), step.heading)
            check_markdown(said, step.heading)
            assert "$" not in step.heading and bool(CJK.search(f"{said}")) == (language == "zh")
            if language == "en":
                assert len(without_math(said).split()) <= MOST_WORDS, step.heading
            else:
                assert len(re.sub(r"\s", "", without_math(said))) <= MOST_CHARACTERS and CJK.search(step.heading), step.heading


@every_lesson
def test_both_languages_derive_the_same(lesson: Lesson) -> None:
    en, zh = (lesson.words[language].derivation for language in languages())
    assert [(s.equation, s.now) for s in en] == [(s.equation, s.now) for s in zh]


def broken(lesson: Lesson, outcome: Outcome) -> Iterator[str]:
    """The equations whose two sides differ with the numbers of this design put in."""
    values = lesson.derived(outcome)
    for step in lesson.words["en"].derivation:
        if not insert_numbers(step, values):
            continue
        for equation, found in sides(step.now, values):
            scale = max(1e-9, *(float(np.max(np.abs(values[name]))) for name in re.findall(r"\[\[(\w+)\]\]", equation)))
            near = partial(np.allclose, found[0], rtol=CLOSE, atol=CLOSE * scale + 1e-12)
            if any(np.shape(v) != np.shape(found[0]) or not near(v) for v in found[1:]):
                yield f"{step.heading}: {equation}: {found}"


def apart(line: str) -> Iterator[str]:
    """The equations of a line whose sides, computed from the numbers as they are printed, are not one number."""
    for equation, found in sides(line, {}):
        plain = re.sub(r"\^\{[^{}]*\}", "", equation)
        scale = max(float(np.max(np.abs(v))) for v in found)
        if SUM.search(plain):  # what cancels is known to the digits of its terms
            scale = max(scale, *(float(n) for n in re.findall(r"\d+(?:\.\d+)?", plain)))
        if any(np.max(np.abs(v - found[-1])) > PRINTED * scale for v in found[:-1]):
            yield f"{equation}: {found}"


@each("line, fine", [(r"4.437 \cdot 10^{-11}=7.492^{6}\cdot6.488 \cdot 10^{-17}", False), ("0.7252-4.725+4=0", True),
                     (r"2196\cdot2.21 \cdot 10^{8}=4.86 \cdot 10^{11}", True), (r"2\cdot3=6.1", False)])
def test_what_is_printed_is_compared_as_printed(line: str, fine: bool) -> None:
    assert (not list(apart(line))) is fine


@every_lesson
def test_the_numbers_put_in_obey_their_equations_at_the_start_and_at_random_knobs(lesson: Lesson) -> None:
    start = lesson.compute(lesson.start())
    values = lesson.derived(start)
    for step in lesson.words["en"].derivation:
        assert insert_numbers(step, values), f"{step.heading}: no numbers at the start"
        for line in insert_numbers(step, values).split("\n"):
            check_mathml(mathml(line, True), step.heading)
            assert not list(apart(line)), step.heading
    assert list(sides(lesson.words["en"].derivation[-1].now, values)), "the last line has no two sides to compare"
    outcomes = (start, *(outcome_of(lesson, design) for design in random_designs(lesson, RANDOM)))
    assert not [line for outcome in outcomes if outcome is not None for line in broken(lesson, outcome)]


SMALL = '{"A": [[0, 1], [-2, -3]], "B": [[0], [1]], "C": [[1, 0]]}'
ADAPTED = [lesson for lesson in LESSONS.values() if lesson.adapt is not None]
THEIR_OWN = frozenset({"hidden-modes", "noise", "kalman", "weak-states"})  # lessons whose steps speak of one motion of their own plant


@pytest.mark.parametrize("lesson", ADAPTED, ids=lambda lesson: lesson.id)
def test_on_a_persons_own_plant_a_step_has_its_numbers_or_says_why_not(lesson: Lesson) -> None:
    """Numbers that stand there are the plant's own and obey their equations; where none can stand, one sentence says so."""
    put = 0
    for plant in (canonical_text(plant_of(SMALL)), example("aircraft"), example("motor")):
        own = lesson.fit(plant)
        for design in (own.start(), *random_designs(own, 1)):
            outcome = outcome_of(own, design)
            if outcome is None:
                continue
            values = own.derived(outcome)
            lines = [insert_numbers(step, values) for step in own.words["en"].derivation]
            put += sum(map(bool, lines))
            assert not list(broken(own, outcome)), (own.plant[:40], design)
            for step, line in zip(own.words["en"].derivation, lines, strict=True):
                said = numbers_of_step(step, values, own.origin is not None, "en")
                assert (phrases.NOT_YOURS("en") in said) == (not line) and (phrases.PUT_IN("en") in said) == bool(line)
    assert (put == 0) == (lesson.id in THEIR_OWN), "where some lesson learns to put a plant's numbers in, it leaves THEIR_OWN"


@every_lesson
def test_every_number_has_its_place(lesson: Lesson) -> None:
    places = {name for step in lesson.words["en"].derivation for name in step.places}
    assert set(lesson.derived(lesson.compute(lesson.start()))) == places


STEP = derived_step(" Two  ", "$$a=b$$\n$$=c$$\nHow.\n### why\nWhy.\n### now\n$$a=[[p]]\\cdot[[q]]=[[r]]$$\n")


def test_a_step_is_read_in_its_parts() -> None:
    assert DerivationStep("Two", "a=b\n=c", "How.", "Why.", r"a=[[p]]\cdot[[q]]=[[r]]") == STEP and STEP.places == ("p", "q", "r")


@each("values, line", [
    ({"p": 2.0, "q": -3.0, "r": -6.0}, r"a=2\cdot(-3)=-6"),
    ({"p": 2.0, "q": 3.0}, ""), ({"p": np.nan, "q": 1.0, "r": 1.0}, ""), ({"p": np.ones((5, 5)), "q": 1.0, "r": 1.0}, ""),
    ({"p": np.array([[1.0, -2.0]]), "q": 1.0, "r": np.array([-1 + 2j, -1 - 2j, 3.0])},
     r"a=\begin{bmatrix} 1 & -2 \end{bmatrix}\cdot1=-1 + 2\,j,\;-1 - 2\,j,\;3"),
])
def test_numbers_stand_in_their_places_or_the_line_is_not_there(values: dict, line: str) -> None:
    assert insert_numbers(STEP, values) == line


@each("latex, value", [(r"-[[a]]\,([[b]] - 1)^2", -8.0), (r"\frac{[[a]]}{4}+\sqrt{[[c]]}", 3.5), (r"\det([[M]])\cdot[[a]]", -4.0),
                       (r"[[M]]^{\mathsf{\top}}[[v]]", [[2.0], [4.0]]), ("[[M]]^{-1}[[v]]", [[-1.0], [1.0]]), ("[[a]]/[[c]]", 2 / 9)])
def test_the_oracle_reads_the_arithmetic(latex: str, value: Any) -> None:
    values = {"a": 2.0, "b": 3.0, "c": 9.0, "M": np.array([[0.0, 1.0], [2.0, 3.0]]), "v": np.array([[1.0], [1.0]])}
    assert np.allclose(Reader(latex, values).value(), value)


if __name__ == "__main__":
    for name in sys.argv[1:] or LESSONS:
        lesson, tried = LESSONS[name], 0
        for found in map(lambda design, lesson=lesson: outcome_of(lesson, design), random_designs(lesson, 200)):
            tried += found is not None
            for line in broken(lesson, found) if found is not None else ():
                print(f"{name}: {line}")
        print(f"{name}: {tried} designs")
