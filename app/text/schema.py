"""Judge plain data from outside by a msgspec type; name what does not fit by its place."""

from __future__ import annotations

import math
import re
from typing import Any, TypeVar

import msgspec
from msgspec import Meta, inspect

MAX_SHOWN_CHARACTERS = 40
PLACE = re.compile(r" - at `(?:key in )?\$(.*)`$", re.S)
STEP = re.compile(r"\.([^.\[]+)|\[(\d+)\]")
MISSING = re.compile(r"Object missing required field `([^`]+)`")
T = TypeVar("T")


class Misfit(ValueError):
    """Data that are not of their kind: the place of the table, the key in it, its value, and what its kind says of itself."""

    def __init__(self, place: tuple[str | int, ...], key: str, value: object, words: str) -> None:
        super().__init__(words)
        self.place, self.key, self.value = place, key, value
        self.words = words.replace("{key}", key).replace("{value}", shown(value))

    def __reduce__(self) -> tuple[type[Misfit], tuple[object, ...]]:
        return Misfit, (self.place, self.key, self.value, self.args[0])


class Checked(msgspec.Struct, frozen=True, rename="kebab", forbid_unknown_fields=True):
    """A table with these keys and no others; an underscore stands for a dash."""


def says(words: str, **limits: Any) -> Meta:
    """Beside a type: what data must be, with "{key}" and "{value}" for what was written in its place; and the limits of the type."""
    return Meta(description=words, **limits)


def judge(data: object, kind: type[T], unknown: str) -> T:
    """The data as that kind. Raises Misfit; `unknown` is said of a key that the kind lacks, with its keys for "{keys}"."""
    try:
        return msgspec.convert(_finite(data), kind)
    except msgspec.ValidationError as problem:
        raise _misfit(str(problem), data, inspect.type_info(kind), unknown) from problem


def fitting(data: object, kind: type[T]) -> T | None:
    """The data as that kind, None where they are another."""
    try:
        return msgspec.convert(_finite(data), kind)
    except msgspec.ValidationError:
        return None


def shown(value: object) -> str:
    """What a file says, as it is quoted in an error."""
    return str(value)[:MAX_SHOWN_CHARACTERS] or "—"


def _finite(data: object) -> object:
    """The data with what is no finite number in place of each that is none; no kind takes bytes."""
    match data:
        case float() if not math.isfinite(data):
            return b""
        case dict():
            return {key: _finite(value) for key, value in data.items()}
        case list():
            return [_finite(value) for value in data]
    return data


def _misfit(problem: str, data: Any, kind: inspect.Type, unknown: str) -> Misfit:
    found = PLACE.search(problem)
    path, any_key, _ = found[1].partition("[...]") if found else ("", "", "")
    place: list[str | int] = [name or int(number) for name, number in STEP.findall(path)]
    words = ""
    for step in place:
        kind, said = _below(kind, step)
        words = said or words
        data = data[step] if isinstance(data, dict) else data[int(step)] if isinstance(data, list) else data
    if any_key:  # msgspec does not say which
        words = _below(kind, "")[1] or words
    plain = _plain(kind)
    if isinstance(plain, inspect.StructType) and isinstance(data, dict):
        missing = MISSING.match(problem)
        if missing is not None:
            return Misfit(tuple(place), missing[1], None, _below(kind, missing[1])[1])
        fields = [field.encode_name for field in plain.fields]
        key = next(key for key in data if key not in fields)
        return Misfit(tuple(place), shown(key), data[key], unknown.replace("{keys}", ", ".join(fields)))
    named = next((k for k in reversed(range(len(place))) if isinstance(place[k], str)), 0)
    return Misfit(tuple(place[:named]), str(place[named]) if place else "", data, words)


def _plain(kind: inspect.Type) -> Any:
    """A type without what is said beside it, and the first of several that has parts."""
    while isinstance(kind, inspect.Metadata):
        kind = kind.type
    if isinstance(kind, inspect.UnionType):
        return next((plain for part in kind.types if hasattr(plain := _plain(part), "fields") or hasattr(plain, "item_type")
                     or hasattr(plain, "value_type")), kind)
    return kind


def _below(kind: inspect.Type, step: str | int) -> tuple[inspect.Type, str]:
    """The type of a part and what is said of it."""
    plain = _plain(kind)
    if isinstance(plain, inspect.StructType):
        inner = next(field.type for field in plain.fields if field.encode_name == step)
    else:
        inner = plain.value_type if isinstance(step, str) else plain.item_type
    return inner, _said(inner)


def _said(kind: inspect.Type) -> str:
    while isinstance(kind, inspect.Metadata):
        if kind.extra_json_schema and "description" in kind.extra_json_schema:
            return kind.extra_json_schema["description"]
        kind = kind.type
    return next(filter(None, map(_said, kind.types)), "") if isinstance(kind, inspect.UnionType) else ""
