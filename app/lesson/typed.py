"""Results found with a pencil and typed in: read, checked at random points, and refuted by numbers or by name."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from ..text import Text, text

LONGEST = 200  # characters that are read
POINTS = 12  # at which an expression is compared
EXACT, DIGITS = 1e-6, 0.005  # relative error allowed of an expression, and of a number: three digits
FUNCTIONS: Mapping[str, Callable[..., float]] = MappingProxyType(
    {"sqrt": math.sqrt, "exp": math.exp, "ln": math.log, "log": math.log, "sin": math.sin, "cos": math.cos, "abs": abs})
CONSTANTS = MappingProxyType({"pi": math.pi, "e": math.e})
OPERATORS: Mapping[Any, Callable[..., Any]] = MappingProxyType({
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv, ast.Pow: math.pow,
    ast.USub: operator.neg, ast.UAdd: operator.pos})
WRITTEN = (("−", "-"), ("–", "-"), ("·", "*"), ("×", "*"), ("÷", "/"), ("^", "**"), ("²", "**2"), ("³", "**3"),
           ("√", "sqrt"), ("π", "pi"), ("（", "("), ("）", ")"), ("，", "."), ("。", "."))
PLAIN = re.compile(r"[A-Za-z0-9_ .+\-*/()=]*")
LEFT_OUT = re.compile(r"((?<![A-Za-z_\d.])(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|\))\s*(?![eE][+-]?\d)(?=[A-Za-z_(])")  # a times


class Unreadable(ValueError):
    """Something typed that is no expression in the letters asked for."""


def value_of(said: str, letters: Mapping[str, float]) -> float:
    """The value of an expression at a point. Raises Unreadable, also where it is not finite."""
    words = said.strip()
    for mark, plain in WRITTEN:
        words = words.replace(mark, plain)
    words = LEFT_OUT.sub(r"\1*", words.rpartition("=")[2])
    try:
        if not words.strip() or len(words) > LONGEST or not PLAIN.fullmatch(words):
            raise Unreadable(said)
        found = _value(ast.parse(words.strip(), mode="eval").body, letters)
    except (SyntaxError, ValueError, ArithmeticError, TypeError, RecursionError, MemoryError) as problem:
        raise Unreadable(said) from problem
    if not isinstance(found, float) or not math.isfinite(found):
        raise Unreadable(said)
    return found


def _value(node: ast.AST, letters: Mapping[str, float]) -> float:
    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return float(number)
        case ast.Name(id=name) if name in letters:
            return float(letters[name])
        case ast.Name(id=name) if name in CONSTANTS:
            return CONSTANTS[name]
        case ast.UnaryOp(op=op, operand=operand) if type(op) in OPERATORS:
            return OPERATORS[type(op)](_value(operand, letters))
        case ast.BinOp(left=left, op=op, right=right) if type(op) in OPERATORS:
            return OPERATORS[type(op)](_value(left, letters), _value(right, letters))
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
            return float(FUNCTIONS[name](_value(argument, letters)))
    raise Unreadable(ast.dump(node)[:40])


@dataclass(frozen=True)
class Typed:
    """What is to be typed under a task: an expression in `letters`, or a number where there are none.

    `answer` is the expression, or the number for the outcome at hand. `slips` are usual mistakes, each with the sentence
    that refutes it. An expression is compared at random points within `span`, a number to the relative `tolerance`.
    """

    answer: str | Callable[[Any], float]
    letters: tuple[str, ...] = ()
    slips: tuple[tuple[str, Text], ...] = ()
    span: tuple[float, float] = (0.3, 3.0)
    tolerance: float = DIGITS

    def right(self, outcome: Any) -> str:
        """The answer as it could be typed."""
        return self.answer if isinstance(self.answer, str) else repr(float(self.answer(outcome)))

    def judge(self, outcome: Any, said: str) -> tuple[bool, Text]:
        """Whether what was typed is right, and the sentence that says so or refutes it."""
        if not said.strip():
            return False, text("Type your result into the field under the task.")
        try:
            points = [(p, value_of(said, p), value_of(self.right(outcome), p)) for p in self._points()]
        except Unreadable:
            return False, self._unreadable(said)
        away = next(((p, mine, true) for p, mine, true in points if not self._same(mine, true)), None)
        if away is None:
            return True, text("{said} is right.", said=said.strip()[:LONGEST])
        for slip, why in self.slips:
            if all(self._same(mine, value_of(slip, p)) for p, mine, _ in points):
                return False, why
        p, mine, true = away
        if not self.letters:
            return False, text("{said} is not it; work it out again.", said=said.strip()[:LONGEST])
        where = ", ".join(f"{name} = {value:g}" for name, value in p.items())
        return False, text("With {where} yours gives {mine:.4g} and the right one {true:.4g}.", where=where, mine=mine, true=true)

    def _points(self) -> list[dict[str, float]]:
        """The random points, the same for everybody; one without letters."""
        low, high = self.span
        rng = np.random.default_rng(len(self.letters))
        rows = np.round(rng.uniform(low, high, size=(POINTS if self.letters else 1, len(self.letters))), 2)
        return [dict(zip(self.letters, map(float, row), strict=True)) for row in rows]

    def _same(self, mine: float, true: float) -> bool:
        relative = EXACT if self.letters else self.tolerance
        return abs(mine - true) <= relative * abs(true) + (1e-9 if self.letters else 1e-12)

    def _unreadable(self, said: str) -> Text:
        shown = said.strip()[:40]
        if not self.letters:
            return text("“{said}” cannot be read as a number; 1.25, 5/4 and sqrt(2) can.", said=shown)
        return text("“{said}” cannot be read; use {letters}, + − * / ^, brackets, sqrt, exp and ln.", said=shown,
                    letters=", ".join(self.letters))
