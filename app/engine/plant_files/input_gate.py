"""Check a plant file's size, text, JSON and matrices before anything is built from it."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..systems.errors import EngineError, Phrase, phrase

__all__ = [
    "MAX_BYTES",
    "MAX_STATES",
    "OBJECT",
    "Entry",
    "Unread",
    "bytes_of",
    "check_size",
    "kind_of",
    "matrix",
    "number",
    "parse",
    "scalar",
    "text_of",
    "vector",
]

MAX_STATES, MAX_BYTES = 200, 1_000_000
OBJECT = phrase("an object")


def check_size(count: int) -> None:
    """Raises EngineError above 1 MB."""
    if count > MAX_BYTES:
        raise EngineError("The file is larger than 1 MB; save only the matrices of the plant in it.")


def number(value: object, what: str) -> float:
    """A real number that JSON holds as `what`, finite or not. Raises EngineError for any other kind."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise EngineError("{what} must hold real numbers only.", what=what)
    try:
        return float(value)
    except OverflowError as problem:
        raise EngineError("{what} holds a number too large to store.", what=what) from problem


def scalar(value: Entry, what: str) -> float:
    """One real number, from JSON or from a 1×1 matrix. Raises EngineError."""
    if isinstance(value, np.ndarray):
        if value.size != 1:
            raise EngineError("{what} must be one number; it is {rows}×{columns}.", what=what, rows=value.shape[0], columns=value.shape[1])
        _real(value, what)
        return float(value.item())
    if isinstance(value, Unread):
        raise _not_full(what, value.what)
    return number(value, what)


def vector(value: Entry, what: str) -> np.ndarray:
    """A row of real numbers (k,), from a list, a number or a matrix of one row or column; none where it is empty. Raises EngineError."""
    if isinstance(value, np.ndarray):
        if value.size and 1 not in value.shape:
            raise EngineError("{what} must be one row of numbers; it is {rows}×{columns}.", what=what, rows=value.shape[0],
                              columns=value.shape[1])
        return _real(value, what).ravel()
    if value is None:
        return np.zeros(0)
    if not isinstance(value, list):
        return np.array([scalar(value, what)])
    flat = value[0] if len(value) == 1 and isinstance(value[0], list) else [row[0] if isinstance(row, list) and len(row) == 1 else row
                                                                           for row in value]
    if len(flat) > MAX_STATES:
        raise EngineError("{what} must have at most {most} numbers.", what=what, most=MAX_STATES)
    return np.array([number(entry, what) for entry in flat])


def matrix(value: Entry, what: str, lying: bool = False) -> np.ndarray:
    """A real matrix of at most 200×200, from a file of either kind; 0×0 where it is empty. Raises EngineError.

    A list of numbers, as `jsonencode` writes a vector, is a row where it is `lying` and a column otherwise.
    """
    if isinstance(value, np.ndarray):
        if max(value.shape) > MAX_STATES:
            raise EngineError("{key} must have at most {most}×{most} numbers; it is {rows}×{columns}.", key=what, most=MAX_STATES,
                              rows=value.shape[0], columns=value.shape[1])
        return _real(value, what)
    if isinstance(value, Unread):
        raise _not_full(what, value.what)
    if value is None or value == []:
        return np.zeros((0, 0))
    if isinstance(value, int | float) and not isinstance(value, bool):
        return np.array([[number(value, what)]])
    return _rows(value, what, lying)


def _real(value: np.ndarray, what: str) -> np.ndarray:
    if np.iscomplexobj(value):
        raise _not_full(what, phrase("complex"))
    return value


def _not_full(what: str, found: str) -> EngineError:
    return EngineError("{key} must be a full real matrix; it is {found}.", key=what, found=found)


def _kind(value: Entry) -> Phrase:
    return phrase("text") if isinstance(value, str) else phrase("a cell array") if isinstance(value, list) else phrase(
        "true or false") if isinstance(value, bool) else phrase("a struct")


def _rows(value: Entry, what: str, lying: bool) -> np.ndarray:
    if not isinstance(value, list) or any(
            isinstance(part, np.ndarray) for row in value if isinstance(row, list) for part in row):
        raise EngineError("{what} must be a list of rows of numbers, a full real matrix; it is {found}.", what=what,
                          found=_kind(value))
    if len(value) > MAX_STATES:
        raise EngineError("{key} must have at most {most}×{most} numbers; it is {rows}×{columns}.", key=what, most=MAX_STATES,
                          rows=len(value), columns=len(value[0]) if isinstance(value[0], list) else 1)
    if not any(isinstance(row, list) for row in value):
        flat = np.array([number(entry, what) for entry in value])
        return flat[None, :] if lying else flat[:, None]
    if not all(isinstance(row, list) for row in value) or len({len(row) for row in value}) != 1 or not 1 <= len(value[0]) <= MAX_STATES:
        raise EngineError("The rows of {what} must be equally long, with 1 to {max_states} numbers each.",
                          what=what, max_states=MAX_STATES)
    return np.array([[number(entry, what) for entry in row] for row in value])


def _constant(word: str) -> float:
    raise EngineError("The file holds {word}; every number must be finite.", word=word)


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise EngineError("The key {key} stands twice in the file; keep one of the two.", key=key[:40])
        found[key] = value
    return found


def parse(text: str) -> dict[str, Any]:
    """The JSON object of a text. Raises EngineError above 1 MB, for what is none, and for a key that stands twice."""
    check_size(len(text))
    try:
        data = json.loads(text, parse_constant=_constant, object_pairs_hook=_once)
    except EngineError:
        raise
    except json.JSONDecodeError as problem:
        raise EngineError("This is not readable JSON: check line {line}, column {column} for a missing or extra comma, quotation mark "
                          "or bracket.", line=problem.lineno, column=problem.colno) from problem
    except (ValueError, RecursionError) as problem:
        raise EngineError("This is not readable JSON: a number has too many digits or brackets stand in each other too deeply; "
                          "write them shorter.") from problem
    if not isinstance(data, dict):
        raise EngineError("The JSON must be one object with the matrices A, B, C and optionally D.")
    return data


def bytes_of(source: str | os.PathLike[str] | bytes) -> bytes:
    """What a file holds, or bytes as they are, at most 1 MB. Raises EngineError."""
    if isinstance(source, bytes):
        check_size(len(source))
        return source
    try:
        with open(source, "rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as problem:
        raise EngineError("The file {name} cannot be read; check its name and place.", name=Path(source).name) from problem
    check_size(len(data))
    return data


def kind_of(name: str) -> str:
    """The suffix of a file's name. Raises EngineError unless it is .json or .mat."""
    suffix = Path(name).suffix.lower()
    if suffix in (".csv", ".tsv", ".txt", ".dat", ".parquet", ".mf4", ".mdf", ".mcap"):
        raise EngineError("This looks like a record of measurements; a record opens in lesson record with --data, and a plant is a .json "
                          "or .mat file.")
    if suffix not in (".json", ".mat"):
        raise EngineError("A plant file must end in .json or .mat.")
    return suffix


def text_of(data: bytes) -> str:
    """The text of a JSON file. Raises EngineError above 1 MB and for what is not UTF-8."""
    check_size(len(data))
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        raise EngineError("The JSON file must be UTF-8 text; choose UTF-8 as its encoding when you save it in your editor.") from problem


@dataclass(frozen=True)
class Unread:
    """A variable that is there but cannot be read: `what` it is in words, and the class `of` an object."""

    what: str
    of: str = ""


# float array (r×c), text, number or truth of JSON, None, list, fields by name, or what cannot be read
Entry = np.ndarray | str | float | bool | None | list | Mapping | Unread
