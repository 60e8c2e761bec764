"""Lyapunov's equations by square-root factors."""

import numpy as np
import pytest

from observer_lab.engine import EngineError
from observer_lab.engine.systems import settled_covariance


@pytest.mark.parametrize("dt", [0.0, 0.1])
def test_variances_that_do_not_settle_are_refused_and_never_infinite(dt: float) -> None:
    """What rounding, or the caller, let through as stable."""
    A = np.diag([0.5, 1.1]) if dt else np.diag([-1.0, 0.5])
    with pytest.raises(EngineError, match="variances"):
        settled_covariance(A, np.ones((2, 1)), dt=dt)
    stable = A - np.diag([0.0, 0.7])
    np.testing.assert_allclose(np.diag(settled_covariance(stable, np.ones((2, 1)), dt=dt)),
                               1 / (1 - np.diag(stable)**2) if dt else -0.5 / np.diag(stable), rtol=1e-13)
