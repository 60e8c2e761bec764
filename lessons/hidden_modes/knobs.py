"""Define the five plants of lesson 6, with or without a hidden motion, and the knobs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.knobs import Choice, Number, Poles
from observer_lab.engine import controllability, kalman_decomposition, observability
from observer_lab.engine.structure import Controllability, KalmanDecomposition, Observability
from observer_lab.plants import two_mass
from observer_lab.plants.bodies.chain_body import chain_body
from observer_lab.plants.model import Model
from observer_lab.text import Text, text

from ..toolkit.knobs import pull_knobs, run_knobs

COMMON = np.kron(np.eye(2), np.array([[1.0, 1.0]])) / np.sqrt(2)  # both blocks alike: position and velocity, 2×4
RELATIVE = np.kron(np.eye(2), np.array([[-1.0, 1.0]])) / np.sqrt(2)  # one against the other, 2×4

MOTION_GAIN = 6.0  # times that the stage exaggerates motion: what the sensor sees is a tenth of a metre


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
    plant, model = model.plant, replace(model, body=replace(model.body, gain=MOTION_GAIN))
    return Case(name, label, model, observability(plant), controllability(plant), kalman_decomposition(plant))


def _visible() -> Model:
    """The chain between magnets with sensor and force on the left block: as unstable as before, and nothing hidden."""
    model, held = two_mass.HIDDEN["unseen-unstable"].model, two_mass.DEPARTS
    return replace(model, id="two-mass-visible", plant=two_mass.plant(held, "first", "first"),
                   body=chain_body(held.left, held.right, two_mass.ACTUATORS["first"]))


_LABELS = MappingProxyType({
    "unseen-unstable": text("distance sensor, magnets"),
    "unseen-stable": text("distance sensor, soft springs"),
    "unmoved-unstable": text("force between blocks, magnets"),
    "unmoved-stable": text("force between blocks, soft springs"),
    "visible": text("sensor and force on one block, magnets"),
})
PLANT_CASES: Mapping[str, Case] = MappingProxyType({
    name: _case(name, label, _visible() if name == "visible" else two_mass.HIDDEN[name].model)  # type: ignore[index]
    for name, label in _LABELS.items()})
UNOBSERVABLE_CASES, UNCONTROLLABLE_CASES = ("unseen-unstable", "unseen-stable"), ("unmoved-unstable", "unmoved-stable")
FIRST_MODEL = PLANT_CASES["unseen-unstable"].model


def _poles(name: str, symbol: str, label: Text, default: tuple[complex, ...], role: str, plants: tuple[str, ...]) -> Poles:
    window = FIRST_MODEL.controller_window if role == "plant" else FIRST_MODEL.observer_window
    return Poles(name, symbol, label, "rad/s", default=default, re_low=window.re_low, re_high=window.re_high,
                 im_high=window.im_high, role=role, when=("plant", plants),
                 hint=text("Drag the crosses on the board; the bolts are not among these poles."))


SLOW_POLES, QUICK_POLES = (-0.9 - 1.2j, -0.9 + 1.2j), (-1.5 - 3j, -1.5 + 3j)
CALM_POLES, FAST_POLES = (-2.5 - 2j, -2.5 + 2j), (-3.5 - 4j, -3.5 + 4j)
KNOBS = (
    Choice("plant", "", text("setup"), default="unseen-unstable",
           options=tuple((case.id, case.label) for case in PLANT_CASES.values()),
           hint=text("The springs or magnets that hold the two blocks, the place of the sensor, and the place of the force.")),
    Number("centre", r"c_0", text("common part of the start"), "m", low=-0.3, high=0.3, default=0.06,
           step=0.01, hint=text("How far both blocks start to the same side. The observer starts from 0.")),
    _poles("controller_all", "p", text("Controller poles"), (*SLOW_POLES, *QUICK_POLES), "plant", (*UNOBSERVABLE_CASES, "visible")),
    _poles("controller_part", "p", text("Controller poles that move"), QUICK_POLES, "plant", UNCONTROLLABLE_CASES),
    _poles("observer_part", "q", text("Observer poles that move"), FAST_POLES, "estimate", UNOBSERVABLE_CASES),
    _poles("observer_all", "q", text("Observer poles"), (*CALM_POLES, *FAST_POLES), "estimate", (*UNCONTROLLABLE_CASES, "visible")),
    *run_knobs(FIRST_MODEL.horizon),
    *pull_knobs(FIRST_MODEL),
)
