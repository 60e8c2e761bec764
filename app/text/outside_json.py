"""Read JSON from outside: replace text that UTF-8 cannot hold, refuse a name that stands twice."""

from __future__ import annotations

import json
import re

LONE_SURROGATE = re.compile("[\ud800-\udfff]")
ESCAPED_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")
REPLACEMENT = "\ufffd"


def replace_surrogates(words: str) -> str:
    """The words with U+FFFD in the place of each character that UTF-8 cannot hold."""
    return LONE_SURROGATE.sub(REPLACEMENT, words)


def read_outside_json(words: str) -> object:
    """The plain data of a JSON text from a stranger; every string in it can be sent and written.

    JSON may name half of a surrogate pair, which no encoder of UTF-8 accepts: an answer that repeated it would end its connection.
    Raises ValueError for what is no JSON, nests too deep, or names a key of an object twice.
    """
    try:
        data = json.loads(replace_surrogates(words), object_pairs_hook=_unique)
        if ESCAPED_SURROGATE.search(words):
            data = json.loads(replace_surrogates(json.dumps(data, ensure_ascii=False)))
    except RecursionError as problem:
        raise ValueError("the JSON nests too deep") from problem
    return data


def _unique(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) != len(pairs):
        raise ValueError("a key stands twice in an object")
    return found
