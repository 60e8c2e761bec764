"""Realise a transfer function, or a matrix of them, entry by entry."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import block_diag

from .errors import EngineError
from .plant import Plant

__all__ = ["Fraction", "realised_by_entries", "zeros_and_poles"]

Fraction = tuple[np.ndarray, np.ndarray]  # coefficients of numerator and denominator, highest power first
_HIGHEST = 60  # degree of a denominator


def zeros_and_poles(zeros: np.ndarray, poles: np.ndarray, gain: float) -> Fraction:
    """The fraction of k ∏(s − z)/∏(s − p). Raises EngineError where a complex one lacks its conjugate."""
    from scipy.signal import zpk2tf  # late: it brings all of scipy.stats, 0.6 s

    for values in (zeros, poles):
        if np.abs(np.imag(np.poly(values))).max(initial=0.0) > 1e-12 * np.abs(np.poly(values)).max(initial=1.0):
            raise EngineError("A complex zero or pole lacks its conjugate; give both.")
    numerator, denominator = zpk2tf(zeros, poles, gain)
    return np.atleast_1d(np.real(numerator)), np.atleast_1d(np.real(denominator))


def realised_by_entries(entries: Sequence[Sequence[Fraction]], dt: float) -> Plant:
    """y_i = Σ_j num_ij / den_ij u_j for p×m fractions, one realisation beside the other, which need not be minimal.

    Raises EngineError for an improper or empty fraction, and for one without finite coefficients.
    """
    blocks = [[_companion(*_checked(*entry), dt) for entry in row] for row in entries]
    p, m = len(blocks), len(blocks[0])
    parts = [block[0] for row in blocks for block in row]
    A = block_diag(*parts) if sum(map(len, parts)) else np.zeros((0, 0))
    B, C, D = np.zeros((len(A), m)), np.zeros((p, len(A))), np.zeros((p, m))
    place = 0
    for i, row in enumerate(blocks):
        for j, (a, b, c, d) in enumerate(row):
            part = slice(place, place + len(a))
            B[part, j], C[i, part], D[i, j], place = b, c, d, part.stop
    return Plant(A, B, C, D, dt)


def _companion(numerator: np.ndarray, denominator: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """A n×n, b (n,), c (n,), d of one fraction in controller form; its clock is scaled so that the coefficients are alike."""
    n = len(denominator) - 1
    over = np.concatenate([np.zeros(n + 1 - len(numerator)), numerator]) / denominator[0]
    under, powers = denominator / denominator[0], np.arange(n + 1)
    sizes = np.abs(under[1:]) ** (1.0 / np.maximum(powers[1:], 1))
    rate = 1.0 if dt or not sizes.any() else float(2.0 ** np.round(np.log2(sizes.max())))
    under, over = under / rate**powers, over / rate**powers
    A = np.eye(n, k=-1)
    A[:1] = -under[1:]
    return A * rate, np.eye(1, n)[0] * rate if n else np.zeros(0), over[1:] - over[0] * under[1:], float(over[0])


def _checked(numerator: np.ndarray, denominator: np.ndarray) -> Fraction:
    if not (np.isfinite(numerator).all() and np.isfinite(denominator).all()):
        raise EngineError("The coefficients of a transfer function must be finite numbers.")
    if not numerator.size:
        raise EngineError("The numerator of a transfer function is empty; give its coefficients, highest power first, or 0.")
    over, under = np.trim_zeros(numerator, "f"), np.trim_zeros(denominator, "f")
    if not under.size:
        raise EngineError("The denominator of a transfer function is zero; give its coefficients, highest power first.")
    if len(over) > len(under):
        raise EngineError("The transfer function has more zeros than poles, which no plant with states has; add the fast poles of its "
                          "sensor or actuator.")
    if len(under) > _HIGHEST:
        raise EngineError("The transfer function is of degree {degree}; give at most {most}, or the matrices A, B, C and D.",
                          degree=len(under) - 1, most=_HIGHEST)
    return (over if over.size else np.zeros(1)), under
