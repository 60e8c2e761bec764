"""Check values that came from a browser before they are used."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import SupportsFloat

from ...course.knobs import KnobError
from ...text import text
from .saved_state import LONGEST_NAME


def check_name(words: object) -> str:
    """A name that a person typed, "" for none. Raises KnobError."""
    name = " ".join(words.split()) if isinstance(words, str) else ""
    if len(name) > LONGEST_NAME or not name.isprintable():
        raise KnobError(text("A name has at most {most} characters.", most=LONGEST_NAME))
    return name


LEAST_PIXELS, MOST_PIXELS = 200.0, 20_000.0  # of a window's side


def check_pixels(value: object) -> float:
    """A side of a window out of what a browser sent. Raises KnobError."""
    return min(max(check_number(value), LEAST_PIXELS), MOST_PIXELS)


def check_number(value: object, finite: bool = True) -> float:
    """A number out of what a browser sent, a finite one unless told otherwise. Raises KnobError."""
    found: float | None = None
    if isinstance(value, (str, SupportsFloat)):
        with suppress(TypeError, ValueError, OverflowError):
            found = float(value)
    if found is None or (finite and not math.isfinite(found)):
        shown = str(value)[:40]
        raise KnobError(text("{shown} is not a finite number; nothing was changed.", shown=shown))
    return found
