"""Find the template of a sentence and the values in it, and say it in Chinese."""

from __future__ import annotations

import re
from functools import lru_cache

from ..text.words import Text
from . import estimation, filters, lessons, loops, matrices, optimal, phrases, plants, poles, runs

TABLES = (matrices, plants, poles, optimal, estimation, filters, loops, runs, lessons, phrases)
LONGEST = 2000  # characters of a sentence that is looked up at all
WIDE = "\u3000-\u303f\u4e00-\u9fff\uff00-\uffef“”…"
BETWEEN = re.compile(f"(?<=[{WIDE}]) +(?=[{WIDE}])|(?<=[。，；：（]) +| +(?=[。，；：）])")  # spaces that Chinese does not write
UNKNOWN = "无法计算（{}）"

Pieces = tuple[str, ...]


def told(problem: Exception) -> Text:
    """What an error says, in both languages; one that knows both itself, in its `text`, is taken at its word."""
    own = getattr(problem, "text", None)
    if isinstance(own, Text):
        return own
    words = str(problem)
    return Text(words, chinese(words) or UNKNOWN.format(words))


@lru_cache(maxsize=256)
def chinese(sentence: str) -> str | None:
    """The sentence in Chinese, None if no table knows it."""
    found = recognise(sentence)
    if found is None:
        return None
    _, translation, values = found
    return BETWEEN.sub("", translation.format(*(chinese(value) or value for value in values)))


def recognise(sentence: str) -> tuple[str, str, tuple[str, ...]] | None:
    """The most particular template that a sentence fits, its translation, and the values in their places."""
    if len(sentence) > LONGEST:
        return None
    for pieces, translation in _templates():
        values = _values(sentence, pieces)
        if values is not None:
            return "{}".join(pieces), translation, values
    return None


@lru_cache(maxsize=1)
def _templates() -> tuple[tuple[Pieces, str], ...]:
    """Every template in its fixed pieces, those with more fixed letters first: the most particular one wins."""
    known = [(tuple(english.split("{}")), translation) for table in TABLES for english, translation in table.SENTENCES]
    return tuple(sorted(known, key=lambda it: -sum(map(len, it[0]))))


def _values(text: str, pieces: Pieces) -> tuple[str, ...] | None:
    """What stands between the pieces, None where the text is another sentence. A value keeps its brackets closed."""
    if not text.startswith(pieces[0]):
        return None
    rest, later = text[len(pieces[0]):], pieces[1:]
    if not later:
        return None if rest else ()
    end = rest.find(later[0], 1)
    while end > 0:
        value = rest[:end]
        if value.count("(") == value.count(")"):
            behind = _values(rest[end:], later)
            if behind is not None:
                return (value, *behind)
        end = rest.find(later[0], end + 1) if end < len(rest) else -1
    return None
