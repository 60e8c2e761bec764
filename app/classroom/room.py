"""Describe what a presenter sees of a room, and what a session may ask of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from .votes import Vote

LECTURE = "lecture"  # the place of those who follow
MAX_PLACES = 6  # that are named; the others are counted together


@dataclass(frozen=True)
class RoomView:
    """Counts of a room, and its latest votes. `places` counts those who work on their own by lesson, scene and task."""

    here: int = 0
    following: int = 0
    slower: int = 0
    places: tuple[tuple[str, int], ...] = ()
    votes: tuple[Vote, ...] = ()


def overview(counts: Mapping[str, int], slower: int, votes: tuple[Vote, ...]) -> RoomView:
    """The view of a room from the counts by place, in all of its workers."""
    own = Counter({place: count for place, count in counts.items() if place != LECTURE and count > 0})
    following = counts.get(LECTURE, 0)
    return RoomView(following + own.total(), following, slower, tuple(sorted(own.most_common(MAX_PLACES))), votes)


class VoteDesk(Protocol):
    """What a presenter's session asks of its room."""

    def open_vote(self, lesson: str, scene: str, options: int) -> RoomView:
        """Ask the class the question of a scene, once more where it was asked before; the vote that was open ends."""
        ...

    def close_vote(self) -> RoomView:
        """Take no more votes."""
        ...

    def lower_hands(self) -> RoomView:
        """Forget who asked for a slower lecture."""
        ...
