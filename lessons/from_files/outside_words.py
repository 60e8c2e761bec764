"""Refuse HTML in the words of an uploaded lesson, which a page shows as they are."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any  # a value of a TOML file is `Any`

from observer_lab.course.reading.toml_table import Table, refusal
from observer_lab.text import Text, text
from observer_lab.text.schema import shown

BEGINS = re.compile(r"<(?![\s\d=])|\\href")  # a tag, also one that begins where a text ends; a link in a formula
NAME = re.compile(r"[\w .,+/()°·²³⁻¹µ%-]{1,80}")
NAMES = ("id", "of")  # keys whose value stands in an attribute of the page
MARKUP = re.compile(r"[^\w\s.,:;()=+-]")


def check_markdown(file: str, words: str) -> None:
    """The words of a Markdown file hold no HTML. Raises LessonFileError."""
    found = BEGINS.search(words)
    if found is not None:
        raise refusal(file, words.count("\n", 0, found.start()) + 1, _why(words, found))


def check_strings(top: Table) -> None:
    """No string of a TOML file holds HTML, and an id is a plain name. Raises LessonFileError."""
    for place, value in top.data.items():
        for key, words in _strings(place, value):
            found = BEGINS.search(words)
            if found is not None:
                raise top.refuse(place, _why(words, found))
            if key in NAMES and not NAME.fullmatch(words):
                raise top.refuse(place, text(
                    "The name {name} must be short and plain; use letters, digits, spaces and signs such as + and %.", name=shown(words)))


def plain_markdown(words: str) -> str:
    """Words that Markdown and HTML show letter by letter."""
    return MARKUP.sub(lambda sign: f"&#{ord(sign[0])};", words)


def _strings(key: str, value: Any) -> Iterator[tuple[str, str]]:
    """Every string, keys included, with the key that it belongs to."""
    if isinstance(value, str):
        yield key, value
    elif isinstance(value, dict):
        for name, part in value.items():
            yield "", name
            yield from _strings(name, part)
    elif isinstance(value, list):
        for part in value:
            yield from _strings(key, part)


def _why(words: str, found: re.Match[str]) -> Text:
    return text("“{begin}” may begin HTML or a link, and this lesson may have none. Put a space after “<”.",
                begin=words[found.start():found.start() + 12].partition("\n")[0])
