"""Commands: each stands in the table once, and its function takes the command's fields under their names."""

from __future__ import annotations

import inspect
from collections.abc import Iterator

import pytest

from observer_lab.session.commands.base import Command, Notice
from observer_lab.session.handlers.table import HANDLERS


def every_command(base: type[Command] = Command) -> Iterator[type[Command]]:
    """All classes that are a command and no base of others."""
    for command in base.__subclasses__():
        if command is Notice:
            yield from every_command(command)
        else:
            yield command


def test_every_command_has_a_function_and_every_function_a_command():
    assert set(every_command()) == set(HANDLERS)


@pytest.mark.parametrize("command", HANDLERS, ids=lambda command: command.__name__)
def test_a_function_takes_the_fields_of_its_command(command: type[Command]):
    presenter, *fields = inspect.signature(HANDLERS[command]).parameters
    assert presenter == "show" and tuple(fields) == command.__struct_fields__
