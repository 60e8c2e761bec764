"""What was given, in words, for the sentence of an error."""

from __future__ import annotations

import numpy as np

from ..errors import phrase

__all__ = ["described"]


def described(value: object) -> str:
    """A value in three or four words: "an array of shape (2,)", "a list of 3 entries", "text", "None", else its kind."""
    if value is None:
        return "None"
    if isinstance(value, np.ndarray):
        return phrase("an array of shape {shape}", shape=str(value.shape))
    if isinstance(value, list | tuple | set | dict):
        return phrase("a {kind} of {count} entries", kind=type(value).__name__, count=len(value))
    if isinstance(value, str | bytes):
        return phrase("text")
    if isinstance(value, bool | int | float | complex | np.number):
        return phrase("the number {value}", value=str(value)[:20])
    return phrase("a {kind}", kind=type(value).__name__[:40])
