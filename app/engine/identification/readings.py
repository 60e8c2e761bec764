"""Whiten innovations row by row, also where only some outputs of a row came."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtr, chdtri

__all__ = ["mean_below", "padded", "partly_seen", "whitened"]


def partly_seen(seen: np.ndarray) -> bool:
    """Whether some row of seen (N, p) has a part of its outputs."""
    return bool((seen.any(axis=1) & ~seen.all(axis=1)).any())


def padded(S: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """S (N, p, p) with the rows and columns of I for readings that did not come: neither S⁻¹ e nor det S counts them."""
    both = seen[:, :, None] & seen[:, None, :]
    return np.where(both, S, np.eye(S.shape[-1]))


def whitened(nu: np.ndarray, S: np.ndarray) -> np.ndarray:
    """S^{-½} ν (N, p) of the readings that came; NaN for the others."""
    seen = np.isfinite(nu)
    roots = np.linalg.cholesky(padded(S, seen))
    return np.where(seen, np.linalg.solve(roots, np.where(seen, nu, 0.0)[:, :, None])[:, :, 0], np.nan)


def mean_below(counts: np.ndarray, share: float) -> float:
    """Mean of χ² below its quantile `share`, over its mean without a limit, for rows of so many readings each."""
    own = np.maximum(counts, 1)
    return float(np.sum(counts * chdtr(own + 2, chdtri(own, 1 - share))) / share / max(float(np.sum(counts)), 1.0))
