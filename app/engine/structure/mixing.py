"""Find the static mixing S = [[1, b], [a, 1]] that minimises the coupling of a 2×2 block.

Source: report on the three-degree-of-freedom platform, equations (19)–(22).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.optimize import minimize

from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import FINITE, INTEGER, array, count, pair, takes
from ..systems.records import record

__all__ = ["Coupling", "Mixing", "best_mixing", "coupling", "mixing_matrix"]

NEAR_SINGULAR = 1e-3  # |1 − ab| below which two mixed inputs are one
EVALUATIONS = 600
VALLEY_TOLERANCE = 1e-3  # how near a simplex must come to the end of a valley before Newton's steps
MAX_NEWTON_STEPS = 12
FINAL_STEP = 1e-6  # a step of Newton's below which J, all rounding there, is no longer asked whether it falls


@record()
class Coupling:
    """The index J of eq. (21) for a 2×2 block G (n_ω, 2, 2), as a function of a and b.

    J(a, b) = Σ_ω |g₁₁b + g₁₂|² / |g₁₁ + g₁₂a|² + |g₂₁ + g₂₂a|² / |g₂₁b + g₂₂|², the squared ratios of the off-diagonal
    entries of G S to the diagonal entry of their row. Without unit.
    """

    response: np.ndarray

    @property
    def count(self) -> int:
        """Number of frequencies: J/count is the mean."""
        return len(self.response)

    @cached_property
    def quadratics(self) -> tuple[np.ndarray, np.ndarray]:
        """For each row the coefficients of |own·x + other|² as a quadratic in x, and of |own + other·x|²: (n_ω, 3)."""
        G = self.response

        def quadratic(p: np.ndarray, q: np.ndarray) -> np.ndarray:
            return np.column_stack([np.abs(p)**2, 2 * np.real(p.conj() * q), np.abs(q)**2])
        return quadratic(G[:, 0, 0], G[:, 0, 1]), quadratic(G[:, 1, 1], G[:, 1, 0])

    def __call__(self, a: float, b: float) -> float:
        """J at one point; ∞ where 1 − ab is (nearly) zero."""
        if abs(1 - a * b) < NEAR_SINGULAR:
            return np.inf
        first, second = self.quadratics
        with np.errstate(divide="ignore", invalid="ignore"):
            J = _share(first, a, b).sum() + _share(second, b, a).sum()
        return float(J) if np.isfinite(J) else np.inf

    def slopes(self, a: float, b: float) -> tuple[np.ndarray, np.ndarray]:
        """Gradient (2,) and Hessian matrix (2×2) of J in (a, b)."""
        first, second = self.quadratics
        (aa, ba, bb), (bb2, ab, aa2) = _bends(first, a, b), _bends(second, b, a)
        return (np.array([aa[0] + aa2[0], bb[0] + bb2[0]]),
                np.array([[aa[1] + aa2[1], ba + ab], [ba + ab, bb[1] + bb2[1]]]))

    def map(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """J over a grid, (n_b, n_a): rows follow b; ∞ where 1 − ab is (nearly) zero."""
        first, second = self.quadratics
        with np.errstate(divide="ignore", invalid="ignore"):
            one = _grid(first, a, b).T
            two = _grid(second, b, a)
            J = np.where(np.abs(1 - np.outer(b, a)) < NEAR_SINGULAR, np.inf, one + two)
        return np.where(np.isfinite(J), J, np.inf)


def _share(row: np.ndarray, inside: float, outside: float) -> np.ndarray:
    """|own·outside + other|² / |own + other·inside|² at each frequency."""
    P, Q, R = row.T
    return (P * outside**2 + Q * outside + R) / (P + Q * inside + R * inside**2)


def _bends(row: np.ndarray, inside: float, outside: float) -> tuple[tuple[float, float], float, tuple[float, float]]:
    """Of the sum over `_share`: first and second derivative by `inside`, the mixed one, both by `outside`."""
    P, Q, R = row.T
    over, over1, over2 = (P * outside + Q) * outside + R, 2 * P * outside + Q, 2 * P
    under, under1, under2 = P + (Q + R * inside) * inside, Q + 2 * R * inside, 2 * R
    share, way = over / under, under1 / under
    return ((float(-(share * way).sum()), float((share * (2 * way**2 - under2 / under)).sum())), float(-(over1 / under * way).sum()),
            (float((over1 / under).sum()), float((over2 / under).sum())))


def _grid(row: np.ndarray, inside: np.ndarray, outside: np.ndarray) -> np.ndarray:
    """The sum over frequencies of `_share` for every pair: (n_inside, n_outside), by one product of matrices."""
    P, Q, R = row.T
    weights = (1 / (P + np.outer(inside, Q) + np.outer(inside**2, R))) @ row
    return weights[:, :1] * outside**2 + weights[:, 1:2] * outside + weights[:, 2:]


@record(eq=True)
class Mixing:
    """The mixing with the least index: a, b and J; `start` is the closed-form (a, b), start_J its index, plain_J that
    of no mixing; `count` frequencies were summed."""

    a: float
    b: float
    J: float
    start: tuple[float, float]
    start_J: float
    plain_J: float
    count: int


@takes(a=FINITE, b=FINITE, size=count(2, 1000), channels=pair(INTEGER, INTEGER))
def mixing_matrix(a: float, b: float, *, size: int = 2, channels: tuple[int, int] = (0, 1)) -> np.ndarray:
    """The identity of `size` with [[1, b], [a, 1]] at two channels: T_u,opt = T_u S, eq. (20).

    Raises EngineError where 1 − ab is nearly zero: the two mixed inputs would then be one.
    """
    if abs(1 - a * b) < NEAR_SINGULAR:
        raise EngineError("With a = {a:.4g} and b = {b:.4g} the mixing is singular, 1 − ab = {a2:.2g}; keep ab "
                          "away from 1.",
                          a=a, b=b, a2=1 - a * b)
    i, j = channels
    if i == j or not (0 <= i < size and 0 <= j < size):
        raise ShapeError("Mixing needs two different channels from 0 to {size}.", size=size - 1)
    S = np.eye(size)
    S[i, j], S[j, i] = b, a
    return S


@takes(response=array("… k k", imaginary=True), channels=pair(INTEGER, INTEGER))
def coupling(response: object, *, channels: tuple[int, int] = (0, 1)) -> Coupling:
    """The index J(a, b) of two channels of a response G (n_ω, k, k). Raises ShapeError or EngineError."""
    G = np.asarray(response)
    if G.ndim != 3 or not len(G) or not all(0 <= i < G.shape[1] for i in channels) or channels[0] == channels[1]:
        raise ShapeError("The index needs a response of at least one frequency, n×k×k, and two different channels "
                         "of it.")
    block = G[:, channels][:, :, channels]
    if not np.isfinite(block).all() or not (np.abs(np.diagonal(block, axis1=1, axis2=2)) > 0).all():
        raise EngineError("The index divides by the diagonal entries: they must be finite and not zero in the "
                          "whole band.")
    return Coupling(np.ascontiguousarray(block) / np.abs(block).max())  # J has no unit, and squares stay in range


def _bottom(J: Coupling, x: np.ndarray) -> np.ndarray | None:
    """The end (2,) of the valley near x by Newton's steps, to rounding of the slopes; None where they do not lead there."""
    begun, value = x, J(*x)
    for _ in range(MAX_NEWTON_STEPS):
        slope, bend = J.slopes(*x)
        if not (bend[0, 0] > 0 and bend[0, 0] * bend[1, 1] > bend[0, 1] ** 2):
            return None
        step = np.linalg.solve(bend, slope)
        x, last = x - step, value
        value = J(*x)
        if (not value <= last * (1 + 1e-12) and np.abs(step).max() > FINAL_STEP) or np.abs(x - begun).max() > 10 * VALLEY_TOLERANCE:
            return None
        if np.abs(step).max() <= 1e-10:
            return x
    return None


@takes(response=array("… k k", imaginary=True), channels=pair(INTEGER, INTEGER))
def best_mixing(response: object, *, channels: tuple[int, int] = (0, 1)) -> Mixing:
    """(a, b) that minimises J of eq. (21): a closed-form start, then simplices without derivatives, then Newton's steps.

    Start: least squares of the numerators over the unmixed diagonal, b = −mean Re(g₁₂/g₁₁), a = −mean Re(g₂₁/g₂₂).
    J has several valleys where resonances lie inside the band; simplices start from the closed form and from no mixing,
    and the better end is kept, so J is never above that of either.
    """
    J = coupling(response, channels=channels)
    G = J.response
    start = (-float(np.mean((G[:, 1, 0] / G[:, 1, 1]).real)), -float(np.mean((G[:, 0, 1] / G[:, 0, 0]).real)))
    spread = max(0.05, *(abs(v) for v in start))

    def walk(x: np.ndarray, side: float, near: float, flat: float) -> np.ndarray:
        corners = np.array([x, (x[0] + side, x[1]), (x[0], x[1] + side)])
        return minimize(lambda v: J(v[0], v[1]), x, method="Nelder-Mead", options={
            "initial_simplex": corners, "xatol": near, "fatol": flat, "maxfev": EVALUATIONS}).x

    def run(x: tuple[float, float]) -> tuple[float, float, float]:
        valley = walk(np.array(x), spread, VALLEY_TOLERANCE, np.inf)
        end = _bottom(J, valley)
        if end is None:
            valley = walk(valley, VALLEY_TOLERANCE, 1e-9, 1e-12)  # as near as J itself can tell, which is half the digits of the slopes
            end = _bottom(J, valley)
            end = valley if end is None else end
        return J(*end), float(end[0]), float(end[1])
    begins = [x for x in (start, (0.0, 0.0)) if np.isfinite(J(*x))]
    value, a, b = min(run(x) for x in begins)
    return Mixing(a, b, value, start, J(*start), J(0.0, 0.0), J.count)
