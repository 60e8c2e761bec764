"""Choose the columns of time, inputs and outputs: those that a person names, else t, u… and y…."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ...systems.errors import EngineError
from .moments import TIME_NAMES, time_heading
from .tables import Choice, Heading, Table

__all__ = ["chosen"]

INPUT, OUTPUT = re.compile(r"[uU](?:_?\d+|_.+)?"), re.compile(r"[yY](?:_?\d+|_.+)?")
FLAG = re.compile(r"(?i).*(?:valid|flag|ok|status|quality|state|error|count|mode)\d*$")
WITH_UNIT = re.compile(r"(?P<name>.*\S)\s*[\[(](?P<unit>[^\])]*)[\])]")
LISTED = 200  # letters of all names in a sentence


def chosen(table: Table, time: str, inputs: Sequence[str], outputs: Sequence[str], counted: bool) -> tuple[Choice, tuple[Heading, ...]]:
    """The choice and the headings, with units that a person gave; `counted` where rows are counted and no column is the time.

    Raises EngineError for a name that is not there, for a column that is chosen twice, and where nothing says which is which.
    """
    headings = list(table.headings)
    listed = ", ".join(heading.words for heading in headings if heading.words)[:LISTED]
    if not inputs and not outputs:
        double = _twice([heading.name for heading in headings if heading.name])
        if double is not None:
            raise EngineError("Two columns are called {name}; give each its own name in the first line.", name=double)
        if all(heading.words == str(k + 1) for k, heading in enumerate(headings)):
            raise EngineError("The file has no head line; say by number which columns are time, inputs and outputs, as in {example}.",
                              example="t=1 u=2 y=3")
    at = None
    if time and counted:
        raise EngineError("Give a column of time or a step, not both.")
    if time:
        at, headings = _place(time, headings, listed)
    elif not counted:
        at = _time_among(headings)
        if at is None:
            raise EngineError("No column is called t or time; the file has {columns}: say which one is the time.", columns=listed)
    if at is not None:
        headings[at] = time_heading(headings[at])
    places: dict[str, list[int]] = {"u": [], "y": []}
    for kind, wanted in (("u", inputs), ("y", outputs)):
        for name in wanted:
            found, headings = _place(name, headings, listed)
            places[kind].append(found)
    if not inputs and not outputs:
        for kind, form in (("u", INPUT), ("y", OUTPUT)):
            places[kind] = [k for k, heading in enumerate(headings)
                            if k != at and form.fullmatch(heading.name) and not FLAG.match(heading.name)]
    if not places["y"]:
        raise EngineError("No column is an output y; the file has {columns}: say which ones are outputs.", columns=listed)
    used = [*([] if at is None else [at]), *places["u"], *places["y"]]
    if len(set(used)) < len(used):
        raise EngineError("A column can be only one of time, input and output; choose each once.")
    return Choice(at, tuple(places["u"]), tuple(places["y"])), tuple(headings)


def _time_among(headings: Sequence[Heading]) -> int | None:
    """The column that is called t, time or the like, or by a unit of time; one of dates only where no other is there."""
    named = [k for k, heading in enumerate(headings) if time_heading(heading).name.strip().lower() in TIME_NAMES]
    named.sort(key=lambda k: headings[k].name.strip().lower() == "date")
    return next(iter(named), next((k for k, heading in enumerate(headings)
                                   if heading.words and not heading.unit and time_heading(heading).unit), None))


def _twice(names: Sequence[str]) -> str | None:
    return next((name for name in names if names.count(name) > 1 and _meant(name)), None)


def _meant(name: str) -> bool:
    return bool(INPUT.fullmatch(name) or OUTPUT.fullmatch(name) or name.lower() in TIME_NAMES)


def _place(name: str, headings: list[Heading], listed: str) -> tuple[int, list[Heading]]:
    """Where a column stands, and the headings with the unit that stands behind the name, if one does."""
    found = _named(name, headings)
    if found is None and (parts := WITH_UNIT.fullmatch(name)) and (found := _named(parts["name"], headings)) is not None:
        headings = list(headings)
        headings[found] = Heading(headings[found].words, headings[found].name, parts["unit"].strip(), True)
    if found is None:
        raise EngineError("There is no column {name}; the file has {columns}.", name=name, columns=listed)
    return found, headings


def _named(name: str, headings: Sequence[Heading]) -> int | None:
    """The place of the one column of that name. Raises EngineError where two have it."""
    forms = (lambda heading: heading.words, lambda heading: heading.name, lambda heading: time_heading(heading).name,
             lambda heading: heading.words.lower())
    for form in forms:
        found = [k for k, heading in enumerate(headings) if form(heading) == (name if form is not forms[3] else name.lower())]
        if len(found) > 1:
            raise EngineError("Two columns are called {name}; give each its own name in the first line.", name=name)
        if found:
            return found[0]
    return None
