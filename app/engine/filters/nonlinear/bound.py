"""Compute the posterior Cramér–Rao bound for the filters of a nonlinear plant."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ...systems.arrays import correlations, is_definite, symmetric
from ...systems.errors import EngineError, ShapeError
from ...systems.gates.argument_checks import array, choice, covariance, takes
from ...systems.noise import root
from ..linear.kalman import ahead, gain, joseph

__all__ = ["posterior_bound"]

NO_NOISE_RTOL = 1e-12  # eigenvalue of the correlations of Q beside the largest: below it there is no noise in that direction
NOISE_FREE_SLOPE_RTOL = 1e-9  # share of a slope by which it may differ from run to run where there is no noise
MAX_UNKNOWNS = 2000  # numbers that may be unknown together
Unknown = Literal["states", "noise"]


@takes(F=array("k N n n"), H=array("j N p n"), Q=covariance("n"), R=covariance("p"), P=covariance("n"),
       unknown=choice("states", "noise"))
def posterior_bound(F: np.ndarray, H: np.ndarray, Q: np.ndarray, R: np.ndarray, P: np.ndarray, *,
                    unknown: Unknown = "states") -> np.ndarray:
    """A covariance (K, n, n) that no filter's errors x̂[k|k] − x[k] stay below on average, at the samples k = 0 … K − 1.

    x[k+1] = f(x[k], u[k]) + w[k], y[k] = h(x[k]) + v[k], with white Gaussian w, v of covariances Q (n×n), R (p×p) and x[0] of
    covariance P (n×n). F (K − 1, N, n, n) and H (K, N, p, n): the slopes ∂f/∂x, ∂h/∂x along N true runs; E is their mean.
    Both bounds are right; on a linear plant both are the covariance of the Kalman filter, elsewhere either may be the higher.
    "states", all x[k] for unknowns (Tichavský, Muravchik and Nehorai 1998): J[0] = P⁻¹ + E HᵀR⁻¹H,
    J[k+1] = Q⁻¹ − Q⁻¹ E F (J[k] + E FᵀQ⁻¹F)⁻¹ E Fᵀ Q⁻¹ + E HᵀR⁻¹H, and the bound is J⁻¹. Computed as
    P⁻ = E F (J + V)⁻¹ E Fᵀ + Q, V = E (F − E F)ᵀ Q⁻¹ (F − E F), so that no Q⁻¹ is needed where F does not vary.
    "noise", the start and all w for unknowns, θ = (x[0], w[0], …) of unit variance: with S[k] = ∂x[k]/∂θ it is
    E S (I + Σ E SᵀHᵀR⁻¹HS)⁻¹ E Sᵀ (Van Trees 1968), for any Q; the time grows as the cube of the number of samples.
    Raises ShapeError, EngineError where R is singular, where "states" lacks noise, where too much is unknown.

    >>> F, H, one = np.full((2, 1, 1, 1), 0.5), np.ones((3, 1, 1, 1)), np.eye(1)
    >>> posterior_bound(F, H, 3 * one, one, one)[:, 0, 0].round(4)
    array([0.5   , 0.7576, 0.7613])
    """
    if len(F) + 1 != len(H) or not H.shape[1]:
        raise ShapeError("H must hold one sample more than F, and at least one run; they hold {h} and {f} samples of {runs} runs.",
                         h=len(H), f=len(F), runs=H.shape[1])
    if not is_definite(R):
        raise EngineError("{name} must be positive definite: every eigenvalue above zero.", name="R")
    return (_of_states if unknown == "states" else _of_noise)(F, H, Q, R, P)


def _of_states(F: np.ndarray, H: np.ndarray, Q: np.ndarray, R: np.ndarray, P: np.ndarray) -> np.ndarray:
    """The recursion, each half of it a correction by what is told."""
    middle, start = F.mean(axis=1), np.asarray(P, dtype=float)
    told, varying = _readings(_mean_square(_whitening(R) @ H)), _readings(_varying(F - middle[:, None], middle, Q))
    found = [_corrected(start, told[0])]
    for k, each in enumerate(middle):
        found.append(_corrected(ahead(each, Q, _corrected(found[-1], varying[k])), told[k + 1]))
    return np.array(found)


def _of_noise(F: np.ndarray, H: np.ndarray, Q: np.ndarray, R: np.ndarray, P: np.ndarray) -> np.ndarray:
    """The information of the start and all noise together, one sample more each time."""
    runs, n = H.shape[1], len(P)
    values, axes, spread = _axes(Q)
    noisy = values > NO_NOISE_RTOL * max(values[-1], 0.0)
    enters = np.broadcast_to(spread[:, None] * axes[:, noisy] * np.sqrt(values[noisy]), (runs, n, int(noisy.sum())))
    count = n + len(F) * enters.shape[2]
    if count > MAX_UNKNOWNS:
        raise EngineError("{count} numbers are unknown together, more than {most}; give fewer samples, or take the states for unknowns.",
                          count=count, most=MAX_UNKNOWNS)
    S: np.ndarray = np.broadcast_to(root(P), (runs, n, n))
    seen, J, found = _whitening(R) @ H, np.eye(n), []
    for k, each in enumerate(seen):
        if k:
            S = np.concatenate([F[k - 1] @ S, enters], axis=2)
            wide = np.eye(S.shape[2])
            wide[:len(J), :len(J)] = J
            J = wide
        J = J + _mean_square(each @ S)
        middle = S.mean(axis=0)
        found.append(symmetric(middle @ np.linalg.solve(J, middle.T)))
    return np.array(found)


def _whitening(R: np.ndarray) -> np.ndarray:
    """M (p×p) with MᵀM = R⁻¹."""
    return np.linalg.inv(root(R))


def _mean_square(M: np.ndarray) -> np.ndarray:
    """E MᵀM (…, n, n) over the runs of M (…, N, p, n)."""
    rows = M.reshape(*M.shape[:-3], -1, M.shape[-1])
    return rows.swapaxes(-1, -2) @ rows / M.shape[-3]


def _axes(Q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eigenvalues and eigenvectors of the correlations of Q, and its deviations (n,)."""
    even, spread = correlations(Q)
    values, axes = np.linalg.eigh(even)
    return values, axes, spread


def _varying(away: np.ndarray, middle: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """E (F − E F)ᵀ Q⁻¹ (F − E F) (k, n, n) of away (k, N, n, n), by the directions in which Q is noise."""
    values, axes, spread = _axes(Q)
    noisy = values > NO_NOISE_RTOL * max(values[-1], 0.0)
    turned = axes.T @ (away / spread[:, None])
    if not noisy.all():
        size = np.abs(axes.T) @ np.abs(middle / spread[:, None])
        if np.any(np.abs(turned[:, :, ~noisy]) > NOISE_FREE_SLOPE_RTOL * size[:, None, ~noisy]):
            raise EngineError("Q is singular where the slopes of f differ between runs. Give every such state some noise, or treat the "
                              "noise as unknown.")
    return _mean_square(turned[:, :, noisy] / np.sqrt(values[noisy])[:, None])


def _readings(information: np.ndarray) -> np.ndarray:
    """C (k, n, n) with CᵀC the information (k, n, n): what is told as readings C x with noise I."""
    spread = np.sqrt(np.maximum(np.diagonal(information, axis1=1, axis2=2), 0.0))
    divisor = np.where(spread > 0, spread, 1.0)
    values, axes = np.linalg.eigh(information / (divisor[:, :, None] * divisor[:, None]))
    return np.sqrt(np.maximum(values, 0.0))[:, :, None] * axes.swapaxes(1, 2) * spread[:, None]


def _corrected(P: np.ndarray, C: np.ndarray) -> np.ndarray:
    """(P⁻¹ + CᵀC)⁻¹ (n×n), right where P is singular too."""
    one = np.eye(len(P))
    return joseph(P, C, one, gain(P, C, one)[1])
