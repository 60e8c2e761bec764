"""Define a study: lesson, settings, axes, number of draws and collected numbers."""

from __future__ import annotations

import hashlib
import json
import math
import platform
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from ..export.data.data import plain

MAX_STUDY_RUNS = 200_000  # runs of a study


class StudyError(ValueError):
    """A study that makes no sense or cannot go on; the message is one sentence."""


@dataclass(frozen=True)
class Axis:
    """What varies: a knob of that name, or the user's plant, an entry such as A(2,1) or a factor of several entries.

    A factor multiplies the entries `times` and divides the entries `over`, as a physical parameter does.
    """

    name: str
    values: tuple[Any, ...]
    log: bool = False
    of_plant: bool = False
    times: tuple[str, ...] = ()
    over: tuple[str, ...] = ()


@dataclass(frozen=True)
class Study:
    """A study that has passed the gate. Its runs are numbered point by point, the last axis fastest, seed by seed.

    `seeds` are those of every point; where there are none, `drawn` different ones are drawn for each point, by `entropy`
    and the number of the point; where that is 0, each point runs once with the seed of its design.
    """

    lesson: str
    plant: str = ""
    changes: tuple[tuple[str, Any], ...] = ()
    axes: tuple[Axis, ...] = ()
    seeds: tuple[float, ...] = ()
    drawn: int = 0
    entropy: int = 1
    collect: tuple[str, ...] = ()
    final: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each axis has."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def points(self) -> int:
        """How many designs there are beside their seeds."""
        return math.prod(self.shape)

    @property
    def runs(self) -> int:
        """How often each point is run."""
        return len(self.seeds) or self.drawn or 1

    @property
    def size(self) -> int:
        """How many runs there are in all."""
        return self.points * self.runs


@dataclass(frozen=True)
class Row:
    """What one run came to: a number for each name that is collected, None where it has none; or why there is nothing."""

    index: int
    values: tuple[float | None, ...]
    problem: str = ""


def record(study: Study) -> dict[str, Any]:
    """A study as plain data: all that its results depend on but the programs."""
    return {
        "lesson": study.lesson, "plant": json.loads(study.plant) if study.plant else None,
        "set": {name: plain(value) for name, value in study.changes},
        "vary": {axis.name: {"values": plain(axis.values), "scale": "log" if axis.log else "linear",
                             "of": "plant" if axis.of_plant else "knob", "times": list(axis.times), "over": list(axis.over)}
                 for axis in study.axes},
        "seeds": plain(study.seeds) if study.seeds else study.drawn, "seed": study.entropy,
        "collect": list(study.collect), "final": study.final,
    }


def programs() -> dict[str, str]:
    """The programs that the last digit of a result depends on, by their versions."""
    return {"observer-lab": _version("observer-lab"), "python": platform.python_version(), "numpy": _version("numpy"),
            "scipy": _version("scipy")}


def digest(study: Study, made_by: Mapping[str, str]) -> str:
    """What tells this study, computed by these programs, from every other."""
    written = json.dumps([record(study), dict(made_by)], sort_keys=True, ensure_ascii=True)
    return hashlib.sha256(written.encode("ascii")).hexdigest()[:32]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "unknown"
