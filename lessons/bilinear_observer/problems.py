"""Define four problems on one plant, one for each possible outcome of the design."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from observer_lab.colours import COLOURS
from observer_lab.engine import BilinearPlant, bilinear_functional_observer
from observer_lab.engine.observers import BilinearObserver
from observer_lab.plants import bilinear as example
from observer_lab.plants.bodies.body import PLANT_COLOUR, Body
from observer_lab.plants.bodies.front_bars import Bar, decade_marks, with_bars
from observer_lab.plants.bodies.gauge_body import gauge_body, named_high
from observer_lab.text import Text, text

PAPER_PROBLEM, THREE_SENSORS, FITTING_SENSORS, NO_SOLUTION = "paper", "three", "three-fitting", "stuck"

LOW, HIGH = -12, 4  # decades of the bars on the stage
PLINTH_HIGH = 0.26  # stage units that the gauges stand above the floor, so that no bar hides a foot
BARS = (Bar(text("input |u|"), COLOURS["force"]), Bar(text("wanted |g|"), PLANT_COLOUR), Bar(text("error |ĝ − g|"), COLOURS["error"]))


@dataclass(frozen=True, eq=False)
class Problem:
    """Which states are measured (from 0), what is wanted, the body, and the eight steps for the pole −30."""

    id: str
    label: Text
    measured: tuple[int, ...]
    plant: BilinearPlant
    K: np.ndarray
    body: Body
    solved: BilinearObserver

    def observer(self, pole: float) -> BilinearObserver:
        """The eight steps for another pole."""
        if pole == example.POLE:
            return self.solved
        return bilinear_functional_observer(self.plant.A, self.plant.B, self.plant.F, self.plant.C, self.K, pole)


def _problem(name: str, label: Text, measured: tuple[int, ...], K: np.ndarray) -> Problem:
    plant = example.with_sensors(measured)
    solved = bilinear_functional_observer(plant.A, plant.B, plant.F, plant.C, K, example.POLE)
    body = with_bars(named_high(gauge_body(plant.n, measured)), plant.n + 1, BARS, decade_marks(LOW, HIGH, 4), up=PLINTH_HIGH)
    return Problem(name, label, measured, plant, K, body, solved)


def _fitting() -> np.ndarray:
    """K = (1, 2, 3, ·, 5, ·) that three sensors allow: measured states may be added to it at will."""
    row, _ = example.fitting_functional(example.with_sensors((0, 1, 2)), example.POLE)
    row = row * 5 / row[0, 4]
    row[0, :3] = 1, 2, 3
    row.setflags(write=False)
    return row


PROBLEMS: Mapping[str, Problem] = MappingProxyType({p.id: p for p in (
    _problem(PAPER_PROBLEM, text("as in the paper: x₁ … x₄ measured"), (0, 1, 2, 3), example.WANTED_ROW),
    _problem(THREE_SENSORS, text("only x₁, x₂, x₃ measured"), (0, 1, 2), example.WANTED_ROW),
    _problem(FITTING_SENSORS, text("x₁, x₂, x₃ measured, another K"), (0, 1, 2), _fitting()),
    _problem(NO_SOLUTION, text("x₁, x₃, x₅, x₆ measured"), (0, 2, 4, 5), example.WANTED_ROW),
)})


def nearest_gain(observer: BilinearObserver) -> np.ndarray:
    """L of least squares: what comes nearest to condition (20) where no L meets it."""
    return observer.right @ np.linalg.pinv(observer.Q)


COMPUTED_GAIN, AS_PRINTED, TYPED_GAIN, ROUNDED_GAIN = "computed", "printed", "typed", "rounded"
