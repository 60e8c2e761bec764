"""Make standard output take any letter: plain letters stand for those that its encoding lacks."""

from __future__ import annotations

import codecs
import io
import os
import sys
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

__all__ = ["give_up_output", "set_up", "shows"]

HANDLER = "observer-lab-plain"
PLAIN: Mapping[str, str] = MappingProxyType({
    "−": "-", "–": "-", "—": "-", "·": "*", "×": "x", "…": "...", "≤": "<=", "≥": ">=", "≠": "!=", "≈": "~", "→": "->", "“": '"', "”": '"',
    "‘": "'", "’": "'", "±": "+-", "∞": "inf", "√": "sqrt", "²": "^2", "³": "^3", "⁻": "^-", "¹": "1", "ᵀ": "^T", "°": " deg", "∫": "int",
    "\u0307": "'", "\u0302": "^", "\u0304": "", "\u00a0": " ", "\u2009": " ", "\u202f": " "})


def set_up() -> None:
    """Let standard output and standard error write what their encoding lacks in plain letters, a question mark where there are none."""
    codecs.register_error(HANDLER, _in_plain_letters)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=HANDLER)


def _in_plain_letters(problem: UnicodeError) -> tuple[str, int]:
    if not isinstance(problem, UnicodeEncodeError):
        raise problem
    words = problem.object[problem.start:problem.end]
    plain = "".join(_plain(letter) for letter in words)
    return plain, problem.end


def _plain(letter: str) -> str:
    import unicodedata

    if letter in PLAIN:
        return PLAIN[letter]
    apart = unicodedata.normalize("NFKD", letter)
    found = "".join(PLAIN.get(part, part) for part in apart)
    return found if found.isascii() else "".join(part for part in found if part.isascii()) or "?"


def shows(words: str) -> bool:
    """Whether standard output can show every letter of these words."""
    encoding: Any = getattr(sys.stdout, "encoding", None) or "utf-8"
    try:
        words.encode(encoding)
    except (UnicodeError, LookupError):
        return False
    return True


def give_up_output() -> None:
    """Send what is still waiting for standard output nowhere, so that the end of the process says nothing of it."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.__stdout__.fileno())  # type: ignore[union-attr]
        os.close(nowhere)
    except (OSError, ValueError, AttributeError):
        pass
    sys.stdout = None  # type: ignore[assignment]
