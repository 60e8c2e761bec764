"""Compute K and L of a design, and the typical sizes of an own plant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from observer_lab.course.lesson import Design
from observer_lab.engine import Plant, dlqe, dlqr, lqe, lqr, observer_gain, place
from observer_lab.engine.design import shift_observer, shift_poles, typical_rate
from observer_lab.plants.model import Model, Signal

from .knobs import by_hand


def gains(design: Design, plant: Plant, model: Model | None = None) -> tuple[np.ndarray, np.ndarray]:
    """K and L of a design: by poles, or by LQR and LQE from the weights. `model` where the plant is a person's own."""
    if by_hand(design):
        return feedback(plant, design["controller_poles"], model), injection(plant, design["observer_poles"], model)
    return _regulated(plant, design["q"], design["r"]), _filtered(plant, design["w"], design["v"])


def feedback(plant: Plant, poles: Sequence[complex], model: Model | None = None) -> np.ndarray:
    """K (m×n) for poles: placed, or for a person's own plant its starting gain with the poles of the board moved."""
    if model is None or model.controller is None:
        return _placed(plant, tuple(poles))
    return shift_poles(plant.A, plant.B, model.controller.gain, model.controller_poles, poles)


def injection(plant: Plant, poles: Sequence[complex], model: Model | None = None) -> np.ndarray:
    """L (n×p) for poles, as `feedback`."""
    if model is None or model.observer is None:
        return _injected(plant, tuple(poles))
    return shift_observer(plant.A, plant.C, model.observer.gain, model.observer_poles, poles)


@lru_cache(maxsize=32)
def _placed(plant: Plant, poles: tuple[complex, ...]) -> np.ndarray:
    """K by its poles, which most knobs leave where they are."""
    return place(plant.A, plant.B, poles, sizes=np.ones(plant.n)).gain


@lru_cache(maxsize=32)
def _injected(plant: Plant, poles: tuple[complex, ...]) -> np.ndarray:
    return observer_gain(plant.A, plant.C, poles, sizes=np.ones(plant.n)).gain


@lru_cache(maxsize=32)
def _regulated(plant: Plant, q: float, r: float) -> np.ndarray:
    """K by LQR: q of the outputs' squares, r of the inputs'."""
    return (dlqr if plant.dt else lqr)(plant.A, plant.B, q * plant.C.T @ plant.C, r * np.eye(plant.m)).gain


@lru_cache(maxsize=32)
def _filtered(plant: Plant, w: float, v: float) -> np.ndarray:
    """L by LQE: w at each input, v at each output."""
    return (dlqe if plant.dt else lqe)(plant.A, plant.B, plant.C, w * np.eye(plant.m), v * np.eye(plant.p)).gain


def sped(plant: Plant, percent: float) -> Plant:
    """The plant as it is when everything in it goes faster by so many per cent than its model says: A and B grow alike."""
    if not percent:
        return plant
    share = 1 + percent / 100
    return replace(plant, A=share * plant.A, B=share * plant.B)


def judged(model: Model) -> tuple[Signal, Signal]:
    """Signals of a person's own plant by which its estimate is judged: an output, and a state that no output reads, if there is one."""
    return model.watched[0], next(signal for signal in model.watched if signal.name("en").startswith("state"))


def sizes(model: Model) -> np.ndarray:
    """The size (p,) of each output of a person's own plant near its start, 1 where that is nothing."""
    size = np.abs(model.plant.C) @ np.abs(np.array(model.x0))
    return np.where(size > 0, size, 1.0)


def noise_units(model: Model) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """G, W and V of unit noises for a person's own plant: intensities, or covariances of a sample where it is sampled.

    w enters where the inputs do and has the size of the natural input over a typical time, v that of the outputs near the
    start; a plant that no input reaches is shaken in every state.
    """
    plant = model.plant
    time = 1.0 if plant.dt else 1.0 / typical_rate(plant)
    V = np.diag(sizes(model) ** 2) * time
    if np.any(plant.B):
        return plant.B, model.u_max**2 * time * np.eye(plant.m), V
    return np.diag(np.abs(np.array(model.x0)) + 1e-9), (1.0 if plant.dt else 1.0 / time) * np.eye(plant.n), V
