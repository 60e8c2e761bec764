"""Design the H∞ filter: error energy stays below γ² times the noise's energy."""

from __future__ import annotations

import warnings

import numpy as np
from scipy.linalg import LinAlgWarning, solve_continuous_are

from ...design.gain_record import ActsAsGain
from ...design.optimal import lqe
from ...design.riccati import lyapunov
from ...design.riccati_problem import RiccatiProblem, in_balanced_units, unit_scale
from ...plotting import with_plot
from ...systems.arrays import as_checked, as_definite, as_weight, correlations, frozen, symmetric
from ...systems.errors import EngineError, ShapeError
from ...systems.gates.argument_checks import matrix, number, optional, takes
from ...systems.pole_sets import sorted_poles
from ...systems.records import record
from ...systems.stability import is_stable

__all__ = ["RobustGain", "h_infinity"]

NEWTON_STEPS = 2
RESIDUAL_LIMIT = 1e-8  # of the terms of the Riccati equation
NEGATIVE = 1e-9  # how far below zero rounding may push an eigenvalue of the correlations of P


@record()
class RobustGain(ActsAsGain):
    """gain L (n×p), solution P (n×n), poles of A − LC, and the bound gamma that they keep."""

    gain: np.ndarray
    solution: np.ndarray
    poles: np.ndarray
    gamma: float


@takes("continuous", A=matrix("n n"), G=matrix("n q"), C=matrix("p n"), W=matrix(), V=matrix(), gamma=number(above=0, infinite=True),
       Z=optional(matrix("r n")))
def h_infinity(A: object, G: object, C: object, W: object, V: object, *, gamma: float, Z: object | None = None) -> RobustGain:
    """L = PCᵀV⁻¹ with ∫|Z(x − x̂)|² < γ² ∫(wᵀW⁻¹w + vᵀV⁻¹v) for all w, v of finite energy; ẋ = Ax + Gw, y = Cx + v.

    P ≥ 0 solves AP + PAᵀ − P(CᵀV⁻¹C − γ⁻²ZᵀZ)P + GWGᵀ = 0; Z (r×n) says which errors count, by default all. An infinite γ is
    the Kalman–Bucy filter, `lqe`. Raises EngineError where no filter keeps γ (Nagpal and Khargonekar 1991).

    >>> np.round(h_infinity([[-1]], [[1]], [[1]], [[1]], [[1]], gamma=2.0).gain, 4)
    array([[0.4305]])
    """
    A, G, C = as_checked(A), as_checked(G), as_checked(C)
    W, V = as_weight(W, "W", G.shape[1]), as_definite(V, "V", len(C))
    Z = np.eye(len(A)) if Z is None else as_checked(Z)
    if not len(A):
        raise ShapeError("The plant has no states, so there is no gain to design.")
    if np.isinf(gamma):
        kalman = lqe(A, G, C, W, V)
        return RobustGain(kalman.gain, kalman.solution, kalman.poles, np.inf)
    P = _solution(A, C, Z, V, symmetric(G @ W @ G.T), gamma)
    L = np.linalg.solve(V, C @ P).T
    return RobustGain(frozen(L), frozen(P), with_plot(frozen(sorted_poles(A - L @ C))), float(gamma))


def _solution(A: np.ndarray, C: np.ndarray, Z: np.ndarray, V: np.ndarray, noise: np.ndarray, gamma: float) -> np.ndarray:
    """P by SciPy's pencil, with Z as sensors whose noise has the negative covariance −γ²I; in states and sensors of like size."""
    p, r = len(C), len(Z)
    weight = np.eye(p + r) * gamma**2
    weight[:p, :p] = V
    own, states, _ = in_balanced_units(RiccatiProblem(A.T, np.hstack([C.T, Z.T]), noise, weight, np.zeros((len(A), p + r))))
    scaled, cost, _ = unit_scale(own)
    weight = scaled.R.copy()
    weight[p:, p:] *= -1
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("error", LinAlgWarning)
            P = symmetric(solve_continuous_are(scaled.A, scaled.B, scaled.Q, weight))
    except (np.linalg.LinAlgError, ValueError, LinAlgWarning) as problem:
        raise _no_filter(gamma) from problem
    seen = scaled.B @ np.linalg.solve(weight, scaled.B.T)
    P = _polished(scaled.A, seen, scaled.Q, P)
    terms = P @ scaled.A, P @ seen @ P, scaled.Q
    residual = terms[0] + terms[0].T - terms[1] + terms[2]
    size = sum(float(np.linalg.norm(term)) for term in terms)
    least = np.linalg.eigvalsh(correlations(P)[0])[0]
    positive = least > -NEGATIVE and np.diag(P).min() >= 0
    if not (positive and np.linalg.norm(residual) <= RESIDUAL_LIMIT * size and is_stable(scaled.A - seen @ P)):
        raise _no_filter(gamma)
    return cost * P / states / states[:, None]


def _polished(A: np.ndarray, seen: np.ndarray, noise: np.ndarray, P: np.ndarray) -> np.ndarray:
    """P after a step or two of Newton's, where they help."""
    def rest(P: np.ndarray) -> np.ndarray:
        return P @ A + A.T @ P - P @ seen @ P + noise

    for _ in range(NEWTON_STEPS):
        try:
            better = symmetric(P + lyapunov((A - seen @ P).T, -rest(P)))
        except np.linalg.LinAlgError:
            break
        if not np.linalg.norm(rest(better)) < np.linalg.norm(rest(P)):
            break
        P = better
    return P


def _no_filter(gamma: float) -> EngineError:
    return EngineError("No filter keeps the bound γ = {gamma:.3g}; raise it, or measure more.", gamma=gamma)
