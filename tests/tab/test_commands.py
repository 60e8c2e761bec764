"""Commands: each stands in the table once, and its function takes the command's fields under their names."""

from __future__ import annotations

import inspect
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from observer_lab.course.knobs import ByHand
from observer_lab.session.commands.commands import Command, Notice, SetKnobs
from observer_lab.session.commands.written import MIRRORED, read_edit, write_edit
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


FINITE = st.floats(allow_nan=False, allow_infinity=False)
VALUES = st.recursive(st.none() | st.booleans() | st.integers() | FINITE | st.complex_numbers(allow_nan=False, allow_infinity=False)
                      | st.text() | st.binary() | st.builds(ByHand, FINITE, st.booleans()),
                      lambda each: st.lists(each) | st.lists(each).map(tuple) | st.dictionaries(st.text(), each), max_leaves=12)


@pytest.mark.parametrize("kind", MIRRORED, ids=lambda kind: kind.__name__)
@given(data=st.data())
def test_what_a_hand_has_done_is_read_at_another_worker_as_it_was_written(kind: type, data: st.DataObject) -> None:
    edit = kind(**{name: data.draw(VALUES) for name in kind.__struct_fields__})
    assert repr(read_edit(write_edit(edit))) == repr(edit)


def test_values_of_numpy_are_written_as_numbers_and_what_has_no_form_is_refused() -> None:
    poles = (np.complex128(-1 + 2j), np.float64(-3.0), np.int64(4))
    assert read_edit(write_edit(SetKnobs({"poles": poles}))) == SetKnobs({"poles": (-1 + 2j, -3.0, 4)})
    with pytest.raises(TypeError):
        write_edit(SetKnobs({"poles": object()}))


@pytest.mark.parametrize("words", [
    "", "1", "[]", '["RunOnTabThread", {"do": 1}]', '["Seek", {}]', '["Seek", [1]]', '["Seek", {"t": {"eval": "1"}}]',
    '["Seek", {"t": {"complex": [1]}}]', '["Seek", {"t": {"a": 1, "b": 2}}]'])
def test_what_is_no_edit_is_refused(words: str) -> None:
    with pytest.raises(ValueError):
        read_edit(words)
