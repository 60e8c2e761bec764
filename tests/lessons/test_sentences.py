"""What a page says can be read from outside: the records of the page, each at its place, in the language asked for."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from all_sentences import Collected, collected, designs, shape
from attack import random_designs, single_moves
from hypothesis import given
from hypothesis import strategies as st
from lesson_checks import CJK, every_lesson
from sentence_laws import LAWS, broken, loop_is_stable

from observer_lab.cli.entry import main
from observer_lab.course.lesson import Lesson
from observer_lab.course.sentences import Sentence, live_parts, prose_parts, sentences
from observer_lab.lessons import LESSONS
from observer_lab.text import label_in_language


@pytest.mark.slow
@every_lesson
def test_a_lesson_says_what_its_page_shows(lesson: Lesson) -> None:
    outcome = lesson.compute(lesson.start())
    found = {each.where: each.text for each in sentences(lesson, outcome, "en")}
    figures = {f"figure.{figure.id}.caption": figure.caption("en") for figure in lesson.figures(outcome) if figure.caption.id}
    assert figures and figures.items() <= found.items()
    assert not outcome.live.id or found["live"] == outcome.live("en")
    assert {f"check.{check.id}": check.text("en") for check in outcome.checks}.items() <= found.items()
    assert found["question"] == lesson.words["en"].question and len(found) > 100
    seen = [knob for knob in lesson.knobs if lesson.shown(knob, outcome.design)]
    assert {where for where in found if re.fullmatch(r"knob\.\w+", where)} == {f"knob.{knob.name}" for knob in seen}
    assert all(found[f"task.{task.id}"] == lesson.words["en"].tasks[task.id].statement for task in lesson.tasks)


@pytest.mark.slow
@every_lesson
def test_every_place_is_named_once_and_the_same_in_both_languages(lesson: Lesson) -> None:
    outcome = lesson.compute(lesson.start())
    english, chinese = sentences(lesson, outcome, "en"), sentences(lesson, outcome, "zh")
    places = [where for where, _ in (*live_parts(lesson, outcome), *prose_parts(lesson.words["en"]))]
    assert len(places) == len(set(places))
    assert {each.lang for each in english} == {"en"} and {each.lang for each in chinese} == {"zh"}
    assert not [each.text for each in english if CJK.search(each.text)]
    assert sum(bool(CJK.search(each.text)) for each in chinese) > 0.7 * len(chinese)


def test_run_prints_the_sentences_of_the_design_and_the_language(capsys) -> None:
    lesson = LESSONS["observability"]
    for language in ("en", "zh"):
        main(["run", "observability", "--set", "left=0.1", "--lang", language, "--json"])
        said = json.loads(capsys.readouterr().out)["sentences"]
        outcome = lesson.compute(lesson.apply(lesson.start(), {"left": 0.1}))
        assert {"where": "live", "text": label_in_language(outcome.live, language), "lang": language} in said
        assert {tuple(each) for each in said} == {("where", "text", "lang")}


def test_a_design_elsewhere_says_something_else() -> None:
    lesson = LESSONS["observability"]
    start, moved = (sentences(lesson, lesson.compute(design), "en") for design in (
        lesson.start(), lesson.apply(lesson.start(), {"left": 0.1})))
    assert set(start) != set(moved) and {each.where for each in start} & {each.where for each in moved}


def test_designs_have_three_seeds_where_the_lesson_has_noise() -> None:
    tried = list(designs(LESSONS["observability"], 2))
    assert len(tried) % 3 == 0 and {design["seed"] for design in tried} == {1.0, 2.0, 3.0} and len(set(tried)) > 30


@given(st.floats(-1e9, 1e9), st.floats(-1e9, 1e9))
def test_sentences_that_differ_in_numbers_alone_have_one_shape(one: float, other: float) -> None:
    assert shape(f"The gain is {one:.3f} N.") == shape(f"The gain is {other:.3f} N.") == "The gain is # N."


@pytest.mark.slow
def test_all_sentences_counts_each_sentence_once_a_design() -> None:
    lesson = LESSONS["observability"]
    found = collected(lesson, designs(lesson, 0), shapes=True, live=True)
    assert found.tried > 30 and max(found.counts.values()) >= found.tried - found.refused
    assert any(one.where == "live" for one in found.first.values()) and not any(one.where == "question" for one in found.first.values())


SAID = {  # a sentence that each law finds
    "a number that is none": "The error is nan.", "a zero with a sign": "The copy says −0.0 K.",
    "a number as a computer writes it": "It costs 1.3e+02.", "a place without its value": "It takes {at:.2f} s.",
    "a blank where a unit is missing": "The peak is 3 .", "a share over 100 %": "It holds for 120 % of the time.",
    "a percentage over 1000": "They differ by 67000 % at most.", "a negative more": "The cost is −6.3·10⁻¹⁰ % larger.",
    "a share of nothing": "In 0 of 0 runs.", "an unstable loop called stable": "The loop is stable.",
    "a stable loop called unstable": "The loop is unstable: it has no spectrum."}
FINE = ("The error is 0.0 K.", "From −0.5 to −0.04 V.", "It is in $e^{-3}$ and Lesson 3-D.", "It takes 3.5 s, or 100 % of the time.",
        "−0·x", "a lag; 0: none.",
        "With 10⁻⁹ it is 2·10⁻³ % larger.", "It runs in 3 of 4 runs.", "It is 120 % of the force.", "C e^{At} is 1×2.")


@pytest.mark.parametrize("law", LAWS)
def test_each_law_finds_its_sentence_and_leaves_true_ones_alone(law: str) -> None:
    lesson = LESSONS["separation"]
    still = lesson.compute(lesson.start())
    outcome = next(each for each in (still, *map(lesson.compute, random_designs(lesson, 40, 1)))
                   if loop_is_stable(each) == (law != "an unstable loop called stable"))
    assert law in set(broken(Sentence("live", SAID[law], "en"), outcome))
    assert not [words for words in FINE if law in set(broken(Sentence("live", words, "en"), outcome))]


@pytest.mark.slow
@every_lesson
def test_what_a_lesson_says_breaks_no_law(lesson: Lesson) -> None:
    """A sample; all designs are tried by `python tests/lessons/all_sentences.py 200 --live --broken`, in both languages."""
    rng = np.random.default_rng(lesson.number)
    moves = list(single_moves(lesson))
    tried = [lesson.start(), *(lesson.apply(lesson.start(), dict(moves[k])) for k in rng.permutation(len(moves))[:4]),
             *random_designs(lesson, 2, lesson.number)]
    found: Collected = collected(lesson, tried)
    assert found.tried > found.refused
    assert not found.false, "\n".join(f"{law}: {where}" for (law, _), where in found.false.items())
    assert not found.witnessed.lies, found.witnessed.lies
