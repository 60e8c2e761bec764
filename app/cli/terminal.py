"""Write to a terminal: any letter, plain where its encoding lacks it, and how far something long is."""

from __future__ import annotations

import codecs
import io
import os
import sys
import time
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

__all__ = ["Progress", "give_up_output", "set_up", "shows"]

HANDLER = "observer-lab-plain"
PROGRESS_INTERVAL_S = 0.2  # s between two looks at how far it is
PLAIN: Mapping[str, str] = MappingProxyType({
    "−": "-", "–": "-", "—": "-", "·": "*", "×": "x", "…": "...", "≤": "<=", "≥": ">=", "≠": "!=", "≈": "~", "→": "->", "“": '"', "”": '"',
    "‘": "'", "’": "'", "±": "+-", "∞": "inf", "√": "sqrt", "²": "^2", "³": "^3", "⁻": "^-", "¹": "1", "ᵀ": "^T", "°": " deg", "∫": "int",
    "\u0307": "'", "\u0302": "^", "\u0304": "", "\u00a0": " ", "\u2009": " ", "\u202f": " "})


def set_up() -> None:
    """Let standard output and standard error write what their encoding lacks in plain letters, a question mark where there are none."""
    codecs.register_error(HANDLER, _in_plain_letters)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=HANDLER)


def _in_plain_letters(problem: UnicodeError) -> tuple[str, int]:
    if not isinstance(problem, UnicodeEncodeError):
        raise problem
    words = problem.object[problem.start:problem.end]
    plain = "".join(_plain(letter) for letter in words)
    return plain, problem.end


def _plain(letter: str) -> str:
    import unicodedata

    if letter in PLAIN:
        return PLAIN[letter]
    apart = unicodedata.normalize("NFKD", letter)
    found = "".join(PLAIN.get(part, part) for part in apart)
    return found if found.isascii() else "".join(part for part in found if part.isascii()) or "?"


def shows(words: str) -> bool:
    """Whether standard output can show every letter of these words."""
    encoding: Any = getattr(sys.stdout, "encoding", None) or "utf-8"
    try:
        words.encode(encoding)
    except (UnicodeError, LookupError):
        return False
    return True


def give_up_output() -> None:
    """Send what is still waiting for standard output nowhere, so that the end of the process says nothing of it."""
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.__stdout__.fileno())  # type: ignore[union-attr]
        os.close(nowhere)
    except (OSError, ValueError, AttributeError):
        pass
    sys.stdout = None  # type: ignore[assignment]


class Progress:
    """How far it is, on stderr: a line that renews itself on a terminal, else one for each tenth."""

    def __init__(self, size: int, done: int, clock: Callable[[], float] = time.monotonic, what: str = "runs") -> None:
        self._size, self._before, self._clock, self._what = size, done, clock, what
        self._began, self._said, self._open = clock(), -1e9, False
        self._tenth = 10 * done // size
        if done:
            print(f"observer-lab: {done} of {size} {what} are done already.", file=sys.stderr)

    def tell(self, done: int) -> None:
        """Say that so many are done, if it is time to."""
        now, tenth = self._clock(), 10 * done // self._size
        lasts = sys.stderr.isatty()
        if (now - self._said < PROGRESS_INTERVAL_S and done < self._size) if lasts else tenth == self._tenth:
            return
        self._said, self._tenth, self._open = now, tenth, lasts
        left = (now - self._began) * (self._size - done) / max(done - self._before, 1)
        words = f"{done} of {self._size} {self._what}, {100 * done / self._size:.0f} %, {_time(left)} left"
        print(f"\r{words:<60}" if lasts else words, end="" if lasts else "\n", file=sys.stderr, flush=True)

    def end(self) -> None:
        """Leave the line."""
        if self._open:
            print(file=sys.stderr)


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"
