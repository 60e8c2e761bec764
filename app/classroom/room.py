"""Describe what a presenter sees of a room, the runs of its class, and what a session may ask of it."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .votes import Asked, Vote

LECTURE = "lecture"  # the place of those who follow
UNSOLVED = "unsolved:"  # before the place of a task that was tried without success
MAX_PLACES = 6  # that are named; the others are counted together


@dataclass(frozen=True)
class RoomView:
    """Counts of a room, and its latest votes. `places` counts those who work on their own by lesson and scene, `unsolved` those who
    have tried a task there without success."""

    here: int = 0
    following: int = 0
    slower: int = 0
    places: tuple[tuple[str, int], ...] = ()
    unsolved: tuple[tuple[str, int], ...] = ()
    votes: tuple[Vote, ...] = ()
    audience: str = ""  # the address of those who follow
    failing: bool = False  # whether the store cannot be read or written
    paused: bool = False  # whether the pages of the class are paused


def overview(counts: Mapping[str, int], slower: int, votes: tuple[Vote, ...]) -> RoomView:
    """The view of a room from the counts by place, in all of its workers."""
    following = counts.get(LECTURE, 0)
    own = Counter({place: count for place, count in counts.items() if place != LECTURE and not place.startswith(UNSOLVED)})
    tried = Counter({place.removeprefix(UNSOLVED): count for place, count in counts.items() if place.startswith(UNSOLVED)})
    return RoomView(following + own.total(), following, slower, _first(own), _first(tried), votes)


def _first(counts: Counter[str]) -> tuple[tuple[str, int], ...]:
    """Those with the highest counts, in the order of their names."""
    return tuple(sorted((place, count) for place, count in counts.most_common(MAX_PLACES) if count > 0))


class VoteDesk(Protocol):
    """What a presenter's session asks of its room."""

    @property
    def audience(self) -> str:
        """The address of those who follow."""
        ...

    def open_vote(self, lesson: str, scene: str, options: int, asked: Asked | None = None) -> RoomView:
        """Ask the class the question of a scene, or what was typed, once more where it was asked before; the open vote ends."""
        ...

    def close_vote(self) -> RoomView:
        """Take no more votes."""
        ...

    def show_counts(self, vote: Vote, shown: bool) -> RoomView:
        """Show the counts of a closed vote to everybody, or hide them."""
        ...

    def discuss(self, vote: Vote) -> RoomView:
        """Let the class discuss a closed vote for a while."""
        ...

    def reveal(self, vote: Vote) -> RoomView:
        """Tell the answer to a closed vote, with its counts."""
        ...

    def lower_hands(self) -> RoomView:
        """Forget who asked for a slower lecture."""
        ...

    def pause(self, on: bool) -> RoomView:
        """Pause the pages of the class, or let them go on."""
        ...

    def draw_seeds(self) -> Mapping[int, int]:
        """The seed of each follower by the follower's number; those who follow now."""
        ...

    def show_runs(self, runs: ClassRuns | None) -> None:
        """Show each follower their own run, or take it away from all."""
        ...


@dataclass(frozen=True)
class OwnRun:
    """One follower's run: the error over the times of the class, its predicted standard deviation, and whether the last error lies in
    the ellipse of P."""

    path: tuple[float, ...]
    sigma: tuple[float, ...]
    inside: bool


@dataclass(frozen=True)
class ClassRuns:
    """The runs by the followers' numbers. `name` says by language what the error is of."""

    name: Mapping[str, str]
    times: tuple[float, ...]
    runs: Mapping[int, OwnRun]

    def write(self) -> str:
        """As text."""
        return json.dumps([dict(self.name), self.times, {str(seat): [run.path, run.sigma, run.inside] for seat, run in self.runs.items()}])


def read_runs(words: str) -> ClassRuns:
    """The runs in such a text. Raises ValueError."""
    name, times, runs = json.loads(words)
    return ClassRuns(name, tuple(times), {int(seat): OwnRun(tuple(path), tuple(sigma), bool(inside))
                                          for seat, (path, sigma, inside) in runs.items()})


def seeds_of(room: int, seats: tuple[int, ...]) -> tuple[int, ...]:
    """The seed of each follower, drawn from the room's seed and the follower's number."""
    return tuple(int(np.random.SeedSequence([room, seat]).generate_state(1)[0]) for seat in seats)
