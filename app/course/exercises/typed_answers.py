"""Read a typed formula or number, check it at random points, and name common slips."""

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

from ...text import Text, text

MAX_TYPED_CHARACTERS = 200  # characters that are read
POINTS = 12  # at which an expression is compared
ROUNDED_TOO_MUCH = 0.05  # relative error of a number that was rounded too much
EXPRESSION_RTOL, NUMBER_RTOL = 1e-6, 0.005  # relative error allowed of an expression, and of a number: three digits
FUNCTIONS: Mapping[str, Callable[..., float]] = MappingProxyType(
    {"sqrt": math.sqrt, "exp": math.exp, "ln": math.log, "log": math.log, "sin": math.sin, "cos": math.cos, "abs": abs})
CONSTANTS = MappingProxyType({"pi": math.pi, "e": math.e})
OPERATORS: Mapping[Any, Callable[..., Any]] = MappingProxyType({
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv, ast.Pow: math.pow,
    ast.USub: operator.neg, ast.UAdd: operator.pos})
WRITTEN = (("−", "-"), ("–", "-"), ("·", "*"), ("×", "*"), ("÷", "/"), ("^", "**"), ("π", "pi"), ("。", "."), ("≈", "="))
FULL_WIDTH = MappingProxyType({code: code - 0xFEE0 for code in range(0xFF01, 0xFF5F)})  # ０–９，．（）＝＋ and their like
FROM_SUPERSCRIPT = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
RAISED_POWER = re.compile("[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+")
ROOT = re.compile(r"√\s*(\d+(?:[.,]\d+)?|[A-Za-z_])")
THOUSANDS = re.compile(r"(?<![\w.,])[1-9]\d{0,2}(?:,\d{3})+(?![\d,])")  # to one reader, three decimals to another
COMMA = re.compile(r"(?<=\d),(?=\d)|(?<![\w),]),(?=\d)")  # a decimal sign
PLAIN_CHARACTERS = re.compile(r"[A-Za-z0-9_ .+\-*/()=]*")
LEFT_OUT = re.compile(r"((?<![A-Za-z_\d.])(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|\))\s*(?![eE][+-]?\d)(?=[A-Za-z_(])")  # a times


class UnreadableInput(ValueError):
    """Something typed that is no expression in the letters asked for."""


class AmbiguousNumber(UnreadableInput):
    """A number that one reader takes for thousands and another for decimals."""


class NoFiniteValue(UnreadableInput):
    """An expression that is read, and has no finite value at this point."""


def evaluate_typed(said: str, letters: Mapping[str, float]) -> float:
    """The value of an expression at a point. Raises Unreadable; where it is not finite, NoValue."""
    words = plain(said).rpartition("=")[2].strip()
    if not words or len(words) > MAX_TYPED_CHARACTERS or not PLAIN_CHARACTERS.fullmatch(words):
        raise UnreadableInput(said)
    try:
        found = _value(ast.parse(words, mode="eval").body, letters)
    except UnreadableInput as problem:
        raise UnreadableInput(said) from problem
    except (ValueError, ArithmeticError) as problem:
        raise NoFiniteValue(said) from problem
    except (SyntaxError, TypeError, RecursionError, MemoryError) as problem:
        raise UnreadableInput(said) from problem
    if not math.isfinite(found):
        raise NoFiniteValue(said)
    return found


def plain(said: str) -> str:
    """What was typed, in plain signs: 5·10⁻², 0,05, √2 and 2(p+1) as Python would have them. Raises Ambiguous for 1,250."""
    words = said.strip().translate(FULL_WIDTH)
    if THOUSANDS.search(words):
        raise AmbiguousNumber(said)
    words = RAISED_POWER.sub(lambda found: "**(" + found[0].translate(FROM_SUPERSCRIPT) + ")", COMMA.sub(".", ROOT.sub(r"sqrt(\1)", words)))
    words = words.replace("√", "sqrt")
    for mark, sign in WRITTEN:
        words = words.replace(mark, sign)
    return LEFT_OUT.sub(r"\1*", words)


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
    raise UnreadableInput(ast.dump(node)[:40])


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
    tolerance: float = NUMBER_RTOL

    def right(self, outcome: Any) -> str:
        """The answer as it could be typed."""
        return self.answer if isinstance(self.answer, str) else repr(float(self.answer(outcome)))

    def judge(self, outcome: Any, said: str) -> tuple[bool, Text]:
        """Whether what was typed is right, and the sentence that says so or refutes it."""
        if not said.strip():
            return False, text("Type your result into the field under the task.")
        try:
            points = [(p, evaluate_typed(said, p), evaluate_typed(self.right(outcome), p)) for p in self._points()]
        except NoFiniteValue:
            return False, self._without_value(outcome, said)
        except UnreadableInput as problem:
            return False, explain_unreadable(said, problem, self.letters)
        away = next(((p, mine, true) for p, mine, true in points if not self._same(mine, true)), None)
        if away is None:
            return True, text("{said} is right.", said=said.strip()[:MAX_TYPED_CHARACTERS])
        for slip, why in self.slips:
            if all(self._same(mine, evaluate_typed(slip, p)) for p, mine, _ in points):
                return False, why
        if all(self._same(-mine, true) for _, mine, true in points):
            return False, text("The size is right, the sign is not.")
        p, mine, true = away
        if self.letters:
            return False, text("With {where} yours gives {mine:.4g} and the right one {true:.4g}.", where=_said(p), mine=mine, true=true)
        if abs(mine - true) <= ROUNDED_TOO_MUCH * abs(true):
            return False, text("{said} is near it, but not near enough: give three digits.", said=said.strip()[:MAX_TYPED_CHARACTERS])
        return False, text("{said} is not it; work it out again.", said=said.strip()[:MAX_TYPED_CHARACTERS])

    def _points(self) -> list[dict[str, float]]:
        """The random points, the same for everybody; one without letters."""
        low, high = self.span
        rng = np.random.default_rng(len(self.letters))
        rows = np.round(rng.uniform(low, high, size=(POINTS if self.letters else 1, len(self.letters))), 2)
        return [dict(zip(self.letters, map(float, row), strict=True)) for row in rows]

    def _same(self, mine: float, true: float) -> bool:
        relative = EXPRESSION_RTOL if self.letters else self.tolerance
        return abs(mine - true) <= relative * abs(true) + (1e-9 if self.letters else 1e-15)

    def _without_value(self, outcome: Any, said: str) -> Text:
        """What is said of an expression that can be read and is infinite or imaginary at one of the points."""
        if not self.letters:
            return explain_unreadable(said, NoFiniteValue(said))
        for p in self._points():
            try:
                evaluate_typed(said, p)
            except NoFiniteValue:
                return text("With {where} yours has no real value, and the right one is {true:.4g}.", where=_said(p),
                            true=evaluate_typed(self.right(outcome), p))
        raise AssertionError


def _said(point: Mapping[str, float]) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in point.items())


def explain_unreadable(said: str, why: UnreadableInput, letters: tuple[str, ...] = ()) -> Text:
    """What is wrong with something typed, and what to type instead."""
    shown = said.strip()[:40]
    if isinstance(why, AmbiguousNumber):
        return text("“{said}” can mean two numbers: write no sign between thousands, and a point before decimals.", said=shown)
    if letters:
        return text("“{said}” cannot be read; use {letters}, + − * / ^, brackets, sqrt, exp, ln, sin and cos, and a sign between any two "
                    "letters.", said=shown, letters=", ".join(letters))
    return text("“{said}” is no number; write one like 0.05, −1.2, 1/3 or √2, without a unit.", said=shown)
