"""Convert plants from and to JSON, .mat files and python-control, with names and units.

A file comes from a stranger: its size, depth, shapes and kinds are checked before anything is built from it.
"""

from __future__ import annotations

import json
import os
import re
from collections import Counter
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from scipy.io import savemat

from .arrays import as_matrix
from .errors import EngineError, phrase
from .file_checks import MAX_BYTES, MAX_STATES, bytes_of, full, kind_of, number, parse, rows, text_of
from .matfile import read_mat
from .plant import Plant

if TYPE_CHECKING:
    import control  # imported where it is used: it takes a second to load

__all__ = ["from_control", "from_json", "from_mat", "load_plant", "read_matrix", "read_plant", "to_control", "to_json", "to_mat"]

MAX_SIGNALS, MAX_NAME = 16, 100
_FORMAT = "observer-lab plant"
_MATRICES = ("A", "B", "C", "D")
_NAMES = ("states", "inputs", "outputs")


def _bounded(plant: Plant) -> Plant:
    if not 1 <= plant.n <= MAX_STATES:
        raise EngineError("A plant needs 1 to {max_states} states; this one has {n}.",
                          max_states=MAX_STATES, n=plant.n)
    if not (1 <= plant.m <= MAX_SIGNALS and 1 <= plant.p <= MAX_SIGNALS):
        raise EngineError("A plant needs 1 to {max_signals} inputs and outputs; this one has {m} and {p}.",
                          max_signals=MAX_SIGNALS, m=plant.m, p=plant.p)
    return plant


def _word(value: object, what: str) -> str:
    if not isinstance(value, str) or len(value) > MAX_NAME or not value.isprintable():
        raise EngineError("{what} must be plain text of at most {max_name} characters.",
                          what=what, max_name=MAX_NAME)
    return value


def _words(value: object, what: str) -> tuple[str, ...]:
    if not isinstance(value, list) or len(value) > MAX_STATES:
        raise EngineError("{what} must be a list of at most {max_states} names.", what=what, max_states=MAX_STATES)
    return tuple(_word(item, phrase("Each name in {what}", what=what)) for item in value)


def _units(value: object) -> tuple[tuple[str, str], ...]:
    if not isinstance(value, dict) or len(value) > MAX_STATES + 2 * MAX_SIGNALS:
        raise EngineError("units must be an object that maps a signal name to its unit.")
    return tuple((_word(k, phrase("A unit's signal")), _word(v, phrase("A unit"))) for k, v in value.items())


def _labels(plant: Plant) -> dict[str, Any]:
    return {"name": plant.name, "states": list(plant.state_names), "inputs": list(plant.input_names),
            "outputs": list(plant.output_names), "units": dict(plant.units)}


def _build(matrices: dict[str, Any], dt: float, labels: dict[str, Any]) -> Plant:
    missing = [key for key in "ABC" if matrices.get(key) is None]
    if missing:
        raise EngineError("The file has no matrix {missing}; a plant needs A, B and C (D may be left out).",
                          missing=missing[0])
    states, inputs, outputs = (_words(labels.get(key, []), key) for key in _NAMES)
    name, units = _word(labels.get("name", ""), "name"), _units(labels.get("units", {}))
    matrix = [matrices.get(key) for key in _MATRICES]
    return _bounded(Plant(*matrix, dt, states, inputs, outputs, units, name))  # type: ignore[arg-type]


def to_json(plant: Plant) -> str:
    """The plant as JSON text; floats are written so that they read back exactly.

    Keys: format, version, name, dt (s), A, B, C, D (lists of rows), states, inputs, outputs, units.
    Raises EngineError beyond 30 states or 16 inputs or outputs, or without states.

    >>> from_json(to_json(Plant([[-1]], [[1]], [[1]]))).n
    1
    """
    _bounded(plant)
    matrices = {key: getattr(plant, key).tolist() for key in _MATRICES}
    return json.dumps({"format": _FORMAT, "version": 1, "dt": plant.dt, **matrices, **_labels(plant)},
                      ensure_ascii=False)


def from_json(text: str) -> Plant:
    """A plant from `to_json`'s text, or from any object with A, B, C and optionally the other keys.

    Raises EngineError for text above 1 MB, not JSON, of another format or version, or with anything but finite
    numbers in the matrices; ShapeError where the shapes disagree.

    >>> from_json(to_json(Plant([[-1]], [[1]], [[1]]))).A
    array([[-1.]])
    """
    data = parse(text)
    if data.get("format", _FORMAT) != _FORMAT or data.get("version", 1) != 1:
        raise EngineError("This JSON is not a plant of version 1; leave out its keys \"format\" and \"version\", or write "
                          "\"{format}\" and 1.", format=_FORMAT)
    matrices = {key: rows(data[key], key) for key in _MATRICES if data.get(key) is not None}
    return _build(matrices, number(data.get("dt", 0.0), "dt"), data)


def to_mat(plant: Plant, path: str | os.PathLike[str] | IO[bytes]) -> None:
    """Write a MATLAB 5 file with A, B, C, D, Ts (s, 0 for continuous time) and `labels`.

    In MATLAB: sys = ss(A, B, C, D, Ts), and jsondecode(labels) gives names and units.
    Raises EngineError beyond 30 states or 16 inputs or outputs, or without states.

    >>> import io
    >>> file = io.BytesIO()
    >>> to_mat(Plant([[-1]], [[1]], [[1]]), file)
    >>> from_mat(file.getvalue()).n
    1
    """
    _bounded(plant)
    labels = json.dumps(_labels(plant))
    target = path if hasattr(path, "write") else os.fspath(path)  # type: ignore[arg-type]
    savemat(target, {**{key: getattr(plant, key) for key in _MATRICES}, "Ts": plant.dt, "labels": labels},
            appendmat=False, do_compression=True)


def from_mat(source: str | os.PathLike[str] | bytes) -> Plant:
    """A plant from a .mat file (a path or its bytes) with the variables A, B, C, optionally D, Ts or dt, labels.

    Raises EngineError for files above 1 MB packed or unpacked, unreadable, of version 7.3, or with anything but
    full real matrices; ShapeError where the shapes disagree.

    >>> import io
    >>> file = io.BytesIO()
    >>> to_mat(Plant([[-1]], [[1]], [[1]]), file)
    >>> from_mat(file.getvalue()).A
    array([[-1.]])
    """
    found = read_mat(bytes_of(source), MAX_BYTES)
    period = [full(found, key) for key in ("Ts", "dt") if key in found][:1] or [np.zeros((1, 1))]
    if period[0].size != 1:
        raise EngineError("Ts must be one number: the sampling period in seconds, or 0.")
    labels = found.get("labels")
    matrices = {key: full(found, key) for key in _MATRICES if key in found}
    return _build(matrices, float(period[0].item()), parse(labels) if isinstance(labels, str) else {})


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


def read_plant(name: str, data: bytes) -> Plant:
    """A plant from the bytes of a file of that name, as `load_plant` reads it."""
    return from_mat(data) if kind_of(name) == ".mat" else from_json(text_of(data))


def read_matrix(name: str, data: bytes, key: str) -> np.ndarray | None:
    """A further matrix in the file of a plant, at most 30×30, None where there is none; gated as `read_plant` gates A.

    >>> read_matrix("plant.json", b'{"F": [[2]]}', "F")
    array([[2.]])
    """
    mat = kind_of(name) == ".mat"
    found = read_mat(bytes_of(data), MAX_BYTES) if mat else parse(text_of(data))
    if found.get(key) is None and not (mat and key in found):
        return None
    return as_matrix(full(found, key) if mat else rows(found[key], key), key)


def to_control(plant: Plant) -> control.StateSpace:
    """The plant as control.StateSpace, with names and dt; units ride along in the attribute `units`.

    A dot is not allowed in python-control's system names and becomes an underscore.
    Raises EngineError when two signals of one kind share a name, which python-control would merge.

    >>> to_control(Plant([[-1]], [[1]], [[1]])).nstates
    1
    """
    from control import StateSpace

    for names in (plant.state_names, plant.input_names, plant.output_names):
        twice = [name for name, count in Counter(names).items() if count > 1]
        if twice:
            raise EngineError("Two signals are called {twice}; give each its own name.", twice=twice[0])
    system = StateSpace(plant.A, plant.B, plant.C, plant.D, plant.dt, states=list(plant.state_names),
                        inputs=list(plant.input_names), outputs=list(plant.output_names),
                        name=plant.name.replace(".", "_") or None)
    system.units = dict(plant.units)  # type: ignore[attr-defined]
    return system


def from_control(system: control.StateSpace) -> Plant:
    """The plant of a control.StateSpace; its default names (x[0], sys[3]) become the lab's own.

    Raises EngineError for anything but a StateSpace, for dt=True (period unknown), and beyond the bounds.

    >>> import control
    >>> from_control(control.ss([[-1]], [[1]], [[1]], [[0]])).A
    array([[-1.]])
    """
    from control import StateSpace

    if not isinstance(system, StateSpace):
        raise EngineError("Only a control.StateSpace can be taken over; convert the system with control.ss first.")
    if system.dt is True:
        raise EngineError("The sampling period is unspecified (dt=True); give it in seconds.")

    def given(labels: list[str], letter: str) -> tuple[str, ...]:
        return () if labels == [f"{letter}[{i}]" for i in range(len(labels))] else tuple(labels)

    name = str(system.name or "")
    A, B, C, D = (np.asarray(getattr(system, key)) for key in _MATRICES)
    return _bounded(Plant(
        A, B, C, D, float(system.dt or 0.0), given(system.state_labels, "x"), given(system.input_labels, "u"),
        given(system.output_labels, "y"), tuple(dict(getattr(system, "units", {})).items()),
        "" if re.fullmatch(r"sys\[\d+\]", name) else name))
