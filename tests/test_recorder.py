"""What a published page knows of its knobs: where each stands on entry, and by which widget it is moved."""

from __future__ import annotations

import math

import pytest

from observer_lab.course.knobs import Number, Poles
from observer_lab.course.scenes import Move, entry_values
from observer_lab.lessons import LESSONS
from observer_lab.page.record.recorded_screen import WINDOWS, Look
from observer_lab.static_pages import site
from observer_lab.static_pages.points import MOST_PLACES, Points, value_for, values_of
from observer_lab.static_pages.recorder import Recorder
from observer_lab.static_pages.site import _widgets

SAMPLED = ("virtual-sensor", "error-dynamics", "noise")
FEW = Points(2, 2, 2)


@pytest.mark.slow
@pytest.mark.parametrize("lesson", [pytest.param(id, marks=() if id in SAMPLED else pytest.mark.whole) for id in LESSONS])
def test_every_knob_stands_somewhere_on_entry_and_has_widgets_of_its_own(lesson: str) -> None:
    recorder, tried = Recorder(LESSONS, lesson, [Look("en", False, next(iter(WINDOWS)))], FEW), 0
    moving = [k for k, scene in enumerate(recorder.path) if isinstance(scene.do, Move) and len(scene.knobs) > 1]
    for k in moving or range(1):
        states = recorder.scene(k).states
        entry, widgets = states[0].values[0], _widgets(states, 0)
        at = {place for place, value in entry.items() if place[1] == "" and isinstance(value, dict) and "value" in value}
        assert {(entity, "value") for entity, _ in at} <= set(entry), "what was never moved has a value all the same"
        taken = [each for found in widgets.values() for each in found]
        assert len(set(taken)) == len(taken), f"{recorder.path[k].id}: a widget of two knobs: {widgets}"
        tried += len(taken)
    assert tried or not moving


@pytest.mark.parametrize("lesson", LESSONS)
def test_every_grid_has_a_value_that_the_scene_asks_for(lesson: str) -> None:
    """Also the coarsest one: a slider that must end between two bounds, a choice that must end at one value."""
    path, start = LESSONS[lesson].path, LESSONS[lesson].start()
    for k, scene in enumerate(path):
        goal = scene.do.goal if isinstance(scene.do, Move) else None
        if goal is None:
            continue
        knob = LESSONS[lesson].knob(scene.do.knobs[0])
        now = entry_values(path, k, start).get(knob.name, start[knob.name])
        values = values_of(knob, now, FEW, [value for value in (value_for(knob, goal),) if value is not None])
        if goal.value is not None:
            assert goal.value in values, scene.id
        elif goal.least is not None and goal.most is not None and isinstance(knob, Number):
            assert any(goal.least <= value <= goal.most for value in values), scene.id


@pytest.mark.parametrize("lesson", LESSONS)
def test_a_slider_and_its_field_show_each_value_of_its_grid(lesson: str) -> None:
    """In the digits that they have: three of a number, and three decimals of a power of ten."""
    for knob in LESSONS[lesson].knobs:
        if not isinstance(knob, Number):
            continue
        for points in (FEW, Points(), Points(slider=12)):
            for value in values_of(knob, None, points):
                shown = 10.0 ** round(math.log10(value), 3) if knob.scale == "log" else round(value, 9)
                assert f"{shown:.3g}" == f"{value:.3g}", (knob.name, value)
                assert value in (knob.low, knob.high) or float(f"{value:.10g}") == value, (knob.name, value)


@pytest.mark.parametrize("pairs", [1, 2, 3, 5, 8])
def test_a_board_with_many_poles_has_a_coarser_grid_and_each_pole_still_moves(pairs: int) -> None:
    now = tuple(complex(-1 - k, sign) for k in range(pairs) for sign in (-2.0, 2.0))
    places = values_of(Poles("p", "p", LESSONS["separation"].words["en"].title, default=now), now, Points())
    assert len(places) <= MOST_PLACES or len(places) <= pairs * 6 * 4
    for k in range(pairs):
        others = set(now) - {now[2 * k], now[2 * k + 1]}
        assert len({place for place in places if others <= set(place)}) >= 12


def test_the_compiled_kernels_are_ready_before_a_lesson_is_recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    """A served page has them: numbers that are rounding alone would differ otherwise."""
    done = list[str]()

    class Ready:
        def join(self) -> None:
            done.append("kernels")

    class Begun(Exception):
        pass

    def recorder(*_: object) -> None:
        done.append("recorder")
        raise Begun
    monkeypatch.setattr(site, "prepare_kernels", Ready)
    monkeypatch.setattr(site, "Recorder", recorder)
    with pytest.raises(Begun):
        site.write_lesson(LESSONS, "separation", [], FEW, lambda name, text: None)
    assert done == ["kernels", "recorder"]
