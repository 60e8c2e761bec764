"""A belief that a person gives has a covariance; one that a filter has computed is shown as it is."""

from __future__ import annotations

import numpy as np
import pytest

from observer_lab.engine import EngineError, KalmanFilter
from observer_lab.engine.filters import Belief


@pytest.mark.parametrize(("P", "words"), [
    ([[1.0, 0.5], [0.0, 1.0]], "symmetric"),
    ([[1.0, 2.0], [2.0, 1.0]], "negative eigenvalue"), ([[-1.0, 0.0], [0.0, 1.0]], "negative eigenvalue"),
    ([[1e12, 0.0], [0.0, -1e-3]], "negative eigenvalue")])
def test_what_is_no_covariance_is_refused(P: list[list[float]], words: str) -> None:
    with pytest.raises(EngineError, match=words):
        Belief([0.0, 0.0], P)
    kf = KalmanFilter(np.eye(2), np.zeros((2, 1)), [[1.0, 0.0]], np.eye(2), [[1.0]])
    with pytest.raises(EngineError, match=words):
        kf.run(([0.0, 0.0], P), [1.0, 2.0])


@pytest.mark.parametrize("P", [np.zeros((2, 2)), np.diag([1e-30, 1e30]), [[1.0, 1.0], [1.0, 1.0]], [[1.0, 1e-17], [0.0, 1.0]]])
def test_covariances_at_the_edge_are_taken(P: object) -> None:
    assert Belief([0.0, 0.0], P).covariance.shape == (2, 2)


def test_a_filter_shows_what_rounding_made_of_its_covariance() -> None:
    """P − M C P with nearly perfect sensors loses its sign; that is shown, and refused only as a start."""
    P = np.array([[1.0, 0.0], [0.0, -1e-9]])
    assert Belief.computed(np.zeros(2), P).covariance[1, 1] == -1e-9
    assert not Belief.computed(np.zeros(2), P).covariance.flags.writeable
