"""Ten small plants of the literature, collected in COMPlib: every lesson takes or refuses them, and verdicts are those of PBH."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from all_plants import wrong_on

from observer_lab.course.lesson import Lesson
from observer_lab.engine import Plant, controllability, observability
from observer_lab.lessons import LESSONS
from observer_lab.plants.own_plant import clean_plant_json

PLANTS = json.loads((Path(__file__).parents[1] / "plants" / "published_small.json").read_text(encoding="utf-8"))
OWN = [lesson for lesson in LESSONS.values() if lesson.adapt is not None]
RANK = 1e-10  # of ‖[A B]‖: a smaller singular value is zero


def hidden_poles(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """The eigenvalues s of A where [s I − A, B] loses rank, by the singular values of Popov's, Belevitch's and Hautus' matrix."""
    poles = np.linalg.eigvals(A)
    size = np.linalg.norm(np.hstack([A, B]), 2)
    return np.array([s for s in poles if np.linalg.svd(np.hstack([s * np.eye(len(A)) - A, B]), compute_uv=False)[-1] < RANK * size])


@pytest.mark.parametrize("plant", PLANTS, ids=[plant["name"] for plant in PLANTS])
def test_verdicts_are_those_of_pbh(plant: dict[str, object]) -> None:
    A, B, C = (np.array(plant[key], dtype=float) for key in "ABC")
    reached, seen = controllability(Plant(A, B, C)), observability(Plant(A, B, C))
    for found, hidden, out in ((hidden_poles(A, B), reached.uncontrollable, reached.stabilizable),
                               (hidden_poles(A.T, C.T), seen.unobservable, seen.detectable)):
        assert len(found) == len(hidden)
        assert out == bool(np.all(found.real < 0))
    assert plant["source"]


@pytest.mark.parametrize("lesson", OWN, ids=[lesson.id for lesson in OWN])
def test_every_lesson_takes_or_refuses_them(lesson: Lesson) -> None:
    """No traceback, no figure that is not finite; a lesson on linear plants refuses three of the ten at most."""
    said = {}
    for plant in PLANTS:
        keys = {key: plant[key] for key in ("A", "B", "C", "name")}
        if lesson.bilinear:
            n = len(keys["A"])
            each = {f"F{j + 1}": np.eye(n, k=j + 1).tolist() for j in range(len(plant["B"][0]))}
            keys |= each | {"K": np.ones((1, n)).tolist()}
        said[plant["name"]] = wrong_on(lesson, clean_plant_json(json.dumps(keys)))
    assert set(said.values()) <= {"", "refused"}, said
    assert list(said.values()).count("refused") <= 3, said
