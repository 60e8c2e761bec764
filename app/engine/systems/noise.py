"""Compute exact noise covariances over a step, and draw noise from a seed."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from .arrays import symmetric
from .balance import MIN_RATE, balance
from .gates.argument_checks import GENERATOR, HORIZON, MOST_NUMBERS, SECONDS, count, covariance, matrix, takes

__all__ = ["process_noise", "step_covariance"]


@takes(A=matrix("n n"), intensity=covariance("n"), duration=HORIZON)
def step_covariance(A: np.ndarray, intensity: np.ndarray, duration: float) -> np.ndarray:
    """Q_d = ∫₀ʰ e^{A s} Q e^{Aᵀ s} ds, n×n, for the intensity Q (n×n) of white noise on ẋ = A x + w.

    Van Loan (1978), the exponential of [−A Q; 0 Aᵀ], over a fraction of the step so short that it cannot
    overflow, then Q(2h) = Q(h) + Φ(h) Q(h) Φ(h)ᵀ up to the whole step. In states balanced with what drives
    them, and with Q of the size of A.
    """
    n = len(A)
    if not n or not intensity.any():
        return np.zeros((n, n))
    scale = balance(A, np.sqrt(np.diag(intensity))[:, None]).states
    A, own = A * scale / scale[:, None], intensity / scale / scale[:, None]
    size = 2.0 ** np.round(np.log2(max(float(np.linalg.norm(A, 1)), MIN_RATE)) - np.log2(np.abs(own).max()))
    return scale * symmetric(_over_step(A, own * size, duration)) / size * scale[:, None]


def _over_step(A: np.ndarray, intensity: np.ndarray, duration: float) -> np.ndarray:
    n = len(A)
    doublings = max(0, int(np.ceil(np.log2(max(np.linalg.norm(A, 1) * duration, 1e-300)))) + 1)
    h = duration / 2**doublings
    exponential: np.ndarray = expm(np.block([[-A, intensity], [np.zeros((n, n)), A.T]]) * h)
    Phi: np.ndarray = exponential[n:, n:].T
    Q: np.ndarray = Phi @ exponential[:n, n:]
    for _ in range(doublings):
        Q = Q + Phi @ Q @ Phi.T
        Phi = Phi @ Phi
    return Q


@takes(covariance=matrix("n n"))
def root(covariance: np.ndarray) -> np.ndarray:
    """The factor D R^½ of a covariance D R D (R: correlations), so that root rootᵀ is the covariance."""
    spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    divisor = np.where(spread > 0, spread, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(divisor, divisor))
    return spread[:, None] * ((vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T)


def _inverse(covariance: np.ndarray) -> np.ndarray:
    """The pseudo-inverse of a covariance, whatever the units of its entries: a small variance is not none."""
    spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    scale = np.outer(*[np.where(spread > 0, spread, 1.0)] * 2)
    return np.linalg.pinv(covariance / scale, hermitian=True) / scale


@takes(M=matrix("N N"), G=matrix("N q"), W=covariance("q"), duration=SECONDS, steps=count(0, MOST_NUMBERS // 20, beside="N"),
       rng=GENERATOR)
def process_noise(M: np.ndarray, G: np.ndarray, W: np.ndarray, duration: float, steps: int,
                  rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """What white noise of intensity W (q×q) through G (N×q) does over each step of ż = M z + G w.

    Returns the means of w over the steps, (steps, q) with covariance W/h, and the jumps of z at their ends,
    (steps, N), drawn jointly: the exact covariance of z and ∫w over a step comes from `step_covariance` with
    ∫w as extra states. The means depend on the seed and W alone, so designs can be compared on one noise.
    """
    N, q = G.shape
    wide = np.zeros((N + q, N + q))
    wide[:N, :N] = M
    enter = np.vstack([G, np.eye(q)])
    joint = step_covariance(wide, enter @ W @ enter.T, duration)
    slope = joint[:N, N:] @ _inverse(W * duration)  # of the jump on ∫w
    rest = joint[:N, :N] - slope @ joint[N:, :N]
    total = rng.standard_normal((steps, q)) @ root(W * duration).T
    jumps = total @ slope.T + rng.standard_normal((steps, N)) @ root(symmetric(rest)).T
    return total / duration, jumps
