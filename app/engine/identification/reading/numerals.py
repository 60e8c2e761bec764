"""Read numbers as people and programs write them: one decimal sign for a whole file, or a question."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ...systems.errors import EngineError

__all__ = ["MISSING", "Numerals", "is_number", "numerals_of"]

MISSING = frozenset({"", "nan", "na", "n/a", "null", "none", "-", "--", "?", ".", "#n/a", "#na", "#value!", "#div/0!", "nat", "nan.0",
                     "-nan", "+nan", "1.#qnan", "-1.#ind", "-nan(ind)", "missing"})
INFINITE = frozenset({"inf", "+inf", "-inf", "infinity", "-infinity", "+infinity", "1.#inf", "-1.#inf", "∞", "-∞"})
PLAIN = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
LOOSE = re.compile(r"[+-]?[0-9.,'’\u00a0\u202f ]*[0-9][0-9.,'’]*(?:[eE][+-]?[0-9]+)?")
GROUPED = re.compile(r"[+-]?[0-9]{1,3}(?:['’\u00a0\u202f ][0-9]{3})+(?![0-9])")
BODY = re.compile(r"[+-]?([0-9.,]*)(?:[eE][+-]?[0-9]+)?")
SIGNS = str.maketrans({"−": "-", "–": "-", "＋": "+"})


@dataclass(frozen=True)
class Numerals:
    """The signs of a file: the decimal one, and the one between groups of three digits ("" where none was met)."""

    decimal: str = "."
    group: str = ""

    def value(self, cell: str) -> float | None:
        """The number of a cell, NaN where it is missing; None where it is no number."""
        word = cell.lower()
        if word in MISSING:
            return np.nan
        if word in INFINITE:
            return -np.inf if word.startswith("-") else np.inf
        cell = _ungrouped(cell.translate(SIGNS))
        if self.group and self.group in cell:
            whole = re.split(r"[eE]|" + re.escape(self.decimal), cell.lstrip("+-"))[0]
            if not re.fullmatch(r"[0-9]{1,3}(?:" + re.escape(self.group) + r"[0-9]{3})+", whole):
                return None
            cell = cell.replace(self.group, "")
        if self.decimal == ",":
            if "." in cell:
                return None
            cell = cell.replace(",", ".")
        return float(cell) if PLAIN.fullmatch(cell) else None


def is_number(cell: str) -> bool:
    """Whether a cell is a number in some way of writing; a missing one is none."""
    return cell.lower() in INFINITE or LOOSE.fullmatch(cell.translate(SIGNS)) is not None


def _ungrouped(cell: str) -> str:
    """A cell without apostrophes and blanks between groups of three digits."""
    found = GROUPED.match(cell)
    if found is None:
        return cell
    return re.sub(r"['’\u00a0\u202f ]", "", found[0]) + cell[found.end():]


@dataclass
class _Votes:
    """Where a sign was met first as the decimal one, between groups, and where it can be either: (row, column, cell)."""

    decimal: tuple[int, str, str] | None = None
    group: tuple[int, str, str] | None = None
    either: tuple[int, str, str] | None = None


def numerals_of(columns: Iterable[tuple[str, Sequence[str]]], lines: Sequence[int] | np.ndarray, decimal: str = "") -> Numerals:
    """The signs of these columns (name, cells). `decimal`: as the person says it. Raises EngineError where they do not agree.

    A sign that stands twice in a number, or before another one, parts groups of three digits. A sign before another count of digits
    than three, or behind 0, is decimal. What is left can be read in two ways.
    """
    votes = {".": _Votes(), ",": _Votes()}
    mixed: tuple[int, str, str] | None = None
    for name, cells in columns:
        whole, doubtful = False, None
        for line, cell in zip(lines, cells, strict=True):
            found = BODY.fullmatch(_ungrouped(cell.translate(SIGNS)))
            if found is None:
                continue
            place = (int(line), name, cell)
            if "." not in found[1] and "," not in found[1]:
                whole = whole or bool(found[1])
            elif _voted(found[1], place, votes) and "." in found[1]:
                doubtful = doubtful or place
        if whole and doubtful:
            mixed = mixed or doubtful
    point, comma = votes["."], votes[","]
    if decimal:
        return Numerals(decimal, "," if decimal == "." else ".")
    for_point, for_comma = point.decimal or comma.group, comma.decimal or point.group
    if for_point and for_comma:
        a, b = sorted((for_point, for_comma))
        raise EngineError("Row {row}, column {name} has {cell}, but row {other}, column {beside} has {second}; use one decimal sign in "
                          "the whole file.", row=a[0], name=a[1], cell=a[2][:20], other=b[0], beside=b[1], second=b[2][:20])
    if for_comma:
        return Numerals(",", "." if point.group or point.either else "")
    if for_point:
        return Numerals(".", "," if comma.group or comma.either else "")
    open_question = comma.either or mixed
    if open_question:
        row, name, cell = open_question
        sign = "," if "," in cell else "."
        raise EngineError("Row {row}, column {name}: {cell} can be {small} or {large}; give the decimal sign, or write numbers without "
                          "signs between thousands.", row=row, name=name, cell=cell[:20],
                          small=cell.replace(sign, ".")[:20], large=cell.replace(sign, "")[:20])
    return Numerals()


def _voted(body: str, place: tuple[int, str, str], votes: dict[str, _Votes]) -> bool:
    """Enter what the signs of a number say; True where they can be read in two ways."""
    last = max(body.rfind("."), body.rfind(","))
    sign, other = body[last], "," if body[last] == "." else "."
    if other in body:
        votes[sign].decimal = votes[sign].decimal or place
        votes[other].group = votes[other].group or place
    elif body.count(sign) > 1:
        votes[sign].group = votes[sign].group or place
    else:
        before, after = body.split(sign)
        if len(after) != 3 or before in ("", "0") or len(before) > 3 or before[0] == "0":
            votes[sign].decimal = votes[sign].decimal or place
        else:
            votes[sign].either = votes[sign].either or place
            return True
    return False
