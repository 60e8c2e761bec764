"""How long the draft of each lesson takes while a knob moves, on random walks of every knob, one tab after another open.

    python tests/benchmarks/bench_drafts.py [--own STATES] [LESSON ...]

Prints a Markdown table: what is looked at first (boards, stage, the open tab), and the whole with all that follows when the hand
pauses. OBSERVER_LAB_KERNELS=off measures the plain ways.
The budget of the first is a 95th percentile of 10 ms where `forced_response` takes 50 ms, which is printed too; with `--own`,
on a chain of masses with so many states, 25 ms for thirty.
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

import bench_loops

from observer_lab.course.figures.records import tab_names
from observer_lab.course.knobs import Choice, Knob, KnobError, Number, Poles, Switch
from observer_lab.course.lazy import FigureSet, complete_figures
from observer_lab.course.lesson import Design, Lesson
from observer_lab.engine import EngineError, Plant
from observer_lab.engine.kernels import COMPILE_CACHE, kernels_off
from observer_lab.engine.systems import move_pole
from observer_lab.lessons import LESSONS
from observer_lab.plants.own_plant import canonical_text

STEPS = 40  # positions of each knob, as a slow sweep of a slider sends them
SNAP = 0.02


def chain(states: int) -> str:
    """A person's own plant: masses between springs and dampers, two forces, two positions measured."""
    count = states // 2
    T = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    A = np.block([[np.zeros((count, count)), np.eye(count)], [-T, -0.1 * T - 0.02 * np.eye(count)]])
    B, C = np.zeros((2 * count, 2)), np.zeros((2, 2 * count))
    B[count, 0] = B[-1, 1] = C[0, 0] = C[1, count // 2] = 1.0
    return canonical_text(Plant(A, B, C))


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


def measure(lesson: Lesson, rng: np.random.Generator) -> tuple[list[tuple[float, float]], int]:
    """Processor milliseconds of each draft (a busy machine hardly counts), first part and whole, and how many designs were refused."""
    times, refused, names = [], 0, [tab("en") for tab in tab_names(lesson.figures(lesson.compute(lesson.start())))]
    for start in settings(lesson):
        for knob in lesson.knobs:
            if not isinstance(knob, (Number, Poles)) or not lesson.shown(knob, start):
                continue
            for value in walk(knob, start[knob.name], rng):
                began, opened = time.process_time(), names[len(times) // STEPS % len(names)]
                first = None
                try:
                    outcome = lesson.compute(lesson.apply(start, {knob.name: value}))
                    figures = lesson.figures(outcome)
                    if isinstance(figures, FigureSet):
                        figures.front(opened)
                    first = time.process_time()
                    complete_figures(figures, lambda: True)
                    outcome.complete()
                except (EngineError, KnobError):
                    refused += 1
                end = time.process_time()
                times.append((1e3 * ((first or end) - began), 1e3 * (end - began)))
    return times, refused


def main(names: list[str]) -> None:
    plant = ""
    if names and names[0] == "--own":
        plant, names = chain(int(names[1])), names[2:]
    compiled, hour = not kernels_off() and COMPILE_CACHE.fill(), bench_loops.linear(*bench_loops.rig()).theirs
    print(f"`forced_response`: {1e3 * hour:.0f} ms; kernels {'compiled' if compiled else 'plain'}.\n")
    print("| lesson | drafts | first: median | p95 [ms] | max | whole: median | p95 [ms] | refused |\n|---|---|---|---|---|---|---|---|")
    for lesson in LESSONS.values():
        if (names and lesson.id not in names) or (plant and lesson.adapt is None):
            continue
        try:
            lesson = lesson.fit(plant)
        except (EngineError, KnobError) as problem:
            print(f"| {lesson.id} | {problem} |", flush=True)
            continue
        lesson.figures(lesson.compute(lesson.start()))  # imports and caches of the first run are not the subject
        times, refused = measure(lesson, np.random.default_rng(1))
        (median, whole), (p95, whole95) = np.percentile(times, (50, 95), axis=0)
        most = max(first for first, _ in times)
        print(f"| {lesson.id} | {len(times)} | {median:.1f} | {p95:.1f} | {most:.1f} | {whole:.1f} | {whole95:.1f} | {refused} |",
              flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
