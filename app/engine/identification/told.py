"""Tell how far a fit is, from 0 to 1."""

from __future__ import annotations

from collections.abc import Callable

__all__ = ["Tell", "part_of", "silent"]

Tell = Callable[[float], object]


def silent(share: float) -> None:
    """Nobody asks."""


def part_of(tell: Tell, first: float, last: float) -> Tell:
    """What a part tells of itself, from 0 to 1, as what the whole is: from `first` to `last`."""
    return lambda share: tell(first + (last - first) * min(share, 1.0))
