"""The five plants of the lesson: a motion hidden from the sensor or from the force, and one that is not hidden."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from app.engine import controllability, kalman_decomposition, observability
from app.engine.structure import Controllability, KalmanDecomposition, Observability
from app.plants import two_mass
from app.plants.chain_body import chain_body
from app.plants.model import Model
from app.text.words import Text

COMMON = np.kron(np.eye(2), np.array([[1.0, 1.0]])) / np.sqrt(2)  # both blocks alike: position and velocity, 2×4
RELATIVE = np.kron(np.eye(2), np.array([[-1.0, 1.0]])) / np.sqrt(2)  # one against the other, 2×4


@dataclass(frozen=True, eq=False)
class Case:
    """One plant with all that can be known before a gain is chosen."""

    id: str
    label: Text
    model: Model
    seen: Observability
    reached: Controllability
    decomposition: KalmanDecomposition

    @property
    def unseen(self) -> tuple[complex, ...]:
        """Poles of the observer that no L moves."""
        return self.seen.unobservable

    @property
    def unmoved(self) -> tuple[complex, ...]:
        """Poles of the controller that no K moves."""
        return self.reached.uncontrollable


def _case(name: str, label: Text, model: Model) -> Case:
    plant = model.plant
    return Case(name, label, model, observability(plant), controllability(plant), kalman_decomposition(plant))


def _visible() -> Model:
    """The chain between magnets with sensor and force on the left block: as unstable as before, and nothing hidden."""
    model, held = two_mass.HIDDEN["unseen-unstable"].model, two_mass.DEPARTS
    return replace(model, id="two-mass-visible", plant=two_mass.plant(held, "first", "first"),
                   body=chain_body(held.left, held.right, two_mass.ACTUATORS["first"]))


_LABELS = MappingProxyType({
    "unseen-unstable": Text("distance sensor, magnets", "间距传感器，磁铁"),
    "unseen-stable": Text("distance sensor, soft springs", "间距传感器，软弹簧"),
    "unmoved-unstable": Text("force between blocks, magnets", "滑块间内力，磁铁"),
    "unmoved-stable": Text("force between blocks, soft springs", "滑块间内力，软弹簧"),
    "visible": Text("sensor and force on one block, magnets", "传感器与力在同一滑块，磁铁"),
})
CASES: Mapping[str, Case] = MappingProxyType({
    name: _case(name, label, _visible() if name == "visible" else two_mass.HIDDEN[name].model)  # type: ignore[index]
    for name, label in _LABELS.items()})
UNSEEN, UNMOVED = ("unseen-unstable", "unseen-stable"), ("unmoved-unstable", "unmoved-stable")
