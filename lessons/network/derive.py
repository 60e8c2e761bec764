"""Compute the numbers in the derivation of lesson 18: fastest mode and critical loss."""

from __future__ import annotations

from collections.abc import Mapping

from observer_lab.course.exercises.derivation import Value
from observer_lab.course.lesson import Outcome

from .study import Study


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """a = max|λ|, p, q = p a², the limit of the lower bound where it has one, and the critical share."""
    a, p = outcome.study.watched.sampled.radius, outcome.design["loss"]
    q = p * a * a
    known: dict[str, Value] = {"a": a, "a2": a * a, "p": p, "gap3": p**3 - p**4, "q": q, "edge": a**-2}
    return known | {"factor": 1 + q / (1 - q)} if q < 1 else known
