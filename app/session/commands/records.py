"""Define the commands about a record that a person brings."""

from __future__ import annotations

from .base import Command


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
    """Open the lesson on the record that was looked at."""


class DropRecord(Command, frozen=True):
    """Leave that file out; the lesson stays as it is."""
