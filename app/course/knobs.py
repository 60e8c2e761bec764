"""Define knobs: what a design holds, the bounds, the check and the text of each value.

A knob validates values for the session, and widgets, command-line options, documentation and property tests are made
from it. A value that a knob accepts is hashable and travels as JSON.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any

from ..text import NO_WORDS, SaidError, Text, text

MAX_TRACK = 400
SAMPLE_S = 0.05  # s of a run between two values of a hand that holds the plant
RELEASE_TIMES = 4.0  # times the last force that a hand gives within one sample when it lets go


class KnobError(SaidError):
    """A value that a knob does not accept; `text` says why in every language."""


def short(value: float) -> str:
    """The number as text that reads back as the same number, short where that loses nothing."""
    return f"{value:g}" if float(f"{value:g}") == value else repr(float(value))


@dataclass(frozen=True)
class Knob(ABC):
    """What all knobs share. `when` = (other knob, its values) hides this one unless the other has such a value.

    Neighbours of one `group` stand under its heading.
    """

    name: str
    symbol: str
    label: Text
    unit: str = ""
    hint: Text = NO_WORDS
    when: tuple[str, tuple[Any, ...]] | None = field(default=None, kw_only=True)
    group: Text | None = field(default=None, kw_only=True)
    hidden: bool = field(default=False, kw_only=True)  # no widget: set by commands, dragging or the command line

    default: Any = field(default=None, init=False)

    @abstractmethod
    def check(self, value: Any) -> Any:
        """The value in the knob's own form. Raises KnobError."""

    def parse(self, words: str) -> Any:
        """A value from the command line. Raises KnobError."""
        return self.check(words)

    def show(self, value: Any) -> str:
        """The value as text that `parse` reads back."""
        return str(value)

    def _refuse(self, value: object, why: Text) -> KnobError:
        return KnobError(text("{label} ({name}) cannot be {value}: {why}", label=self.label, name=self.name,
                              value=str(value)[:40], why=why))


@dataclass(frozen=True)
class Number(Knob):
    """A number in [low, high]; `scale` is "linear", "log" or "integer"."""

    low: float = 0.0
    high: float = 1.0
    default: float = 0.5
    scale: str = "linear"
    step: float | None = None

    def check(self, value: Any) -> float:
        try:
            number = float(value)
        except (TypeError, ValueError, OverflowError):
            raise self._refuse(value, text("it must be a number.")) from None
        if not math.isfinite(number):
            raise self._refuse(value, text("it must be a finite number."))
        if not self.low <= number <= self.high:
            for end in (self.low, self.high):
                if math.isclose(number, float(f"{end:g}"), rel_tol=1e-12):  # an end as it is shown, or by its logarithm, is that end
                    return float(end)
            bounds = f"{self.low:g} … {self.high:g}" + (f" {self.unit}" if self.unit else "")
            raise self._refuse(f"{number:g}", text("choose a value within {bounds}.", bounds=bounds))
        return float(round(number)) if self.scale == "integer" else number

    def show(self, value: Any) -> str:
        return short(value)


@dataclass(frozen=True)
class Choice(Knob):
    """One of a few named options."""

    options: tuple[tuple[str, Text], ...] = ()
    default: str = ""

    def check(self, value: Any) -> str:
        if value not in [name for name, _ in self.options]:
            names = ", ".join(name for name, _ in self.options)
            raise self._refuse(value, text("choose one of {names}.", names=names))
        return str(value)


@dataclass(frozen=True)
class Switch(Knob):
    """On or off."""

    default: bool = False

    def check(self, value: Any) -> bool:
        if isinstance(value, bool):
            return value
        if str(value).lower() in ("on", "true", "1", "yes"):
            return True
        if str(value).lower() in ("off", "false", "0", "no"):
            return False
        raise self._refuse(value, text("it is on or off."))

    def show(self, value: Any) -> str:
        return "on" if value else "off"


@dataclass(frozen=True)
class Poles(Knob):
    """A set of poles, closed under conjugation, inside a window of the s-plane. Sorted by (real, imag)."""

    default: tuple[complex, ...] = ()
    re_low: float = -10.0
    re_high: float = 1.0
    im_high: float = 10.0
    role: str = "plant"

    def check(self, value: Any) -> tuple[complex, ...]:
        if isinstance(value, str):
            value = self._split(value)
        try:
            poles = [complex(*p) if isinstance(p, (tuple, list)) else complex(p) for p in value]
        except (TypeError, ValueError, OverflowError):
            raise self._refuse(value, text("give poles such as −2, −3+1j, −3−1j.")) from None
        if len(poles) != len(self.default):
            raise self._refuse(self.show(tuple(poles)), text("give exactly {count} poles, not {count2}.",
                                                             count=len(self.default), count2=len(poles)))
        for pole in poles:
            inside = self.re_low <= pole.real <= self.re_high and abs(pole.imag) <= self.im_high
            if not inside:  # NaN fails every comparison and lands here too
                where = f"{self.re_low:g} ≤ Re ≤ {self.re_high:g}, |Im| ≤ {self.im_high:g}"
                raise self._refuse(f"{pole:.4g}", text("keep every pole within {where}.", where=where))
        return self._paired(poles)

    def _paired(self, poles: list[complex]) -> tuple[complex, ...]:
        from ..engine.systems import PoleError, pair_conjugates  # NumPy is loaded where a pole is set, not where lessons are listed

        try:
            paired = pair_conjugates(poles, rtol=1e-6, floor=max([1.0, *map(abs, poles)]))
        except PoleError:
            raise self._refuse(self.show(tuple(poles)), text("complex poles must come in conjugate pairs.")) from None
        return tuple(sorted(paired.tolist(), key=lambda p: (p.real, p.imag)))

    @staticmethod
    def _split(words: str) -> list[str]:
        return [w.replace(" ", "").replace("i", "j") for w in words.replace(";", ",").strip("()[] ").split(",") if w.strip()]

    def show(self, value: Any) -> str:
        return ", ".join(short(p.real) if p.imag == 0 else
                         f"{short(p.real)}{'-' if p.imag < 0 else '+'}{short(abs(p.imag))}j" for p in value)


@dataclass(frozen=True)
class Track(Knob):
    """A hand-drawn input: a piecewise-constant function of time as (t, value) pairs, t ascending."""

    default: tuple[tuple[float, float], ...] = ()
    low: float = -1.0
    high: float = 1.0

    def check(self, value: Any) -> tuple[tuple[float, float], ...]:
        try:
            pairs = tuple((float(t), float(v)) for t, v in value)
        except (TypeError, ValueError, OverflowError):
            raise self._refuse(value, text("give pairs t:value.")) from None
        if len(pairs) > MAX_TRACK:
            raise self._refuse(len(pairs), text("at most {max_track} changes fit; reset the hand input.",
                                                max_track=MAX_TRACK))
        if not all(math.isfinite(t) and t >= 0 and self.low <= v <= self.high for t, v in pairs):
            raise self._refuse(self.show(pairs), text("times must be ≥ 0 and values within {low:g} … {high:g}.",
                                                      low=self.low, high=self.high))
        return tuple(sorted(pairs))

    def parse(self, words: str) -> Any:
        try:
            return self.check([tuple(pair.split(":")) for pair in words.split(",") if pair.strip()])
        except ValueError as problem:
            if isinstance(problem, KnobError):
                raise
            raise self._refuse(words, text("give pairs t:value, separated by commas.")) from None

    def show(self, value: Any) -> str:
        return ", ".join(f"{short(t)}:{short(v)}" for t, v in value)

    def record(self, track: tuple[tuple[float, float], ...], t: float, value: float) -> tuple[tuple[float, float], ...]:
        """The track with `value` from time t on: what was drawn before t stays."""
        kept = [pair for pair in track if pair[0] < t - 1e-9]
        return self.check([*kept[-(MAX_TRACK - 1):], (max(t, 0.0), value)])


@dataclass(frozen=True)
class ByHand:
    """The force with which a hand holds a plant now, or with which it lets go."""

    force: float
    released: bool = False


@dataclass(frozen=True)
class Pull(Track):
    """The force of a hand on the plant: one value for each SAMPLE_S of the run, in whole `step`s, 0 where nothing is held.

    A hand holds with at most `most`. Where it lets go, one sample is RELEASE_TIMES as large: the push that a spring gives back.
    """

    step: float = 0.05
    most: float = 1.0

    def check(self, value: Any) -> tuple[tuple[float, float], ...]:
        samples = {round(t / SAMPLE_S): v for t, v in super().check(value)}
        return tuple((round(k * SAMPLE_S, 3), round(round(v / self.step) * self.step, 6) + 0.0) for k, v in sorted(samples.items()))

    def take(self, track: tuple[tuple[float, float], ...], t: float, hand: ByHand) -> tuple[tuple[float, float], ...]:
        """The record with what a hand does at time t of the run. Raises KnobError."""
        if not math.isfinite(hand.force):
            raise self._refuse(hand.force, text("it must be a finite number."))
        begin = SAMPLE_S * math.floor(t / SAMPLE_S + 1e-9)
        force = min(max(hand.force, -self.most), self.most)
        drawn = self.record(track, begin, RELEASE_TIMES * force if hand.released else force)
        return self.record(drawn, begin + SAMPLE_S, 0.0) if hand.released else drawn
