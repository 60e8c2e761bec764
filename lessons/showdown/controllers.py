"""Build the compared controllers: none, SISO pair, LQG steady and recursive, decoupled LQG."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from observer_lab.engine import Belief, KalmanFilter, Plant, balanced_truncation, compensator, lqe, lqr, sampled_lqg
from observer_lab.engine.sampled import SampledController, SampledLqg, recursive_controller, sampled_controller
from observer_lab.engine.systems import root, settled_covariance, symmetric
from observer_lab.plants.platform import model
from observer_lab.plants.platform import siso_loops as siso
from observer_lab.plants.platform.lqg_weights import GROUND_UNIT, H_MAG, V_MAG, Weights, coils, ground
from observer_lab.text import Text, same, text, text_in

DT = 1e-3  # s: the computer's period
OPEN_LOOP, SISO, LQE, RECURSIVE, DECOUPLED = ORDER = ("open", "siso", "lqe", "recursive", "decoupled")
CONTROLLER_NAMES = (
    text("no control"), text("two SISO loops"), text("LQG, steady LQE"),
    text("LQG, recursive filter"), text("decoupled LQG"),
)
CONTROLLER_ROLES = ("muted", "second", "plant", "reference", "error")  # of their colours, on the stage and in figures
OWN_PAIR, PUBLISHED_PAIR = "own", "published"
SCALES = ((V_MAG, 2), (V_MAG, 2), (H_MAG, 1))  # of each channel: its unit of velocity, and coils that share its force
Steps = tuple[np.ndarray, np.ndarray, np.ndarray]  # A, G, H of a filter's step in its covariance, stacks
LOOK_STRIDE_SAMPLES, LOOK_COUNT = 512, 40  # samples between two looks at the recursive gain, and how many: 20 s


@dataclass(frozen=True, eq=False)
class Player:
    """One controller: its id, its name, and what the computer runs."""

    id: str
    name: Text
    controller: SampledController


@lru_cache(maxsize=1)
def reduced() -> Plant:
    """The eight states on which the report designs, with coils and ground as inputs."""
    return balanced_truncation(model.plant(), 8).plant


@lru_cache(maxsize=1)
def _feedback() -> tuple[np.ndarray, SampledLqg]:
    """What does not depend on the believed noise: K in continuous time, and the sampled design with its own K."""
    weights, plant = Weights(), reduced()
    return (lqr(plant.A, coils(plant).B, weights.Q(plant), weights.R).gain,
            sampled_lqg(coils(plant), weights.Q(plant), weights.R, weights.W, weights.V, DT, G=ground(plant)))


@lru_cache(maxsize=3)
def channel(index: int) -> tuple[Plant, np.ndarray, np.ndarray]:
    """The reduced model of a channel, its G, and its K by the report's weights seen in this channel."""
    plant, G = siso.reduced_channel(siso.THREE[index])
    magnitude, pair = SCALES[index]
    weights = Weights()
    Q = weights.alpha_q * 2 / magnitude**2 * plant.C.T @ plant.C
    return plant, G, lqr(plant.A, plant.B, Q, [[weights.alpha_r * pair]]).gain


def full(v: float) -> Plant:
    """The full LQG with its steady LQE, y → u: `platform_lqg.lqg` on eight states."""
    weights, plant = Weights(v0=v), reduced()
    return compensator(coils(plant), _feedback()[0], lqe(plant.A, ground(plant), plant.C, weights.W, weights.V).gain)


def channel_filter(index: int, v: float) -> np.ndarray:
    """L of a channel's steady filter: two sensors together are half as noisy."""
    plant, G, _ = channel(index)
    return lqe(plant.A, G, plant.C, GROUND_UNIT * np.eye(2), [[v / 2]]).gain


def decoupled(v: float) -> Plant:
    """Three LQGs of two states each, y → u: `platform_siso.decoupled_lqg`."""
    parts = [compensator(channel(index)[0], channel(index)[2], channel_filter(index, v)) for index in range(3)]
    return siso.from_channels(*parts, name="decoupled LQG")


@lru_cache(maxsize=64)
def sampled_design(v: float) -> SampledLqg:
    """The LQG of the computer's own time, for the believed intensity v of the sensors' noise."""
    weights, plant, made = Weights(v0=v), reduced(), _feedback()[1]
    return replace(made, filter=KalmanFilter.from_plant(coils(plant), weights.W, weights.V, dt=DT, G=ground(plant)))


def first_belief(v: float) -> Belief:
    """What the recursive filter knows when it is switched on: the deck shakes as it does without control."""
    plant = reduced()
    G = ground(plant)
    return Belief(np.zeros(plant.n), settled_covariance(plant.A, G @ root(Weights(v0=v).W)))


def _player(index: int, controller: Plant) -> Player:
    return Player(ORDER[index], CONTROLLER_NAMES[index], sampled_controller(controller, DT))


def siso_pair(pair: str) -> Plant:
    """The two SISO loops, y → u, in continuous time: the report's or ours."""
    return siso.published() if pair == PUBLISHED_PAIR else siso.designed()


@lru_cache(maxsize=4)
def _unbelieving(pair: str) -> tuple[Player, Player]:
    """Those whom the believed noise does not concern."""
    silent = Plant(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((3, 0)), np.zeros((3, 4)), DT)
    return _player(0, silent), _player(1, siso_pair(pair))


@lru_cache(maxsize=64)
def _believing(v: float) -> tuple[Player, Player, Player]:
    return _player(2, full(v)), _player(3, sampled_design(v).controller), _player(4, decoupled(v))


def players(v: float, pair: str) -> tuple[Player, ...]:
    """All five for the believed intensity v and a choice of the SISO pair; the recursive filter with its settled gain."""
    return _unbelieving(pair) + _believing(v)


def recursion(v: float, steps: int) -> SampledController:
    """The recursive filter from the moment when it is switched on, with the feedback of the sampled LQG."""
    design = sampled_design(v)
    return recursive_controller(design.filter, design.K, first_belief(v), steps)


@lru_cache(maxsize=64)
def gain_gap(v: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (s) and ‖M − M∞‖/‖M∞‖ of the recursive gain there, without the samples in between.

    P⁺ = H + A P (I + G P)⁻¹Aᵀ is the step of the filter; one step after another is again one of this form: doubled up to the
    stride, and doubled again to all strides at once.
    """
    kf, far = sampled_design(v).filter, np.arange(LOOK_COUNT)
    step: Steps = kf.A[None], (kf.C.T @ np.linalg.solve(kf.R, kf.C))[None], kf.Q[None]
    for _ in range(round(np.log2(LOOK_STRIDE_SAMPLES))):
        step = _after(step, step)
    while len(step[0]) < LOOK_COUNT - 1:
        last = tuple(part[-1:] for part in step)
        step = tuple(np.concatenate(parts) for parts in zip(step, _after(step, last), strict=True))  # type: ignore[assignment,arg-type]
    A, G, H = (part[:LOOK_COUNT - 1] for part in step)
    P = first_belief(v).covariance
    P = np.concatenate([P[None], H + A @ P @ np.linalg.solve(np.eye(8) + G @ P, A.swapaxes(1, 2))])
    CP = kf.C @ P
    away = np.linalg.norm(np.linalg.solve(CP @ kf.C.T + kf.R, CP).swapaxes(1, 2) - kf.steady.filter_gain, axis=(1, 2))
    return DT * LOOK_STRIDE_SAMPLES * far, away / np.linalg.norm(kf.steady.filter_gain)


def _after(first: Steps, second: Steps) -> Steps:
    """Steps P⁺ = H + A P (I + G P)⁻¹Aᵀ of stacks (k, 8, 8), each one of `first` and then that of `second`."""
    (A, G, H), (B, F, E) = first, second
    both = np.linalg.solve(np.eye(8) + H @ F, np.concatenate([A, H], axis=2))
    return (B @ both[:, :, :8], symmetric(G + A.swapaxes(1, 2) @ F @ both[:, :, :8]),
            symmetric(E + B @ both[:, :, 8:] @ B.swapaxes(1, 2)))


SHORT_NAMES = (text_in("showdown", "none"), text("SISO"), same("LQE"), text("recursive"), text("decoupled"))
