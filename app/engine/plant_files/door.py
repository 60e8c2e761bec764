"""The door of this room: what each of its calls takes from outside."""

from __future__ import annotations

import os

from ..systems.argument_checks import NAME, count, gated, instance
from ..systems.plant import Plant
from . import libraries, reading, writing
from .reduction import reduced_to as _reduced_to

_PLANT = instance(Plant)


def _target(value: object, name: str, sizes: dict[str, int]) -> object:
    return value if hasattr(value, "write") else instance(str, bytes, os.PathLike)(value, name, sizes)


from_control = libraries.from_control
from_scipy = libraries.from_scipy
from_json = gated(text=NAME)(reading.from_json)
from_mat = gated(source=instance(str, os.PathLike, bytes))(reading.from_mat)
load_plant = gated(path=instance(str, os.PathLike))(reading.load_plant)
read_content = gated(name=NAME, data=instance(bytes))(reading.read_content)
read_plant = gated(name=NAME, data=instance(bytes))(reading.read_plant)
reduced_to = gated(plant=_PLANT, most=count(1, 200))(_reduced_to)
to_control = gated(plant=_PLANT)(libraries.to_control)
to_json = gated(plant=_PLANT)(writing.to_json)
to_mat = gated(plant=_PLANT, path=_target)(writing.to_mat)
