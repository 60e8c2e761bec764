"""Slopes of an extended filter: of maps that a complex step differentiates, and of maps that it does not."""

from __future__ import annotations

import numpy as np
import pytest

from observer_lab.engine import Belief, ExtendedKalmanFilter

NODES, HEIGHTS = np.array([-4.0, -1.0, 0.5, 2.0, 5.0]), np.array([-3.0, -2.0, 0.0, 2.5, 3.0])
TABLE_SLOPES = np.diff(HEIGHTS) / np.diff(NODES)
MAPS = {
    "sin": (lambda x, u: np.sin(x), np.cos),
    "drag": (lambda x, u: x * np.abs(x), lambda x: 2 * np.abs(x)),
    "root": (lambda x, u: np.sqrt(np.abs(x)), lambda x: np.sign(x) / (2 * np.sqrt(np.abs(x)))),
    "friction": (lambda x, u: x + np.sign(x), lambda x: np.ones_like(x)),
    "conjugate": (lambda x, u: np.real(np.conj(x) * x), lambda x: 2 * x),
    "table": (lambda x, u: np.interp(x[0], NODES, HEIGHTS)[None], lambda x: TABLE_SLOPES[np.searchsorted(NODES, x) - 1]),
}


@pytest.mark.parametrize("at", [-1.7, 0.8, 3.1])
@pytest.mark.parametrize("kind", MAPS)
def test_the_covariance_is_led_by_the_slope_that_the_map_has(kind: str, at: float) -> None:
    f, slope = MAPS[kind]
    led = ExtendedKalmanFilter(f, lambda x, u: x, np.zeros((1, 1)), np.eye(1)).predict(Belief([at], [[0.01]]))
    assert led.covariance[0, 0] == pytest.approx(0.01 * slope(np.array(at)) ** 2, rel=1e-7)


def test_the_norm_of_a_position_has_its_own_slope() -> None:
    ekf = ExtendedKalmanFilter(lambda x, u: x, lambda x, u: np.linalg.norm(x, axis=0)[None], np.eye(2), np.eye(1))
    found = ekf.correct(Belief([3.0, 4.0], np.diag([0.1, 0.2])), [5.0])
    assert found.S[0, 0] == pytest.approx(1 + 0.1 * 0.36 + 0.2 * 0.64, rel=1e-8)


def test_what_a_map_raises_comes_through_in_its_own_words() -> None:
    def f(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        raise TypeError("the tank has no third valve")
    with pytest.raises(TypeError, match="third valve"):
        ExtendedKalmanFilter(f, lambda x, u: x, np.eye(1), np.eye(1)).predict(Belief([1.0], [[1.0]]))
