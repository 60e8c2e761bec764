"""One gate for matrices and periods: nonsense is one sentence, before any work."""

from __future__ import annotations

import numpy as np
import pytest

from observer_lab.engine import EngineError, Plant, lqe, lqr, place
from observer_lab.engine.systems import as_covariance, as_matrix

MASKED = np.ma.masked_array(np.eye(2), mask=[[False, True], [False, False]])
NONSENSE = [None, "text", b"text", [[1, 2], [3]], [[1, 1j]], np.array([[1j, 0], [0, 1]]), MASKED, [[np.nan, 0], [0, 1]],
            [[np.inf, 0], [0, 1]], np.zeros((2, 2, 2)), {}, object(), np.array(["a"]), np.array(["2020-01-01"], dtype="M8[D]"), 10**400]


@pytest.mark.parametrize("value", NONSENSE, ids=lambda v: type(v).__name__)
@pytest.mark.parametrize("use", [
    lambda v: as_matrix(v, "M"), lambda v: as_covariance(v, "M", 2), lambda v: Plant(v, np.eye(2), np.eye(2)),
    lambda v: place(np.eye(2), v, [-1, -2]), lambda v: lqr(np.eye(2), np.eye(2), v, np.eye(2)),
    lambda v: lqe(np.eye(2), np.eye(2), np.eye(2), np.eye(2), v)], ids=["matrix", "covariance", "plant", "place", "lqr", "lqe"])
def test_what_is_no_matrix_is_refused_in_a_sentence(use: object, value: object) -> None:
    with pytest.raises(EngineError):
        use(value)  # type: ignore[operator]


@pytest.mark.parametrize("dt", [None, "a", -1.0, np.nan, np.inf, [1, 2], 10**400], ids=lambda v: repr(v)[:20])
def test_a_period_that_is_none_is_refused(dt: object) -> None:
    with pytest.raises(EngineError, match="dt must be"):
        Plant([[1]], [[1]], [[1]], dt=dt)  # type: ignore[arg-type]


def test_an_asymmetric_small_entry_beside_a_large_variance_is_refused() -> None:
    with pytest.raises(EngineError, match="symmetric"):
        as_covariance([[1e6, 0.5], [0.4, 1.0]], "P", 2)
