"""Compute the numbers in the derivation of lesson 8: error variance of a one-state plant."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import solve_continuous_are

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .knobs import SPRING_PLANT
from .study import Study


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Gain, variance and slope of a plant with one state, as fast against its Kalman filter as the block's observer is."""
    W, V, a = outcome.design["w"], outcome.design["v"], float(np.real(SPRING_PLANT.poles).mean())
    rho = outcome.metrics["speed"] / outcome.metrics["kalman_speed"]
    least = float(solve_continuous_are([[a]], [[1.0]], [[W]], [[V]])[0, 0])
    best = least / V
    L = a + rho * (best - a)
    rate = L - a
    return {
        "W": W, "V": V, "a": a, "rho": rho, "best": best, "least": least, "L": L, "P": W / (2 * rate) + L**2 * V / (2 * rate),
        "slope": L * V / rate - (W + L**2 * V) / (2 * rate**2), "still": 0.0,
        "product": float(np.prod(outcome.study.kalman.poles).real)}
