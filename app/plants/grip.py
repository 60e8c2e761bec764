"""Define where a hand can take hold of a plant, and what its force does there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..text import Text
from .bodies.body import Vector


@dataclass(frozen=True)
class Grip:
    """One place of a plant that a hand can pull.

    `knob` names the record of the hand in a design; `parts` are the parts of the body that can be taken hold of, `at(x, gain)`
    is the point that is pulled and `along` the unit vector of its force, both in stage units. `push` (n,) is how fast the state
    changes for one `unit` of force, `most` the largest force of a hand. `label` says what is pulled.
    """

    knob: str
    label: Text
    parts: tuple[str, ...]
    at: Callable[[Sequence[float], float], Vector]
    along: Vector
    push: tuple[float, ...]
    most: float
    unit: str = "N"
