"""One outcome for one design of a lesson, shared by all laws of a worker that ask for it."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from observer_lab.course.lesson import Design, Outcome
from observer_lab.lessons import LESSONS

KEPT = 150  # outcomes of a lesson


class SharedOutcomes:
    """The draft of a lesson, which is pure: it is computed once for a design. What it refuses it refuses each time."""

    def __init__(self, compute: Callable[[Design], Outcome[Any]]) -> None:
        self.compute = compute
        self.kept = lru_cache(maxsize=KEPT)(compute)

    def __call__(self, design: Design) -> Outcome[Any]:
        try:
            hash(design)
        except TypeError:  # a value that no gate has checked
            return self.compute(design)
        return self.kept(design)

    def forget(self) -> None:
        """Forget them, where a test has put something else in place of what computes them."""
        self.kept.cache_clear()

    def __reduce__(self) -> tuple[Any, ...]:
        return SharedOutcomes, (self.compute,)


def share() -> None:
    """Let the lessons share their outcomes from now on."""
    for lesson in LESSONS.values():
        object.__setattr__(lesson, "compute", SharedOutcomes(lesson.compute))


def forget() -> None:
    """Forget all shared outcomes."""
    for lesson in LESSONS.values():
        if isinstance(lesson.compute, SharedOutcomes):
            lesson.compute.forget()
