"""Which tasks of a lesson are fair on a person's own plant."""

from __future__ import annotations

from dataclasses import replace

from app.engine import EngineError
from app.lesson.knobs import KnobError
from app.lesson.lesson import Lesson, Task


def fair(lesson: Lesson) -> Lesson:
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
