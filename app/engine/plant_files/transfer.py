"""Realise a transfer function or a small matrix of them with as few states as its poles need."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import block_diag

from ..structure.decomposition import kalman_decomposition
from ..systems.errors import EngineError, Phrase
from ..systems.plant import Plant
from ..systems.spectrum import frequency_response
from .notes import note

__all__ = ["Fraction", "realised", "zeros_and_poles"]

Fraction = tuple[np.ndarray, np.ndarray]  # coefficients of numerator and denominator, highest power first
SAME = 1e-7  # how well the smaller realisation must give the same frequency response, relative to its size
_HIGHEST = 60  # degree of a denominator


def zeros_and_poles(zeros: np.ndarray, poles: np.ndarray, gain: float) -> Fraction:
    """The fraction of k ∏(s − z)/∏(s − p). Raises EngineError where a complex one lacks its conjugate."""
    from scipy.signal import zpk2tf  # late: it brings all of scipy.stats, 0.6 s

    for values in (zeros, poles):
        if np.abs(np.imag(np.poly(values))).max(initial=0.0) > 1e-12 * np.abs(np.poly(values)).max(initial=1.0):
            raise EngineError("A complex zero or pole lacks its conjugate; give both.")
    numerator, denominator = zpk2tf(zeros, poles, gain)
    return np.atleast_1d(np.real(numerator)), np.atleast_1d(np.real(denominator))


def realised(entries: Sequence[Sequence[Fraction]], dt: float) -> tuple[Plant, tuple[Phrase, ...]]:
    """The plant of a p×m matrix of fractions, and the note that says whether it is minimal.

    Raises EngineError for an improper or empty fraction, and for one without finite coefficients.
    """
    blocks = [[_companion(*_checked(*entry), dt) for entry in row] for row in entries]
    p, m = len(blocks), len(blocks[0])
    A = block_diag(*(block[0] for row in blocks for block in row))
    B, C, D = np.zeros((len(A), m)), np.zeros((p, len(A))), np.zeros((p, m))
    place = 0
    for i, row in enumerate(blocks):
        for j, (a, b, c, d) in enumerate(row):
            part = slice(place, place + len(a))
            B[part, j], C[i, part], D[i, j], place = b, c, d, part.stop
    if not len(A):
        raise EngineError("The transfer function is a plain gain without states; there is nothing to observe.")
    return _least(Plant(A, B, C, D, dt))


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


def _least(plant: Plant) -> tuple[Plant, tuple[Phrase, ...]]:
    """The part that is reached and seen, where it gives the same frequency response; else the plant as it is."""
    try:
        found = kalman_decomposition(plant)
        small, hidden = found.minimal, plant.n - found.sizes[0]
    except EngineError:
        return plant, (note("not_minimal", after=plant.n),)
    if not hidden:
        return plant, (note("realised", after=plant.n),)
    if not small.n or not _same(plant, small):
        return plant, (note("not_minimal", after=plant.n),)
    made = Plant(small.A, small.B, small.C, small.D, plant.dt)
    return made, (note("minimal", after=made.n, gone=hidden),)


def _same(plant: Plant, small: Plant) -> bool:
    size = max(float(np.abs(plant.poles).max(initial=0.0)), 1e-300)
    grid = np.linspace(0.05, 3.0, 17) / plant.dt if plant.dt else size * np.geomspace(1e-4, 1e2, 25)
    with np.errstate(all="ignore"):
        one, two = (frequency_response(part.A, part.B, part.C, part.D, grid, dt=plant.dt) for part in (plant, small))
    return bool(np.isfinite(two).all() and np.abs(one - two).max() <= SAME * max(np.abs(one).max(), 1e-300))
