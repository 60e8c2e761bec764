"""Check two classics: Doyle's vanishing margins and MATLAB's Kalman example."""

from __future__ import annotations

import numpy as np

from ..engine import Plant, closed_loop, compensator, dlqe, frequency_response, lqe, lqr
from .record import Published

FORMULA = "the value of the printed formula"
DOYLE, MATLAB = "Doyle 1978", "MATLAB kalman"
UNSTABLE = Plant(np.array([[1, 1], [0, 1]]), np.array([[0], [1]]), np.array([[1, 0]]))
A_D = np.array([[1.1269, -0.4940, 0.1129], [1, 0, 0], [0, 1, 0]])
B_D = np.array([[-0.3832], [0.5919], [0.5191]])
C_D = np.array([[1.0, 0.0, 0.0]])


def doyle_gains(q: float, sigma: float) -> tuple[np.ndarray, np.ndarray]:
    """K and L of the example for Q = q[1;1][1 1], R = 1, W = σ[1;1][1 1], V = 1."""
    ones = np.ones((2, 2))
    K = lqr(UNSTABLE.A, UNSTABLE.B, q * ones, [[1]]).gain
    return K, lqe(UNSTABLE.A, np.eye(2), UNSTABLE.C, sigma * ones, [[1]]).gain


def gain_limit(q: float, sigma: float) -> float:
    """The largest loop gain m for which plant (A, mB, C) and the compensator of (A, B, C) are stable, by bisection."""
    K, L = doyle_gains(q, sigma)
    low, high = 1.0, 2.0
    for _ in range(60):
        m = (low + high) / 2
        stable = closed_loop(Plant(UNSTABLE.A, m * UNSTABLE.B, UNSTABLE.C), K, L, model=UNSTABLE).stable
        low, high = (m, high) if stable else (low, m)
    return low


def nearest_to_minus_one(q: float, sigma: float) -> float:
    """min over ω of |1 + L(jω)|, the loop cut at the input, ω = 0 and ∞ included."""
    built = compensator(UNSTABLE, *doyle_gains(q, sigma))
    omega = np.concatenate([[0.0], np.geomspace(1e-3, 1e4, 20001)])
    of_plant = frequency_response(UNSTABLE.A, UNSTABLE.B, UNSTABLE.C, UNSTABLE.D, omega)[:, 0, 0]
    of_compensator = frequency_response(built.A, built.B, built.C, built.D, omega)[:, 0, 0]
    return float(min(np.abs(1 - of_plant * of_compensator).min(), 1.0))


def kalman_gains() -> np.ndarray:
    """Filter gain M of MATLAB's example, Q = 2.3 through B, R = 1."""
    return dlqe(A_D, B_D, C_D, [[2.3]], [[1.0]]).filter_gain


def predictor_gap() -> float:
    """The predictor gain against A·M."""
    steady = dlqe(A_D, B_D, C_D, [[2.3]], [[1.0]])
    return float(np.abs(steady.predictor_gain - A_D @ kalman_gains()).max())


RECORDS = (
    Published(DOYLE, "q = 60: K = f(1, 1), f = 2 + √(4 + q)", "10, 10", lambda: doyle_gains(60, 60)[0],
              note=FORMULA, tolerance=1e-9),
    Published(DOYLE, "σ = 60: L = d(1, 1), d = 2 + √(4 + σ)", "10, 10", lambda: doyle_gains(60, 60)[1],
              note=FORMULA, tolerance=1e-9),
    Published(DOYLE, "q = 1, σ = 32: f, d", "4.2360680, 4.2360680, 8, 8",
              lambda: [*doyle_gains(1, 32)[0].ravel(), *doyle_gains(1, 32)[1].ravel()], note=FORMULA, tolerance=1e-7),
    Published(DOYLE, "q = σ = 60: stable up to m = 1 + 1/(df)", "1.01", lambda: gain_limit(60, 60), note=FORMULA,
              tolerance=1e-9),
    Published(DOYLE, "q = 1, σ = 32: stable up to m = 1 + 1/(df)", "1.0295085", lambda: gain_limit(1, 32),
              note=FORMULA),
    Published(DOYLE, "q = σ = 1: min |1 + L|", "", lambda: nearest_to_minus_one(1, 1), "beyond", "0.0528",
              note="control.stability_margins says infinite"),
    Published(MATLAB, "filter gain M", "0.5345, 0.0101, -0.4776", kalman_gains),
    Published(MATLAB, "predictor gain against A·M", "A·M", predictor_gap, right="0", tolerance=1e-12),
)
