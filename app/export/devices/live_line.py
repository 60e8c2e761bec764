"""Write the header by which a device names the columns of its lines."""

from __future__ import annotations

from ...devices import Routine
from .words import identifier

__all__ = ["column_names", "header_line"]


def column_names(routine: Routine) -> list[str]:
    """The columns of a line: the time, every input, every reading."""
    taken: set[str] = set()
    inputs, readings = ([identifier(name, taken) for name in names] for names in (routine.u_names, routine.y_names))
    return ["t", *(f"u:{name}" for name in inputs), *(f"y:{name}" for name in readings)]


def header_line(routine: Routine) -> str:
    """The comment line that names the columns, as in `# t,u:force,y:angle`."""
    return "# " + ",".join(column_names(routine))
