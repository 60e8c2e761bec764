"""Read plants from files: JSON, MATLAB's -v4, -v6 and -v7, Octave's text.

A file comes from a stranger and is checked first.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from ..systems.errors import EngineError
from ..systems.gates.argument_checks import NAME, instance, takes
from ..systems.plant import Plant
from .build import Content, built
from .found import Found
from .input_gate import MAX_BYTES, Entry, bytes_of, kind_of, parse, text_of
from .labels import spread
from .mat_level4 import is_level4, read_level4
from .mat_level5 import read_level5
from .octave_text import is_octave_text, read_octave_text

__all__ = ["from_json", "from_mat", "load_plant", "read_content", "read_plant"]

_PLANT_KEYS = frozenset(["A", "a", "num", "den", "Numerator", "Denominator", "numerator", "denominator"])
_PACKED, _OCTAVE_BINARY, _HDF = b"\x1f\x8b", b"Octave-1-", b"\x89HDF"


@takes(text=NAME)
def from_json(text: str) -> Plant:
    """A plant from `to_json`'s text, or from any object with A, B, C or with a transfer function; `Plant.notes` says what was done to it.

    Raises EngineError for text above 1 MB, not JSON, of another format or version, with a key that is not known, or with anything
    but finite numbers in the matrices; ShapeError where the shapes disagree.

    >>> from_json('{"A": [[-1]], "B": [[1]], "C": [[1]], "Ts": 0.1}').dt
    0.1
    """
    return _of_json(text).plant


@takes(source=instance(str, os.PathLike, bytes))
def from_mat(source: str | os.PathLike[str] | bytes) -> Plant:
    """A plant from a .mat file (a path or its bytes): variables A, B, C or num and den, or one struct with them; E, Ts, D, delays, names.

    Other variables are named in `Plant.notes`. Raises EngineError for files above 1 MB packed or unpacked, unreadable, of version
    7.3, with objects alone, or with anything but real matrices; ShapeError where the shapes disagree.

    >>> import io
    >>> file = io.BytesIO()
    >>> to_mat(Plant([[-1]], [[1]], [[1]]), file)
    >>> from_mat(file.getvalue()).A
    array([[-1.]])
    """
    return _of_mat(bytes_of(source)).plant


@takes(path=instance(str, os.PathLike))
def load_plant(path: str | os.PathLike[str]) -> Plant:
    """A plant from a file, by its suffix: .json or .mat. Raises EngineError for any other, and as they do.

    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "plant.json"
    >>> _ = path.write_text(to_json(Plant([[-1]], [[1]], [[1]])))
    >>> load_plant(path).A
    array([[-1.]])
    """
    kind_of(Path(path).name)
    return read_plant(Path(path).name, bytes_of(path))


@takes(name=NAME, data=instance(bytes))
def read_plant(name: str, data: bytes) -> Plant:
    """A plant from the bytes of a file of that name, as `load_plant` reads it."""
    return read_content(name, data).plant


@takes(name=NAME, data=instance(bytes))
def read_content(name: str, data: bytes) -> Content:
    """The same with what else the file says of a bilinear plant: F, F1, … and K."""
    kind = kind_of(name)
    data = bytes_of(data)
    if kind == ".mat" or _is_mat(data):
        return _of_mat(data)
    return _of_json(text_of(data))


def _is_mat(data: bytes) -> bool:
    """Whether a file is one of MATLAB or Octave whatever its name says."""
    return data[126:128] in (b"IM", b"MI") or is_octave_text(data)


def _of_json(text: str) -> Content:
    return built(Found(_inside(parse(text)), workspace=False))


def _of_mat(data: bytes) -> Content:
    return built(Found(spread(_inside(_variables(data)), parse), workspace=True))


def _variables(data: bytes) -> dict[str, Entry]:
    if is_octave_text(data):
        return read_octave_text(text_of(data))
    if data.startswith(_HDF):
        raise EngineError("This .mat file is of version 7.3; save it in MATLAB with the option -v7.")
    if data.startswith((_OCTAVE_BINARY, _PACKED)):
        raise EngineError("This is one of Octave's packed or binary files; save it in Octave with the option -v7.")
    if is_level4(data):
        return read_level4(data)
    return read_level5(data, MAX_BYTES)


def _inside(entries: dict[str, Entry]) -> dict[str, Entry]:
    """The fields of the one struct that holds the plant, where the file itself has no matrices. Raises EngineError where two do."""
    if any(entries.get(key) is not None for key in _PLANT_KEYS):
        return entries
    structs = {name: value for name, value in entries.items() if isinstance(value, Mapping) and any(key in value for key in _PLANT_KEYS)}
    if not structs:
        return entries
    if len(structs) > 1:
        raise EngineError("The file holds several plants, {names}; keep one of them.", names=", ".join(structs)[:100])
    name, fields = next(iter(structs.items()))
    return {**{key: value for key, value in entries.items() if key != name and key not in fields}, **fields}
