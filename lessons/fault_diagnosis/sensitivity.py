"""Compute the least fault that each observer of the bank detects, for any loop and noise."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .diagnosis import ENERGY, Rule
from .observer_bank import DT, guard

TONES = np.geomspace(0.2, 5.0, 90)  # Hz


@lru_cache(maxsize=1)
def of_bias() -> np.ndarray:
    """Length of the whitened residual that a lasting bias of 1 m/s leaves, (7 members, 4 sensors)."""
    return np.linalg.norm(guard().bank.response(1.0)[:, :, :4], axis=1)


@lru_cache(maxsize=64)
def of_force(tone: float) -> np.ndarray:
    """Amplitude of the whitened residual for a missing force of 1 N amplitude at `tone` Hz, (7 members, 3 coils)."""
    return np.linalg.norm(guard().bank.response(np.exp(2j * np.pi * tone * DT))[:, :, 4:], axis=1)


@lru_cache(maxsize=1)
def over_tones() -> np.ndarray:
    """The same for the least sensitive member that is to see it, (tones, 3)."""
    rows = []
    for tone in TONES:
        size = np.linalg.norm(guard().bank.response(np.exp(2j * np.pi * tone * DT))[:, :, 4:], axis=1)
        rows.append([min(size[i, j] for i in range(7) if i != 4 + j) for j in range(3)])
    return np.array(rows)


def gathered(test: Rule, tone: np.ndarray | float) -> np.ndarray:
    """What a window gathers of a sine of amplitude 1, on the average over its phase: N/2, or less where a mean cancels it."""
    half = np.pi * DT * np.asarray(tone, dtype=float)
    if test.statistic == ENERGY:
        return np.full(half.shape, test.window / 2)
    return (np.sin(test.window * half) / np.sin(half)) ** 2 / (2 * test.window)


def least(test: Rule, tone: float) -> np.ndarray:
    """The least bias (m/s) or missing amplitude (N) that each member sees with probability DETECTION_POWER, (7 members, 7 faults).

    inf where a member does not see a fault.
    """
    bias, force = of_bias() * np.sqrt(test.window), of_force(tone) * np.sqrt(gathered(test, tone))
    size = np.hstack([bias, force])
    seen = guard().bank.signature
    return np.where(seen, np.sqrt(test.needed) / np.where(seen, np.maximum(size, 1e-9), 1.0), np.inf)


def least_force(test: Rule) -> np.ndarray:
    """The least missing amplitude in N that all six see on the average, over TONES: (tones, 3)."""
    return np.sqrt(test.needed / np.maximum(gathered(test, TONES), 1e-6))[:, None] / over_tones()
