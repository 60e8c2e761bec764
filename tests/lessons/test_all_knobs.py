"""Every knob of every lesson: it moves a figure, a board drags it, and no value of it is worse than a sentence."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from laws import each, holds_for_all
from lesson_checks import boards_of, check_figures, contents, every_lesson, others, satisfied, shown
from strategies import designs

from observer_lab.colours import COLOURS
from observer_lab.course.knobs import Choice, Knob, KnobError, Number, Poles, Switch
from observer_lab.course.lesson import KEYS, Design, Lesson, Outcome
from observer_lab.engine import EngineError
from observer_lab.lessons import LESSONS
from observer_lab.page.column.knob_widgets import label_of, slider_place, slider_value
from observer_lab.plants.examples import example
from observer_lab.text import languages

IN_SIGHT = 6  # knobs that the lab shows before "more" is asked for
EXAMPLES, VALUES = 15, 3  # random designs of each lesson; other values of each number, its extremes among them


def scenery(outcome: Outcome[Any]) -> tuple[object, ...]:
    """The parts that stand on the stage, and the pixels of its picture."""
    stage = outcome.stage
    return () if stage is None else (*(part.name for part in stage.body.parts), stage.picture and stage.picture.image.tobytes())


def moves_something(lesson: Lesson, knob: Knob) -> None:
    """Some value of the knob changes a figure, a board, the picture on the stage or which parts stand there."""
    tried = 0
    for base in satisfied(lesson, knob, lesson.start()):
        assert lesson.shown(knob, base)
        try:
            outcome, figures = shown(base)
        except EngineError:
            continue
        for value in others(knob, base):
            try:
                new, drawn = shown(lesson.apply(base, {knob.name: value}))
            except EngineError:
                continue
            tried += 1
            if contents(drawn) != contents(figures) or boards_of(new) != boards_of(outcome) or scenery(new) != scenery(outcome):
                return
    pytest.fail(f"nothing changed in {tried} tries")


@pytest.mark.slow
@every_lesson
def test_every_knob_changes_what_is_seen(lesson: Lesson) -> None:
    holds_for_all([knob for knob in lesson.knobs if not knob.hidden], partial(moves_something, lesson), lambda knob: knob.name)


@every_lesson
def test_a_slider_at_its_end_and_an_end_that_is_typed_give_the_end(lesson: Lesson) -> None:
    """A field beside a slider that moves in decades sends the logarithm of what is typed."""
    for knob in lesson.knobs:
        if isinstance(knob, Number):
            for end in (knob.low, knob.high):
                typed = math.log10(end) if knob.scale == "log" else end
                assert knob.check(slider_value(knob, slider_place(knob, end))) == end, (knob.name, end)
                assert knob.check(slider_value(knob, typed)) == pytest.approx(end, rel=1e-12), (knob.name, end)


@every_lesson
def test_boards_are_dragged_through_knobs_that_hold_poles(lesson: Lesson) -> None:
    outcome, _ = shown(lesson.start())
    assert len({b.id for b in outcome.boards}) == len(outcome.boards)
    for board in outcome.boards:
        assert board.side in ("left", "right", "middle")
        assert board.role in COLOURS
        assert board.re_low < board.re_high and board.im_high > 0
        dragged = dict(board.also)
        if board.knob is not None:
            knob = lesson.knob(board.knob)
            assert isinstance(knob, Poles)
            assert (board.re_low, board.re_high, board.im_high) == (knob.re_low, knob.re_high, knob.im_high)
            dragged[board.knob] = board.held
        after = lesson.apply(outcome.design, dragged)  # what a drag posts is valid
        shown(after)
        for pole in (*board.held, *board.fixed):
            assert board.re_low <= pole.real <= board.re_high and abs(pole.imag) <= board.im_high


@pytest.mark.slow
@every_lesson
@settings(max_examples=EXAMPLES, derandomize=True, database=None,
          suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(data=st.data())
def test_any_valid_design_gives_a_finite_picture_or_one_sentence(lesson: Lesson, data: st.DataObject) -> None:
    design = data.draw(designs(lesson))
    try:
        outcome = lesson.compute(design)
        figures = tuple(lesson.figures(outcome))
    except (EngineError, KnobError) as problem:
        assert str(problem).strip() and "\n" not in str(problem)
        return
    check_figures(figures)
    for board in outcome.boards:
        assert np.all(np.isfinite(np.array([*board.poles, *board.fixed, *board.zeros], dtype=complex)))
    if outcome.stage is not None:
        assert np.all(np.isfinite(outcome.stage.t))
        assert outcome.stage.xhat is None or outcome.stage.xhat.shape == outcome.stage.x.shape
    assert outcome.live("en") and outcome.live("zh")


@pytest.mark.slow
@every_lesson
def test_a_change_of_one_knob_from_the_start_is_never_worse_than_a_sentence_and_keeps_the_figures_ids(lesson: Lesson) -> None:
    ids = {figure.id for figure in shown(lesson.start())[1]}
    for knob in lesson.knobs:
        values = others(knob, lesson.start())
        for value in values[-VALUES:] if isinstance(knob, Number) else values:
            try:
                _, figures = shown(lesson.apply(lesson.start(), {knob.name: value}))
            except (EngineError, KnobError) as problem:
                assert str(problem).strip()
                continue
            check_figures(figures)
            assert {figure.id for figure in figures} == ids, (knob.name, value)


@each("lesson", LESSONS.values())
def test_what_is_aside_is_a_knob_with_a_widget_and_something_is_left_in_sight(lesson: Lesson) -> None:
    named, start = {knob.name: knob for knob in lesson.knobs}, lesson.start()
    for name in lesson.aside:
        assert not named[name].hidden and not isinstance(named[name], Poles), name
    assert any(lesson.shown(knob, start) and name not in lesson.aside for name, knob in named.items()), "no knob in sight"


def most_in_sight(lesson: Lesson) -> int:
    """How many knobs the lab shows at most at the start and with any one option chosen."""
    start = lesson.start()
    choices = [knob for knob in lesson.knobs if isinstance(knob, Choice)]
    designs = [start, *(start.with_values(**{knob.name: key}) for knob in choices for key, _ in knob.options)]
    sliders = [knob for knob in lesson.knobs if knob.name not in lesson.aside and not isinstance(knob, Poles)]
    return max(sum(lesson.shown(knob, design) for knob in sliders) for design in designs)


def test_few_knobs_are_in_sight_before_one_asks_for_more() -> None:
    assert {id: most_in_sight(lesson) for id, lesson in LESSONS.items() if most_in_sight(lesson) > IN_SIGHT} == {}


def ways_to_hide(lesson: Lesson) -> Iterator[Design]:
    """The start with every combination of what its key knobs wait for."""
    asked: dict[str, tuple[object, ...]] = {}
    waiting = [lesson.knob(name) for name in lesson.keys]
    while waiting:
        knob = waiting.pop()
        if knob.when is None or knob.when[0] in asked:
            continue
        other = lesson.knob(knob.when[0])
        asked[other.name] = (tuple(name for name, _ in other.options) if isinstance(other, Choice) else (False, True)
                             if isinstance(other, Switch) else (other.default, *knob.when[1]))
        waiting.append(other)
    for values in product(*asked.values()):
        yield lesson.apply(lesson.start(), dict(zip(asked, values, strict=True)))


@each("lesson", [LESSONS["lqg"].fit(example("aircraft")), *LESSONS.values()])
def test_a_hall_has_at_most_three_knobs_in_sight_in_every_design_and_never_none(lesson: Lesson) -> None:
    named = {knob.name: knob for knob in lesson.knobs}
    offered = [name for name, knob in named.items() if lesson.shown(knob, lesson.start()) and not isinstance(knob, Poles)]
    for name in lesson.keys:
        assert not named[name].hidden and not isinstance(named[name], Poles), name
        assert name not in lesson.aside, f"{name} is a key knob and turned rarely"
    for design in ways_to_hide(lesson):
        seen = [name for name in lesson.keys if lesson.shown(named[name], design)]
        assert min(2, len(offered)) <= len(seen) <= KEYS, f"{seen} in {dict(design.values)}"


def test_a_unit_and_its_bracket_stand_in_one_line() -> None:
    for language in languages():
        numbers = [knob for lesson in LESSONS.values() for knob in lesson.knobs if isinstance(knob, Number) and knob.unit]
        labels = [label_of(knob, language) for knob in numbers]
        assert any("/" in label for label in labels)
        assert [label for label in labels if re.search(" |/(?!\N{WORD JOINER})", label.partition("[")[2])] == []
