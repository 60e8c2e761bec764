"""What one move of a slider runs without the page: calls, functions and files of ours by cProfile, beside what fbea0ee needed.

    python tests/benchmarks/calls_of_a_move.py [LESSON:KNOB ...]

A tab with a view that records moves the knob ten times, so that everything is loaded; the eleventh move is counted. The engine's share is
told apart: how often it iterates is the numbers' affair. Status 1 where a bound is passed.
"""

from __future__ import annotations

import cProfile
import os
import pstats
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
sys.path.insert(0, str(Path(__file__).parents[1] / "tab"))

from fakes import Clock, FakeView

from observer_lab.course.knobs import Number
from observer_lab.lessons import LESSONS
from observer_lab.session.commands.commands import SetKnobs
from observer_lab.session.session import Session

BOUNDS = {"separation:stiffness_error": (3228, 387, 70), "kalman:q": (4539, 332, 64)}  # calls, functions, files at fbea0ee
BEFORE = {"separation:stiffness_error": ((2562, 337, 66), (720, 172, 40)), "kalman:q": ((2949, 335, 64), (672, 187, 37))}  # by this script
OURS = (f"{os.sep}app{os.sep}", f"{os.sep}lessons{os.sep}")
Count = tuple[int, int, int]
WARM_MOVES = 10


def counted(lesson: str, knob: str) -> pstats.Stats:
    """The profile of one move of a slider in a lesson that is open and warm."""
    clock = Clock()
    session = Session(LESSONS, FakeView(), lesson, "en", clock=clock)
    session.restore(None)
    session.open()
    slider = next(each for each in LESSONS[lesson].knobs if each.name == knob)
    assert isinstance(slider, Number)
    start = LESSONS[lesson].start()[knob]
    step = (slider.high - slider.low) / 100 * (-1 if start > (slider.low + slider.high) / 2 else 1)
    profile = cProfile.Profile()
    for move in range(WARM_MOVES + 1):
        clock.advance(0.05)
        session.post(SetKnobs({knob: start + step * (move + 1)}))
        if move == WARM_MOVES:
            profile.enable()
        session.step()
        profile.disable()
    return pstats.Stats(profile)


def figures_of(stats: pstats.Stats, engine: bool) -> Count:
    """Calls, functions and files of ours, with or without the engine's."""
    table = {place: told for place, told in stats.stats.items()  # type: ignore[attr-defined]
             if any(part in place[0] for part in OURS) and "site-packages" not in place[0]
             and (engine or f"{os.sep}engine{os.sep}" not in place[0])}
    return sum(calls for _, calls, *_ in table.values()), len(table), len({file for file, *_ in table})


def told(count: Count | None) -> str:
    """A count as one cell of the table."""
    return "—" if count is None else ", ".join(f"{n:,}" for n in count)


def main(asked: list[str]) -> int:
    """Print the table; 1 where a bound is passed."""
    over = 0
    print("Calls, functions, files:\n")
    print("| move | now | at fbea0ee | bound | now, without the engine | at fbea0ee |\n|---|---|---|---|---|---|")
    for name in asked or list(BOUNDS):
        lesson, _, knob = name.partition(":")
        stats, bound, before = counted(lesson, knob), BOUNDS.get(name), BEFORE.get(name, (None, None))
        found, lean = figures_of(stats, engine=True), figures_of(stats, engine=False)
        over += bound is not None and any(now > then for now, then in zip(found, bound, strict=True))
        print(f"| {name} | {told(found)} | {told(before[0])} | {told(bound)} | {told(lean)} | {told(before[1])} |")
    return 1 if over else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
