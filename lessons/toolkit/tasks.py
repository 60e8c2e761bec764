"""Share two-sided targets of tasks, and select the tasks that an own plant can solve."""

from __future__ import annotations

from dataclasses import replace

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Lesson, Task, Verdict
from observer_lab.engine import EngineError
from observer_lab.text import Text, text


def keep_fair_tasks(lesson: Lesson) -> Lesson:
    """The lesson with those tasks alone that fail at its start and pass at their own solution."""
    start = lesson.start()
    opened = lesson.compute(start)

    def passes(task: Task) -> bool:
        try:
            outcome = lesson.compute(lesson.apply(start, task.solution))
            return task.judge(outcome, task.typed.right(outcome) if task.typed else "").solved
        except (EngineError, KnobError):
            return False
    return replace(lesson, tasks=tuple(t for t in lesson.tasks if not t.judge(opened).solved and passes(t)))


def check_gentle_settling(found: Text, settled: float, band: tuple[float, float], force: float, most: float) -> Verdict:
    """Whether something comes to rest within a band of time, neither sooner nor later, with a force of at most so much."""
    if not band[0] <= settled <= band[1] or force > most:
        return Verdict(False, text("{found}; wanted are {low:g} to {high:g} s and at most {most:g} N.", found=found, low=band[0],
                                   high=band[1], most=most))
    return Verdict(True, text("{found}.", found=found))
