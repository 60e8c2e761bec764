"""Read times: dates, clocks, epochs, numbers with a unit; ask where a number can mean several."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import date
from types import MappingProxyType

import numpy as np

from ...systems.errors import EngineError, Phrase, phrase
from .tables import Heading

__all__ = ["TIME_NAMES", "UNITS", "dated", "is_moment", "scaled", "time_heading", "unit_of"]

UNITS = MappingProxyType({
    "s": 1.0, "sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3, "msecs": 1e-3, "millis": 1e-3,
    "millisecond": 1e-3, "milliseconds": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "usec": 1e-6, "usecs": 1e-6, "micros": 1e-6,
    "microsecond": 1e-6, "microseconds": 1e-6, "ns": 1e-9, "nsec": 1e-9, "nsecs": 1e-9, "nanos": 1e-9, "nanosecond": 1e-9,
    "nanoseconds": 1e-9, "min": 60.0, "mins": 60.0, "minute": 60.0, "minutes": 60.0, "h": 3600.0, "hr": 3600.0, "hrs": 3600.0,
    "hour": 3600.0, "hours": 3600.0, "d": 86400.0, "day": 86400.0, "days": 86400.0, "excel": 86400.0, "datenum": 86400.0})
TIME_NAMES = frozenset({"t", "time", "timestamp", "datetime", "date", "date time", "date/time", "time stamp", "date_time", "index time"})
EPOCHS = MappingProxyType({"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9})
YEAR_2000, YEAR_2100 = 946_684_800.0, 4_102_444_800.0  # s since 1970
EXCEL, DATENUM = (36526.0, 73051.0), (730486.0, 767011.0)  # days of the years 2000 to 2100
DAY = 86400.0
LONGEST_STEP = 60.0  # s between rows with which a number of that size is taken as Unix time
COARSE = 100.0  # a step between whole numbers from which they are asked about
ROUND = 1e-3
ZONE = r"\s*(?P<zone>Z|UTC|GMT|[+-]\d\d(?::?\d\d)?)?"
CLOCK = r"(?P<hour>\d{1,2}):(?P<minute>\d\d)(?::(?P<second>\d\d)(?:[.,](?P<part>\d{1,9})\d*)?)?\s*(?P<half>[AaPp]\.?[Mm]\.?)?"
YEAR_FIRST = re.compile(r"(?P<a>\d{4})[-/.](?P<b>\d{1,2})[-/.](?P<c>\d{1,2})(?:[T ,]+" + CLOCK + ")?" + ZONE)
YEAR_LAST = re.compile(r"(?P<b>\d{1,2})(?P<mark>[-/.])(?P<c>\d{1,2})(?P=mark)(?P<a>\d{4})(?:[T ,]+" + CLOCK + ")?" + ZONE)
CLOCK_ALONE = re.compile(CLOCK + ZONE)


def unit_of(word: str) -> float | None:
    """Seconds in a unit of time, None for another word."""
    word = word.strip().strip(".")
    return UNITS.get(word, UNITS.get(word.lower()))


def time_heading(heading: Heading) -> Heading:
    """The heading of a column of time with its unit found: in brackets, behind a slash, "in" or an underscore, or as the name itself."""
    if heading.unit:
        return heading
    words = heading.words.strip().lstrip("%").strip()
    for found in re.findall(r"[\[(]\s*([^\])]+?)\s*[\])]", words):
        if unit_of(found) is not None:
            return Heading(heading.words, re.split(r"[\[(]", words)[0].strip() or words, found, True)
    if unit_of(words) is not None and words.lower() not in ("d", "h", "s"):
        return Heading(heading.words, words, words)
    found = re.fullmatch(r"(?P<name>.+?)(?:\s*[/_.,:-]\s*|\s+in\s+|\s+)(?P<unit>[A-Za-zµμ]+)", words)
    if found is not None and unit_of(found["unit"]) is not None:
        return Heading(heading.words, found["name"].strip(), found["unit"])
    found = re.fullmatch(r"(?i)(?P<name>t|time|timestamp|elapsed|clock)(?P<unit>us|usec|ms|msec|ns|nsec|sec)", words)
    if found is not None:
        return Heading(heading.words, found["name"], found["unit"])
    return Heading(heading.words, words if heading.words.lstrip().startswith("%") else heading.name, "")


def is_moment(cell: str) -> bool:
    """Whether a cell is a date or a time of the day."""
    return any(form.fullmatch(cell) is not None for form in (YEAR_FIRST, YEAR_LAST, CLOCK_ALONE))


def dated(cells: Sequence[str], lines: np.ndarray) -> np.ndarray:
    """Dates and times of the day in s after the first. Raises EngineError for a cell that is none, and where day and month are open."""
    form = next((form for form in (YEAR_FIRST, YEAR_LAST, CLOCK_ALONE) if form.fullmatch(cells[0])), YEAR_FIRST)
    found = []
    for cell, line in zip(cells, lines, strict=True):
        match = form.fullmatch(cell)
        if match is None:
            raise EngineError("Row {row}: {cell} is not a date and time such as 2026-11-25 13:05:00.", row=int(line), cell=cell[:30])
        found.append(match)
    zoned = [match["zone"] is not None for match in found]
    if any(zoned) and not all(zoned):
        row = int(lines[zoned.index(not zoned[0])])
        raise EngineError("Row {row}: some times name their offset from UTC and others do not; write all in one way.", row=row)
    swap = form is YEAR_LAST and _day_first(found, cells)
    out, days, first = np.empty(len(found)), {}, None
    for k, match in enumerate(found):
        try:
            day = 0
            if form is not CLOCK_ALONE:
                key = match["a"], match["b"], match["c"]
                if key not in days:
                    days[key] = date(int(key[0]), *((int(key[2]), int(key[1])) if swap else (int(key[1]), int(key[2])))).toordinal()
                day = days[key]
            whole = 86400 * day + _seconds(match)
        except ValueError as problem:
            raise EngineError("Row {row}: {cell} is not a date and time such as 2026-11-25 13:05:00.", row=int(lines[k]),
                              cell=cells[k][:30]) from problem
        first = whole if first is None else first
        part = match["part"] or ""
        out[k] = whole - first + (int(part) / 10 ** len(part) if part else 0.0)
    return out


def _seconds(match: re.Match[str]) -> int:
    """Whole seconds of the day in UTC. Raises ValueError for a clock that no day has."""
    if match["hour"] is None:
        return 0
    hour, minute, second = int(match["hour"]), int(match["minute"]), int(match["second"] or 0)
    if match["half"]:
        if not 1 <= hour <= 12:
            raise ValueError
        hour = hour % 12 + (12 if match["half"].lower().startswith("p") else 0)
    if hour > 24 or minute > 59 or second > 60:
        raise ValueError
    zone, away = match["zone"] or "", 0
    if zone[:1] in "+-" and zone:
        digits = zone[1:].replace(":", "").ljust(4, "0")
        away = (1 if zone[0] == "+" else -1) * (3600 * int(digits[:2]) + 60 * int(digits[2:]))
    return 3600 * hour + 60 * minute + second - away


def _day_first(found: Sequence[re.Match[str]], cells: Sequence[str]) -> bool:
    """Whether the day stands before the month: always with points, and where a number is above 12. Raises EngineError."""
    if found[0]["mark"] == ".":
        return True
    first, second = max(int(m["b"]) for m in found), max(int(m["c"]) for m in found)
    if first <= 12 and second <= 12:
        raise EngineError("The order of day and month in {cell} is open; write dates as 2026-11-25.", cell=cells[0][:30])
    return first > 12


def scaled(t: np.ndarray, heading: Heading, whole: bool) -> tuple[np.ndarray, tuple[Phrase, ...]]:
    """Times in s from numbers, with a note where no unit was said; `whole` if all are whole numbers. Raises EngineError."""
    size, step = float(np.nanmax(np.abs(t), initial=0.0)), _step(t)
    if heading.unit:
        factor = unit_of(heading.unit)
        if factor is None:
            raise EngineError("The unit {unit} of {name} is not one of s, ms, us, ns, min, h and d.", unit=heading.unit, name=heading.name)
        if size * factor > 10 * YEAR_2100:
            raise EngineError("Column {name} says {unit}, but {value} {unit} is longer than a thousand years; say its unit.",
                              name=heading.name, unit=heading.unit, value=f"{size:.6g}")
        return factor * t, ()
    low = float(np.nanmin(t)) if len(t) else 0.0
    for unit, factor in EPOCHS.items():
        if low * factor >= YEAR_2000 and size * factor <= YEAR_2100:
            if step * factor <= LONGEST_STEP:
                return factor * t, (phrase("The numbers of {name} were read as Unix time in {unit}.", name=heading.name, unit=unit),)
            raise _asked(heading, low)
    for (first, last), name in ((EXCEL, "Excel"), (DATENUM, "MATLAB")):
        if low >= first and size <= last:
            if "date" in heading.words.lower() or "excel" in heading.words.lower() or _like_days(step):
                return DAY * t, (phrase("The numbers of {name} were read as days of {program}.", name=heading.name, program=name),)
            raise _asked(heading, low)
    if size > YEAR_2000 or (whole and step >= COARSE):
        raise _asked(heading, float(t[0]))
    return t, (phrase("Column {name} names no unit; its numbers were read as seconds.", name=heading.name),)


def _step(t: np.ndarray) -> float:
    return float(np.median(np.diff(t))) if len(t) > 1 else 0.0


def _like_days(step: float) -> bool:
    """Whether a step is round in seconds when it counts days, and not round as it stands."""
    seconds = step * DAY
    scale = 10.0 ** np.floor(np.log10(max(seconds, 1e-9)))
    nice = min(abs(seconds / scale / k - 1) for k in (1, 1.2, 1.5, 1.8, 2, 2.5, 3, 3.6, 4, 5, 6, 7.2, 8, 9, 10))
    own = 10.0 ** np.floor(np.log10(max(step, 1e-12)))
    plain = abs(step / own * 100 - round(step / own * 100)) / 100
    return nice < ROUND and plain > ROUND


def _asked(heading: Heading, value: float) -> EngineError:
    return EngineError("Column {name} names no unit, and {value} can be seconds, milliseconds, microseconds, days or a date; say it, as "
                       "in {example}.", name=heading.name, value=f"{value:.10g}", example=f"t={heading.name}[ms]")
