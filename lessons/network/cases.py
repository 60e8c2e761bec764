"""Define the plants of lesson 18: sampled model, noise, controller, filter without loss."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from observer_lab.engine import KalmanFilter, Plant, critical_loss, dlqe, dlqr
from observer_lab.engine.design import DiscreteFilter
from observer_lab.engine.network import CriticalLoss, spectral_radius
from observer_lab.plants import MODELS, Signal
from observer_lab.plants.bodies.body import Body
from observer_lab.plants.bodies.deck_body import MOTION_GAIN as DECK_GAIN
from observer_lab.plants.bodies.deck_body import STAGE_SCALE as DECK_SCALE
from observer_lab.plants.cart_pendulum import STAGE_SCALE as CART_SCALE
from observer_lab.plants.chip import STAGE_SCALE as CHIP_SCALE
from observer_lab.plants.platform.model import deck_disturbance
from observer_lab.text import Text, text

from .bodies import SCALE, columns_body, ridge_with_target, with_lamps

RUN_SAMPLES = 80
SCALAR_CASE, TWO, CHIP_CASE, CART_CASE, DECK_CASE = "scalar", "two", "chip-runaway", "cart-pendulum", "deck"
PERIODS = MappingProxyType({SCALAR_CASE: 0.1, TWO: 0.1, CHIP_CASE: 0.5, CART_CASE: 0.05, DECK_CASE: 0.04})  # s
MAX_PERIOD_FACTOR = 3.0  # times the period
HORIZON = RUN_SAMPLES * MAX_PERIOD_FACTOR * PERIODS[CHIP_CASE]  # s, the longest run


@dataclass(frozen=True, eq=False)
class Kind:
    """What of a case no knob moves. `shown`: weights of the state whose spread is drawn, in stage units."""

    label: Text
    body: Body
    x0: tuple[float, ...]
    kick: tuple[float, ...]
    watched: Signal
    shown: tuple[float, ...]
    input_unit: str


CASE_KINDS: MappingProxyType[str, Kind] = MappingProxyType({
    SCALAR_CASE: Kind(text("Scalar: a ball on a ridge"), ridge_with_target(), (3.0,), (4.0,),
                 Signal(text("place of the ball x"), (1.0,), "cm"), (SCALE,), "cm"),
    TWO: Kind(text("Two unstable modes, one sensor"), with_lamps(columns_body(2, 60.0), 2),
              (20.0, -10.0), (30.0, 0.0), Signal(text("first state x₁"), (1.0, 0.0), ""), (0.7 / 60, 0.0), ""),
    CHIP_CASE: Kind(MODELS[CHIP_CASE].label, with_lamps(MODELS[CHIP_CASE].body, 2), MODELS[CHIP_CASE].x0, MODELS[CHIP_CASE].kick,
               MODELS[CHIP_CASE].watched[0], (CHIP_SCALE, 0.0), "W"),
    CART_CASE: Kind(MODELS[CART_CASE].label, with_lamps(MODELS[CART_CASE].body, 4), (0.0, 0.05, 0.0, 0.0), (0.0, 0.0, 0.0, 0.15),
               MODELS[CART_CASE].watched[0], (CART_SCALE, CART_SCALE, 0.0, 0.0), "N"),
    DECK_CASE: Kind(MODELS[DECK_CASE].label, with_lamps(MODELS[DECK_CASE].body, 6), MODELS[DECK_CASE].x0, MODELS[DECK_CASE].kick,
               MODELS[DECK_CASE].watched[0], (0.0, DECK_SCALE * DECK_GAIN, 0.0, 0.0, 0.0, 0.0), "N"),
})


@dataclass(frozen=True, eq=False)
class Sampled:
    """A plant at its samples: Q of the process noise, R of the sensor at its normal noise, K, what may be lost, and K's weights."""

    plant: Plant
    Q: np.ndarray
    R: np.ndarray
    K: np.ndarray
    edge: CriticalLoss
    radius: float
    state: np.ndarray
    force: np.ndarray


@dataclass(frozen=True, eq=False)
class Watched:
    """A sampled plant with R at the noise of the design, the filter without loss, and the weights of the ratio shown.

    The ratio of a covariance P is Σ weightsᵢ Pᵢᵢ: its variances, each over that of the filter without loss, averaged.
    """

    sampled: Sampled
    R: np.ndarray
    steady: DiscreteFilter
    weights: np.ndarray

    def ratio(self, P: np.ndarray) -> np.ndarray:
        """Of covariances (…, n, n)."""
        return np.diagonal(P, axis1=-2, axis2=-1) @ self.weights


def _from_model(name: str, h: float) -> tuple[KalmanFilter, np.ndarray, np.ndarray]:
    """The sampled filter, and the weights of state and input for the controller."""
    model = MODELS[name]
    plant = model.plant
    if name == CHIP_CASE:  # 1.5 W of fluctuating power in a second, 0.3 K of sensor noise
        return KalmanFilter.from_plant(plant, 2.0, 0.09 * h, dt=h), np.diag([1.0, 1.0]), 0.05 * np.eye(1)
    if name == CART_CASE:  # gusts on the cart, half a millimetre of sensor noise
        return KalmanFilter.from_plant(plant, 1e-4, 2.5e-7 * h, dt=h), np.diag([20.0, 20.0, 1.0, 1.0]), 0.3 * np.eye(1)
    G = np.column_stack([deck_disturbance(), plant.B[:, 1] - plant.B[:, 0]])  # ground and a draught, 1 mm/s of noise
    kf = KalmanFilter.from_plant(plant, np.diag([4e-10, 4e-10, 3e-4]), 1e-6 * h * np.eye(4), dt=h, G=G)
    return kf, plant.C.T @ plant.C, 1e-4 * np.eye(3)


@lru_cache(maxsize=128)
def sampled(name: str, a: float, stretch: float) -> Sampled:
    """The case at a (scalar only) and its sampling period times `stretch` (the scalar and the pair of modes keep theirs)."""
    h = PERIODS[name] * (1.0 if name in (SCALAR_CASE, TWO) else stretch)
    if name == SCALAR_CASE:
        plant, Q, R = Plant(np.array([[a]]), np.eye(1), np.eye(1), dt=h), 0.09 * np.eye(1), 0.09 * np.eye(1)
        state, force = np.eye(1), 0.5 * np.eye(1)
    elif name == TWO:
        plant = Plant(np.array([[1.25, 0.0], [1.0, 1.1]]), np.array([[1.0], [0.0]]), np.array([[1.0, 1.0]]), dt=h)
        Q, R, state, force = 20 * np.eye(2), 2.5 * np.eye(1), np.eye(2), np.eye(1)
    else:
        kf, state, force = _from_model(name, h)
        plant, Q, R = Plant(kf.A, kf.B, kf.C, dt=h), kf.Q, kf.R
    K = dlqr(plant.A, plant.B, state, force).gain
    return Sampled(plant, Q, R, K, critical_loss(plant.A, plant.C), spectral_radius(plant.A), state, force)


@lru_cache(maxsize=128)
def watched(name: str, a: float, stretch: float, noise: float) -> Watched:
    """The same with the sensor's standard deviation times `noise`."""
    s = sampled(name, a, stretch)
    R = noise**2 * s.R
    steady = dlqe(s.plant.A, np.eye(s.plant.n), s.plant.C, s.Q, R)
    return Watched(s, R, steady, 1 / (s.plant.n * np.diag(steady.solution)))
