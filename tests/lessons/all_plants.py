"""Every lesson that takes a person's own plant, on many random ones: no exception, no warning, no figure against another.

    python tests/lessons/all_plants.py [plants] [seed] [lesson …]
"""

from __future__ import annotations

import sys
import warnings
from collections import Counter
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    tests = Path(__file__).resolve().parents[1]
    sys.path[:0] = [str(tests.parent), str(tests), str(tests / "engine"), str(tests / "lessons")]

from lesson_checks import check_figures, numbers_of
from unit_cases import ones, random_case, random_units  # type: ignore[import-not-found]

from observer_lab.course.knobs import KnobError
from observer_lab.course.lesson import Lesson, Outcome
from observer_lab.engine import EngineError, Plant
from observer_lab.lessons import LESSONS
from observer_lab.plants.own_plant import canonical_text
from observer_lab.plants.plant_extras import PlantExtras

ABOVE = (("J", "J_least"), ("J", "J_known"), ("rms", "least_rms"))  # the first is never below the second
NEVER_NEGATIVE = ("J", "J_least", "J_known", "J_open", "rms", "least_rms", "nis_mean", "nis_expected", "nees_mean",
                  "sensor_input", "clipped_share", "union_error", "riccati_residual", "dynamics_residual", "output_residual")
ROUNDING = 1e-7


def contradictions(outcome: Outcome) -> str:
    """What two numbers of an outcome say against each other, or one against what it is."""
    m = outcome.metrics
    for high, low in ABOVE:
        if high in m and low in m and m[high] < m[low] * (1 - ROUNDING):
            return f"{high} = {m[high]:.9g} is below {low} = {m[low]:.9g}"
    for name in NEVER_NEGATIVE:
        if m.get(name, 0.0) < 0:
            return f"{name} = {m[name]:.3g} is negative"
    if outcome.stage is not None and outcome.stage.spread is not None and np.any(np.asarray(outcome.stage.spread) < 0):
        return "a deviation on the stage is negative"
    wrong = [name for name, values in numbers_of(outcome) if not np.all(np.isfinite(values))]
    return f"{wrong[0]} is not finite" if wrong else ""


def wrong_on(lesson: Lesson, plant: str) -> str:
    """What is wrong with a lesson on a plant; nothing if it is whole, "refused" where a sentence says why it does not fit."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            own = lesson.fit(plant)
            outcome = own.compute(own.start())
            check_figures(tuple(own.figures(outcome)))
            return contradictions(outcome)
        except (EngineError, KnobError) as problem:
            return "refused" if "\n" not in str(problem) else f"two sentences: {problem}"
        except Exception as problem:
            return f"{type(problem).__name__}: {problem}".replace("\n", " ")


def random_plant(seed: tuple[int, ...], sampled: bool = False, bilinear: bool = False) -> str:
    """In its own units, or in others up to six decades away; a bilinear one has F, of one input or all, and one to three rows of K."""
    rng = np.random.default_rng(seed)
    case = random_case(rng, sampled)
    z = ones(case) if rng.random() < 0.5 else random_units(case, rng)
    plant = case.to(z).plant
    if not bilinear or sampled:
        return canonical_text(plant)
    k = 1 if rng.random() < 0.5 else plant.m
    F, K = rng.standard_normal((plant.n, k * plant.n)), rng.standard_normal((int(rng.integers(1, 4)), plant.n))
    return canonical_text(Plant(plant.A, plant.B[:, :k], plant.C), PlantExtras(z.tau * F * np.kron(z.U[:k], z.X) / z.X[:, None], K * z.X))


def main(plants: int = 200, seed: int = 1, *ids: str) -> None:
    """A row for each lesson: on how many plants it fails, on how many it says that it does not fit, and an example."""
    for lesson in LESSONS.values():
        if lesson.adapt is None or (ids and lesson.id not in ids):
            continue
        found: Counter[str] = Counter()
        example = ""
        for k in range(plants):
            wrong = wrong_on(lesson, random_plant((seed, k), sampled=k % 4 == 3, bilinear=lesson.bilinear))
            found["refused" if wrong == "refused" else "wrong" if wrong else "whole"] += 1
            example = example or (f"plant {k}: {wrong}" if wrong not in ("", "refused") else "")
        print(f"{lesson.id:18s} {found['wrong']:4d} wrong, {found['refused']:4d} refused of {plants}  {example[:150]}", flush=True)


if __name__ == "__main__":
    plants, seed = [*sys.argv[1:], "200", "1"][:2] if len(sys.argv) < 2 else [*sys.argv[1:3], "1"][:2]
    main(int(plants), int(seed), *sys.argv[3:])
