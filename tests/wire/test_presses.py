"""A press that a page sends again after an outage is done once: what the page keeps says which presses it holds."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from client import CALLED, WireTab

from observer_lab.lessons import LESSONS
from observer_lab.page.screen.server import LabServer

STIFFNESS, UNDO = "stiffness error in the model [%]", "undo"
LIMITED = "limit the coils"
MOVES = ((STIFFNESS, 7.0), (LIMITED, True))
Enter = Callable[..., WireTab]


def kept(tab: WireTab) -> list[dict[str, Any]]:
    """What the page was given to keep, in order, each with the number of the last press in it."""
    calls = [CALLED.fullmatch(message["source"]) for message in tab.messages if message["type"] == "RunJavascriptMessage"]
    return [json.loads(call[2]) for call in calls if call is not None and call[1] == "remember"]


def missed(tab: WireTab) -> list[str]:
    """The names of the widgets that came too late, as the page was told."""
    calls = [CALLED.fullmatch(message["source"]) for message in tab.messages if message["type"] == "RunJavascriptMessage"]
    return [json.loads(call[2])["widget"] for call in calls if call is not None and call[1] == "missed"]


def shown(tab: WireTab) -> tuple[Any, ...]:
    """What the knobs show."""
    return tuple(tab.value(label) for label, _ in MOVES)


def press(tab: WireTab, number: int, label: str) -> None:
    """Press a button as a page does: the number of the press comes before it."""
    tab.send("LocalStorageGetItemResponseMessage", value=None, error=None, request_uuid=f"press:{number}")
    tab.press(label)


@pytest.mark.parametrize("many", [1, 2])
def test_whatever_a_page_keeps_when_it_is_cut_a_press_is_done_once(server: LabServer, enter: Enter, many: int) -> None:
    """The network may end behind any message: the page then does again the presses that what it keeps does not hold."""
    tab = enter()
    states = [shown(tab)]
    for label, value in MOVES:
        tab.update(label, value=value)
        tab.settle()
        states.append(shown(tab))
    assert len(set(states)) == len(states)
    before = len(kept(tab)) - 1  # the last one holds all moves
    for number in range(1, many + 1):
        press(tab, number, UNDO)
        tab.settle()
    wanted = states[-1 - many]
    assert shown(tab) == wanted
    found = {each["text"]: each["answered"] for each in kept(tab)[before:]}
    assert set(found.values()) == set(range(many + 1))
    for text, answered in found.items():
        back = enter(kept=text)
        for number in range(answered + 1, many + 1):
            press(back, number, UNDO)
        back.settle()
        assert shown(back) == wanted, f"kept with {answered} presses"
        back.close()


def test_a_page_hears_of_a_press_that_came_too_late_for_its_widget(enter: Enter) -> None:
    """Laid out anew, as for another lesson, a page has other widgets; what comes for those of before is not passed over in silence."""
    tab = enter()
    before = [uuid for uuid, widget in tab.widgets.items() if widget["type"] == "GuiButtonGroupMessage"]
    commands = list(tab.commands.values())
    tab.update("lesson", value=LESSONS["duality"].words["en"].title)
    tab.until(lambda: not set(before) & set(tab.widgets), "the page of the other lesson")
    tab.settle()
    for uuid in before:
        tab.send("GuiUpdateMessage", uuid=uuid, updates={"value": ""})
    tab.settle()
    assert missed(tab) == before
    tab.send("CommandTriggerMessage", uuid=commands[0])
    tab.settle()
    assert missed(tab) == [*before, commands[0]]
    tab.send("GuiUpdateMessage", uuid="x" * 999, updates={"value": ""})
    tab.settle()
    assert missed(tab) == [*before, commands[0]], "no page of ours has such a widget"
