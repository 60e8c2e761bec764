"""Define a derivation in steps, with the present numbers put in."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..figures.latex import MOST_ENTRIES, matrix, number

Value = float | np.ndarray  # a number, a matrix, or a row of numbers that may be complex
PLACE = re.compile(r"\[\[(\w+)\]\]")
SHOWN_DIGITS = 4
BEFORE = ("", "\n", "=", "(", "&", "{", "\\", ",", "|", "$", "<", ">", "[")  # after these a number that is negative needs no brackets


@dataclass(frozen=True)
class DerivationStep:
    """One step: its equation, how it follows, why it is taken, and the equation with places `[[name]]` for present numbers.

    Equations are LaTeX, a line each.
    """

    heading: str
    equation: str
    text: str
    why: str
    now: str

    @property
    def places(self) -> tuple[str, ...]:
        """The names of the numbers that are put in, in their order."""
        return tuple(PLACE.findall(self.now))


def derived_step(heading: str, body: str) -> DerivationStep:
    """Read a step: `$$equation$$`, text, `### why` with text, `### now` with `$$equation with places$$`."""
    body, _, now = body.partition("\n### now")
    body, _, why = body.partition("\n### why")
    equation, words = _equation(body)
    return DerivationStep(heading.strip(), equation, words, why.strip(), _equation(now)[0])


def _equation(body: str) -> tuple[str, str]:
    """The lines of an equation, each `$$…$$`, and the text that follows them."""
    found = re.match(r"(?:\s*\$\$.+?\$\$)*", body, flags=re.S)
    end = found.end() if found else 0
    return "\n".join(line.strip() for line in re.findall(r"\$\$(.+?)\$\$", body[:end], flags=re.S)), body[end:].strip()


def no_numbers(outcome: object) -> Mapping[str, Value]:
    """The numbers of a derivation that shows none."""
    return {}


def insert_numbers(step: DerivationStep, values: Mapping[str, Value]) -> str:
    """The step's equation with the numbers in their places; nothing where one is not known, not finite or too large to read."""
    known = [values.get(name) for name in step.places]
    if not known or not all(value is not None and _readable(value) for value in known):
        return ""
    return fill_placeholders(step.now, values)


def fill_placeholders(words: str, values: Mapping[str, Value | str], digits: int = SHOWN_DIGITS) -> str:
    """Words with the values in their places `[[name]]`, as they stand in LaTeX; one that is written already stays as it is.

    Raises KeyError for a place without a value.
    """
    return PLACE.sub(lambda place: _written(values[place[1]], words[:place.start()], words[place.end():], digits), words)


def _readable(value: Value) -> bool:
    return 0 < np.size(value) <= MOST_ENTRIES and bool(np.all(np.isfinite(value)))


def _written(value: Value | str, before: str, after: str, digits: int) -> str:
    if not isinstance(value, str) and np.ndim(value) == 2:
        return matrix(np.asarray(value), digits)
    if not isinstance(value, str) and np.ndim(value) == 1:
        return r",\;".join(_complex(complex(v)) for v in np.asarray(value))
    words = value if isinstance(value, str) else number(float(np.real(value)), digits)
    stuck = re.sub(r"(\\[,;:! ]|\\left|\\begin\{\w+\}|[ \t])+$", "", before)[-1:]
    raised = after.lstrip().startswith("^") and not re.fullmatch(r"[\d.]+", words)
    return f"({words})" if raised or (words.startswith("-") and stuck not in BEFORE) else words


def _complex(value: complex) -> str:
    if abs(value.imag) <= 1e-6 * max(1.0, abs(value)):
        return number(value.real)
    sign = "+" if value.imag > 0 else "-"
    return f"{number(value.real)} {sign} {number(abs(value.imag))}\\,j"
