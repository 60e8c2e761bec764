"""A task answers every design with a verdict: each setting of each switch and choice, alone, is judged and never raises."""

from __future__ import annotations

from laws import each

from observer_lab.course.knobs import Choice, KnobError, Switch
from observer_lab.course.lesson import Lesson
from observer_lab.engine import EngineError
from observer_lab.lessons import LESSONS

FIRST_COURSE = [lesson for lesson in LESSONS.values() if lesson.number <= 7]


@each("lesson", FIRST_COURSE)
def test_every_task_judges_every_setting(lesson: Lesson) -> None:
    start = lesson.start()
    for knob in lesson.knobs:
        values = (True, False) if isinstance(knob, Switch) else [value for value, _ in knob.options] if isinstance(knob, Choice) else ()
        for value in values:
            try:
                outcome = lesson.compute(lesson.apply(start, {knob.name: value}))
            except (KnobError, EngineError):
                continue  # said in one sentence
            for task in lesson.tasks:
                assert task.judge(outcome).text.id, f"{task.id} at {knob.name} = {value}"
