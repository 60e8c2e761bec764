"""The script of a lesson that says itself what it starts from, by which equations it goes, and what it finds again."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..lesson.code import Code, Given, Shown
from ..lesson.lesson import Lesson
from .literals import array_text, complex_text, part_text
from .spoken import made_by

__all__ = ["told_parts"]

LONG, INSTANTS = 40, 6  # rows from which on only some moments are asserted, and how many


def told_parts(lesson: Lesson, code: Code, token: str, language: str) -> Iterator[tuple[str, str]]:
    """Title and code of every part, in order: head, numbers, equations, assertions, curves."""
    imports, *equations = "\n\n".join(map(part_text, code.parts)).split("# %% ")
    words = lesson.words[language]
    yield f"{words.title}: {words.question}", "\n".join([
        made_by(token, "#", language), imports.strip(), "\n", part_text("proof")])
    yield "What is given", "\n".join(map(_given, code.given))
    for part in equations[:-1]:
        title, body = part.split("\n", 1)
        yield title, body.rstrip()
    yield "What the page shows", "\n".join(_asserted(code))
    title, body = equations[-1].split("\n", 1)
    yield title, body.rstrip()


def _given(given: Given) -> str:
    value, note = given.value, f"  # {given.note}" if given.note else ""
    if isinstance(value, (bool, int, str)):
        return f"{given.name} = {value!r}{note}"
    if isinstance(value, float):
        return f"{given.name} = {_number(value)}{note}"
    return array_text(given.name, value, given.note)


def _number(value: float) -> str:
    return repr(float(value)) if np.isfinite(value) else f"np.{'nan' if np.isnan(value) else 'inf' if value > 0 else 'inf * -1'}"


def _asserted(code: Code) -> Iterator[str]:
    if code.unsaid:
        yield f"# {code.unsaid}: the page shows them too, and they are not computed here."
    for shown in code.shown:
        yield _assertion(shown)
    yield f"print('Observer Lab: {len(code.shown)} results of the page, its run among them, agree to 1e-06.')"


def _assertion(shown: Shown) -> str:
    name, value = shown.name, shown.value
    if shown.poles:
        return f"assert same_poles({name}, {complex_text(np.asarray(value).ravel())}), {name!r}"
    array = np.asarray(value, dtype=float)
    if array.ndim == 0:
        size = "" if shown.size is None else f", {shown.size!r}"
        return f"assert agree({name}, {_number(float(array))}{size}), {name!r}"
    largest = float(np.abs(array).max(initial=0.0))
    size = largest if shown.size is None else shown.size
    if len(array) < LONG:
        return f"{array_text('page', array)}\nassert agree({name}, page, {size!r}), {name!r}"
    at = np.unique(np.linspace(0, len(array) - 1, INSTANTS).astype(int))
    return (f"assert len({name}) == {len(array)}, {name!r}\n{array_text('page', array[at])}\n"
            f"assert agree({name}[{at.tolist()}], page, {size!r}), {name!r}\n"
            f"assert agree(np.abs({name}).max(), {largest!r}, {size!r}), {f'the largest of {name}'!r}")
