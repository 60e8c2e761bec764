"""Estimate x(0) from y and its derivatives, and from noisy y over a growing window."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from .cases import Sensed

KNOWN_SHARE = 0.1  # a direction is known when its half axis has shrunk to a tenth
SIGMAS_FOR_95_PERCENT = tuple(float(np.sqrt(chdtri(k, 0.05))) for k in (1, 2, 3))  # σ that hold 95 % of 1, 2, 3 normal numbers


@dataclass(frozen=True, eq=False)
class Rebuilt:
    """x(0) from the first `rows` block rows of O: `guess` (n,), numerical `rank`, and per state the share fixed by them.

    `data` = (y, ẏ, ÿ, …) at t = 0 as read, `exact` the same without reading errors; `sizes`: singular values.
    """

    rows: int
    matrix: np.ndarray
    data: np.ndarray
    exact: np.ndarray
    guess: np.ndarray
    sizes: np.ndarray
    rank: int
    share: np.ndarray


@dataclass(frozen=True, eq=False)
class Belief:
    """What y on [0, t] with white noise of intensity v says about x(0), before which x(0) ~ N(0, I).

    `P` (n_t, n, n) = (I + W(t)/v)⁻¹, `mean` (n_t, n), `halves` (n_t, n) = half axes of the 1σ ellipsoid, longest first.
    """

    P: np.ndarray
    mean: np.ndarray
    halves: np.ndarray

    @property
    def known(self) -> int:
        """How many directions are known to a tenth at the end."""
        return int(np.count_nonzero(self.halves[-1] <= KNOWN_SHARE))


def rebuild(s: Sensed, start: np.ndarray, blocks: int, reading: float, rtol: float, seed: int) -> Rebuilt:
    """O_k x(0) = (y, ẏ, …, y^(k−1)) solved by least squares; each derivative is read with relative error `reading`.

    Singular values at or below rtol·σ₁ count as zero: those directions of x(0) stay open and are set to 0.
    """
    O = s.seen.matrix[:blocks * s.plant.p]
    exact = O @ start
    data = exact * (1 + reading * np.random.default_rng(seed).standard_normal(len(exact)))
    U, sizes, Vt = np.linalg.svd(O, full_matrices=False)
    rank = int(np.count_nonzero(sizes > rtol * sizes[0])) if sizes[0] > 0 else 0
    V = Vt[:rank].T
    guess = V @ ((U[:, :rank].T @ data) / sizes[:rank])
    return Rebuilt(blocks, O, data, exact, guess, sizes, rank, np.sum(V * V, axis=1))


def learn(s: Sensed, start: np.ndarray, noise: float, seed: int) -> Belief:
    """P(t)⁻¹ = I + W(t)/v, P⁻¹ mean = (1/v)∫e^{Aᵀτ}Cᵀ dy, with v = noise²·T: the noise in shares of a typical reading.

    The noise term of one step has covariance e^{Aᵀτ} W(h) e^{Aτ}/v exactly, so the ellipsoid and its centre agree.
    """
    v = noise**2 * s.t[-1]
    halves = 1 / np.sqrt(1 + s.heard / v)
    P = (s.axes * (halves**2)[:, None, :]) @ s.axes.transpose(0, 2, 1)
    draws = np.random.default_rng(seed).standard_normal((len(s.t) - 1, s.plant.n)) @ s.root.T / np.sqrt(v)
    drift = np.zeros((len(s.t), s.plant.n))
    np.cumsum(np.einsum("kji,kj->ki", s.powers[:-1], draws), axis=0, out=drift[1:])
    heard = s.energy @ start / v + drift
    return Belief(P, np.einsum("kij,kj->ki", P, heard), halves)
