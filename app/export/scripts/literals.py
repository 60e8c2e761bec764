"""Write numbers and arrays as Python literals that read back exactly."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np

__all__ = ["array_text", "complex_text", "template_text"]

TEMPLATES_FOLDER = Path(__file__).parents[1] / "templates"  # templates/<language>/<group>/<name>.txt


def template_text(name: str) -> str:
    """A part of the scripts as it stands in its file, with the functions of the library that it asks for (`#: name`)."""
    return re.sub(r"^#: (\w+)$", lambda asked: _library()[asked[1]], _file(name), flags=re.M)


def _file(name: str) -> str:
    language, _, matlab = name.partition("_") if name.startswith("matlab_") else ("python", "", name)
    (path,) = TEMPLATES_FOLDER.glob(f"{language}/*/{matlab}.txt")
    return path.read_text(encoding="utf-8").rstrip()


@cache
def _library() -> dict[str, str]:
    """What several parts call, by name."""
    return {block.split("(", 1)[0].split()[-1]: block.rstrip() for block in re.split(r"\n(?=def )", _file("library"))}


def array_text(name: str, value: object, note: str = "") -> str:
    """An assignment that reads back exactly, a row of a matrix a line."""
    array = np.asarray(value, dtype=float)
    if array.ndim < 2 or not array.size:
        body = f"np.zeros({array.shape})" if not array.size else _numbers(array.tolist())
        return f"{name} = np.array({body})" + (f"  # {note}" if note else "") if array.size else f"{name} = {body}"
    rows = f",\n{' ' * (len(name) + 13)}".join(map(_numbers, array.tolist()))
    return (f"# {note}\n" if note else "") + f"{name} = np.array([{rows}])"


def _numbers(row: object) -> str:
    """A list of numbers as Python reads it; `nan` and `inf` are names of numpy's."""
    return re.sub(r"\b(nan|inf)\b", r"np.\1", repr(row))


def complex_text(poles: Iterable[complex]) -> str:
    """A set of poles."""
    return "[" + ", ".join(repr(complex(p)) if p.imag else repr(float(p.real)) for p in poles) + "]"
