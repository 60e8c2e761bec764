"""Define four problems on one plant, one for each possible outcome of the design."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from observer_lab.colours import COLOURS
from observer_lab.engine import BilinearPlant, bilinear_functional_observer
from observer_lab.engine.observers import BilinearObserver
from observer_lab.plants import bilinear as example
from observer_lab.plants.bodies.body import PLANT_COLOUR, Body
from observer_lab.plants.bodies.front_bars import Bar, decade_marks, with_bars
from observer_lab.plants.bodies.gauge_body import free_space, gauge_body
from observer_lab.plants.bodies.term_pipes import with_lag_pipe, with_pipes
from observer_lab.text import Text, text

PAPER_PROBLEM, THREE_SENSORS, FITTING_SENSORS, NO_SOLUTION = "paper", "three", "three-fitting", "stuck"

LOW, HIGH = -12, 4  # decades of the bars on the stage
PLINTH_HIGH, BEHIND = 0.26, 0.5  # stage units that the gauges stand up and back, so that no bar hides a foot
BARS = (Bar(text("wanted |g|"), PLANT_COLOUR), Bar(text("error |ĝ − g|"), COLOURS["error"]))
ROOM, LARGE_AT = (-2.1, -0.3), 1.5  # of the small gauges, and where the large one stands: pipes run in the free space between them
TERMS = ("F T₂", "A T₃", "F T₃")  # unknown terms of the error
LAG_FULL = 8.0  # missed by the differentiator where its pipe has the cross-section of share one
LAG_BARS, LAG_ERROR = BARS[1:], 0.2  # the bar before the pipe of a lag, and the error at its end
LAG_MARKS = (("0", 0.0), ("0.1", 0.5), ("0.2", 1.0))


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
    return Problem(name, label, measured, plant, K, _behind_bars(gauge_body(plant.n, measured, ROOM, LARGE_AT), plant.n + 1), solved)


def _behind_bars(body: Body, states: int) -> Body:
    return with_bars(body, states, BARS, decade_marks(LOW, HIGH, 4), BEHIND, PLINTH_HIGH, decades=(LOW, HIGH))


def unknown_terms(o: BilinearObserver, L: np.ndarray) -> np.ndarray:
    """Sizes (2, 3) of V₂ and of V₂ − L V₁ times F T₂, A T₃ and F T₃."""
    F = o.plant.F[0] if np.ndim(o.plant.F) == 3 else o.plant.F
    blocks = (F @ o.T[1], o.plant.A @ o.T[2], F @ o.T[2])
    return np.array([[np.linalg.norm(row @ block) for block in blocks] for row in (o.V[1], o.V[1] - L @ o.V[0])])


@lru_cache(maxsize=4)
def piped_body(problem: str) -> Body:
    """The gauges with a pipe for each unknown term."""
    p = PROBLEMS[problem]
    alone = unknown_terms(p.solved, np.zeros((1, p.plant.m)))[0]
    n = p.plant.n + 1
    body = with_pipes(gauge_body(p.plant.n, p.measured, ROOM, LARGE_AT), n, tuple(zip(TERMS, alone / alone.max(), strict=True)),
                      free_space(p.plant.n, p.measured, ROOM, LARGE_AT))
    return _behind_bars(body, n + len(TERMS))


@lru_cache(maxsize=4)
def lag_body(problem: str) -> Body:
    """The gauges with the pipe of what a differentiator misses, behind a bar of the error on an even scale."""
    p = PROBLEMS[problem]
    n = p.plant.n + 1
    body = with_lag_pipe(gauge_body(p.plant.n, p.measured, ROOM, LARGE_AT), n, (text("lag of ẏ"), text("L · lag")), LAG_FULL,
                         free_space(p.plant.n, p.measured, ROOM, LARGE_AT))
    return with_bars(body, n + 2, LAG_BARS, LAG_MARKS, BEHIND, PLINTH_HIGH, full=LAG_ERROR)


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
