"""How large the estimation error of the block gets: in the limit, along a ray of observers, from sample to sample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm, solve_discrete_lyapunov

from app.engine import Plant
from app.engine.filters import ErrorParts

__all__ = ["Ray", "growing", "ray_of"]


@dataclass(frozen=True, eq=False)
class Ray:
    """Observers whose poles are those of one pattern times a factor.

    speed (n,): geometric mean of |pole| in rad/s; process, sensor (n, 2): variances of the error in position and
    velocity by cause; peak (n,): largest velocity error for each metre of starting error, without noise, in 1/s.
    """

    speed: np.ndarray
    process: np.ndarray
    sensor: np.ndarray
    peak: np.ndarray


def ray_of(plant: Plant, pattern: tuple[complex, ...], speeds: np.ndarray, W: float, V: float) -> Ray:
    """All observers along a ray at once, for two states and one output: Ackermann's gain, Lyapunov by Kronecker."""
    unit = np.asarray(pattern) / np.sqrt(abs(pattern[0] * pattern[1]))
    damping, square = -np.real(unit.sum()) * speeds, np.real(unit[0] * unit[1]) * speeds**2  # s² + damping s + square
    A, C, eye = plant.A, plant.C, np.eye(2)
    last = np.linalg.solve(np.vstack([C, C @ A]), np.array([[0.0], [1.0]]))
    L = (A @ A + damping[:, None, None] * A + square[:, None, None] * eye) @ last
    F = A - L @ C
    M = np.einsum("kij,ab->kiajb", F, eye) + np.einsum("ij,kab->kiajb", eye, F)
    noise = np.stack([np.broadcast_to(W * plant.B @ plant.B.T, F.shape), V * L @ np.swapaxes(L, 1, 2)], axis=-1)
    P = np.linalg.solve(M.reshape(-1, 4, 4), -noise.reshape(-1, 4, 2)).reshape(-1, 2, 2, 2)
    variances = np.maximum(np.diagonal(P, axis1=1, axis2=2), 0.0)  # (n, cause, state)
    return Ray(speeds, variances[:, 0], variances[:, 1], peak_of(F[:, 1, 0], damping, square))


def peak_of(F21: np.ndarray, damping: np.ndarray, square: np.ndarray) -> np.ndarray:
    """max |e₂(t)| for ė = F e from e(0) = (1, 0): e₂ = F₂₁ e^{αt} sinh(δt)/δ with α = −damping/2, δ² = α² − square.

    Its slope vanishes at tanh(δt) = −δ/α, where sinh(δt)/δ = 1/√square.
    """
    alpha = -damping / 2
    gap = alpha**2 - square
    delta = np.sqrt(np.abs(gap))
    small = delta < 1e-6 * np.abs(alpha)
    safe = np.where(small, 1.0, delta)
    turning = np.arctan2(safe, -alpha) / safe
    real = np.arctanh(np.minimum(safe / -alpha, 1 - 1e-12)) / safe
    t = np.where(small, -1 / alpha, np.where(gap < 0, turning, real))
    return np.abs(F21) * np.exp(alpha * t) / np.sqrt(square)


def growing(plant: Plant, L: np.ndarray, parts: ErrorParts, V: float, dt: float, steps: int) -> np.ndarray:
    """Covariances (steps, 2, 2) of e at 0, dt, … from P(0) = 0, exactly as simulated: v is held over a step.

    P_k = P_h − Φᵏ P_h Φᵏᵀ, where P_h is the limit with the sampled sensor noise of covariance V/dt.
    """
    F = plant.A - L @ plant.C
    wide = np.zeros((4, 4))
    wide[:2, :2], wide[:2, 2:] = F, np.eye(2)
    both = expm(wide * dt)
    Phi, push = both[:2, :2], both[:2, 2:] @ L
    limit = parts.process + solve_discrete_lyapunov(Phi, V / dt * push @ push.T)
    powers = np.empty((steps, 2, 2))
    powers[0], done, jump = np.eye(2), 1, Phi
    while done < steps:
        more = min(done, steps - done)
        powers[done:done + more] = powers[:more] @ jump
        done, jump = done + more, jump @ jump
    return limit - powers @ limit @ np.swapaxes(powers, 1, 2)
