"""Plants from and to files and libraries; plants made smaller."""

from ..systems.gates.room_gates import with_gates
from .build import Content
from .libraries import from_control, from_scipy, to_control
from .reading import from_json, from_mat, load_plant, read_content, read_plant
from .reduction import reduced_to
from .writing import to_json, to_mat

__all__ = [
    "Content",
    "from_control",
    "from_json",
    "from_mat",
    "from_scipy",
    "load_plant",
    "read_content",
    "read_plant",
    "reduced_to",
    "to_control",
    "to_json",
    "to_mat",
]

with_gates(globals())
