"""What a page says can be read from outside: the records of the page, each at its place, in the language asked for."""

from __future__ import annotations

import json
import re

import pytest
from all_sentences import collected, designs, shape
from hypothesis import given
from hypothesis import strategies as st
from lesson_checks import CJK, every_lesson

from observer_lab.cli.entry import main
from observer_lab.course.lesson import Lesson
from observer_lab.course.sentences import live_parts, prose_parts, sentences
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
    found = collected(LESSONS["observability"], 0, shapes=True, live=True)
    assert found.tried > 30 and max(found.counts.values()) >= found.tried - found.refused
    assert any(one.where == "live" for one in found.first.values()) and not any(one.where == "question" for one in found.first.values())
