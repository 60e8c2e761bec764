"""Keep the history of designs for undo and redo."""

from __future__ import annotations

from collections.abc import Hashable

from ...course.lesson import Design

MERGE_WINDOW_S = 0.8  # s within which changes of the same knobs are one step of undo
MAX_UNDO_DESIGNS = 500  # designs that undo remembers


class History:
    """Designs that undo and redo walk along."""

    def __init__(self, design: Design) -> None:
        self._designs = [design]
        self._at = 0
        self._key: Hashable = None
        self._time = -1e9

    @property
    def design(self) -> Design:
        """The present design."""
        return self._designs[self._at]

    def push(self, design: Design, key: Hashable, now: float, held: bool = False) -> None:
        """A new present. A quick change with the same key replaces the last one, a `held` one however slow."""
        if design == self.design:
            return
        merge = key is not None and key == self._key and (held or now - self._time <
                                                          MERGE_WINDOW_S) and self._at == len(self._designs) - 1
        if merge and self._at > 0:
            self._designs[self._at] = design
        else:
            self._designs = [*self._designs[: self._at + 1], design][-MAX_UNDO_DESIGNS:]
            self._at = len(self._designs) - 1
        self._key, self._time = key, now

    def insert_before_present(self, design: Design) -> bool:
        """Put a design one step of undo before the present one; False if it is the present one."""
        if design == self.design:
            return False
        designs = [*self._designs[: self._at], design, *self._designs[self._at :]]
        gone = max(len(designs) - MAX_UNDO_DESIGNS, 0)
        self._designs, self._at, self._key = designs[gone:], self._at + 1 - gone, None
        return True

    def save(self) -> tuple[tuple[Design, ...], int]:
        """Where the history stands, for `restore`."""
        return tuple(self._designs), self._at

    def restore(self, saved: tuple[tuple[Design, ...], int]) -> None:
        """Go back to what `save` gave: the last change could not be shown."""
        self._designs, self._at, self._key = list(saved[0]), saved[1], None

    def move(self, step: int) -> bool:
        """Walk by so many steps, back where negative; False where there are not so many."""
        if not 0 <= self._at + step < len(self._designs):
            return False
        self._at += step
        self._key = None
        return True

    @property
    def can_undo(self) -> bool:
        """Whether there is something before."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is something after."""
        return self._at < len(self._designs) - 1
