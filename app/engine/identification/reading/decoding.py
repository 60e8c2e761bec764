"""Turn the bytes of a text file into text: UTF-8, UTF-16 or, with a note, Windows-1252."""

from __future__ import annotations

import codecs

from ...systems.errors import EngineError, Phrase, phrase

__all__ = ["decoded"]

SAMPLE = 4000  # bytes that show whether every second one is zero
MOST_CONTROLS = 0.01  # share of control characters above which a file is no text
ALLOWED = frozenset("\t\n\r\f\x1a")


def decoded(name: str, data: bytes) -> tuple[str, tuple[Phrase, ...]]:
    """The text of a file and what is to be said about it. Raises EngineError where it is no text."""
    kind, note = _encoding(data)
    try:
        text = data.decode(kind)
    except UnicodeDecodeError as problem:
        raise _no_text(name) from problem
    sample = text[:SAMPLE]
    if sum(c < " " and c not in ALLOWED for c in sample) > MOST_CONTROLS * len(sample):
        raise _no_text(name)
    return text.lstrip("\ufeff"), note


def _encoding(data: bytes) -> tuple[str, tuple[Phrase, ...]]:
    if data.startswith(codecs.BOM_UTF8):
        return "utf-8-sig", ()
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16", ()
    start = data[:SAMPLE]
    if start and start[1::2].count(0) > 0.4 * len(start[1::2]) > 0 and not start[::2].count(0):
        return "utf-16-le", ()
    if start and start[::2].count(0) > 0.4 * len(start[::2]) and not start[1::2].count(0):
        return "utf-16-be", ()
    try:
        data.decode("utf-8")
        return "utf-8", ()
    except UnicodeDecodeError:
        return "cp1252", (phrase("The file is not UTF-8; letters such as µ and ° were read as Windows-1252."),)


def _no_text(name: str) -> EngineError:
    return EngineError("The file {name} is not UTF-8 text; save it as CSV in UTF-8.", name=name)
