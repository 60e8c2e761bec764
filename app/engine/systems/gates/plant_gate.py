"""The gate for a plant: ours, python-control's or SciPy's, or its matrices one after another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import as_matrix, described
from ..errors import EngineError
from ..libraries import plant_like
from ..plant import Plant
from .array_checks import matrix
from .checked_calls import Gate, Sizes

__all__ = ["CONTROLLER", "DRIVEN", "PLANT", "SEEN", "PlantGate"]


@dataclass(frozen=True)
class PlantGate:
    """A plant, whose n, m, p other arguments must agree with; `letters` are the matrices that may stand in its place."""

    letters: str

    def __call__(self, value: object, name: str, sizes: Sizes) -> Plant:
        plant = plant_like(value)
        if plant is None:
            raise EngineError("{name} must be a {kind}; {given} was given.", name=name, kind="Plant", given=described(value))
        for letter in "nmp":
            sizes.setdefault(letter, getattr(plant, letter))
        return plant

    def of_matrices(self, given: Sequence[object]) -> Plant:
        """The plant of its matrices in the order of `letters`; what is not asked for is zero, with one column or row."""
        found = {letter: as_matrix(value, letter) for letter, value in zip(self.letters, given, strict=False)}
        n = len(found["A"])
        return Plant(found["A"], found.get("B", np.zeros((n, 1))), found.get("C", np.zeros((1, n))), found.get("D"))  # type: ignore[arg-type]


PLANT = PlantGate("ABCD")
DRIVEN = PlantGate("AB")  # what the question needs of the plant: how u drives x
SEEN = PlantGate("AC")  # how x is seen in y


def _controller(value: object, name: str, sizes: Sizes) -> Plant | np.ndarray:
    return PLANT(plant, name, sizes) if (plant := plant_like(value)) is not None else _GAIN(value, name, sizes)


_GAIN = matrix()
CONTROLLER: Gate = _controller  # a system, or a matrix of gains
