"""Make a record from a table: times, inputs, outputs, and a sentence for all that was done."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...systems.errors import EngineError, Phrase, phrase
from ..records import REGULAR, Record
from .columns import chosen
from .doubtful_values import refuse_marks, stuck_runs
from .moments import dated, is_moment, scaled
from .numerals import MISSING
from .tables import Choice, Heading, Table

__all__ = ["Asked", "record_in", "unrounded"]

STUCK, NONE = "stuck", "none"
MANY_NAMES = 120
DECIMALS = 6  # of the finest times that are looked at
COARSEST = 0.5  # of a step: what the last decimal may be worth, so that a missing row never looks like rounding
SLACK = 1e-6


@dataclass(frozen=True)
class Asked:
    """What a person says about a file: columns, step in s, values that mark a missing one, and whether inputs hold their last value."""

    time: str = ""
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    step: float | None = None
    missing: tuple[str, ...] = ()
    hold: bool = False

    @property
    def marks(self) -> tuple[float, ...]:
        """The numbers among `missing`. Raises EngineError for a word that is neither a number nor one of two words."""
        try:
            return tuple(float(word.replace("−", "-")) for word in self.missing if word not in (STUCK, NONE))
        except ValueError as problem:
            raise EngineError("A missing value is marked by a number, or by the words stuck or none; {given} is neither.",
                              given=", ".join(self.missing)[:40]) from problem


def record_in(table: Table, asked: Asked) -> Record:
    """The record of a table. Raises EngineError, in one sentence, where its meaning is open."""
    choice, headings = chosen(table, asked.time, asked.inputs, asked.outputs, asked.step is not None)
    lines = table.lines
    notes: list[Phrase] = []
    signals = (*choice.inputs, *choice.outputs)
    t, values, said = _times_and_values(table, choice, headings, asked, signals)
    notes += said
    t, said = unrounded(t)
    notes += said
    late = np.flatnonzero(~(np.diff(t) > 0))
    if late.size:
        raise EngineError("The times must grow from row to row; row {row} is not later than the row before.", row=int(lines[late[0] + 1]))
    for k, column in enumerate(values.T):
        notes += _cleaned(column, headings[signals[k]].name, lines, asked, k >= len(choice.inputs))
    count = len(choice.inputs)
    u, y = values[:, :count], values[:, count:]
    _fill_inputs(u, [headings[k].name for k in choice.inputs], lines, asked.hold, notes)
    for name, column in zip((headings[k].name for k in choice.outputs), y.T, strict=True):
        gone = int(np.isnan(column).sum())
        if gone:
            notes.append(phrase("{name}: values that are missing: {count}.", name=name, count=gone))
    unused = [heading.words for k, heading in enumerate(headings) if k not in (choice.time, *signals) and heading.words]
    if unused:
        notes.append(phrase("Columns that were not used: {names}.", names=", ".join(unused)[:MANY_NAMES]))
    names = tuple(headings[k].name or headings[k].words for k in signals)
    units = tuple((name, headings[k].unit) for name, k in zip(names, signals, strict=True) if headings[k].unit)
    return Record(t - t[0], u, y, names[:count], names[count:], units, (*table.notes, *notes))


def _times_and_values(table: Table, choice: Choice, headings: Sequence[Heading], asked: Asked,
                      signals: Sequence[int]) -> tuple[np.ndarray, np.ndarray, list[Phrase]]:
    """Times in s and the columns of the signals, and what to say about the times."""
    lines = table.lines
    if choice.time is None:
        step = float(asked.step or 0.0)
        return step * np.arange(len(lines)), np.array(table.numbers(signals)), [
            phrase("The rows were counted: one for each {step:.6g} s.", step=step)]
    words = table.words(choice.time)
    first = "" if words is None else words[0]
    if words is not None and is_moment(first):
        day = next((k for k, heading in enumerate(headings) if heading.name.lower() == "date" and k != choice.time), None)
        days = None if day is None else table.words(day)
        if days is not None and ":" in first and not any(mark in first for mark in "-/ T"):
            words = [f"{a} {b}" for a, b in zip(days, words, strict=True)]
        for line, cell in zip(lines, words, strict=True):
            if cell.lower() in MISSING:
                raise EngineError("Row {row} has no time; every row needs one.", row=int(line))
        return dated(words, lines), np.array(table.numbers(signals)), []
    both = np.array(table.numbers([choice.time, *signals]))
    t = both[:, 0]
    if not np.isfinite(t).all():
        raise EngineError("Row {row} has no time; every row needs one.", row=int(lines[np.flatnonzero(~np.isfinite(t))[0]]))
    if words is not None and np.abs(t).max() >= 1e15 and all(word.lstrip("+").isdigit() for word in words):
        start = int(words[0])
        exact, notes = scaled(t, headings[choice.time], True)
        factor = float(exact[0] / t[0])
        return factor * np.array([int(word) - start for word in words], dtype=float), both[:, 1:], list(notes)
    t, notes = scaled(t, headings[choice.time], bool((t == np.round(t)).all()))
    return t, both[:, 1:], list(notes)


def _cleaned(column: np.ndarray, name: str, lines: np.ndarray, asked: Asked, output: bool) -> list[Phrase]:
    """Set infinite, marked and stuck values of a column to NaN, in place, and say so. Raises EngineError for a mark nobody spoke of."""
    notes = []
    endless = np.flatnonzero(np.isinf(column))
    if endless.size:
        notes.append(phrase("{name}: values that are infinite and count as missing: {count}, the first in row {row}.", name=name,
                            count=int(endless.size), row=int(lines[endless[0]])))
        column[endless] = np.nan
    for mark in asked.marks:
        at = np.isclose(column, mark, rtol=1e-9, atol=0.0)
        if at.any():
            notes.append(phrase("{name}: the mark {mark} of a missing value stands in {count} rows.", name=name,
                                mark=f"{mark:g}".replace("-", "−"), count=int(at.sum())))
            column[at] = np.nan
    if NONE not in asked.missing:
        refuse_marks(name, column, lines, asked.marks)
    if output:
        runs, said = stuck_runs(name, column, lines)
        if STUCK in asked.missing:
            for a, b in runs:
                column[a + 1:b] = np.nan
                notes.append(phrase("{name}: rows {first} to {last} were stuck and count as missing.", name=name, first=int(lines[a + 1]),
                                    last=int(lines[b - 1])))
        else:
            notes += said
    return notes


def _fill_inputs(u: np.ndarray, names: Sequence[str], lines: np.ndarray, hold: bool, notes: list[Phrase]) -> None:
    """Hold the last value of an input where it is missing, if a person says that it holds. Raises EngineError where nobody does."""
    for name, column in zip(names, u.T, strict=True):
        gone = np.isnan(column)
        if not gone.any():
            continue
        row = int(lines[np.flatnonzero(gone)[0]])
        if not hold or gone[0]:
            raise EngineError("Input {name} is missing in row {row}; every input must be known. If it keeps its last value there, say so "
                              "with hold.", name=name, row=row)
        last = np.maximum.accumulate(np.where(gone, 0, np.arange(len(column))))
        column[:] = column[last]
        notes.append(phrase("{name} was held at its last value in {count} rows.", name=name, count=int(gone.sum())))


def unrounded(t: np.ndarray) -> tuple[np.ndarray, tuple[Phrase, ...]]:
    """Times at a regular step, with a note, where those given in s differ from them by the rounding of their last decimal alone."""
    count = len(t) - 1
    step = float(t[-1] - t[0]) / count if count > 1 else 0.0
    if not step > 0 or np.abs(np.diff(t) - step).max() <= REGULAR * step:
        return t, ()
    last = next((10.0**-k for k in range(DECIMALS + 1) if np.abs(np.round(t * 10**k) - t * 10**k).max() <= 1e-4), 0.0)
    if not 0 < last <= COARSEST * step:
        return t, ()
    rows = np.arange(count + 1)
    rate = round(1 / step)
    for regular in ((1 / rate, step) if rate else (step,)):
        if np.ptp(t - regular * rows) <= last * (1 + SLACK):
            return t[0] + regular * rows, (phrase(
                "The times are rounded to {last:g} s; the rows were read at a regular step of {step:.4g} s.", last=last, step=regular),)
    return t, ()
