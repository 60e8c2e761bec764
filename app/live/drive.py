"""Bound what a page sends to a plant: by a limit, a rate, and zero once the page is gone."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..devices import Routine
from .lines import with_checksum

__all__ = ["PAGE_GONE_S", "Drive", "feedback_of", "input_line"]

PAGE_GONE_S = 1.5  # s without a sign of life of the page that drives, after which u = 0


def feedback_of(routine: Routine) -> tuple[np.ndarray, np.ndarray] | None:
    """K (m, n) and the first command r (m,) of u = r − K x̂, None where the design feeds nothing back."""
    K = next((each for each in routine.constants if each.name == "K"), None)
    if K is None:
        return None
    r = next((each.values for each in routine.states if each.name == "r"), (0.0,) * K.shape[0])
    return np.array(K.values).reshape(K.shape), np.array(r)


def input_line(u: Sequence[float] | np.ndarray) -> bytes:
    """The line that tells a device its input: `u,…*HH`, always with a checksum."""
    return (with_checksum(",".join(["u", *(repr(float(v)) for v in u)])) + "\n").encode()


@dataclass
class Drive:
    """The input that is sent, from the one that the feedback asks for: |u| ≤ `limit`, |u̇| ≤ `rate`.

    Only the tab that has switched it on keeps it on, by its signs of life; without one for `patience` seconds it is off, u = 0 at once,
    and stays off until somebody switches it on again.
    """

    limit: float
    rate: float = float("inf")
    patience: float = PAGE_GONE_S
    driver: Hashable | None = None
    ended: str = ""  # why it is off: "page" where the page was gone, "lines" where the estimate began anew
    _heard: float = 0.0
    _last: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def switch_on(self, tab: Hashable, now: float) -> None:
        """This tab drives from now on."""
        self.driver, self._heard, self.ended = tab, now, ""

    def switch_off(self, why: str = "") -> None:
        """Nobody drives."""
        self.driver, self.ended, self._last = None, why, np.zeros(0)

    def hear(self, tab: Hashable, now: float) -> None:
        """A sign of life of a tab."""
        if tab == self.driver:
            self._heard = now

    def runs(self, now: float) -> bool:
        """Whether somebody drives; switches off where their page is gone."""
        if self.driver is not None and now - self._heard > self.patience:
            self.switch_off("page")
        return self.driver is not None

    def input(self, asked: np.ndarray, period: float, now: float) -> np.ndarray:
        """What is sent now."""
        if not self.runs(now) or not np.isfinite(asked).all():
            return np.zeros(len(asked))
        before = self._last if len(self._last) == len(asked) else np.zeros(len(asked))
        step = self.rate * period
        self._last = np.clip(np.clip(asked, -self.limit, self.limit), before - step, before + step)
        return self._last.copy()
