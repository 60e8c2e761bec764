"""Write plants to JSON and to MATLAB .mat files, so that they read back exactly."""

from __future__ import annotations

import json
import os
from typing import IO

from scipy.io import savemat

from ..systems.errors import EngineError
from ..systems.gates.argument_checks import Sizes, instance, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from .build import bounded
from .labels import as_text, labels_record
from .notes import coded

__all__ = ["to_json", "to_mat"]

_FORMAT = "observer-lab plant"
_MATRICES = ("A", "B", "C", "D")
_PATH = instance(str, bytes, os.PathLike)


def _target(value: object, name: str, sizes: Sizes) -> object:
    return value if hasattr(value, "write") else _PATH(value, name, sizes)


@takes(plant=PLANT)
def to_json(plant: Plant) -> str:
    """The plant as JSON text; floats are written so that they read back exactly.

    Keys: format, version, name, dt (s), A, B, C, D (lists of rows), states, inputs, outputs, units, and changes where there are notes.
    Raises EngineError beyond 200 states or 16 inputs or outputs, or without states.

    >>> from_json(to_json(Plant([[-1]], [[1]], [[1]]))).n
    1
    """
    bounded(plant)
    matrices = {key: getattr(plant, key).tolist() for key in _MATRICES}
    changes = {"changes": coded(plant.notes)} if plant.notes else {}
    return json.dumps({"format": _FORMAT, "version": 1, "dt": plant.dt, **matrices, **labels_record(plant), **changes},
                      ensure_ascii=False)


@takes(plant=PLANT, path=_target)
def to_mat(plant: Plant, path: str | os.PathLike[str] | IO[bytes]) -> None:
    """Write a MATLAB 5 file with A, B, C, D, Ts (s, 0 for continuous time) and `labels`.

    In MATLAB: sys = ss(A, B, C, D, Ts), and jsondecode(labels) gives names and units.
    Raises EngineError beyond 200 states or 16 inputs or outputs, or without states.

    >>> import io
    >>> file = io.BytesIO()
    >>> to_mat(Plant([[-1]], [[1]], [[1]]), file)
    >>> from_mat(file.getvalue()).n
    1
    """
    bounded(plant)
    target = path if hasattr(path, "write") else os.fspath(path)  # type: ignore[arg-type]
    try:
        savemat(target, {**{key: getattr(plant, key) for key in _MATRICES}, "Ts": plant.dt, "labels": as_text(plant)},
                appendmat=False, do_compression=True)
    except OSError as problem:
        raise EngineError("The file {name} cannot be written; check its name and place.", name=str(path)) from problem
