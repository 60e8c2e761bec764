"""Read what a page says of its connection: it asks for a sign of life, or numbers a press."""

from __future__ import annotations

import re
from typing import Any

ASKED = re.compile(r"beat:(\d{0,15})", re.ASCII)  # with the number of the last edit that was not answered yet
NAME = re.compile(r"[\w-]{1,64}", re.ASCII)  # of a widget
PRESSED = re.compile(r"press:(\d{1,15})", re.ASCII)  # before a press, which must not be done twice


def beat(message: Any) -> str | None:
    """What stands behind `beat:` in a page's question; None where the message is another."""
    said = message.request_uuid
    found = ASKED.fullmatch(said) if isinstance(said, str) else None
    return None if found is None else found[1]


def press(message: Any) -> int | None:
    """The number of the press that follows; None where the message is another."""
    said = message.request_uuid
    found = PRESSED.fullmatch(said) if isinstance(said, str) else None
    return None if found is None else int(found[1])
