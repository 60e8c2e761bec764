"""How long the draft of each lesson takes while a knob moves: compute and figures, on random walks of every knob.

    python tests/benchmarks/bench_drafts.py [LESSON ...]

Prints a Markdown table; the budget is a 95th percentile of 20 ms.
"""


from __future__ import annotations

import os

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")

import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from app.engine import EngineError
from app.engine.systems import move_pole
from app.lesson.knobs import Choice, Knob, KnobError, Number, Poles, Switch
from app.lesson.lesson import Design, Lesson
from lessons import LESSONS

STEPS = 40  # positions of each knob, as a slow sweep of a slider sends them
SNAP = 0.02


def settings(lesson: Lesson) -> Iterator[Design]:
    """The start, and the start with each choice and switch at each of its values: every knob is shown in one of them."""
    start = lesson.start()
    yield start
    for knob in lesson.knobs:
        if isinstance(knob, Choice):
            values: tuple[Any, ...] = tuple(name for name, _ in knob.options)
        elif isinstance(knob, Switch):
            values = (True, False)
        else:
            continue
        for value in values:
            if value != start[knob.name]:
                yield lesson.apply(start, {knob.name: value})


def walk(knob: Knob, value: Any, rng: np.random.Generator) -> Iterator[Any]:
    """Neighbouring values of a knob, from its present one on, reflected at its bounds."""
    for _ in range(STEPS):
        if isinstance(knob, Number):
            low, high = (np.log10([knob.low, knob.high]) if knob.scale == "log" else (knob.low, knob.high))
            at = (np.log10(value) if knob.scale == "log" else value) + rng.normal(0.0, 0.05) * (high - low)
            at = low + abs((at - low) % (2 * (high - low)) - (high - low)) if not low <= at <= high else at
            value = float(np.clip(10.0**at if knob.scale == "log" else at, knob.low, knob.high))
        elif isinstance(knob, Poles):
            pole = int(rng.integers(len(value)))
            to = value[pole] + complex(rng.normal(0, 0.05) * (knob.re_high - knob.re_low), rng.normal(0, 0.1) * knob.im_high)
            to = complex(np.clip(to.real, knob.re_low, knob.re_high), np.clip(to.imag, -knob.im_high, knob.im_high))
            value = move_pole(value, pole, to, axis_snap=SNAP * knob.im_high)
        yield value


def measure(lesson: Lesson, rng: np.random.Generator) -> tuple[list[float], int]:
    """Processor milliseconds of each draft (a busy machine hardly counts), and how many designs were refused."""
    times, refused = [], 0
    for start in settings(lesson):
        for knob in lesson.knobs:
            if not isinstance(knob, (Number, Poles)) or not lesson.shown(knob, start):
                continue
            for value in walk(knob, start[knob.name], rng):
                began = time.process_time()
                try:
                    lesson.figures(lesson.compute(lesson.apply(start, {knob.name: value})))
                except (EngineError, KnobError):
                    refused += 1
                times.append(1e3 * (time.process_time() - began))
    return times, refused


def main(names: list[str]) -> None:
    print("| lesson | drafts | median [ms] | p95 [ms] | max [ms] | refused |\n|---|---|---|---|---|---|")
    for lesson in LESSONS.values():
        if names and lesson.id not in names:
            continue
        lesson.figures(lesson.compute(lesson.start()))  # imports and caches of the first run are not the subject
        times, refused = measure(lesson, np.random.default_rng(1))
        median, p95 = np.percentile(times, (50, 95))
        print(f"| {lesson.id} | {len(times)} | {median:.1f} | {p95:.1f} | {max(times):.1f} | {refused} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
