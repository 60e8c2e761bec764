"""What is free in linear algebra, and so each processor's own, decides nothing: a seed means the same noise on every machine."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from lesson_checks import numbers_of

from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS

TURNED = {"observability": {"stage x", "stage xhat"}}  # an ellipsoid's axes, of which each may point either way
OURS = ("app.", "lessons.")


def _signs(n: int) -> np.ndarray:
    return np.where(np.arange(n) % 2, 1.0, -1.0)


def other_vectors(decompose: Callable[..., Any]) -> Callable[..., Any]:
    """An eigendecomposition whose vectors point the other way, every second one."""
    def turned(*given: Any, **how: Any) -> Any:
        found = decompose(*given, **how)
        if how.get("eigvals_only") or not isinstance(found, tuple) or len(found) != 2:
            return found
        values, vectors = found
        vectors = vectors * _signs(vectors.shape[-1])
        return type(found)(values, vectors) if hasattr(found, "_fields") else (values, vectors)
    return turned


def other_pairs(decompose: Callable[..., Any]) -> Callable[..., Any]:
    """A singular value decomposition whose pairs of vectors point the other way, every second one."""
    def turned(*given: Any, **how: Any) -> Any:
        found = decompose(*given, **how)
        if not isinstance(found, tuple):
            return found
        left, sizes, right = (np.array(part) for part in found)
        count = sizes.shape[-1]
        left[..., :, :count] *= _signs(count)
        right[..., :count, :] *= _signs(count)[:, None]
        return type(found)(left, sizes, right) if hasattr(found, "_fields") else (left, sizes, right)
    return turned


def forget() -> None:
    """What was computed before is computed anew."""
    for name, module in list(sys.modules.items()):
        if name.startswith(OURS):
            for held in list(vars(module).values()):
                if hasattr(held, "cache_clear"):
                    held.cache_clear()


@pytest.fixture
def another_machine(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], None]]:
    """Changes the signs that decompositions choose, once called."""
    def change() -> None:
        for library in (np.linalg, scipy.linalg):
            for name, other in (("eig", other_vectors), ("eigh", other_vectors), ("svd", other_pairs)):
                known = getattr(library, name)
                changed = other(known)
                monkeypatch.setattr(library, name, changed)
                for module in [m for key, m in list(sys.modules.items()) if key.startswith(OURS)]:
                    for mine, held in list(vars(module).items()):
                        if held is known:
                            monkeypatch.setattr(module, mine, changed)
        forget()
    yield change
    monkeypatch.undo()
    forget()


def told(lesson: Lesson) -> dict[str, np.ndarray]:
    """What a lesson says in numbers, at its start."""
    return {name: numbers for name, numbers in numbers_of(lesson.compute(lesson.start())) if name not in TURNED.get(lesson.id, ())}


def test_no_number_depends_on_the_signs_of_eigenvectors(another_machine: Callable[[], None]) -> None:
    here = {lesson.id: told(lesson) for lesson in LESSONS.values()}
    another_machine()
    wrong = []
    for lesson in LESSONS.values():
        there = told(lesson)
        assert there.keys() == here[lesson.id].keys()
        for name, numbers in here[lesson.id].items():
            finite = np.isfinite(numbers)
            size = np.abs(numbers[finite]).max(initial=0.0)
            if not np.allclose(numbers, there[name], rtol=1e-6, atol=1e-6 * size, equal_nan=True):
                wrong.append(f"{lesson.id}: {name}")
    assert not wrong
