"""Sliders stand for the poles of the boards: each moves one pole or pair, the rest stays, and it keeps its pole."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pytest
from laws import each

from observer_lab.course.knobs import Poles
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.page.column.pole_sliders import PoleSliders, in_order
from observer_lab.session.commands.commands import SetKnobs

NONSENSE = ("", ":", "observer.0.0", "observer.0.0:nan:0", "observer.0.0:inf:1", "observer.9.0:0.5:1", "observer.-1.0:0.5:1",
            "observer.x.0:0.5:1", "nobody.0.0:0.5:1", "observer.0.0:half:1", "::::", "observer:0.5:1", "é.0.0:0.5:0" * 50)


def sliders(lesson: Lesson) -> tuple[PoleSliders, Any, list[SetKnobs]]:
    """The sliders of a lesson's boards as they open, what they were given to show, and what they post."""
    outcome, posted = lesson.compute(lesson.start()), list[SetKnobs]()
    picture: Any = SimpleNamespace(lesson=lesson, boards=outcome.boards, resting=True, answered=0, veiled=False, scene=None,
                                   state=SimpleNamespace(language="en"))

    def post(edit: object) -> int:
        assert isinstance(edit, SetKnobs)
        posted.append(edit)
        return len(posted)
    made = PoleSliders(MagicMock(), picture, post)
    made.show(picture)
    return made, picture, posted


@each("lesson", LESSONS.values())
def test_each_slider_moves_one_pole_within_what_its_knob_takes(lesson: Lesson) -> None:
    made, picture, posted = sliders(lesson)
    for board in (board for board in picture.boards if board.knob is not None and board.poles):
        knob = lesson.knob(board.knob)
        assert isinstance(knob, Poles)
        order = in_order((), board.held)
        for k, pole in enumerate(order):
            if pole.imag < 0:
                continue
            for share in (0.0, 0.3, 1.0):
                posted.clear()
                picture.answered = 1
                made.show(picture)
                made._heard(f"{board.id}.{k}.0:{share}:1:1")
                moved = posted[0].values[board.knob]
                assert isinstance(moved, tuple)
                knob.check(moved)
                assert moved[k].real == pytest.approx(board.re_low + share * (board.re_high - board.re_low), abs=1e-3 * abs(board.re_low))
                assert moved[k].imag == pole.imag
                partner = {k, k + 1} if pole.imag else {k}
                assert all(moved[other] == order[other] for other in range(len(order)) if other not in partner)


def test_a_slider_keeps_its_pole_where_that_overtakes_another() -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        pairs, reals = rng.integers(0, 3), rng.integers(0, 4)
        upper = [complex(x, abs(y)) for x, y in rng.normal(size=(pairs, 2))]
        order = (*(pole for head in upper for pole in (head, head.conjugate())), *map(complex, rng.normal(size=reals)))
        ordered = tuple(sorted(order, key=lambda s: (s.real, s.imag)))
        assert in_order(order, ordered) == order, "the same poles stand where they stood"
        anew = in_order((), ordered)
        assert sorted(anew, key=lambda s: (s.real, s.imag)) == list(ordered)
        for k, pole in enumerate(anew):
            assert pole.imag >= 0 or anew[k - 1] == pole.conjugate(), "the lower pole of a pair stands behind its upper one"


def test_a_move_builds_on_the_one_before_also_where_an_older_picture_comes_between() -> None:
    made, picture, posted = sliders(LESSONS["error-dynamics"])
    board = next(each for each in picture.boards if each.knob is not None)
    made._heard(f"{board.id}.0.0:0.7:1:1")
    made.show(picture)  # of before that move: it answers none
    made._heard(f"{board.id}.0.1:0.2:1:1")
    first, second = (edit.values[board.knob] for edit in posted)
    assert isinstance(first, tuple) and isinstance(second, tuple)
    assert second[0].real == first[0].real != board.held[0].real and second[0].imag != first[0].imag


@pytest.mark.parametrize("said", NONSENSE)
def test_nonsense_moves_nothing(said: str) -> None:
    made, _, posted = sliders(LESSONS["separation"])
    made._heard(said)
    assert posted == []


def test_poles_that_no_hand_moves_are_said_in_words() -> None:
    made, picture, _ = sliders(LESSONS["hidden-modes"])
    bolted = [pole for board in picture.boards for pole in board.fixed]
    assert bolted and re.search(r"fixed mode", made._words.content)
