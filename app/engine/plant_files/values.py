"""What a variable of a file may be: matrix, text, list, record, or something that cannot be read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..systems.errors import phrase

__all__ = ["OBJECT", "Entry", "Unread"]

OBJECT = phrase("an object")


@dataclass(frozen=True)
class Unread:
    """A variable that is there but cannot be read: `what` it is in words, and the class `of` an object."""

    what: str
    of: str = ""


# float array (r×c), text, number or truth of JSON, None, list, fields by name, or what cannot be read
Entry = np.ndarray | str | float | bool | None | list | Mapping | Unread
