"""Define the commands about a record that a person brings, and what its fit tells."""

from __future__ import annotations

from ...course.lesson import Lesson
from .commands import Command, Notice


class UploadRecord(Command, frozen=True):
    """The record in a file that the person chose, to be looked at first."""

    name: object
    data: object


class SetColumnRole(Command, frozen=True):
    """The role of a column of that file, by its place: t, u, y or "" where it is not used."""

    place: object
    role: object


class TellOfRecord(Command, frozen=True):
    """Tell the reader one thing about that file: `name` is a field of `Told`."""

    name: str
    value: object


class UseRecord(Command, frozen=True):
    """Fit the record that was looked at, and open the lesson on it."""


class StopFit(Command, frozen=True):
    """End that fit; the lesson stays as it is."""


class FitGoesOn(Notice, frozen=True):
    """A fit has come farther."""

    fitting: object


class FitEnded(Notice, frozen=True):
    """A fit is through: the lesson on the record, or what went wrong; neither where it was ended."""

    fitting: object
    lesson: Lesson | None
    problem: BaseException | None


class DropRecord(Command, frozen=True):
    """Leave that file out; the lesson stays as it is."""
