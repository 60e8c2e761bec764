"""No task falls to a knob at its stop, to a click or to luck; the whole attack is `attack.py`."""

from __future__ import annotations

import numpy as np
import pytest
from attack import outcome_of, random_designs, single_moves, solved
from lesson_checks import every_lesson

from observer_lab.course.lesson import Lesson

MOVES, LUCK = 16, 8  # of a lesson: stops and clicks tried, designs at random


@pytest.mark.slow
@every_lesson
def test_no_stop_and_no_click_solves_a_task(lesson: Lesson) -> None:
    easy = {task.id for task in lesson.tasks if task.easy}
    moves = list(single_moves(lesson))
    for k in np.random.default_rng(lesson.number).permutation(len(moves))[:MOVES]:
        outcome = outcome_of(lesson, lesson.apply(lesson.start(), dict(moves[k])))
        fallen = set(solved(lesson, outcome)) - easy if outcome is not None else set()
        assert not fallen, f"{moves[k]} solves {fallen}"


@pytest.mark.slow
@every_lesson
def test_luck_does_not_solve_a_task(lesson: Lesson) -> None:
    fallen = [task for design in random_designs(lesson, LUCK, 11) if (outcome := outcome_of(lesson, design)) is not None
              for task in solved(lesson, outcome)]
    assert max((fallen.count(task) for task in fallen), default=0) <= 1, fallen
