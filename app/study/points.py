"""Compute one run of a study from its number, the same in any process or order."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from observer_lab.lessons import LESSONS

from ..course.knobs import KnobError, Number
from ..course.lesson import Design, Lesson, Outcome
from ..engine import EngineError
from ..engine.kernels import COMPILE_CACHE
from ..plants.own_plant import canonical_text, parts_of, plant_of
from ..plants.plant_extras import PlantExtras
from .plan import Axis, Row, Study, StudyError, programs

ENTRY = re.compile(r"([ABCDFK])\((\d{1,3}),\s*(\d{1,3})\)")
SEED_KNOB = "seed"  # the knob that noise is drawn from
CHECK_PREFIX = "check."  # stands before the name of a check among the numbers

Chunk = tuple[dict[str, str], list[Row]]  # by which programs, and what


def outcome_of(lesson: Lesson, design: Design, final: bool) -> Outcome:
    """What a design leads to; the lesson's long computation too if `final`. Raises what the lesson raises."""
    outcome = lesson.compute(design)
    outcome.complete()
    if final and lesson.job is not None:
        for _, better in lesson.job.outcomes(outcome):
            outcome = better
    return outcome


def numbers(outcome: Outcome) -> Mapping[str, float]:
    """The numbers of an outcome by name: its metrics, and for every check 1 where it holds and 0 where not."""
    return {**{name: float(value) for name, value in outcome.metrics.items()},
            **{CHECK_PREFIX + check.id: float(check.holds) for check in outcome.checks}}


def grid_place(study: Study, index: int) -> tuple[int, int, tuple[int, ...]]:
    """The number of a run's point, of the run at that point, and the point's place on each axis."""
    point, run = divmod(index, study.runs)
    return point, run, tuple(map(int, np.unravel_index(point, study.shape))) if study.axes else ()


def seed_at(study: Study, index: int) -> float | None:
    """The seed of a run, None for that of its design."""
    point, run, _ = grid_place(study, index)
    if study.seeds:
        return study.seeds[run]
    if not study.drawn:
        return None
    knob = seed_knob(LESSONS[study.lesson])
    return knob.low + float(_drawn(study.entropy, point, int(knob.high - knob.low) + 1)[run])


def seed_knob(lesson: Lesson) -> Number:
    """The knob of the seed. Raises StudyError where a lesson draws nothing."""
    knob = next((knob for knob in lesson.knobs if knob.name == SEED_KNOB), None)
    if not isinstance(knob, Number):
        raise StudyError(f"Lesson {lesson.id} draws nothing from a seed; leave out seeds.")
    return knob


@lru_cache(maxsize=4)
def _drawn(entropy: int, point: int, span: int) -> np.ndarray:
    """The numbers below `span` in an order of their own for each point, by the hash that every NumPy computes alike."""
    return np.argsort(np.random.SeedSequence(entropy, spawn_key=(point,)).generate_state(span, np.uint64), kind="stable")


def design_of(study: Study) -> tuple[Lesson, Design]:
    """The lesson and the design that all varies from. Raises KnobError or EngineError where what is set fits no such plant."""
    lesson = LESSONS[study.lesson].fit(study.plant)
    return lesson, lesson.apply(lesson.start(), dict(study.changes))


def design_at(study: Study, index: int) -> tuple[Lesson, Design]:
    """The lesson of a run, fitted to its plant, and its design. Raises KnobError or EngineError where there is none."""
    _, _, place = grid_place(study, index)
    changes, plant = dict(study.changes), study.plant
    here = [(axis, axis.values[at]) for axis, at in zip(study.axes, place, strict=True)]
    changes.update((axis.name, value) for axis, value in here if not axis.of_plant)
    turned = [(axis, float(value)) for axis, value in here if axis.of_plant]
    if turned:
        matrices = matrices_of(plant)
        for axis, value in turned:
            matrices = with_value(matrices, axis, value)
        F, K = matrices.pop("F", None), matrices.pop("K", None)
        plant = canonical_text(replace(plant_of(plant), **matrices), PlantExtras(F, K))
    seed = seed_at(study, index)
    if seed is not None:
        changes[SEED_KNOB] = seed
    lesson = LESSONS[study.lesson].fit(plant)
    return lesson, lesson.apply(lesson.start(), changes)


def matrices_of(plant: str) -> dict[str, np.ndarray]:
    """A, B, C and D of a plant in its canonical text, and F and K of a bilinear one, to be changed."""
    linear, beyond = parts_of(plant)
    found = {name: getattr(linear, name) for name in "ABCD"} | {"F": beyond.F, "K": beyond.K}
    return {name: np.array(matrix) for name, matrix in found.items() if matrix is not None}


def with_value(given: Mapping[str, np.ndarray], axis: Axis, value: float) -> dict[str, np.ndarray]:
    """The matrices with an entry set, or with entries multiplied and divided by a factor. Raises StudyError."""
    matrices = {name: np.array(matrix) for name, matrix in given.items()}
    for entry in axis.times:
        name, i, j = entry_of(matrices, entry)
        matrices[name][i, j] *= value
    for entry in axis.over:
        name, i, j = entry_of(matrices, entry)
        matrices[name][i, j] /= value
    if not axis.times and not axis.over:
        name, i, j = entry_of(matrices, axis.name)
        matrices[name][i, j] = value
    return matrices


def entry_of(matrices: Mapping[str, np.ndarray], words: str) -> tuple[str, int, int]:
    """Matrix, row and column from 0 of an entry such as A(2,1). Raises StudyError where the plant has none."""
    found = ENTRY.fullmatch(words.replace(" ", ""))
    if found is None:
        raise StudyError(f"{words[:40]} is no entry of a plant; write A(2,1) for row 2 and column 1 of A.")
    if found[1] not in matrices:
        raise StudyError(f"The plant has no entry {words[:40]}: its file has no {found[1]}.")
    rows, columns = matrices[found[1]].shape
    i, j = int(found[2]), int(found[3])
    if not (1 <= i <= rows and 1 <= j <= columns):
        raise StudyError(f"The plant has no entry {words[:40]}: its {found[1]} is {rows}×{columns}.")
    return found[1], i - 1, j - 1


def run_at(study: Study, index: int) -> Row:
    """What a run comes to; one that its lesson refuses, or fails at, says so in place of numbers."""
    try:
        lesson, design = design_at(study, index)
        found = numbers(outcome_of(lesson, design, study.final))
        return Row(index, tuple(found.get(name) for name in study.collect))
    except (EngineError, KnobError) as problem:
        return Row(index, (None,) * len(study.collect), str(problem))
    except Exception as problem:  # of a hundred thousand runs one may meet what nobody foresaw; the others go on
        return Row(index, (None,) * len(study.collect), f"an error in the program, {type(problem).__name__}: {str(problem)[:200]}")


def run_chunk(study: Study, indexes: Sequence[int]) -> Chunk:
    """What some runs come to. Kernels stay out of it: what is compiled rounds as its processor does."""
    with COMPILE_CACHE.holding({}):
        return programs(), [run_at(study, index) for index in indexes]
