"""Read the tasks of a lesson file: a metric, or several, each within a range."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any  # the value of a knob is `Any` until the knob has checked it

from observer_lab.course.knobs import Knob
from observer_lab.course.lesson import Lesson, Outcome, Task, Verdict
from observer_lab.course.reading.toml_table import Table, read_values
from observer_lab.engine import EngineError
from observer_lab.text import Text, error_words, joined, text

from .study import METRICS

TASK_KEYS = ("id", "within", "keep", "solution")


def read_tasks(top: Table, knobs: tuple[Knob, ...]) -> tuple[Task, ...]:
    """`[[tasks]]`. Raises LessonFileError."""
    return tuple(_task(table.only(*TASK_KEYS), knobs) for table in top.tables("tasks"))


def _task(table: Table, knobs: tuple[Knob, ...]) -> Task:
    within = table.table("within")
    if not within.data:
        raise table.refuse("within", text("A task needs within = {{ metric = [low, high] }}; the metrics are {names}.",
                                          names=", ".join(METRICS)))
    for name in within.only(*METRICS).data:
        within.range(name)
    ranges = {name: within.range(name) for name in within.data}
    kept = read_values(table, "keep", knobs)
    return Task(table.words("id"), partial(_judge, ranges, kept), read_values(table, "solution", knobs))


def _judge(ranges: Mapping[str, tuple[float, float]], kept: Mapping[str, Any], outcome: Outcome) -> Verdict:
    """Whether every metric lies within its range, with the knobs that must stay where they are."""
    moved = [name for name, value in kept.items() if outcome.design[name] != value]
    if moved:
        return Verdict(False, text("Set {names} back; this task is about the other knobs.", names=", ".join(moved)))
    values = {name: outcome.metrics.get(name, float("nan")) for name in ranges}
    solved = all(low <= values[name] <= high for name, (low, high) in ranges.items())
    return Verdict(solved, joined(*(_said(METRICS[name], values[name], *bounds) for name, bounds in ranges.items())))


def _said(name: Text, value: float, low: float, high: float) -> Text:
    return text("Wanted: {name} within {low:g} … {high:g}; now {value:.3g}.", name=name, value=value, low=low, high=high)


def check_tasks(top: Table, lesson: Lesson) -> None:
    """Each task fails at the start and passes at its own solution. Raises LessonFileError."""
    start = lesson.start()
    for table, task in zip(top.tables("tasks"), lesson.tasks, strict=True):
        if task.judge(_outcome(table, partial(lesson.compute, start))).solved:
            raise table.refuse("within", text("The task {id} is solved at the start already; narrow its ranges.", id=task.id))
        verdict = task.judge(_outcome(table, lambda task=task: lesson.compute(lesson.apply(start, task.solution))))
        if not verdict.solved:
            raise table.refuse("solution", text("The solution of the task {id} does not solve it: {why}", id=task.id, why=verdict.text))


def _outcome(table: Table, compute: Callable[[], Outcome]) -> Outcome:
    try:
        return compute()
    except EngineError as problem:
        raise table.refuse("solution", error_words(problem)) from problem
