"""Turn residuals into a diagnosis: windows, thresholds, alarms, identified fault, delay."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from observer_lab.engine.observers import isolate, needed_noncentrality, residual_threshold, window_energy, window_mean

from .observer_bank import FAULT_PLACES, SAMPLE_COUNT, guard
from .runs import Record

ENERGY, MEAN = "energy", "mean"
NO_FAULT, UNCLEAR_FAULT = -1, -2  # what `isolate` says beside the column of a fault
ALARM_HOLD_SAMPLES = 10  # samples that one pattern of alarms must last before anyone is accused
FADE = 100  # samples until a kick has no more effect on the bank
DETECTION_POWER = 0.99


@dataclass(frozen=True)
class Rule:
    """How the residuals are judged: the statistic, its window in samples, the false-alarm rate of one window."""

    statistic: str = ENERGY
    window: int = 25
    rate: float = 1e-3

    @property
    def dof(self) -> int:
        """Degrees of freedom of χ²."""
        return guard().bank.dof * (self.window if self.statistic == ENERGY else 1)

    @property
    def threshold(self) -> float:
        """The upper quantile of χ²."""
        return _threshold(self.dof, self.rate)

    @property
    def needed(self) -> float:
        """The noncentrality that gives an alarm with probability DETECTION_POWER."""
        return _needed(self.dof, self.rate)

    def values(self, residuals: np.ndarray) -> np.ndarray:
        """The statistic of the windows that end at each sample, (SAMPLE_COUNT, …, 7); zero before the first is full."""
        out = np.zeros(residuals.shape[:-1])
        out[self.window - 1:] = (window_energy if self.statistic == ENERGY else window_mean)(residuals, self.window)
        return out


_threshold = lru_cache(maxsize=256)(residual_threshold)


@lru_cache(maxsize=256)
def _needed(dof: int, rate: float) -> float:
    return needed_noncentrality(dof, rate, DETECTION_POWER)


@dataclass(frozen=True, eq=False)
class Verdict:
    """values: statistic over threshold (SAMPLE_COUNT, 7). named (SAMPLE_COUNT,): column of the fault, −1 none, −2 unclear.

    first: sample of the first alarm; decided: sample of the accusation, and who; None if there is none.
    """

    values: np.ndarray
    named: np.ndarray
    first: int | None
    decided: int | None
    who: str | None


def judge(test: Rule, record: Record) -> Verdict:
    """Name the fault whose row the alarms fit for ALARM_HOLD_SAMPLES samples on end, the member that ignores it quiet before.

    "Before" goes back to the last sample without any alarm, or by a window and FADE samples: what upsets every member is none
    of these faults, also while it fades and some have forgotten it already.
    """
    return judged(test, test.values(record.residuals) / test.threshold)


def judged(test: Rule, ratio: np.ndarray) -> Verdict:
    """`judge` by the statistic over its threshold, (SAMPLE_COUNT, 7)."""
    alarms, signature = ratio > 1, guard().bank.signature
    at, first = lasting_fit(alarms, signature, test.window), np.flatnonzero(alarms.any(axis=1))
    column = int(at.argmin())
    return Verdict(ratio, isolate(alarms, signature), int(first[0]) if len(first) else None,
                   *((int(at[column]), FAULT_PLACES[column]) if at[column] < SAMPLE_COUNT else (None, None)))


def lasting_fit(alarms: np.ndarray, signature: np.ndarray, window: int) -> np.ndarray:
    """The sample at which alarms name each column of a signature (members, faults): alarms (SAMPLE_COUNT, members).

    SAMPLE_COUNT stands for never."""
    fits = (alarms[:, :, None] == signature).all(axis=1)
    calm = np.maximum.accumulate(np.where(alarms.any(axis=1), -1, np.arange(SAMPLE_COUNT)))  # the last sample without an alarm
    heard = np.vstack([np.zeros(alarms.shape[1], dtype=int), np.cumsum(alarms, axis=0)])
    since = np.maximum(calm + 1, np.arange(SAMPLE_COUNT) + 1 - window - FADE)
    upset = heard[1:] > heard[since]  # which members have given an alarm since
    return lasting(fits & ~(upset @ ~signature))


def lasting(holds: np.ndarray) -> np.ndarray:
    """The sample at which each column's condition has first held for ALARM_HOLD_SAMPLES samples, SAMPLE_COUNT for never."""
    total = np.zeros((len(holds) + 1, holds.shape[1]), dtype=int)
    np.cumsum(holds, axis=0, out=total[1:])
    full = total[ALARM_HOLD_SAMPLES:] - total[:-ALARM_HOLD_SAMPLES] == ALARM_HOLD_SAMPLES
    return np.where(full.any(axis=0), full.argmax(axis=0) + ALARM_HOLD_SAMPLES - 1, SAMPLE_COUNT)


@dataclass(frozen=True, eq=False)
class Forecast:
    """strength (SAMPLE_COUNT, 7): noncentrality of each window over what DETECTION_POWER asks for; delay: when all that should see it do.

    `delay` counts samples from the fault on, ALARM_HOLD_SAMPLES included; None if that never comes.
    """

    strength: np.ndarray
    delay: int | None


def forecast(test: Rule, silent: Record, column: int | None, start: int, until: int = SAMPLE_COUNT) -> Forecast:
    """What the fault does without noise: from when on every member that sees it gives an alarm with probability DETECTION_POWER.

    `until`: where another fault begins, after which alarms are no longer those of this one.
    """
    strength = test.values(silent.residuals) / test.needed
    if column is None:
        return Forecast(strength, None)
    seen = guard().bank.signature[:, column]
    at = int(lasting(np.all(strength[:, seen] >= 1, axis=1, keepdims=True))[0])
    return Forecast(strength, at - start if at < until else None)
