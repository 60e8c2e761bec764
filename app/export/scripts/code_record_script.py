"""Write the Python script of a lesson that describes its run by a code record."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...course.lesson import Lesson
from ...course.script_record import Code, GivenValue, ShownValue
from .comment_translation import script_header
from .literals import array_text, complex_text, template_text

__all__ = ["check_of", "code_record_parts"]

LONG, INSTANTS = 40, 6  # rows from which on only some moments are asserted, and how many


def code_record_parts(lesson: Lesson, code: Code, token: str, language: str) -> Iterator[tuple[str, str]]:
    """Title and code of every part, in order: head, numbers, equations, assertions, curves."""
    imports, *equations = "\n\n".join(map(template_text, code.parts)).split("# %% ")
    words = lesson.words[language]
    yield f"{words.title}: {words.question}", "\n".join([
        script_header(token, "#", language), imports.strip(), "\n", template_text("proof")])
    yield "What is given", "\n".join(map(_given, code.given))
    for part in equations[:-1]:
        title, body = part.split("\n", 1)
        yield title, body.rstrip()
    yield "What the page shows", "\n".join(_asserted(code))
    title, body = equations[-1].split("\n", 1)
    yield title, body.rstrip()


def _given(given: GivenValue) -> str:
    value, note = given.value, f"  # {given.note}" if given.note else ""
    if isinstance(value, (bool, int, str)):
        return f"{given.name} = {value!r}{note}"
    if isinstance(value, float):
        return f"{given.name} = {_number(value)}{note}"
    return array_text(given.name, value, given.note)


def _number(value: float) -> str:
    return repr(float(value)) if np.isfinite(value) else f"np.{'nan' if np.isnan(value) else 'inf' if value > 0 else 'inf * -1'}"


@dataclass(frozen=True, eq=False)
class Check:
    """A number of the page as a script compares it: all of its rows, or those `at` some moments of a long one's `length`.

    `size` is what 1e-6 is counted in, `largest` the largest entry.
    """

    values: np.ndarray
    at: list[int] | None
    length: int
    largest: float
    size: float


def check_of(shown: ShownValue) -> Check:
    """What is compared of a number that is no set of poles."""
    values = np.asarray(shown.value, dtype=float)
    largest = float(np.abs(values).max(initial=0.0))
    size = largest if shown.size is None else shown.size
    if values.ndim == 0 or len(values) < LONG:
        return Check(values, None, values.size, largest, size)
    at = np.unique(np.linspace(0, len(values) - 1, INSTANTS).astype(int))
    return Check(values[at], at.tolist(), len(values), largest, size)


def _asserted(code: Code) -> Iterator[str]:
    if code.unsaid:
        yield f"# {code.unsaid}: the page shows them too, and they are not computed here."
    for shown in code.shown:
        yield _assertion(shown)
    yield f"print('Observer Lab: {len(code.shown)} results of the page, its run among them, agree to 1e-06.')"


def _assertion(shown: ShownValue) -> str:
    name = shown.name
    if shown.poles:
        return f"assert same_poles({name}, {complex_text(np.asarray(shown.value).ravel())}), {name!r}"
    check = check_of(shown)
    if check.values.ndim == 0:
        return f"assert agree({name}, {_number(float(check.values))}, {_number(check.size)}), {name!r}"
    if check.at is None:
        return f"{array_text('page', check.values)}\nassert agree({name}, page, {_number(check.size)}), {name!r}"
    return (f"assert len({name}) == {check.length}, {name!r}\n{array_text('page', check.values)}\n"
            f"assert agree({name}[{check.at}], page, {_number(check.size)}), {name!r}\n"
            f"assert agree(np.abs({name}).max(), {_number(check.largest)}, {_number(check.size)}), {f'the largest of {name}'!r}")
