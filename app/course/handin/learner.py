"""Describe a student whom a learning platform has sent: the key, and where hand-ins go."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from ...text import Text


@dataclass(frozen=True)
class Report:
    """What came of a hand-in, in one sentence."""

    words: Text
    bad: bool = False


@dataclass(frozen=True, eq=False)
class Learner:
    """The key that the course draws numbers for, which nobody can change, and what takes a hand-in to the platform.

    `report` may wait for another machine, and does not raise; None where the platform takes no points. `item` is the name of the exam or
    task that the launch opens, "" for all of a lesson.
    """

    key: str
    report: Callable[[str], Report] | None = field(default=None, repr=False)
    item: str = ""
