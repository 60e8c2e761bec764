"""The records of the lesson: three simulated ones whose plant is known, and one that was measured."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.resources import files
from types import MappingProxyType

import numpy as np

from observer_lab.course.knobs import KnobError
from observer_lab.engine import Plant
from observer_lab.engine.identification import Record, RecordFit, read_record
from observer_lab.engine.systems import affine_scan, discretise
from observer_lab.text import text

from .knobs import FAULTY, FURNACE, MASSES, SPRING, TANKS

HELD, BEFORE = 5, 200  # samples that an input is held, and samples that run before the record begins
JUMP, JUMPING, BIAS = 0.5, 0.03, 0.1  # of a faulty sensor: its jumps, their share of the readings, its bias
FIRST_JUMP, FIRST_BIAS = 400, 640  # rows from which a faulty sensor jumps, and from which it has a bias


@dataclass(frozen=True, eq=False)
class Truth:
    """The plant behind a simulated record, sampled; standard deviations q of the input's noise and r of the sensor's."""

    plant: Plant
    rows: int
    q: float
    r: float

    @property
    def Q(self) -> np.ndarray:
        """Covariance of what the input's noise does to the states in one step."""
        return self.q**2 * self.plant.B @ self.plant.B.T

    @property
    def R(self) -> np.ndarray:
        """Covariance of the sensor's noise."""
        return self.r**2 * np.eye(self.plant.p)


@dataclass(frozen=True, eq=False)
class Given:
    """A record, and if it is simulated the output without sensor noise and the plant.

    `own` if a person brought it; `plant` if that person's plant is filtered, and not fitted; `opening`: the fit with the order that
    its singular values suggest, with which the lesson opens. jumps, bias: what a faulty sensor adds to the readings.
    """

    record: Record
    clean: np.ndarray | None = None
    truth: Truth | None = None
    own: bool = False
    plant: Plant | None = None
    opening: RecordFit | None = None
    jumps: np.ndarray | None = None
    bias: np.ndarray | None = None


def _plant(A: list[list[float]], B: list[float], C: list[float], dt: float) -> Plant:
    return discretise(Plant(A, [[b] for b in B], [C]), dt)


TRUTHS = MappingProxyType({
    SPRING: Truth(_plant([[0, 1], [-4, -0.8]], [0, 1], [1, 0], 0.1), 800, 0.5, 0.05),
    TANKS: Truth(_plant([[-0.5, 0], [0.3, -2]], [1, 0], [0, 1], 0.2), 1000, 0.5, 0.03),
    MASSES: Truth(_plant([[0, 0, 1, 0], [0, 0, 0, 1], [-20, 10, -0.6, 0.2], [10, -10, 0.2, -0.3]], [0, 0, 1, 0], [0, 1, 0, 0], 0.15),
                  1000, 0.5, 0.02),
})


@lru_cache(maxsize=16)
def record_of(data: str, seed: int) -> Given:
    """The record of that name; of a simulated one with the noise of that seed. Raises KnobError for a name that is none."""
    if data == FURNACE:
        words = (files("observer_lab.plants") / "data" / "gas-furnace.csv").read_text(encoding="utf-8")
        return Given(read_record(words, inputs=("gas rate",), outputs=("CO2",)))
    if data == FAULTY:
        return _faulty(record_of(SPRING, seed), seed)
    if data not in TRUTHS:
        raise KnobError(text("There is no record of your own here; upload it, or start the lab with --data FILE.csv."))
    truth = TRUTHS[data]
    plant, total = truth.plant, truth.rows + BEFORE
    rng = np.random.default_rng(seed)
    u = np.repeat(rng.choice([-1.0, 1.0], (total // HELD + 1, 1)), HELD, axis=0)[:total]
    driven = (u + truth.q * rng.standard_normal(u.shape)) @ plant.B.T
    clean = affine_scan(plant.A, driven, np.zeros(plant.n), total)[:total] @ plant.C.T
    y = clean + truth.r * rng.standard_normal(clean.shape)
    t = plant.dt * np.arange(truth.rows)
    return Given(Record(t, u[BEFORE:], y[BEFORE:], ("u",), ("y",)), clean[BEFORE:], truth)


def _faulty(given: Given, seed: int) -> Given:
    """The same record with readings that jump, and a bias from a later row on."""
    record, rng = given.record, np.random.default_rng(seed + 1)
    rows = np.arange(record.rows)[:, None]
    jumps = np.where((rows >= FIRST_JUMP) & (rng.random(record.y.shape) < JUMPING), JUMP * rng.choice([-1.0, 1.0], record.y.shape), 0.0)
    bias = np.where(rows >= FIRST_BIAS, BIAS, np.zeros(record.y.shape))
    return replace(given, record=replace(record, y=record.y + jumps + bias), jumps=jumps, bias=bias)
