"""Read a TOML file table by table; what is wrong is one sentence with file and line."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any  # a value of a TOML file is `Any` until one of these functions has checked it

from ...text import Text, read_outside_toml, same, text
from ...text.schema import shown
from ..knobs import Knob, KnobError

HEADER = re.compile(r"\s*(\[\[?)\s*([\w.-]+)\s*\]")
KEY = re.compile(r"""\s*["']?([^"'=.#\[\]]+?)["']?\s*[=.]""")
QUOTED = re.compile(r"\"(?:\\.|[^\"\\])*\"|'[^']*'|#.*")
AT_LINE = re.compile(r"\s*\(at line (\d+),.*\)|\s*\(at end of document\)")
MAX_TEXT_CHARS = 400
Place = tuple[str | int, ...]  # keys and numbers that lead to a value


class LessonFileError(KnobError):
    """A file of a lesson that cannot be used; `text` says file, line and why in every language."""


def refusal(file: str, line: int, why: Text) -> LessonFileError:
    """The error that names file and line."""
    return LessonFileError(text("{file}, line {line}: {why}", file=file, line=line, why=why))


def lines_of(words: str) -> dict[Place, int]:
    """The line of every table and of every key at the beginning of a line, counted from 1."""
    found: dict[Place, int] = {(): 1}
    table: Place = ()
    counts: dict[Place, int] = {}
    depth = 0
    for number, line in enumerate(words.splitlines(), 1):
        bare = QUOTED.sub("", line)
        if depth == 0 and (header := HEADER.match(line)):
            table = _table_of(header[2], header[1] == "[[", counts)
            found[table] = number
            continue
        if depth == 0 and (key := KEY.match(line)):
            found.setdefault((*table, key[1]), number)
        depth = max(0, depth + sum(map(bare.count, "[{")) - sum(map(bare.count, "]}")))
    return found


def _table_of(name: str, repeated: bool, counts: dict[Place, int]) -> Place:
    """The place of a table by its header; `[a.b]` below `[[a]]` belongs to the last of these."""
    place: Place = ()
    keys = name.split(".")
    for k, key in enumerate(keys):
        place = (*place, key)
        if k == len(keys) - 1 and repeated:
            counts[place] = counts.get(place, -1) + 1
        if place in counts:
            place = (*place, counts[place])
    return place


@dataclass(frozen=True)
class Table:
    """One table of a file, its place and the lines of all places."""

    file: str
    data: Mapping[str, Any]
    lines: Mapping[Place, int]
    place: Place = ()

    def line(self, key: str = "") -> int:
        """The line of a key, else that of the nearest table around it."""
        place: Place = (*self.place, key)
        while place not in self.lines:
            place = place[:-1]
        return self.lines[place]

    def refuse(self, key: str, why: Text) -> LessonFileError:
        """The error about one key."""
        return refusal(self.file, self.line(key), why)

    def only(self, *keys: str) -> Table:
        """Itself. Raises LessonFileError at any other key."""
        for key in self.data:
            if key not in keys:
                raise self.refuse(key, text("There is no key {key} here; use {keys}.", key=shown(key), keys=", ".join(keys)))
        return self

    def table(self, key: str) -> Table:
        """The table below a key, an empty one where there is none."""
        data = self.data.get(key, {})
        if not isinstance(data, dict):
            raise self.refuse(key, text("{key} must be a table.", key=key))
        return Table(self.file, data, self.lines, (*self.place, key))

    def tables(self, key: str) -> Iterator[Table]:
        """The tables of a list, each written under [[key]]."""
        data = self.data.get(key, [])
        if not isinstance(data, list) or not all(isinstance(each, dict) for each in data):
            raise self.refuse(key, text("Write each of the {key} under [[{key}]].", key=key))
        yield from (Table(self.file, each, self.lines, (*self.place, key, number)) for number, each in enumerate(data))

    def number(self, key: str, default: float | None = None) -> float:
        """A finite number."""
        value = self.data.get(key, default)
        if value is None:
            raise self.refuse("", text("{key} is missing; give a number.", key=key))
        if not is_number(value):
            raise self.refuse(key, text("{key} must be a number; it is {value}.", key=key, value=shown(value)))
        return float(value)

    def words(self, key: str, default: str | None = None) -> str:
        """A text of one line."""
        value = self.data.get(key, default)
        if value is None:
            raise self.refuse("", text("{key} is missing; give a text in quotes.", key=key))
        if not isinstance(value, str) or len(value) > MAX_TEXT_CHARS:
            raise self.refuse(key, text("{key} must be a text in quotes; it is {value}.", key=key, value=shown(value)))
        return value.strip()

    def label(self, key: str, default: str) -> Text:
        """A text as it is shown, the same in every language."""
        return same(self.words(key, default))

    def one_of(self, key: str, names: Iterable[str], default: str | None = None) -> str:
        """One of some names."""
        value, allowed = self.words(key, default), tuple(names)
        if value not in allowed:
            raise self.refuse(key, text("{key} cannot be {value}; use one of {names}.", key=key, value=shown(value),
                                        names=", ".join(allowed)))
        return value

    def names(self, key: str, allowed: Iterable[str] | None = None) -> tuple[str, ...]:
        """A list of names, of those that are allowed; empty where the key is missing."""
        values, known = self.data.get(key, []), None if allowed is None else tuple(allowed)
        if not isinstance(values, list) or not all(isinstance(value, str) for value in values):
            raise self.refuse(key, text("{key} must be a list of names in brackets.", key=key))
        for value in values:
            if known is not None and value not in known:
                raise self.refuse(key, text("{key} names {value}, which does not exist; there are {names}.", key=key, value=shown(value),
                                            names=", ".join(known) or "—"))
        return tuple(values)

    def range(self, key: str) -> tuple[float, float]:
        """A range [low, high]."""
        value = self.data.get(key)
        if not isinstance(value, list) or len(value) != 2 or not all(map(is_number, value)):
            raise self.refuse(key, text("{key} must be a range of two numbers, [low, high]; it is {value}.", key=key, value=shown(value)))
        if value[0] > value[1]:
            raise self.refuse(key, text("The range of {key} is reversed: {low:g} is above {high:g}.", key=key, low=value[0], high=value[1]))
        return float(value[0]), float(value[1])

    def switch(self, key: str, default: bool) -> bool:
        """True or false."""
        value = self.data.get(key, default)
        if not isinstance(value, bool):
            raise self.refuse(key, text("{key} must be true or false; it is {value}.", key=key, value=shown(value)))
        return value


def is_number(value: object) -> bool:
    """Whether a value is a finite number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e30


def read_values(table: Table, key: str, knobs: Sequence[Knob]) -> dict[str, Any]:
    """Values of knobs by name, in the form of each knob. Raises LessonFileError."""
    below = table.table(key)
    return {name: check_value(below, name, knob_named(below, name, name, knobs)) for name in below.data}


def check_value(table: Table, key: str, knob: Knob) -> Any:
    """The value of a key in the form of a knob. Raises LessonFileError."""
    try:
        return knob.check(table.data[key])
    except KnobError as problem:
        raise table.refuse(key, problem.text) from problem


def knob_named(table: Table, key: str, name: object, knobs: Sequence[Knob]) -> Knob:
    """The knob of that name. Raises LessonFileError with the names that exist."""
    for knob in knobs:
        if knob.name == name:
            return knob
    raise table.refuse(key, text("There is no knob {name}; there are {names}.", name=shown(name),
                                 names=", ".join(knob.name for knob in knobs if not knob.hidden) or "—"))


def read_table(file: str, words: str) -> Table:
    """The whole file. Raises LessonFileError where it is no TOML."""
    try:
        return Table(file, read_outside_toml(words), lines_of(words))
    except tomllib.TOMLDecodeError as problem:
        said, at = str(problem), AT_LINE.search(str(problem))
        line = int(at[1]) if at is not None and at[1] else len(words.splitlines()) or 1
        raise refusal(file, line, text("This is no valid TOML ({reason}).", reason=AT_LINE.sub("", said)[:120])) from problem
