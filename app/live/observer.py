"""Run a design's observer on the samples of a device, at the device's own rate."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ..devices import Device, Routine, watching
from .lines import Sample

__all__ = ["LiveObserver", "Step"]

MOST_BRIDGED = 1000  # periods without a line that are stepped through; after a longer gap the observer begins anew
RESET_LINES = 5  # out of order in turn, each after the one before: the device was switched on again
JITTER_SHARE = 0.25  # of a period: a line that is farther off its grid counts as jittered


@dataclass(frozen=True, eq=False)
class Step:
    """What the observer made of a line: its sample, its estimate, innovation (p,), NIS, verdict, lost periods before it."""

    sample: Sample
    xhat: np.ndarray
    innovation: np.ndarray | None
    nis: float | None
    fault: float | None
    lost: int


@dataclass
class LiveObserver:
    """The observer of a routine, told what acts on the plant. Counts lost periods, lines out of order, jitter and new beginnings."""

    routine: Routine
    lost: int = 0
    disordered: int = 0
    jittered: int = 0
    restarts: int = 0
    steps: int = 0
    first: float | None = None
    _device: Device = field(init=False)
    _last: Sample | None = None
    _due: float = 0.0
    _behind: list[float] = field(default_factory=list)  # times of the last lines in turn that were out of order

    def __post_init__(self) -> None:
        self.routine = watching(self.routine)
        self._device = Device(self.routine)

    def take(self, sample: Sample) -> Step | None:
        """One line; None where it comes before the one already taken. Periods without a line are stepped with missing readings."""
        period, gap = self.routine.period, 0
        if self._last is not None:
            behind = (sample.t - self._due) / period
            if sample.t <= self._last.t:
                self.disordered += 1
                if not self._was_reset(sample.t):
                    return None
                self._begin_again()
            elif behind > MOST_BRIDGED:
                self._begin_again()
            else:
                gap = max(0, round(behind))
                if abs(behind - gap) > JITTER_SHARE:
                    self.jittered += 1
                self.lost += gap
                for _ in range(gap):
                    self._step(np.full(len(sample.y), np.nan), self._last.u)
                self._due += gap * period
        if self._last is None:
            self._due = sample.t
        self._behind = []
        self.first = sample.t if self.first is None else self.first
        self._step(sample.y, sample.u)
        if not np.isfinite(self._device.read("xnext" if "xnext" in self._device.tables else "xhat")).all():
            self._begin_again()
            self._step(sample.y, sample.u)
        self._due += period
        self._last = sample
        self.steps += 1
        tables = self._device.tables
        return Step(sample, self._device.read("xhat"), self._device.read("v") if "v" in tables else None,
                    float(tables["nis"][0]) if "nis" in tables else None, float(tables["fault"][0]) if "fault" in tables else None, gap)

    @property
    def own_step(self) -> float:
        """Mean time between the lines taken, 0 of fewer than two."""
        return 0.0 if self.steps < 2 or self._last is None or self.first is None else (self._last.t - self.first) / (self.steps - 1)

    @property
    def last_time(self) -> float:
        """The time of the last line taken in s, 0 before the first."""
        return 0.0 if self._last is None else self._last.t

    @property
    def predicted(self) -> np.ndarray:
        """The estimate for the next sample, where the routine predicts one."""
        return self._device.read("xnext" if "xnext" in self._device.tables else "xhat")

    def _step(self, y: np.ndarray, u: np.ndarray) -> None:
        try:
            self._device.step(y, u)
        except (ArithmeticError, ValueError):  # a covariance that has lost all sense
            self._begin_again()

    def _was_reset(self, t: float) -> bool:
        """Whether the clock of the device has begun anew: so many lines in turn are older than the last one and follow one another."""
        follows = bool(self._behind) and 0 < t - self._behind[-1] < MOST_BRIDGED * self.routine.period
        self._behind = [*self._behind, t] if follows else [t]
        return len(self._behind) >= RESET_LINES

    def _begin_again(self) -> None:
        self.restarts += 1
        self._device, self._last = Device(self.routine), None

    def change(self, routine: Routine) -> None:
        """Another design of the same plant from now on; its observer begins at the present estimate."""
        new = watching(routine)
        xhat = self._device.tables.get("xnext")
        if xhat is not None and any(each.name == "xnext" and len(each.values) == len(xhat) for each in new.states):
            new = replace(new, states=tuple(replace(each, values=tuple(xhat)) if each.name == "xnext" else each for each in new.states))
        self.routine, self._device = new, Device(new)
