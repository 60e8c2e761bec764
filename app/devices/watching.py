"""Turn a routine that drives into one that is told the input that acts on the plant."""

from __future__ import annotations

from dataclasses import replace

from ..text import text
from . import kalman, observer
from .routine import Routine
from .sampling import DeviceError

__all__ = ["watching"]

NOTHING_TO_WATCH = text("This design is a controller without an estimate of the plant's state, so there is nothing to compare "
                        "with a plant.")


def watching(routine: Routine) -> Routine:
    """The same observer, its feedback left out: u is given. Raises DeviceError for a controller without an estimate."""
    if not routine.drives:
        return routine
    if "xnext" not in routine.lengths:
        raise DeviceError(NOTHING_TO_WATCH)
    source = routine.source.replace("asked[j]", "u[j]")
    for part in (observer.FEEDBACK, observer.CLIP, kalman.FEEDBACK, kalman.CLIP):
        source = source.replace(part.strip() + "\n", "")
    dropped = {"K", "u_min", "u_max"}
    return replace(routine, source=source, drives=False, constants=tuple(each for each in routine.constants if each.name not in dropped),
                   states=tuple(each for each in routine.states if each.name != "r"),
                   scratch={name: size for name, size in routine.scratch.items() if name != "asked"},
                   watched=tuple(name for name in routine.watched if name != "u"))
