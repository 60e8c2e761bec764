"""Write the MATLAB script of a lesson that describes its run by a code record."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...course.script_record import Code, GivenValue, ShownValue
from .code_record_script import check_of
from .matlab_literals import array, body_of, complex_row, formula, functions_for, number

__all__ = ["code_record_lines"]

CURVES_MARKER = "%% The curves\n"


def code_record_lines(code: Code) -> Iterator[str]:
    """The body of the function behind its head, its `end`, and the functions that it calls."""
    bodies = [body_of(name) for name in code.parts]
    equations, _, curves = "\n\n".join(body for body, _ in bodies).partition(CURVES_MARKER)
    yield "%% What is given"
    yield from map(_given, code.given)
    if code.drawn:
        yield "\n"
        yield "%% Noise as Python drew it; the generator of this language gives other numbers from the same seed"
        yield from map(_given, code.drawn)
    shown = list(_asserted(code))
    yield "\n" + equations.rstrip() + "\n"
    yield "%% What the page shows"
    yield from shown
    yield "\n" + CURVES_MARKER + curves + "\nend\n"
    local = "\n\n".join(text for _, text in bodies if text)
    yield "\n\n".join(text for text in (local, functions_for("\n".join([equations, local, *shown]))) if text)


def _given(given: GivenValue) -> str:
    value, note = given.value, f"  % {given.note}" if given.note else ""
    if isinstance(value, bool):
        return f"{given.name} = {str(value).lower()};{note}"
    if isinstance(value, (int, str)):
        return f"{given.name} = {value!r};{note}"
    if isinstance(value, float):
        return f"{given.name} = {number(value)};{note}"
    return array(given.name, value, given.note)


def _asserted(code: Code) -> Iterator[str]:
    if code.unsaid:
        yield f"% {code.unsaid}: the page shows them too, and they are not computed here."
    for shown in code.shown:
        yield _assertion(shown)
    yield f"disp('Observer Lab: {len(code.shown)} results of the page, its run among them, agree to 1e-06.');"


def _assertion(shown: ShownValue) -> str:
    name = formula(shown.name)
    if shown.poles:
        return f"same_poles('{name}', {name}, {complex_row(np.asarray(shown.value).ravel())});"
    check = check_of(shown)
    size = number(check.size)
    if check.values.ndim == 0:
        return f"agree('{name}', {name}, {number(float(check.values))}, {size});"
    if check.at is None:
        return f"{array('page', check.values)}\nagree('{name}', {name}, page, {size});"
    places = " ".join(str(k + 1) for k in check.at)
    return f"{array('page', check.values)}\nagree_at('{name}', {name}, {check.length}, [{places}], page, {number(check.largest)}, {size});"
