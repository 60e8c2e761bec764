"""The numbers that stand now in the derivation of lesson 18: the fastest mode, the loss, and the edge between them."""

from __future__ import annotations

from collections.abc import Mapping

from app.lesson.derivation import Value
from app.lesson.lesson import Outcome

from .study import Study


def derived(outcome: Outcome[Study]) -> Mapping[str, Value]:
    """a = max|λ|, p, q = p a², the limit of the lower bound where it has one, and the critical share."""
    a, p = outcome.study.watched.sampled.radius, outcome.design["loss"]
    q = p * a * a
    known: dict[str, Value] = {"a": a, "a2": a * a, "p": p, "gap3": p**3 - p**4, "q": q, "edge": a**-2}
    return known | {"factor": 1 + q / (1 - q)} if q < 1 else known
