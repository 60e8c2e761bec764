"""Define three cases: deck on hardening springs, cart-pendulum, falling body."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from observer_lab.colours import COLOURS
from observer_lab.engine import NonlinearPlant, lqr
from observer_lab.engine.systems import Flow, step_covariance
from observer_lab.plants import cart_pendulum
from observer_lab.plants.bodies import falling_body
from observer_lab.plants.bodies.body import Body
from observer_lab.plants.bodies.deck_body import MOTION_GAIN
from observer_lab.plants.bodies.deck_body import STAGE_SCALE as DECK_STAGE
from observer_lab.plants.bodies.front_bars import Bar, decade_marks, with_bars
from observer_lab.plants.model import Signal
from observer_lab.plants.platform import model, nonlinear
from observer_lab.text import text

PLATFORM, PENDULUM_CASE, FALL_CASE = "platform", "pendulum", "fall"
KF, EKF, UKF = "kf", "ekf", "ukf"
TEST_DECADES = -2, 6  # of the bars of NEES and NIS
DEGREE = 180 / np.pi
GROUND_INTENSITY, COUPLE = 4e-10, 3e-4  # m² s of each ground motion, N² s of a draught that tilts the deck
SINE_HZ = 0.16  # Hz, of the known force
LENGTH = nonlinear.NonlinearLaws.length


@dataclass(frozen=True, eq=False)
class Case:
    """What an experiment needs, and how it is drawn.

    Q, R: covariances at noise scales of one. spread (n,): standard deviations of the start at size one about `guess`.
    draft, full: samples of the picture while knobs move and of the long job. scale, state: stage units a unit of the state
    by which the cloud is drawn. judged_by: the sign of the signal that the bars on the stage are about.
    """

    id: str
    step: float
    parts: int
    draft: int
    full: int
    guess: np.ndarray
    spread: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    body: Body
    watched: tuple[Signal, Signal]
    kick: np.ndarray
    gain: np.ndarray
    u_max: np.ndarray
    scale: float
    state: int
    judged_by: str
    decades: tuple[int, int] = (-2, 2)  # of the bars on the stage, in the unit of the signal that filters are judged by
    by: float = 0.6  # stage units that the body stands behind them

    @cached_property
    def barred(self) -> Body:
        """The body behind the bars of what the chosen filter states and of its RMS error; of a falling body more is shown."""
        bars = (Bar(text("stated σ of {signal}", signal=self.judged_by), COLOURS["estimate"]),
                Bar(text("RMS error of {signal}", signal=self.judged_by), COLOURS["error"]))
        marks = decade_marks(*self.decades, 2 if self.decades[1] - self.decades[0] > 5 else 1)
        *first, (last, share) = marks if self.body.gain == 1 else marks[:-1]  # else a factor is written below the last one
        shown = (*first, (f"{last} [{self.watched[judged(self)].unit}]", share))
        return with_bars(self.body, self.drawn, bars, shown, self.by, gate=True, decades=self.decades)

    @property
    def drawn(self) -> int:
        """How many numbers pose the body alone."""
        return len(self.guess) + 4 * (self.id == FALL_CASE)

    @cached_property
    def tested(self) -> Body:
        """The body behind the bars of NEES per state and of NIS per reading, both 1 for a consistent filter."""
        bars = (Bar(text("mean NEES per state"), COLOURS["muted"]), Bar(text("mean NIS per reading"), COLOURS["error"]))
        marks = decade_marks(*TEST_DECADES, 2)
        return with_bars(self.body, self.drawn, bars, marks if self.body.gain == 1 else marks[:-1], self.by, decades=TEST_DECADES)


@lru_cache(maxsize=1)
def cases() -> tuple[Case, Case, Case]:
    """All three, made once: a stage keeps the body that it has built."""
    return _platform(), _pendulum(), _fall()


def case_of(name: str) -> Case:
    """The case of that name."""
    return next(c for c in cases() if c.id == name)


def _unit(n: int, i: int) -> tuple[float, ...]:
    return tuple(float(j == i) for j in range(n))


def _platform() -> Case:
    deck, step = model.deck(), 0.025
    G = np.column_stack([model.deck_disturbance(), deck.B[:, 1] - deck.B[:, 0]])
    gain = lqr(deck.A, deck.B, 2e4 * deck.C.T @ deck.C, np.eye(3)).gain
    return Case(PLATFORM, step, 1, 27, 100, np.zeros(6), np.array([1.5e-3, 2e-3, 9e-3, 1e-2, 1.4e-2, 7e-2]),
                step_covariance(deck.A, G @ np.diag([GROUND_INTENSITY, GROUND_INTENSITY, COUPLE]) @ G.T, step), 1e-6 * np.eye(4),
                model.rigid_body(),
                (Signal(text("height of the deck z"), _unit(6, 1), "mm", 1e3),
                 Signal(text("pitch of the deck θ"), _unit(6, 2), "mrad", 1e3)),
                np.array(model.DECK_MODEL.kick), gain, np.full(3, 10.0), DECK_STAGE * MOTION_GAIN, 1, "z", by=0.95)


def _pendulum() -> Case:
    line, step = cart_pendulum.plant(), 0.05
    noise = line.B @ line.B.T * 1e-3 + np.diag([0.0, 0.0, 0.0, 1e-4])
    gain = lqr(line.A, line.B, np.diag([1.0, 5.0, 1.0, 1.0]), [[0.1]]).gain
    return Case(PENDULUM_CASE, step, 1, 26, 60, np.zeros(4), np.array([0.05, 0.1, 0.05, 0.1]),
                step_covariance(line.A, noise, step), np.array([[0.005**2]]), cart_pendulum.MODEL.body,
                (Signal(text("angle of the pole θ"), _unit(4, 1), "°", DEGREE),
                 Signal(text("position of the cart p"), _unit(4, 0), "m")),
                np.array(cart_pendulum.MODEL.kick), gain, np.array([30.0]), cart_pendulum.STAGE_SCALE, 1, "θ")


def _fall() -> Case:
    return Case(FALL_CASE, falling_body.SAMPLE_S, 2, 31, 31, np.array(falling_body.GUESS), np.array(falling_body.START_SIGMAS),
                np.zeros((3, 3)), np.array([[falling_body.NOISE**2]]), falling_body.body(),
                (Signal(text("altitude h"), _unit(3, 0), "m"),
                 Signal(text("drag coefficient β"), _unit(3, 2), "1/km", 1e3)),
                np.array([0.0, 300.0, 0.0]), np.zeros((0, 3)), np.zeros(0), falling_body.STAGE_SCALE, 0, "β", (-3, 5))


@lru_cache(maxsize=16)
def plant_of(name: str, hardening: float, weakening: float) -> NonlinearPlant:
    """The equations; hardening and weakening are those of the platform."""
    if name == PLATFORM:
        return nonlinear.plant(nonlinear.NonlinearLaws(hardening, weakening))
    return cart_pendulum.nonlinear_plant() if name == PENDULUM_CASE else falling_body.plant()


def flow_of(case: Case, plant: NonlinearPlant) -> Flow:
    """One sampling step."""
    return plant.flow(case.step, parts=case.parts)


def starts(case: Case, size: float, runs: int, rng: np.random.Generator) -> np.ndarray:
    """True starts (n, runs), drawn from what the filters believe; the falling body's drag alone is that of the papers."""
    x0 = case.guess[:, None] + size * case.spread[:, None] * rng.standard_normal((len(case.guess), runs))
    if case.id == FALL_CASE:
        x0[2] = falling_body.TRUE_START[2]
    return x0


def inputs_of(case: Case, count: int, force: float) -> np.ndarray:
    """Known inputs (count, m): on the platform a force at 0.16 Hz, a quarter period ahead, half of it across."""
    if case.id != PLATFORM:
        return np.zeros((count, len(case.u_max)))
    return np.outer(force * np.cos(2 * np.pi * SINE_HZ * case.step * np.arange(count)), [1.0, 1.0, 0.5])


def judged(case: Case) -> int:
    """Which of the watched signals the filters are judged by: of the falling body the drag, elsewhere the first."""
    return int(case.id == FALL_CASE)
