"""The arithmetic of a line with numbers put in, read from its LaTeX: what stands on both sides of each =, from the values alone."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

TOKEN = re.compile(r"\[\[(?P<place>\w+)\]\]|(?P<number>\d+(?:\.\d+)?)|(?P<word>\\[A-Za-z]+)|(?P<mark>[-+()^{}/])")
FUNCTIONS = {"\\sqrt": np.sqrt, "\\lg": np.log10, "\\ln": np.log, "\\exp": np.exp}
SKIPPED = re.compile(r"\\[,;:! ]|\\left|\\right|\\bigl|\\bigr|\\Bigl|\\Bigr|\\mathrm\{(?:rad|dB|Hz)\}|\^\\circ|\s")


class Unread(ValueError):
    """A side that holds letters: a name, nothing to compute."""


class Reader:
    """Sums of products of places, numbers, brackets, fractions, roots, logarithms, traces, determinants, powers and transposes."""

    def __init__(self, latex: str, values: Mapping[str, Any]) -> None:
        self._values, self._tokens, at = values, [], 0
        plain = SKIPPED.sub("", latex)
        if plain == "\\pi":  # alone it is a name
            raise Unread(latex)
        while at < len(plain):
            found = TOKEN.match(plain, at)
            if found is None:
                raise Unread(latex)
            self._tokens.append((found.lastgroup, found["place"] or found[0]))
            at = found.end()
        self._at = 0

    def value(self) -> Any:
        """The value of all of it."""
        result = self._sum()
        if self._at != len(self._tokens):
            raise Unread(str(self._tokens[self._at:]))
        return result

    def _peek(self) -> tuple[str | None, str]:
        return self._tokens[self._at] if self._at < len(self._tokens) else ("end", "")

    def _take(self, *marks: str) -> bool:
        if self._peek()[0] != "place" and self._peek()[1] in marks:
            self._at += 1
            return True
        return False

    def _sum(self) -> Any:
        negative = self._take("-")
        total = self._product()
        total = -total if negative else total
        while True:
            if self._take("+"):
                total = total + self._product()
            elif self._take("-"):
                total = total - self._product()
            else:
                return total

    def _product(self) -> Any:
        result = self._power()
        while self._peek()[1] not in ("", "+", "-", ")", "}"):
            over = self._take("/")
            self._take("\\cdot")
            other = self._power()
            result = result / other if over else result @ other if np.ndim(result) == np.ndim(other) == 2 else result * other
            result = result[0, 0] if np.shape(result) == (1, 1) else result
        return result

    def _power(self) -> Any:
        base = self._atom()
        while self._take("^"):
            braced = self._take("{")
            if self._take("\\mathsf"):
                braced_inner = self._take("{")
                self._letter()
                base = np.transpose(base)
                if braced_inner and not self._take("}"):
                    raise Unread("mathsf")
            else:
                power = self._sum() if braced else self._atom()
                base = np.linalg.matrix_power(base, int(power)) if np.ndim(base) == 2 else base ** power
            if braced and not self._take("}"):
                raise Unread("brace")
        return base

    def _letter(self) -> None:
        if not self._take("\\top"):
            raise Unread("transpose")

    def _atom(self) -> Any:
        kind, word = self._peek()
        self._at += 1
        if kind == "place":
            return self._values[word]
        if kind == "number":
            return float(word)
        if word in ("(", "{"):
            inner = self._sum()
            if not self._take(")", "}"):
                raise Unread("bracket")
            return inner
        if word == "\\frac":
            return self._atom() / self._atom()
        if word in FUNCTIONS:
            return FUNCTIONS[word](self._atom())
        if word == "\\pi":
            return np.pi
        if word == "\\det":
            return np.linalg.det(self._atom())
        raise Unread(word)


def sides(line: str, values: Mapping[str, Any]) -> Iterator[tuple[str, list[Any]]]:
    """Each equation of a line, and the values of those of its sides that can be computed."""
    for equation in re.split(r"\n|,?\s*\\q?quad|,\\;|\\leq", re.sub(r"\\mathsf(\{T\}| T)", r"\\mathsf{\\top}", line)):
        found = []
        for side in equation.strip().strip(",").split("="):
            try:
                found.append(Reader(side, values).value())
            except Unread:
                continue
        if len(found) > 1:
            yield equation, found
