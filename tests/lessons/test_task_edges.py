"""Every threshold of every task: just inside it the task is solved, just outside it is not, and no other threshold exists."""

from __future__ import annotations

import pytest
from lesson_checks import every_lesson
from task_edges import declared, trials

from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS

NEAR, ZERO = 1e-3, 1e-9  # how near a found edge is to the declared one: relative, and at zero
JUST = 3e-3  # of an edge: that far inside and outside


@pytest.mark.slow
@every_lesson
def test_each_threshold_of_a_task_stands_where_its_words_say(lesson: Lesson) -> None:
    """The solved design is judged with one compared number replaced; `task_edges.txt` holds the numbers of the words."""
    table = declared()
    for trial in trials(lesson.id):
        wanted = table.get((lesson.id, trial.task.id), {})
        found = dict(trial.edges())
        assert found.keys() == wanted.keys(), f"{trial.task.id}: the table and the check compare other numbers"
        for (expression, side), edge in wanted.items():
            assert found[expression, side] == pytest.approx(edge, rel=NEAR, abs=ZERO), f"{trial.task.id}: {expression}, {side}"
            outward = (1 if side == "most" else -1) * max(JUST * abs(edge), ZERO)
            assert not trial.holds({expression: edge + outward}), f"{trial.task.id}: solved with {expression} beyond {edge:g}"


def test_the_table_names_only_tasks_that_exist() -> None:
    assert declared().keys() <= {(lesson.id, task.id) for lesson in LESSONS.values() for task in lesson.tasks}
