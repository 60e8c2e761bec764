"""Check a plant's file, bytes to matrices, before anything is built from it."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from .errors import EngineError

__all__ = ["MAX_BYTES", "MAX_STATES", "bytes_of", "check_size", "full", "kind_of", "number", "parse", "rows", "text_of"]

MAX_STATES, MAX_BYTES = 30, 1_000_000


def check_size(count: int) -> None:
    """Raises EngineError above 1 MB."""
    if count > MAX_BYTES:
        raise EngineError("The file is larger than 1 MB; a plant with 30 states needs far less.")


def number(value: object, what: str) -> float:
    """A real number that JSON holds as `what`, finite or not. Raises EngineError for any other kind."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise EngineError("{what} must hold real numbers only.", what=what)
    try:
        return float(value)
    except OverflowError as problem:
        raise EngineError("{what} holds a number too large to store.", what=what) from problem


def rows(value: object, what: str) -> list[list[float]]:
    """A matrix of JSON, at most 30×30, as a list of rows. Raises EngineError."""
    rows = value if isinstance(value, list) else None
    if not rows or len(rows) > MAX_STATES or not all(isinstance(row, list) for row in rows):
        raise EngineError("{what} must be a list of 1 to {max_states} rows, each a list of numbers.",
                          what=what, max_states=MAX_STATES)
    if len({len(row) for row in rows}) != 1 or not 1 <= len(rows[0]) <= MAX_STATES:
        raise EngineError("The rows of {what} must be equally long, with 1 to {max_states} numbers each.",
                          what=what, max_states=MAX_STATES)
    return [[number(entry, what) for entry in row] for row in rows]


def _constant(word: str) -> float:
    raise EngineError("The file holds {word}; every number must be finite.", word=word)


def parse(text: str) -> dict[str, Any]:
    """The JSON object of a text. Raises EngineError above 1 MB and for what is none."""
    check_size(len(text))
    try:
        data = json.loads(text, parse_constant=_constant)
    except EngineError:
        raise
    except json.JSONDecodeError as problem:
        raise EngineError("This is not readable JSON: look at line {line}, column {column} for a comma, a quotation mark or a "
                          "bracket that is missing or too many.", line=problem.lineno, column=problem.colno) from problem
    except (ValueError, RecursionError) as problem:
        raise EngineError("This is not readable JSON: a number has too many digits or brackets stand in each other too deeply; "
                          "write them shorter.") from problem
    if not isinstance(data, dict):
        raise EngineError("The JSON must be one object with the matrices A, B, C and optionally D.")
    return data


def full(found: dict[str, Any], key: str) -> np.ndarray:
    """A variable of a .mat file that is a full real matrix, at most 30×30. Raises EngineError."""
    value = found[key]
    if not isinstance(value, np.ndarray) or max(value.shape) > MAX_STATES:
        raise EngineError("{key} must be a full real matrix of at most {max_states}×{max_states} numbers.",
                          key=key, max_states=MAX_STATES)
    return value


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
