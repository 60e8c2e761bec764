"""Read the example plants in `data` as user files are read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from types import MappingProxyType

from ..text import Text, listed, same, text
from .own_plant import UnsuitablePlant, read_plant_file

__all__ = ["EXAMPLES", "Example", "example"]

DATA = files("observer_lab.plants") / "data"


@dataclass(frozen=True)
class Example:
    """A plant in a file, and what it is called."""

    file: str
    label: Text


EXAMPLES: Mapping[str, Example] = MappingProxyType({
    "aircraft": Example("aircraft.json", text("Aircraft, lateral motion")),
    "motor": Example("motor.json", text("Motor with a flexible shaft")),
    "tanks": Example("tanks.json", text("Four tanks")),
    "pendulum": Example("pendulum.json", text("Inverted pendulum, sampled")),
    "beam": Example("beam.mat", text("Flexible beam, 16 states")),
    "exchanger": Example("exchanger.json", text("Heat exchanger, bilinear")),
})


@lru_cache(maxsize=8)
def example(name: str) -> str:
    """The canonical text of an example plant. Raises Misfit naming those there are."""
    if name not in EXAMPLES:
        raise UnsuitablePlant(text("There is no example plant {name}; there are {names}.", name=name[:40],
                          names=listed(same(key) for key in EXAMPLES)))
    file = EXAMPLES[name].file
    return read_plant_file(file, (DATA / file).read_bytes())
