"""Designs that nobody has thought about: every knob at random, each at its stops, every option clicked.

`python tests/lessons/attack.py [LESSON …]` tries every task on all of them and prints what falls.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np

from observer_lab.course.knobs import Choice, Knob, KnobError, Number, Poles, Switch, Track
from observer_lab.course.lesson import Design, Lesson, Outcome, Task
from observer_lab.engine import EngineError

RANDOM = 200  # designs of a lesson in the whole attack
Move = tuple[str, Any]


def at_random(knob: Knob, rng: np.random.Generator) -> Any:
    """Any value that the knob accepts, all decades alike where its scale is logarithmic."""
    if isinstance(knob, Number):
        low, high = knob.low, knob.high
        value = low * (high / low) ** rng.random() if knob.scale == "log" else low + (high - low) * rng.random()
        return knob.check(min(max(value, low), high))
    if isinstance(knob, Choice):
        return knob.options[int(rng.integers(len(knob.options)))][0]
    if isinstance(knob, Switch):
        return bool(rng.integers(2))
    if isinstance(knob, Poles):
        return knob.check(_poles(knob, len(knob.default), rng))
    if isinstance(knob, Track):
        return knob.check([(t, knob.low + (knob.high - knob.low) * rng.random()) for t in (0.0, 0.5, 1.0)])
    raise TypeError(type(knob).__name__)


def _poles(knob: Poles, count: int, rng: np.random.Generator) -> list[complex]:
    found: list[complex] = []
    while len(found) < count:
        re = knob.re_low + (knob.re_high - knob.re_low) * rng.random()
        if count - len(found) > 1 and knob.im_high > 0 and rng.random() < 0.6:
            im = knob.im_high * rng.random()
            found += [complex(re, im), complex(re, -im)]
        else:
            found.append(complex(re))
    return found


def random_designs(lesson: Lesson, count: int, seed: int = 0) -> Iterator[Design]:
    """Designs with every knob at random."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        yield lesson.apply(lesson.start(), {knob.name: at_random(knob, rng) for knob in lesson.knobs})


def stops(knob: Knob) -> list[Any]:
    """The values at which a hand ends that pushes the knob as far as it goes."""
    if isinstance(knob, Number):
        return [knob.check(knob.low), knob.check(knob.high)]
    if isinstance(knob, Poles):
        n = len(knob.default)
        return [knob.check([complex(edge * (1 - 0.01 * k) if edge < 0 else edge - 0.01 * k * (edge - knob.re_low)) for k in range(n)])
                for edge in (knob.re_low, knob.re_high)]
    if isinstance(knob, Track):
        return [knob.check([(0.0, knob.low)]), knob.check([(0.0, knob.high)])]
    return []


def clicks(knob: Knob) -> list[Any]:
    """The options that can be clicked."""
    return [name for name, _ in knob.options] if isinstance(knob, Choice) else [False, True] if isinstance(knob, Switch) else []


def single_moves(lesson: Lesson) -> Iterator[tuple[Move, ...]]:
    """One stop or one click, from the lesson's start."""
    start = lesson.start()
    for knob in lesson.knobs:
        yield from (((knob.name, value),) for value in (*stops(knob), *clicks(knob)) if value != start[knob.name])


def double_moves(lesson: Lesson) -> list[tuple[Move, ...]]:
    """One click, and one stop or click of another knob."""
    singles = [m[0] for m in single_moves(lesson)]
    clicked = [m for m in singles if clicks(lesson.knob(m[0]))]
    return [(first, second) for k, (first, second) in enumerate(product(clicked, singles))
            if first[0] != second[0] and (second not in clicked or clicked.index(second) > k // len(singles))]


def outcome_of(lesson: Lesson, design: Design) -> Outcome | None:
    """The outcome, None where the lesson refuses in a sentence."""
    try:
        return lesson.compute(design)
    except (EngineError, KnobError):
        return None


def solved(lesson: Lesson, outcome: Outcome) -> list[str]:
    """The tasks that this outcome solves; none that refuses in a sentence when it is looked at."""
    return [task.id for task in lesson.tasks if _solves(task, outcome)]


def _solves(task: Task[Any], outcome: Outcome) -> bool:
    try:
        return task.judge(outcome).solved
    except (EngineError, KnobError):
        return False


def attack(lesson: Lesson) -> Iterator[str]:
    """One line for every task that falls: its share of random designs, and the moves that solve it."""
    start = lesson.start()
    doubles = double_moves(lesson)
    np.random.default_rng(0).shuffle(doubles)
    for kind, moves in (("one move", single_moves(lesson)), ("two moves", doubles[:RANDOM])):
        for move in moves:
            outcome = outcome_of(lesson, lesson.apply(start, dict(move)))
            for task in solved(lesson, outcome) if outcome is not None else ():
                yield f"{lesson.id}/{task}: {kind}: {', '.join(f'{name} = {str(value)[:40]}' for name, value in move)}"
    fallen: dict[str, int] = {}
    for design in random_designs(lesson, RANDOM):
        outcome = outcome_of(lesson, design)
        for task in solved(lesson, outcome) if outcome is not None else ():
            fallen[task] = fallen.get(task, 0) + 1
    yield from (f"{lesson.id}/{task}: random: {100 * n / RANDOM:.1f} %" for task, n in fallen.items())


if __name__ == "__main__":
    from observer_lab.lessons import LESSONS
    for name in sys.argv[1:] or LESSONS:
        for line in attack(LESSONS[name]):
            print(line, flush=True)
