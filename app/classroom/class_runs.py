"""Hold the runs of a class, one for each follower, as the workers of a server hand them on."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np


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
