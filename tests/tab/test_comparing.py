"""Pins are kept with the lesson, drawn thin beside the present design, and told in a table; any step is one press away."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
from fakes import BROKEN, FakeView, Tab, toy
from laws import holds_for_all

from observer_lab.course.design_differences import changed, describe_design, describe_difference, describe_step
from observer_lab.course.figures.ranges import axis_range
from observer_lab.course.figures.records import LineFigure, same_key
from observer_lab.course.knobs import Number
from observer_lab.course.pinned_designs import MAX_PINS, Pin, Pinned, boards_with_pins, comparison_table, figures_with_pins, ghosts_of_pins
from observer_lab.lessons import LESSONS
from observer_lab.page.charts.charts import data_of
from observer_lab.plants import MODELS
from observer_lab.plants.examples import EXAMPLES, example
from observer_lab.session.commands.commands import OpenLesson, SetLanguage, Undo
from observer_lab.session.commands.files import GoToStep, OpenPin, PinDesign, ToggleGhost, Unpin
from observer_lab.session.handlers.kept_designs import NO_PIN, NO_STEP, TOO_MANY_PINS
from observer_lab.session.session import Session
from observer_lab.session.state.history import MAX_HISTORY_CHARACTERS, MAX_UNDO_DESIGNS, History, read_steps, write_steps
from observer_lab.session.state.saved_state import design_as_plain_data
from observer_lab.text import languages, same


def pinned_tab(*gains: float) -> Tab:
    tab = Tab({name: toy(name) for name in ("first", "second")})
    for gain in gains:
        tab.set(gain=gain)
        tab.rest()
        tab.do(PinDesign())
    return tab


def test_a_pin_is_a_thin_line_with_its_name_until_it_is_taken_away() -> None:
    tab = pinned_tab(2.0, 3.0)
    tab.set(gain=5.0)
    (figure,), stage = tab.picture.seen, tab.picture.outcome.stage
    assert isinstance(figure, LineFigure) and stage is not None
    own, *thin = figure.curves
    assert [curve.called("en") for curve in thin] == ["x · A", "x · B"] and all(curve.width < own.width for curve in thin)
    for curve, gain in zip(thin, (2.0, 3.0), strict=True):
        np.testing.assert_allclose(curve.y, gain * np.exp(-stage.t), atol=1e-12)
    assert tab.picture.figures[0].curves == (own,), "the lesson's own figures stay as they are"
    tab.do(Unpin("0"))
    assert [curve.pin("en") for curve in tab.picture.seen[0].curves[1:]] == ["B"]
    tab.do(PinDesign("mine"))
    assert [pin.name for pin in tab.picture.state.pins] == ["B", "mine"]
    tab.set(gain=1.0)
    tab.do(OpenPin(1))
    assert tab["gain"] == 5.0
    tab.do(Undo())
    assert tab["gain"] == 1.0


def test_a_run_of_another_length_is_drawn_as_far_as_it_goes() -> None:
    tab = pinned_tab(2.0)
    tab.set(length=4.0)
    curve = tab.picture.seen[0].curves[1]
    t = tab.picture.seen[0].x
    assert np.array_equal(np.isnan(curve.y), t > 2.0) and np.isfinite(axis_range(tab.picture.seen[0])).all()
    rows = data_of(tab.picture.seen[0], (-1.0, 3.0))
    assert np.isnan(rows[2]).any() and np.isfinite(rows[1]).all()


def test_pins_survive_a_reload_a_language_and_another_lesson_and_are_bounded() -> None:
    tab = pinned_tab(2.0, 3.0, 4.0, 5.0)
    tab.set(gain=6.0)
    tab.do(PinDesign())
    assert tab.view.scolded() == [TOO_MANY_PINS] and len(tab.picture.state.pins) == MAX_PINS
    tab.do(SetLanguage("zh"))
    tab.do(OpenLesson("second"))
    assert tab.picture.state.pins == ()
    again = Session(tab.lessons, FakeView(), "first")
    again.restore(tab.view.kept)
    again.open()
    again.post(OpenLesson("first"))
    again.step()
    assert again.picture is not None and [pin.design["gain"] for pin in again.picture.state.pins] == [2.0, 3.0, 4.0, 5.0]
    assert [each.pin.name for each in again.picture.pinned] == ["A", "B", "C", "D"]


def test_the_ghost_of_a_pin_walks_where_it_is_wanted_also_after_a_reload_and_not_with_another_plant() -> None:
    tab = pinned_tab(2.0, 3.0)
    assert tab.picture.ghosts == ()
    tab.do(ToggleGhost("1"))
    (ghost,), stage = tab.picture.ghosts, tab.picture.outcome.stage
    assert (ghost.place, ghost.name) == (1, "B") and stage is not None
    np.testing.assert_allclose(ghost.states[:, 0], 3.0 * np.exp(-ghost.t), atol=1e-12)
    again = Session(tab.lessons, FakeView(), "first")
    again.restore(tab.view.kept)
    again.open()
    assert again.picture is not None and [each.name for each in again.picture.ghosts] == ["B"]
    assert (
        ghosts_of_pins(replace(stage, body=MODELS["two-mass"].body), tab.picture.pinned) == ghosts_of_pins(None, tab.picture.pinned) == ()
    )
    tab.do(ToggleGhost(1))
    assert tab.picture.ghosts == ()
    tab.do(ToggleGhost(7))
    assert tab.view.scolded() == [NO_PIN]


def test_a_reload_keeps_the_steps_and_where_one_stands() -> None:
    tab = Tab({name: toy(name) for name in ("first", "second")})
    for k in range(1, 21):
        tab.set(gain=k / 10, **({"mode": "b"} if k == 7 else {}))
        tab.clock.advance(1.0)
    tab.do(GoToStep(12))
    tab.rest()
    assert tab.view.kept is not None
    again = Session(tab.lessons, FakeView(), "first")
    again.restore(tab.view.kept)
    again.open()
    assert again.picture is not None and (again.picture.steps, again.picture.at) == (tab.picture.steps, 12)
    assert again.picture.design == tab.picture.design and again.picture.state.can_undo and again.picture.state.can_redo
    data = json.loads(tab.view.kept)
    for steps, back, on in (
            (3, 0, 0), ([3, 4], 0, 0), ([[[{"gain": "5"}], 3, [{"gain": "6"}]], []], 1, 0), ([[], [[{"gain": "99"}]]], 0, 0),
                            ([[], [[{"gain": "5"}], [3]]], 0, 1), ([[[{"gain": "2"}, "no such plant"]], [[{}, {}]]], 0, 0)):
        data["desks"]["first"]["steps"] = steps
        torn = Session(tab.lessons, FakeView(), "first")
        torn.restore(json.dumps(data))
        torn.open()
        assert torn.picture is not None and torn.picture.design == tab.picture.design, "the present design is there whatever the steps are"
        assert (torn.picture.at, len(torn.picture.steps)) == (back, back + on + 1), steps


def test_the_steps_of_every_lesson_come_back_and_take_no_more_than_their_room() -> None:
    def law(name: str) -> None:
        lesson = LESSONS[name]
        start, drawn = lesson.start(), np.random.default_rng(1)
        walk = [start, *(lesson.apply(start, dict(task.solution)) for task in lesson.tasks)]
        walk += [lesson.fit(example(key)).start() for key in EXAMPLES] if lesson.universal else []
        numbers = [knob for knob in lesson.knobs if isinstance(knob, Number) and knob.scale != "integer"]
        walk += [lesson.apply(walk[-1], {knob.name: knob.low + (knob.high - knob.low) * drawn.random()}) for knob in numbers[:3]
                 if walk[-1].plant == lesson.plant]
        walk = [a for a, b in zip(walk, [None, *walk], strict=False) if a != b]
        history = History(start)
        history.restore((tuple(walk), len(walk) // 2))
        written = json.loads(json.dumps(write_steps(lesson, history)))
        found = read_steps(written, design_as_plain_data(lesson, history.design), history.design, LESSONS)
        assert found.save() == history.save()
        history.restore((tuple(walk * 60), 30 * len(walk)))
        assert len(json.dumps(write_steps(lesson, history))) <= 2.2 * MAX_HISTORY_CHARACTERS
    holds_for_all(LESSONS, law)


def test_torn_and_hostile_pins_are_left_out() -> None:
    good = {"version": 1, "lesson": "first", "knobs": {"gain": "3"}}
    for pins in (3, [3], [["A"]], [["A", 3]], [["", good]], [["A" * 500, good]], [["A", {**good, "lesson": "second"}]],
                 [["A", {**good, "knobs": {"gain": "99"}}]], [["A", {**good, "knobs": {"gain": str(BROKEN)}}]]):
        tab = Tab({name: toy(name) for name in ("first", "second")})
        view = FakeView()
        session = Session(tab.lessons, view, "first")
        session.restore(None)
        session.restore(json.dumps({"version": 2, "lesson": "first", "desks": {"first": {**good, "pins": pins}}}))
        session.open()
        assert session.picture is not None and session.picture.pinned == () == session.picture.seen[0].curves[1:]
    tab = pinned_tab(2.0)
    for wrong in (Unpin("1"), Unpin(-1), OpenPin(float("nan")), GoToStep(99), GoToStep("x"), PinDesign("x" * 999), PinDesign(["a"])):
        tab.do(wrong)
    assert len(tab.view.scolded()) == 7 and {NO_PIN, NO_STEP} <= set(tab.view.scolded()) and len(tab.picture.state.pins) == 1


def test_any_of_several_hundred_steps_is_one_press_away_and_says_what_it_did() -> None:
    tab, count = Tab(), 300
    for k in range(1, count + 1):
        tab.set(gain=k / 100)
        tab.clock.advance(1.0)
    assert len(tab.picture.steps) == count + 1 <= MAX_UNDO_DESIGNS and tab.picture.at == count
    for place in (7, 250, 0, count):
        tab.do(GoToStep(str(place)))
        assert tab["gain"] == (place / 100 or 1.0) and tab.picture.at == place and len(tab.picture.steps) == count + 1
    said = [describe_step(tab.picture.lesson, a, b)("en") for a, b in zip(tab.picture.steps[1:], tab.picture.steps[2:], strict=False)]
    assert said[:2] == ["gain: 0.01 → 0.02", "gain: 0.02 → 0.03"] and len(set(said)) == count - 1


def test_every_lesson_compares_with_its_first_task_solved() -> None:
    def law(name: str) -> None:
        lesson = LESSONS[name]
        start = lesson.start()
        other = next(design for task in lesson.tasks if (design := lesson.apply(start, task.solution)) != start)
        outcome, solved = lesson.compute(start), lesson.compute(other)
        figures = lesson.figures(outcome)
        pinned = (Pinned(Pin("A", other), 0, solved, lesson.figures(solved)), Pinned(Pin("B", start), 1, outcome, figures))
        shown = figures_with_pins(figures, pinned)
        assert [figure.id for figure in shown] == [figure.id for figure in figures]
        assert not any(curve.pin == same("B") for figure in shown for curve in getattr(figure, "curves", ())), "what lies under it"
        for figure in shown:
            if isinstance(figure, LineFigure):
                data_of(figure, axis_range(figure))
                assert same_key(figure, figure)
        assert [board.id for board in boards_with_pins(outcome.boards, pinned)] == [board.id for board in outcome.boards]
        table = comparison_table(lesson, start, outcome, pinned)
        assert table is not None and len(table.rows) >= 2 and all(len(row) == 4 for row in table.rows)
        assert any(row[1] != row[2] for row in table.rows) and all(row[1] == row[3] for row in table.rows)
        names = {knob.name for knob in changed(lesson, start, other)}
        assert names and names <= set(dict(start.values))
        for language in languages():
            for said in (
                describe_difference(lesson, same("A"), other, start),
                describe_step(lesson, start, other),
                describe_design(lesson, other),
            ):
                assert "{" not in said(language) and said(language)
    holds_for_all(LESSONS, law)
