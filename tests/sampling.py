"""Take a sample of the cases of costly laws in the suite, and all of them with `--whole`.

`sampled.txt` names these laws: of how many cases one is taken, and how many seconds of a processor the others cost. The cases of a law
are counted as they are collected. Of so many turns a law has one by its own name, so that laws over the same things take other cases
of them. No date and no random number has a part in it. `python tests/sampling.py` prints the sums.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple, TypeVar
from zlib import crc32

T = TypeVar("T")
WHOLE = "OBSERVER_LAB_WHOLE"  # set by `--whole`, for laws that take several things in one test


class Sample(NamedTuple):
    """Of how many cases the suite takes one, and what the others cost, in seconds of a processor."""

    every: int
    seconds: float


def read(text: str) -> Mapping[str, Sample]:
    """The laws of a table, in lines of `every seconds law`."""
    rows = [line.split() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return MappingProxyType({law: Sample(int(every), float(seconds)) for every, seconds, law in rows})


SAMPLED = read((Path(__file__).parent / "sampled.txt").read_text(encoding="utf-8"))


def whole() -> bool:
    """Whether everything is run that the suite samples."""
    return WHOLE in os.environ


def turn(law: str, every: int) -> int:
    """Which of `every` turns a law has."""
    return crc32(law.encode()) % every


def taken(law: str, things: Iterable[T], every: int) -> list[T]:
    """Those of the things that are a law's turn; one of them where they are fewer than turns."""
    found = list(things)
    every = max(1, min(every, len(found)))
    return found[turn(law, every)::every]


def some(law: str, things: Iterable[T], every: int) -> list[T]:
    """The law's turn of the things, all of them with `--whole`."""
    return list(things) if whole() else taken(law, things, every)


def left_out(cases: Sequence[T], law_of: Callable[[T], str]) -> set[int]:
    """The places of the cases that the suite leaves out."""
    places = defaultdict[str, list[int]](list)
    for k, case in enumerate(cases):
        places[law_of(case)].append(k)
    return {k for law, sample in SAMPLED.items() for k in {*places[law]} - {*taken(law, places[law], sample.every)}}


if __name__ == "__main__":
    sums = defaultdict[str, float](float)
    for law, sample in SAMPLED.items():
        sums[law.partition("/")[0]] += sample.seconds
    print(*(f"{seconds:6.0f} s  {folder}" for folder, seconds in sorted(sums.items(), key=lambda pair: -pair[1])), sep="\n")
