"""Read files and TOML from outside: regular files alone, bounded in size, depth, parts and digits.

A text is measured before it is parsed: tomllib builds a table for every part of a dotted key, and 58 kB of `a.a.a…` took a gigabyte.
"""

from __future__ import annotations

import json
import os
import re
import stat
import tomllib
from itertools import accumulate
from pathlib import Path

MAX_TOML_CHARACTERS = 500_000
MAX_DEPTH, MAX_PARTS, MAX_DIGITS = 32, 16, 400  # of arrays and tables in each other, of a dotted key, of a number
STRING = re.compile(r'"""(?:\\.|[^\\])*?"""|\'\'\'.*?\'\'\'|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'|#[^\n]*', re.DOTALL)
LONG_KEY = re.compile(rf"(?<![\w-])(?:[\w-]+[ \t]*\.[ \t]*){{{MAX_PARTS}}}")
LONG_NUMBER = re.compile(rf"(?<!\w)[0-9A-Fa-fxob_]{{{MAX_DIGITS},}}")
TOO_LONG = ((LONG_KEY, f"A key has more than {MAX_PARTS} parts"), (LONG_NUMBER, f"A number has more than {MAX_DIGITS} digits"))
LONE_SURROGATE = re.compile("[\ud800-\udfff]")
ESCAPED_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")
REPLACEMENT = "\ufffd"


class OutsideFileError(ValueError):
    """A file that is not read; the message says why, to follow the file's name."""


def read_outside_bytes(path: Path, most: int) -> bytes:
    """What a regular file of at most `most` bytes holds. Raises OutsideFileError, or OSError.

    It is opened without waiting for who writes into a pipe, and asked what it is when it is open, so that nobody can change it between.
    """
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with open(descriptor, "rb") as file:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise OutsideFileError("it is no plain file")
        content = file.read(most + 1)
    if len(content) > most:
        raise OutsideFileError(f"it is larger than {f'{most // 1_000_000} MB' if most >= 1_000_000 else f'{most // 1000} kB'}")
    return content


def read_outside_toml(words: str) -> dict[str, object]:
    """The data of a TOML text from a stranger. Raises tomllib.TOMLDecodeError, also for what is too long, too deep or too large."""
    if len(words) > MAX_TOML_CHARACTERS:
        raise tomllib.TOMLDecodeError(f"It has more than {MAX_TOML_CHARACTERS} characters (at line 1, column 1)")
    bare = STRING.sub(lambda found: "x" + "\n" * found[0].count("\n"), words)
    for pattern, why in TOO_LONG:
        if (found := pattern.search(bare)) is not None:
            raise _refused(bare, found.start(), why)
    signs = [(place.start(), 1 if place[0] in "[{" else -1) for place in re.finditer(r"[\[\]{}]", bare)]
    for (place, _), depth in zip(signs, accumulate(step for _, step in signs), strict=True):
        if depth > MAX_DEPTH:
            raise _refused(bare, place, f"Arrays and tables are more than {MAX_DEPTH} deep")
    try:
        return tomllib.loads(words)
    except (RecursionError, ValueError) as problem:
        if isinstance(problem, tomllib.TOMLDecodeError):
            raise
        raise tomllib.TOMLDecodeError(f"{str(problem)[:100]} (at end of document)") from problem


def _refused(words: str, place: int, why: str) -> tomllib.TOMLDecodeError:
    line = words.count("\n", 0, place) + 1
    return tomllib.TOMLDecodeError(f"{why} (at line {line}, column {place - words.rfind(chr(10), 0, place)})")


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
