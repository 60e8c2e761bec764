"""Check the critical loss of a scalar plant and the example of Sinopoli et al. (2004)."""

from __future__ import annotations

import numpy as np

from ..engine import critical_loss
from ..engine.network import mare, mean_bounds
from .record import Published

SCALAR, SINOPOLI = "scalar plant, lossy measurements", "Sinopoli et al. 2004"
FORMULA = "the value of the printed formula"
A, C = np.array([[1.25, 0.0], [1.0, 1.1]]), np.array([[1.0, 1.0]])
Q, R = 20 * np.eye(2), np.array([[2.5]])


def edge(a: float) -> float:
    """The critical loss of x⁺ = a x + w, y = x + v."""
    found = critical_loss([[a]], [[1.0]])
    return found.lost if found.exact else float("nan")


def growth_at(loss: float, a: float) -> float:
    """Growth of the lower bound of the mean covariance over the last of 400 steps."""
    lower, _ = mean_bounds([[a]], [[1.0]], 1.0, 1.0, 1.0, loss, 400)
    return float(lower[-1, 0, 0] / lower[-2, 0, 0])


def arrivals() -> tuple[float, float]:
    """Lower and upper bound of the critical probability of arrival in the example."""
    found = critical_loss(A, C)
    return 1 - found.lost, 1 - found.safe


def solvable_from() -> float:
    """The arrival probability below which the modified Riccati equation has no solution: where 1/‖X‖ falls to 0, by secants."""

    def calm(arrival: float) -> float:
        return float(1 / np.linalg.norm(mare(A, C, Q, R, 1 - arrival)))

    before, here = 0.6, 0.55
    while (left := calm(here)) > 1e-9:
        before, here = here, here - left * (here - before) / (left - calm(before))
    return here


RECORDS = (
    Published(SCALAR, "a = 1.25: critical loss 1/a²", "0.64", lambda: edge(1.25), note=FORMULA, tolerance=1e-12),
    Published(SCALAR, "a = 2: critical loss 1/a²", "0.25", lambda: edge(2.0), note=FORMULA, tolerance=1e-12),
    Published(SCALAR, "a = 2, loss 0.3: the mean grows by loss · a² a step", "1.2", lambda: growth_at(0.3, 2.0),
              note=FORMULA, tolerance=1e-9),
    Published(SINOPOLI, "A = [1.25 0; 1 1.1], C = [1 1]: lower bound 1 − 1/1.25² of the critical arrival rate", "0.36",
              lambda: arrivals()[0], note=FORMULA, tolerance=1e-12),
    Published(SINOPOLI, "the same: upper bound, 1 − 1/(1.25 · 1.1)² for one sensor", "", lambda: arrivals()[1],
              "beyond", "0.471074", note="the closed form for a sensor of rank one"),
    Published(SINOPOLI, "the same: least arrival rate with a solution of X = g(X)", "", solvable_from, "beyond",
              "0.471074", tolerance=3e-6, note="where its solution grows without bound, Q = 20 I, R = 2.5"),
)
