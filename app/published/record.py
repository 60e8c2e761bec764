"""Define a published value, how ours is computed, and whether both must agree."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

__all__ = ["Published", "Result", "half_a_digit", "numbers", "verify_one"]

Kind = Literal["agrees", "slip", "beyond"]
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
ONLY_NUMBERS = re.compile(r"[\d\s.,;e+-]*")


@dataclass(frozen=True)
class Published:
    """One published value.

    `kind` is the verdict that is expected: "agrees" (ours is what was printed), "slip" (the source is wrong there, and
    `right` is what it should say), "beyond" (not printed there, `right` is the value known from elsewhere).
    `printed` and `right` are numbers with the digits they are known to, separated by spaces, commas or semicolons; a
    `printed` that holds words is a statement, and `right` says in numbers what it means. Every number must be met to
    half a unit of its last digit, whole numbers to 1e-9; `tolerance` (absolute) or `relative` replace that.
    `ours` computes the value with the engine, as a number or an array read row by row.
    """

    source: str
    item: str
    printed: str
    ours: Callable[[], Any]
    kind: Kind = "agrees"
    right: str = ""
    tolerance: float | None = None
    relative: float | None = None
    note: str = ""


@dataclass(frozen=True)
class Result:
    """A published value with ours. `verdict` is what was found: the expected kind, or "differs"."""

    published: Published
    ours: tuple[float, ...]
    verdict: str
    holds: bool

    def record(self) -> dict[str, Any]:
        """As plain data, for JSON."""
        p = self.published
        return {"source": p.source, "item": p.item, "printed": p.printed, "right": p.right,
                "ours": [v if np.isfinite(v) else None for v in self.ours],
                "verdict": self.verdict, "expected": p.kind, "note": p.note}


def numbers(text: str) -> tuple[str, ...]:
    """The numbers of a text as they are written, none if it holds words."""
    text = text.replace("−", "-")
    return tuple(NUMBER.findall(text)) if ONLY_NUMBERS.fullmatch(text) else ()


def half_a_digit(number: str) -> float:
    """Half a unit of the last printed digit; 1e-9 for a whole number, which is exact."""
    mantissa, _, exponent = number.partition("e")
    digits = len(mantissa.partition(".")[2])
    return 0.5 * 10.0 ** (int(exponent or 0) - digits) * (1 + 1e-9) if digits else 1e-9


def verify_one(published: Published) -> Result:
    """Compute ours and judge."""
    ours = tuple(float(v) for v in np.asarray(published.ours(), dtype=float).ravel())
    if published.kind == "agrees":
        holds = _meets(published, published.printed if numbers(published.printed) else published.right, ours)
    elif published.kind == "slip":
        repeated = bool(numbers(published.printed)) and _meets(published, published.printed, ours)
        holds = not repeated and _meets(published, published.right, ours)
    else:
        holds = _meets(published, published.right, ours)
    return Result(published, ours, published.kind if holds else "differs", holds)


def _meets(published: Published, expected: str, ours: Sequence[float]) -> bool:
    wanted = numbers(expected)
    if not wanted or len(wanted) != len(ours):
        return False
    return all(abs(value - float(number)) <= _tolerance(published, number)
               for value, number in zip(ours, wanted, strict=True))


def _tolerance(published: Published, number: str) -> float:
    if published.tolerance is not None:
        return published.tolerance
    return abs(float(number)) * published.relative if published.relative is not None else half_a_digit(number)
