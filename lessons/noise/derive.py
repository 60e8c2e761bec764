"""The numbers that stand now in the derivation of lesson 8: the valley of one state at the present noises and speed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.linalg import solve_continuous_are

from app.lesson.derivation import Value
from app.lesson.lesson import Outcome

from .knobs import PLANT
from .study import Study


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """Gain, variance and slope of a plant with one state, as fast against its Kalman filter as the block's observer is."""
    W, V, a = outcome.design["w"], outcome.design["v"], float(np.real(PLANT.poles).mean())
    rho = outcome.metrics["speed"] / outcome.metrics["kalman_speed"]
    least = float(solve_continuous_are([[a]], [[1.0]], [[W]], [[V]])[0, 0])
    best = least / V
    L = a + rho * (best - a)
    rate = L - a
    return {
        "W": W, "V": V, "a": a, "rho": rho, "best": best, "least": least, "L": L, "P": W / (2 * rate) + L**2 * V / (2 * rate),
        "slope": L * V / rate - (W + L**2 * V) / (2 * rate**2), "still": 0.0,
        "product": float(np.prod(outcome.study.kalman.poles).real)}
