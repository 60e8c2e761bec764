"""Drive the loop of lesson 4 to a command: with the gain N̄ alone, or with integral action too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from observer_lab.course.lesson import Design
from observer_lab.engine import EngineError, Plant
from observer_lab.engine.feedback import integral_action, reference_gain
from observer_lab.engine.simulation import Run
from observer_lab.plants import Model
from observer_lab.text import NO_WORDS, Text, error_words

RATES = 9.0  # that the integrator's own pole has in the length of a run: what it started with has then decayed


@dataclass(frozen=True)
class Target:
    """The signal z = c x + d u that follows the command r, with its axis, unit and scale.

    `of` gives c (k×n) and d (k×m) of a plant: the first row is z, the others are signals that N̄ keeps at zero. `value` gives r of a
    design, in SI.
    """

    axis: Text | str
    unit: str
    scale: float
    of: Callable[[Plant], tuple[np.ndarray, np.ndarray]]
    value: Callable[[Design], float]

    def followed(self, plant: Plant) -> tuple[np.ndarray, np.ndarray]:
        """The rows c (1×n) and d (1×m) of z."""
        c, d = self.of(plant)
        return c[:1], d[:1]

    def along(self, run: Run, plant: Plant) -> np.ndarray:
        """The signal over a run of this plant (or of the plant with the integrator as one more state), in its unit."""
        c, d = self.followed(plant)
        return (run.x[:, :plant.n] @ c.T + run.u_applied[:, :plant.m] @ d.T)[:, 0] * self.scale


@dataclass(frozen=True, eq=False)
class Driven:
    """What a scenario runs: plant, model and gains, with integral action all one state larger, and the reference that stands for r.

    `m` inputs belong to the plant; with integral action one more brings r to the integrator. `own` holds the pole of the integrator and
    that of its copy in the observer, (0, 0) without one. `refused` says why there is no gain for a command, if so.
    """

    model: Model
    truth: Plant
    belief: Plant
    K: np.ndarray
    L: np.ndarray
    reference: np.ndarray | None
    m: int
    N: np.ndarray | None = None
    own: tuple[float, float] = (0.0, 0.0)
    refused: Text = NO_WORDS

    @property
    def integral(self) -> bool:
        """Whether the integrator is part of the loop."""
        return self.truth.m > self.m


def driven(model: Model, target: Target, r: float, plants: tuple[Plant, Plant], gains: tuple[np.ndarray, np.ndarray],
           integral: bool) -> Driven:
    """The loop for the command r (SI) with plants = (truth, belief) and gains = (K, L)."""
    (truth, belief), (K, L) = plants, gains
    plain = Driven(model, truth, belief, K, L, None, truth.m)
    if not r and not integral:
        return plain
    held, commanded = (Plant(belief.A, belief.B, *rows, belief.dt) for rows in (target.of(belief), target.followed(belief)))
    try:
        N = reference_gain(held, K)[:, :1]
        if not integral:
            return replace(plain, reference=r * N[:, 0], N=N)
        rate, copied = _rates(model, belief.dt)
        action = integral_action(commanded, K, rate, N=N)
    except EngineError as problem:
        return replace(plain, refused=error_words(problem))
    nothing = np.zeros((1, belief.n))
    wide_K = np.block([[action.K, -action.K_I], [nothing, np.zeros((1, 1))]])
    wide_L = np.block([[L, np.zeros((belief.n, 2))], [np.zeros((1, belief.p)), np.array([[-1.0, copied]])]])
    hold = 1.0 if belief.dt else 0.0
    return Driven(_wider(model), with_integrator(truth, target), with_integrator(belief, target), wide_K, wide_L,
                  r * np.append(N[:, 0], 1.0), truth.m, N, (hold - rate, hold - copied))


def _rates(model: Model, dt: float) -> tuple[float, float]:
    """How fast the integrator's value and its copy in the observer settle: in 1/s, or as shares of a step."""
    rate = RATES / model.horizon
    return (float(-np.expm1(-rate * dt)), float(-np.expm1(-2 * rate * dt))) if dt else (rate, 2 * rate)


def with_integrator(plant: Plant, target: Target) -> Plant:
    """The plant with x_I as last state, ẋ_I = r − z, r as last input, and with z and x_I as last outputs.

    The observer gain [0 … 0, −1, l] of the last row turns its copy into ẋ̂_I = r − z + l (x_I − x̂_I): from one start both stay equal, for
    every model and every error of x̂.
    """
    (c, d), n, m = target.followed(plant), plant.n, plant.m
    A = np.block([[plant.A, np.zeros((n, 1))], [-c, np.full((1, 1), 1.0 if plant.dt else 0.0)]])
    B = np.block([[plant.B, np.zeros((n, 1))], [-d, np.ones((1, 1))]])
    C = np.block([[plant.C, np.zeros((plant.p, 1))], [c, np.zeros((1, 1))], [np.zeros((1, n)), np.ones((1, 1))]])
    D = np.block([[np.asarray(plant.D), np.zeros((plant.p, 1))], [d, np.zeros((1, 1))], [np.zeros((1, m + 1))]])
    return Plant(A, B, C, D, plant.dt, (*plant.state_names, "x_I"), (*plant.input_names, "r"), (*plant.output_names, "z", "x_I"),
                 name=plant.name)


def _wider(model: Model) -> Model:
    """The model of a lesson with one more state, which starts at zero and shows nowhere."""
    return replace(model, x0=(*model.x0, 0.0), guess=(*model.guess, 0.0), kick=(*model.kick, 0.0),
                   grips=tuple(replace(grip, push=(*grip.push, 0.0)) for grip in model.grips),
                   watched=tuple(replace(signal, weights=(*signal.weights, 0.0)) for signal in model.watched))
