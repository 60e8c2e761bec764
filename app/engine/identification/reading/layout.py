"""Find the parts of a text table: separator, head line, units, remarks, rows and their numbers."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from ...systems.errors import EngineError, Phrase, phrase
from ..records import MAX_ROWS
from .moments import is_moment, unit_of
from .numerals import MISSING, is_number
from .tables import Heading

__all__ = ["Layout", "cells_of", "heading_of", "laid_out"]

COMMENTS = ("#", "%", "//", "!")
MARKS = (";", "\t", ",", "|", " ")
SAMPLE, SHOWN = 200, 40  # lines that show the separator; those of them that vote
BRACKETS = re.compile(r"^\s*(?P<name>[^\[(]*?)\s*[\[(]\s*(?P<unit>[^\])]*?)\s*[\])]\s*$")
BEHIND = re.compile(r"^\s*(?P<name>.+?)(?:\s*/\s*|\s+in\s+)(?P<unit>[^\s/]+)\s*$")
WORDS = re.compile(r"[^\s\[(]\S*(?:\s*[\[(][^\])]*[\])])?")  # of a head whose columns are separated by blanks
UNIT_WORDS = frozenset((
    "v", "mv", "kv", "a", "ma", "ka", "w", "kw", "mw", "n", "kn", "nm", "n·m", "n*m", "m", "mm", "cm", "km", "um", "µm", "rad", "deg",
    "°", "°c", "degc", "deg c", "k", "°f", "degf", "c", "f", "pa", "kpa", "mpa", "bar", "mbar", "hz", "khz", "rpm", "g", "kg", "%", "pct",
    "1", "-", "--", "m/s", "m/s2", "m/s^2", "m/s²", "rad/s", "deg/s", "°/s", "l/min", "m3/h", "m³/h", "smp", "avg", "ohm", "lux", "ppm",
    "db", "count", "counts", "none", "ts", "rn", "yyyy-mm-dd", "hh:mm:ss"))


@dataclass(frozen=True, eq=False)
class Layout:
    """A text table: headings, the lines of its rows with their numbers in the file, the separator, and what to say about it."""

    headings: tuple[Heading, ...]
    rows: tuple[str, ...]
    lines: tuple[int, ...]
    mark: str
    notes: tuple[Phrase, ...]


def cells_of(line: str, mark: str) -> list[str]:
    """The cells of a line; a separator within quotes parts nothing."""
    if mark == " ":
        return line.split()
    if '"' in line:
        return [cell.strip() for cell in next(csv.reader([line.replace("\0", "")], delimiter=mark, skipinitialspace=True))]
    return [cell.strip() for cell in line.split(mark)]


def laid_out(text: str) -> Layout:
    """The parts of a text table. Raises EngineError where it has no rows or no columns."""
    numbered = [(k, line) for k, line in enumerate(re.split(r"\r\n|\n|\r", text), 1) if line.strip(" \t\f\x1a\0,;|")]
    mark = ""
    if numbered and (said := re.fullmatch(r"\s*\"?sep=(.)\"?\s*", numbered[0][1], re.IGNORECASE)):
        mark, numbered = said[1], numbered[1:]
    remarks = [(k, line) for k, line in numbered if line.lstrip().startswith(COMMENTS)]
    lines = [(k, line) for k, line in numbered if not line.lstrip().startswith(COMMENTS)]
    if len(lines) < 2:
        raise EngineError("The file holds no rows; it needs a head line such as t [s],u1 [V],y1 [m] and one row for each time.")
    if len(lines) - 1 > MAX_ROWS:
        raise EngineError("The file holds {count} rows; at most {most} can be read.", count=len(lines) - 1, most=MAX_ROWS)
    mark = mark or _separator([line for _, line in lines[:SAMPLE]])
    first, numeric = _first_row(lines, mark)
    headings, skipped = _head(lines[:first], [line for k, line in remarks if k < lines[first][0]], mark, len(numeric))
    notes = [] if not skipped else [phrase("Lines before the head line that were not used: {count}.", count=skipped)]
    rows = lines[first:]
    if len(rows) > 2 and len(cells_of(rows[-1][1], mark)) < len(numeric):
        notes.append(phrase("The last line, row {row}, is cut off and was left out.", row=rows[-1][0]))
        rows = rows[:-1]
    return Layout(headings, tuple(line for _, line in rows), tuple(k for k, _ in rows), mark, tuple(notes))


def _separator(lines: Sequence[str]) -> str:
    """What parts the cells: the mark with which most cells are values, in columns of one number."""
    shown = lines[-SHOWN:]
    best, found = 0.0, ","
    for mark in MARKS:
        split = [cells_of(line, mark) for line in shown]
        width, often = Counter(map(len, split)).most_common(1)[0]
        if width < 2 or often < 0.8 * len(split):
            continue
        rows = [cells for cells in split if len(cells) == width]
        score = sum(_is_value(cell) for cells in rows for cell in cells) / (width * len(rows)) * often / len(split)
        if score > best + 1e-9:
            best, found = score, mark
    return found


def _is_value(cell: str) -> bool:
    return cell.lower() in MISSING or is_number(cell) or is_moment(cell)


def _first_row(lines: Sequence[tuple[int, str]], mark: str) -> tuple[int, list[bool]]:
    """The place of the first row, and which columns hold values. Raises EngineError where no line is a row."""
    split = [cells_of(line, mark) for _, line in lines[:SAMPLE]]
    shown = split[-SHOWN:]
    width = Counter(map(len, shown)).most_common(1)[0][0]
    rows = [cells for cells in shown if len(cells) == width]
    numeric = [2 * sum(_is_value(cells[j]) for cells in rows) > len(rows) for j in range(width)]
    if any(numeric):
        for k, cells in enumerate(split):
            if len(cells) == width and any(_is_value(c) and c for c in cells) and all(
                    _is_value(cell) for cell, value in zip(cells, numeric, strict=True) if value) and not _names_units(cells):
                return k, numeric
    raise EngineError("The file holds no rows of numbers; it needs a head line such as t [s],u1 [V],y1 [m].")


def _head(before: Sequence[tuple[int, str]], remarks: Sequence[str], mark: str, width: int) -> tuple[tuple[Heading, ...], int]:
    """The headings and how many lines before them were not used; columns without a head are numbered from 1."""
    split = [_head_cells(line, mark, width) for _, line in before]
    block = next((len(split) - k for k in range(len(split)) if len(split[-1 - k]) != width), 0)
    at = next((k for k in range(block, len(split) - 1) if _names_units(split[k + 1])), None)
    if at is not None:
        units = [cell.strip("[]() ") for cell in split[at + 1]]
        return tuple(heading_of(cell, unit) for cell, unit in zip(split[at], units, strict=True)), at
    if block < len(split):
        return tuple(map(heading_of, split[-1])), len(split) - 1
    if split and mark == "," and 1 < len(split[-1]) < width <= 2 * len(split[-1]):
        raise EngineError("The comma stands both between the columns and in the numbers (row {row}); save the file with semicolons "
                          "between columns.", row=before[-1][0] + 1)
    if split and len(split[-1]) > 1:
        raise EngineError("In row {row} the number of values differs from that of the names in the first line: {count} instead of "
                          "{columns}.", row=before[-1][0] + 1, count=width, columns=len(split[-1]))
    for remark in reversed(remarks):
        cells = _head_cells(remark.lstrip("#%!/ \t"), mark, width)
        if len(cells) == width and not any(map(is_number, cells)):
            return tuple(map(heading_of, cells)), len(before)
    return tuple(Heading(str(k + 1), str(k + 1)) for k in range(width)), len(before)


def _head_cells(line: str, mark: str, width: int) -> list[str]:
    """The names of a head line; of one whose columns are separated by blanks, a unit in brackets belongs to the name before it."""
    cells = cells_of(line, mark)
    if mark == " " and len(cells) != width:
        wide = re.split(r"\s{2,}|\t", line.strip())
        return wide if len(wide) == width else WORDS.findall(line)
    if len(cells) > width and not any(cells[width:]):
        return cells[:width]
    return cells


def _names_units(cells: Sequence[str]) -> bool:
    """Whether a line gives units below the names."""
    given = [cell for cell in cells if cell]
    return bool(given) and not all(map(is_number, given)) and all(
        re.fullmatch(r"[\[(].*[\])]", cell) or cell.lower() in UNIT_WORDS or unit_of(cell) is not None for cell in given)


def heading_of(cell: str, unit: str = "") -> Heading:
    words = cell.strip().strip("'\"").strip()
    if unit:
        return Heading(words, words, unit, True)
    found = BRACKETS.match(words)
    if found is not None:
        return Heading(words, found["name"], found["unit"], True)
    found = BEHIND.match(words)
    return Heading(words, words) if found is None else Heading(words, found["name"].strip(), found["unit"])
