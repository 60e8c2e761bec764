"""A scene judges what a hand has done: the wrong way, too little and too far are said, and praised is only what was asked."""

from __future__ import annotations

from itertools import pairwise

import pytest
from fakes import toy

from observer_lab.course.guiding.goals import judge_move
from observer_lab.course.knobs import Number, Poles, Switch
from observer_lab.course.scenes import Goal, Move
from observer_lab.text import languages, text

LESSON = toy("goals", knobs=(Number("level", "q", text("gain"), low=0.0, high=10.0, default=5.0),
                             Switch("on", "s", text("gain"), default=False),
                             Poles("poles", "p", text("gain"), default=(-4.0, -2.0))))


def said(goal: Goal, knob: str, value: object) -> tuple[bool, str]:
    done, why = judge_move(LESSON, Move((knob,), goal), LESSON.start(), LESSON.apply(LESSON.start(), {knob: value}))
    assert done != bool(why.id) or value == LESSON.start()[knob]
    assert all(why(language) or not why.id for language in languages())
    return done, why("en")


@pytest.mark.parametrize("way", ["right", "left"])
def test_a_number_is_judged_by_its_direction(way: str) -> None:
    sign = 1 if way == "right" else -1
    for step in (0.5, 1.0, 5.0):
        assert said(Goal(way), "level", 5.0 + sign * step) == (True, "")
        done, why = said(Goal(way), "level", 5.0 - sign * step)
        assert not done and ("went down" in why) == (way == "right")
    assert "hardly" in said(Goal(way), "level", 5.0 + sign * 0.01)[1]
    assert said(Goal(way), "level", 5.0) == (False, "")


def test_bounds_say_too_low_and_too_high_and_are_reached_between_them() -> None:
    found = [said(Goal(least=6.0, most=8.0), "level", value) for value in (5.5, 6.0, 7.0, 8.0, 8.5)]
    assert [done for done, _ in found] == [False, True, True, True, False]
    assert "too low" in found[0][1] and "too high" in found[-1][1]


def test_a_switch_is_judged_by_its_value() -> None:
    assert said(Goal(value=True), "on", True) == (True, "")
    assert judge_move(LESSON, Move(("on",), Goal(value=True)), LESSON.apply(LESSON.start(), {"on": True}), LESSON.start())[1].id


def test_poles_are_judged_by_the_slowest_one_and_never_past_the_axis() -> None:
    assert said(Goal("right"), "poles", (-4.0, -1.0)) == (True, "")
    assert "away from" in said(Goal("right"), "poles", (-4.0, -3.0))[1]
    assert "Too far" in said(Goal("right"), "poles", (-4.0, 0.5))[1]
    assert "hardly" in said(Goal("right"), "poles", (-9.0, -2.0))[1], "the fast pole alone changes nothing of the slowest"
    assert said(Goal("left"), "poles", (-4.0, -3.0)) == (True, "")
    steps = [said(Goal("right"), "poles", (-4.0, -2.0 + 0.25 * k))[0] for k in range(10)]
    assert sum(a != b for a, b in pairwise(steps)) == 2, "from nothing to done, and from done to too far"
