"""The gate for a plant: ours, python-control's or SciPy's, neither of them loaded, or its matrices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import as_matrix, described
from ..errors import EngineError
from ..fractions import Fraction, realised_by_entries, zeros_and_poles
from ..plant import Plant
from .array_checks import matrix
from .checked_calls import Gate, Sizes

__all__ = ["CONTROLLER", "DRIVEN", "PLANT", "SEEN", "PlantGate", "fractions_of", "period_of", "plant_like"]


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


def plant_like(value: Any) -> Plant | None:
    """The plant that a system is: ours, python-control's StateSpace or TransferFunction, SciPy's lti or dlti; None for the rest.

    A transfer function with several inputs or outputs is realised entry by entry, which need not be minimal. Raises EngineError
    for a sampled system whose period is not known, and for a transfer function with more zeros than poles.
    """
    if isinstance(value, Plant):
        return value
    library = type(value).__module__.split(".")[0]
    if library == "control" and type(value).__name__ in ("StateSpace", "TransferFunction"):
        return _of_control(value)
    if library == "scipy" and ".signal" in type(value).__module__ and hasattr(value, "to_ss"):
        return _of_scipy(value)
    return None


def _of_control(system: Any) -> Plant:
    if type(system).__name__ == "TransferFunction":
        return realised_by_entries(fractions_of(system), period_of(system))
    return Plant(*(np.asarray(getattr(system, key)) for key in "ABCD"), dt=period_of(system))


def _of_scipy(system: Any) -> Plant:
    if hasattr(system, "A"):
        return Plant(system.A, system.B, system.C, system.D, period_of(system))
    return realised_by_entries(fractions_of(system), period_of(system))


def period_of(system: Any) -> float:
    """The sampling period of a library's system, 0 for continuous time. Raises EngineError where it is unknown."""
    if system.dt is True:
        raise EngineError("The sampling period is unspecified (dt=True); give it in seconds.")
    return float(system.dt or 0.0)


def fractions_of(system: Any) -> list[list[Fraction]]:
    """Numerators and denominators (p×m) of a transfer function of python-control or SciPy, zeros and poles included."""
    if type(system).__module__.split(".")[0] == "control":
        given = (system.num_list, system.den_list) if hasattr(system, "num_list") else (system.num, system.den)  # before control 0.10.2
        return [[(np.asarray(num, dtype=float), np.asarray(den, dtype=float)) for num, den in zip(nums, dens, strict=True)]
                for nums, dens in zip(*given, strict=True)]
    if hasattr(system, "zeros") and hasattr(system, "gain"):
        return [[zeros_and_poles(np.atleast_1d(system.zeros), np.atleast_1d(system.poles), float(system.gain))]]
    return [[(np.asarray(row, dtype=float), np.asarray(system.den, dtype=float))] for row in np.atleast_2d(system.num)]
