"""When a value that a browser shows may be overwritten: the rules of `ReadBack`, on a widget without a browser."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from observer_lab.page.viser_private import widget_values
from observer_lab.page.viser_private.widget_values import ReadBack


class Widget:
    """A widget that notes what is written to it."""

    def __init__(self, value: Any) -> None:
        self.value, self.written = value, list[Any]()

    def on_update(self, heard: Any) -> Any:
        self.heard = heard
        return heard

    def by_hand(self, value: Any) -> None:
        """A change that comes from the browser."""
        asyncio.run(self.heard(SimpleNamespace(client_id=1, target=SimpleNamespace(value=value))))


@pytest.fixture
def widget(monkeypatch: pytest.MonkeyPatch) -> Widget:
    monkeypatch.setattr(widget_values.viser_internals, "write", lambda handle, value: handle.written.append(value))
    return Widget(1.0)


def picture(answered: int, resting: bool) -> Any:
    return SimpleNamespace(answered=answered, resting=resting)


def test_a_change_that_crosses_with_a_written_value_is_written_back_at_rest(widget: Widget) -> None:
    """The browser sends 3 while the page writes 2, and ends with 2: the accepted 3 is written though it is what was heard last."""
    back = ReadBack(widget, lambda value: 7)
    back.show(2.0, picture(answered=6, resting=True))
    widget.by_hand(3.0)
    back.show(3.0, picture(answered=7, resting=False))
    assert widget.written == [2.0], "the hand is not disturbed while it moves"
    back.show(3.0, picture(answered=7, resting=True))
    assert widget.written == [2.0, 3.0]
    back.show(3.0, picture(answered=7, resting=True))
    assert widget.written == [2.0, 3.0], "once is enough"


def test_a_change_that_crosses_with_nothing_is_not_written_back(widget: Widget) -> None:
    back = ReadBack(widget, lambda value: 7)
    widget.by_hand(3.0)
    back.show(3.0, picture(answered=7, resting=True))
    assert widget.written == []


def test_an_answer_older_than_the_last_change_is_not_written(widget: Widget) -> None:
    back = ReadBack(widget, lambda value: 7)
    widget.by_hand(3.0)
    back.show(2.0, picture(answered=6, resting=True))
    assert widget.written == []
    back.show(2.5, picture(answered=8, resting=False))
    assert widget.written == [2.5]
