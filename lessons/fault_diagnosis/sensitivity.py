"""Compute the least fault that each observer detects, and that the bank of pairs detects."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from observer_lab.engine.observers import FaultBank, needed_noncentrality

from .diagnosis import DETECTION_POWER, ENERGY, Rule
from .fault_pairs import PAIRS, pair_bank
from .observer_bank import DT, FAULT_PLACES, guard

TONES = np.geomspace(0.2, 5.0, 90)  # Hz
RESIDUAL_ROUNDING = 1e-9  # of a whitened residual: less is rounding
PLACE_COUNT = len(FAULT_PLACES)


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


def _lengths(bank: FaultBank, tone: float) -> np.ndarray:
    """Length of the whitened residual that 1 m/s of lasting bias, or 1 N missing at `tone` Hz, leaves: (members, 7)."""
    bias, force = (np.linalg.norm(bank.response(z), axis=1) for z in (1.0, np.exp(2j * np.pi * tone * DT)))
    return np.hstack([bias[:, :4], force[:, 4:]])


@lru_cache(maxsize=64)
def weakest(tone: float) -> np.ndarray:
    """The same of the member that hears least, (7, 7): of the fault in the row, among the members that ignore the part in the column.

    On the diagonal that of the seven, where the fault is alone.
    """
    alone, beside = _lengths(guard().bank, tone), _lengths(pair_bank(), tone)
    found = np.empty((PLACE_COUNT, PLACE_COUNT))
    for i in range(PLACE_COUNT):
        for j in range(PLACE_COUNT):
            found[i, j] = (min(alone[k, i] for k in range(PLACE_COUNT) if k != i) if i == j else
                           min(beside[m, i] for m, pair in enumerate(PAIRS) if j in pair and i not in pair))
    return np.where(found > RESIDUAL_ROUNDING, found, 0.0)


def least_beside(test: Rule, tone: float) -> np.ndarray:
    """The least bias (m/s) or missing amplitude (N) of the row's fault seen with probability DETECTION_POWER, laid out as `weakest`."""
    samples = np.array([float(test.window)] * 4 + [float(gathered(test, tone))] * 3)[:, None]
    needed = np.where(
        np.eye(PLACE_COUNT, dtype=bool), test.needed, _needed(pair_bank().dof * (test.window if test.statistic == ENERGY else 1), test.rate)
    )
    size = weakest(tone)
    return np.where(size > 0, np.sqrt(needed / np.maximum(samples, 1e-6)) / np.where(size > 0, size, 1.0), np.inf)


@lru_cache(maxsize=64)
def _needed(dof: int, rate: float) -> float:
    return needed_noncentrality(dof, rate, DETECTION_POWER)


def deaf(tone: float, fault: int, other: int) -> int:
    """What else the member ignores that hears least of a fault, of those that ignore the other part."""
    beside = _lengths(pair_bank(), tone)
    others = (k for k in range(PLACE_COUNT) if k not in (fault, other))
    return min(others, key=lambda k: beside[PAIRS.index((min(k, other), max(k, other))), fault])
