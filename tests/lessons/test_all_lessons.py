"""What holds for every lesson, whoever wrote it: its start, its draft, its stage, the table of contents."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lesson_checks import check_figures, contents, every_lesson, numbers_of, others, shown
from shared_outcomes import forget
from strategies import values_of

from observer_lab.course.lesson import Lesson
from observer_lab.engine import EngineError
from observer_lab.lessons import LESSONS, OPENING
from observer_lab.text import languages


# --- designs -------------------------------------------------------------------------------------------------------
@every_lesson
def test_defaults_are_valid_and_in_the_knobs_own_form(lesson: Lesson) -> None:
    start = lesson.start()
    assert [name for name, _ in start.values] == [k.name for k in lesson.knobs]
    assert len({k.name for k in lesson.knobs}) == len(lesson.knobs)
    assert lesson.apply(start, dict(start.values)) == start
    assert hash(start) == hash(lesson.start())


@every_lesson
def test_the_start_travels_as_json_and_as_words(lesson: Lesson) -> None:
    start = lesson.start()
    sent = json.dumps(dict(start.values), default=lambda z: [z.real, z.imag], allow_nan=False)
    assert lesson.apply(start, json.loads(sent)) == start
    for knob in lesson.knobs:
        assert knob.parse(knob.show(start[knob.name])) == start[knob.name], knob.name


@every_lesson
def test_conditions_of_knobs_name_knobs_and_values_that_exist(lesson: Lesson) -> None:
    for knob in lesson.knobs:
        if knob.when is not None:
            other = lesson.knob(knob.when[0])
            assert knob.when[1] and all(other.check(v) == v for v in knob.when[1]), knob.name


@pytest.mark.slow
@every_lesson
def test_the_figure_that_answers_the_prediction_is_one_of_the_lessons(lesson: Lesson) -> None:
    assert lesson.answering in [figure.id for figure in lesson.figures(lesson.compute(lesson.start()))]


@every_lesson
def test_no_check_of_a_lesson_fails_at_its_defaults(lesson: Lesson) -> None:
    """What it shows on purpose is a finding: `run` ends with status 0."""
    assert [check.id for check in lesson.compute(lesson.start()).checks if not (check.holds or check.informative)] == []


@every_lesson
def test_compute_is_pure(lesson: Lesson) -> None:
    design, written = lesson.start(), repr(lesson.start())
    first = lesson.compute(design)
    before = [(name, value.copy()) for name, value in numbers_of(first)], contents(tuple(lesson.figures(first)))
    for knob in lesson.knobs:  # something else in between
        for value in others(knob, design)[:1]:
            try:
                lesson.figures(lesson.compute(lesson.apply(design, {knob.name: value})))
            except EngineError:
                continue
    forget()
    second = lesson.compute(design)
    assert second is not first and repr(design) == written and second.design == design
    for (name, a), (_, b), (_, old) in zip(numbers_of(first), numbers_of(second), before[0], strict=True):
        assert np.array_equal(a, b), name
        assert np.array_equal(a, old), f"{name} was changed afterwards"
    assert contents(tuple(lesson.figures(second))) == before[1] == contents(tuple(lesson.figures(first)))
    assert (first.live, first.formulas, first.checks) == (second.live, second.formulas, second.checks)


@every_lesson
def test_the_draft_is_finite(lesson: Lesson) -> None:
    outcome, figures = shown(lesson.start())
    assert outcome.design == lesson.start() and figures
    check_figures(figures)
    for name, values in numbers_of(outcome):
        assert np.all(np.isfinite(values)), name


@every_lesson
def test_the_stage_fits_its_body_and_the_run_its_knobs(lesson: Lesson) -> None:
    outcome, _ = shown(lesson.start())
    stage = outcome.stage
    if stage is None:
        assert not lesson.kick
        return
    assert stage.t[0] == 0 and np.all(np.diff(stage.t) > 0)
    for record in (stage.x, stage.xhat, stage.u):
        assert record is None or len(record) == len(stage.t)
    assert stage.xhat is None or stage.xhat.shape == stage.x.shape
    poses = stage.body.pose(stage.x[0].tolist(), stage.body.gain)
    assert {p.name for p in stage.body.parts} <= set(poses)
    if lesson.kick:
        lesson.apply(lesson.start(), {"kick": float(stage.t[-1])})


@every_lesson
def test_a_kick_changes_the_run(lesson: Lesson) -> None:
    if not lesson.kick:
        assert "kick" not in {k.name for k in lesson.knobs}
        return
    start = lesson.start()
    outcome, figures = shown(start)
    assert outcome.stage is not None
    assert contents(shown(lesson.apply(start, {"kick": float(outcome.stage.t[-1]) / 3}))[1]) != contents(figures)


# --- all together ----------------------------------------------------------------------------------------------------
def test_lessons_are_in_order_and_the_opening_is_one_of_them() -> None:
    numbers = [lesson.number for lesson in LESSONS.values()]
    assert numbers == sorted(set(numbers))
    assert all(key == lesson.id and re.fullmatch(r"[a-z]+(-[a-z]+)*", key) for key, lesson in LESSONS.items())
    assert OPENING in LESSONS
    for language in languages():
        titles = [lesson.words[language].title for lesson in LESSONS.values()]
        assert len(set(titles)) == len(titles)


@every_lesson
@settings(max_examples=40, derandomize=True, database=None)
@given(data=st.data())
def test_random_values_pass_the_gate_unchanged(lesson: Lesson, data: st.DataObject) -> None:
    """A strategy that a knob refuses would make the random tests above say nothing."""
    knob = data.draw(st.sampled_from(lesson.knobs))
    value = knob.check(data.draw(values_of(knob)))
    assert knob.check(value) == value
    assert hash(value) == hash(knob.check(value))
