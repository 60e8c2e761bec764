"""Text that JSON can hold and UTF-8 cannot, at every door of a tab: the connection lives, one sentence comes, the knobs go on."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from client import WireTab

from observer_lab.page.screen.server import LabServer
from observer_lab.session.state.saved_state import VERSION
from observer_lab.session.state.token import packed

STIFFNESS = "stiffness error in the model [%]"
FIELDS = {"version": VERSION, "lesson": "separation", "knobs": {}}
TOKENS = {name: packed(json.dumps(FIELDS | odd)) for name, odd in {
    "lesson": {"lesson": "\ud800"}, "knob": {"knobs": {"\udfff": "1"}}, "value": {"knobs": {"delay": "\ud800"}}, "field": {"\ud800": 1},
    "plant": {"plant": {"A": [[-1]], "B": [[1]], "C": [[1]], "name": "\ud800", "states": ["\udead"]}}}.items()}
KEPT = json.dumps({"version": VERSION, "lesson": "\ud800", "desks": {"\ud800": {}}})


class Hostile(WireTab):
    """A tab whose browser kept odd text and has an odd address."""

    def __init__(self, url: str, said: list[Any]) -> None:
        self.said = said
        super().__init__(url)

    def _run(self, script: str, given: dict[str, Any]) -> None:
        if script == "recall":
            self.send("LocalStorageGetItemResponseMessage", value=json.dumps(self.said), error=None, request_uuid=given["request"])
        else:
            super()._run(script, given)


def works(tab: WireTab) -> None:
    """It answers, and obeys the knob that its lesson has (another plant brings other knobs)."""
    tab.settle()
    if not tab.has(STIFFNESS):
        return
    tab.update(STIFFNESS, value=7.0)
    tab.until(lambda: tab.value(STIFFNESS) == 7.0, "a good value")
    tab.answered()


@pytest.mark.parametrize("token", TOKENS.values(), ids=list(TOKENS))
def test_a_link_with_half_a_character_leaves_the_tab_alive(server: LabServer, token: str) -> None:
    with Hostile(server.url, [None, token, False, "http://127.0.0.1/", None, None]) as tab:
        works(tab)


@pytest.mark.parametrize("said", [[KEPT, "", False, "\ud800", KEPT, KEPT], ["\ud800", "\ud800", True, "\ud800", "\ud800", "\ud800"],
                                  [None, "\ud800{", False, "", None, json.dumps({"\ud800": KEPT})]], ids=["memory", "half", "designs"])
def test_a_storage_with_half_a_character_leaves_the_tab_alive(server: LabServer, said: list[Any]) -> None:
    with Hostile(server.url, said) as tab:
        works(tab)


def test_an_upload_and_a_said_place_with_half_a_character_leave_the_tab_alive(enter: Callable[..., WireTab]) -> None:
    tab = enter()
    heard = [w["uuid"] for w in tab.widgets.values() if w["type"] == "GuiTextMessage"]
    for uuid in heard:
        tab.send("GuiUpdateMessage", uuid=uuid, updates={"value": json.dumps({"open": "\ud800{", "asked": 1})})
        tab.send("GuiUpdateMessage", uuid=uuid, updates={"value": json.dumps({"tab": "\ud800", "step": "\ud800"})})
    for uuid in [w["uuid"] for w in tab.widgets.values() if w["type"] == "GuiUploadButtonMessage"]:
        content = json.dumps({"A": [[-1]], "B": [[1]], "C": [[1]], "name": "\ud800", "\ud800": "\udead"}).encode()
        tab.send("FileTransferStartUpload", source_component_uuid=uuid, transfer_uuid="t", filename="\u00e9.json", mime_type="",
                 part_count=1, size_bytes=len(content))
        tab.send("FileTransferPart", source_component_uuid=uuid, transfer_uuid="t", part_index=0, content=content)
    works(tab)


@pytest.mark.parametrize("data", [b"\xc1" * 40, b"\x81\xa4type\xa3\xed\xa0\x80", "text instead of bytes"], ids=["noise", "half", "text"])
def test_a_message_that_cannot_be_read_is_left_out(enter: Callable[..., WireTab], data: bytes | str) -> None:
    tab = enter()
    tab.send_raw(data)
    works(tab)
