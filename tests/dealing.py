"""Deal the tests out to the workers: each begins with what takes long, so that what is left at the end is short and can be shared.

`--dist worksteal` gives each worker an equal piece of the list, and who has nothing left takes half of what another has, from its end.
In the order of the folders the browser's tests stood in one piece, behind the longest ones, and were what all waited for.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import TypeVar

T = TypeVar("T")
SECONDS = {  # roughly, of a test in a folder or of a whole file; what is not named is short
    "test_kernels.py": 30.0,  # a compiler of low priority, which waits for whatever else runs; 5 where the cache has them
    "test_package.py": 45.0,
    "e2e": 5.0, "wire": 1.0, "test_cli_serve.py": 40.0, "test_refusals.py": 8.0}
HOUSE = frozenset({"test_architecture.py", "test_public_names.py", "test_reached.py", "test_text.py"})  # one worker reads it for all these


def dealt(things: Sequence[T], workers: int, place: Callable[[T], tuple[str, str]]) -> list[T]:
    """The same things, in equal pieces for the workers: files of long ones first, shared evenly, then the short ones as they came.

    `place` gives folder and file of a thing. A file is never divided, nor are those of `HOUSE`: they share what they have read.
    """
    long, short = list[tuple[float, list[T]]](), list[T]()
    house = [thing for thing in things if place(thing)[1] in HOUSE]
    for (folder, file), group in groupby(things, place):
        tests = list(group)
        if file in SECONDS or folder in SECONDS:
            long.append((SECONDS[file] if file in SECONDS else SECONDS[folder] * len(tests), tests))
        elif file not in HOUSE:
            short += tests
    pieces, taken = [list[T]() for _ in range(workers)], [0.0] * workers
    for seconds, tests in sorted([*long, (60.0, house)], key=lambda each: -each[0]):
        least = taken.index(min(taken))
        pieces[least] += tests
        taken[least] += seconds
    found, left = list[T](), len(things)
    for k, piece in enumerate(pieces):
        room = max(0, left // (workers - k) - len(piece))
        found += [*piece, *short[:room]]
        short, left = short[room:], len(things) - len(found)
    return [*found, *short]
