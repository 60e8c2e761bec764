"""Hold the records that a tab's state is made of: tasks, exams, loop and performance."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any  # the values of knobs are of any kind, as `Any` says

from ...course.course_map import Progress
from ...course.design import Design
from ...course.error_window import ErrorWindow
from ...course.lesson import Verdict
from ...course.many_seeds import SeedErrors


@dataclass(frozen=True)
class TaskState:
    """What a person has seen and reached of one task."""

    verdict: Verdict | None = None
    hints: int = 0
    solution: bool = False
    typed: str = ""  # what was typed when it was last checked
    judged: Design | None = None  # the design that the verdict is about, None where it was not kept

    def is_stale(self, design: Design) -> bool:
        """Whether the verdict is about another design than this one."""
        return self.verdict is not None and self.judged is not None and self.judged != design


def progress_of(predicted: int | None, tasks: Mapping[str, TaskState]) -> Progress:
    """How far a person is with a prediction and these tasks."""
    return Progress(predicted is not None, sum(task.verdict is not None and task.verdict.solved for task in tasks.values()))


MOST_ANSWERS = 20  # kept of an exam
MOST_VARIANTS = 10**6


@dataclass(frozen=True)
class ExamAnswer:
    """An answer to one variant of an exam, drawn for one key."""

    student: str
    variant: int
    said: str


@dataclass(frozen=True)
class ExamState:
    """How far a person is with one exam: the variant that is practised, and what was answered, latest last."""

    variant: int = 1
    answers: tuple[ExamAnswer, ...] = ()


USUAL = (1366.0, 768.0)  # px of a window that has not told its size


@dataclass(frozen=True)
class ReplayLoop:
    """A part of the run that is played `rounds` times more; then it comes to rest at `rest`."""

    part: ErrorWindow
    rounds: int
    rest: float


@dataclass(frozen=True)
class Performance:
    """What the guide still performs by itself: the values of knobs at the coming steps, and when the next is due."""

    frames: tuple[Mapping[str, Any], ...]
    due: float


@dataclass(frozen=True, eq=False)
class ManySeeds:
    """The errors of many seeds of a design, None while there are none; `fraction` says how far the runs are, None at their end.
    `followers` says whether each seed is that of a follower."""

    design: Design
    found: SeedErrors | None
    fraction: float | None
    followers: bool
