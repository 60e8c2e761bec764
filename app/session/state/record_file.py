"""Hold the file of a record until it is used, what was told and read of it, and how far its fit is."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from ...course.knobs import KnobError
from ...text import text

if TYPE_CHECKING:  # the reader is imported late: it brings scipy.optimize
    from ...engine.identification import RecordPreview

MAX_RECORD_BYTES = 1_000_000
MAX_COLUMNS = 40  # of a file whose roles the page can change
ROLES = ("t", "u", "y", "")
TIME_UNITS = ("", "s", "ms", "us", "ns", "min", "h", "d")
DECIMALS = ("", ".", ",")
LONGEST_MARKS = 80
MOST_FIT_S = 180.0  # s by the clock that a fit may take
SAID_EVERY_S, KNOWN_AFTER_S, KNOWN_SHARE = 0.5, 1.0, 0.03  # s between two reports; s and share after which its end can be estimated
TOO_LONG = text("This fit takes more than {seconds:.0f} s and was ended; use fewer rows or columns.", seconds=MOST_FIT_S)


@dataclass(frozen=True)
class Told:
    """The words of a person about a file: the role of each column (None as found), and how its cells are read."""

    roles: tuple[str, ...] | None = None
    unit: str = ""
    decimal: str = ""
    step: float = 0.0
    missing: str = ""
    hold: bool = False


@dataclass(frozen=True, eq=False)
class RecordFile:
    """A file that was brought, what was told about it, what was read so, and the fit of it."""

    name: str
    data: bytes = field(repr=False)
    told: Told
    preview: RecordPreview
    fitting: RecordFitting | None = field(default=None, repr=False)  # while it goes on


def open_record(name: object, data: object) -> RecordFile:
    """The record file that a browser sent. Raises KnobError, and EngineError where it holds no table."""
    from ...engine.identification import preview_record

    if not isinstance(data, bytes) or not isinstance(name, str):
        raise KnobError(text("The browser did not send a file; nothing was changed."))
    if len(data) > MAX_RECORD_BYTES:
        raise KnobError(text("The file is larger than 1 MB; keep fewer rows or columns, or start the lab with --data."))
    preview = preview_record(name, data)
    if len(preview.columns) > MAX_COLUMNS:
        raise KnobError(text("The file has {count} columns; keep at most {most} of them.", count=len(preview.columns), most=MAX_COLUMNS))
    return RecordFile(name, data, Told(), preview)


def told_again(file: RecordFile, changes: Mapping[str, object]) -> RecordFile:
    """The file read anew with other words about it. Raises KnobError for words that make no sense, and EngineError."""
    from ...engine.identification import preview_record

    told = replace(file.told, **{name: _checked(name, value, len(file.preview.columns)) for name, value in changes.items()})
    columns, roles = file.preview.columns, told.roles
    time, inputs, outputs = "", tuple[str, ...](), tuple[str, ...]()
    if roles is None and told.unit:
        roles = tuple(column.role for column in columns)
    if roles is not None:
        named = {role: tuple(column.words for column, its in zip(columns, roles, strict=True) if its == role) for role in ROLES}
        time, inputs, outputs = "" if told.step or not named["t"] else named["t"][0], named["u"], named["y"]
        time = f"{time}[{told.unit}]" if time and told.unit else time
    preview = preview_record(file.name, file.data, time=time, inputs=inputs, outputs=outputs, step=told.step or None,
                             missing=tuple(told.missing.replace(";", " ").split()), decimal=told.decimal, hold=told.hold)
    if roles is not None and len(preview.columns) == len(roles):
        preview = replace(preview, columns=tuple(replace(column, role=role) for column, role in zip(preview.columns, roles, strict=True)))
    return replace(file, told=replace(told, roles=roles), preview=preview)


def with_role(file: RecordFile, place: object, role: object) -> RecordFile:
    """The file with another role for one column; only one column can be the time. Raises KnobError and EngineError."""
    roles = [column.role for column in file.preview.columns]
    if not isinstance(place, int) or not 0 <= place < len(roles) or role not in ROLES:
        raise KnobError(text("A column can be t, u, y or unused."))
    if role == "t":
        roles = ["" if its == "t" else its for its in roles]
    roles[place] = str(role)
    return told_again(file, {"roles": tuple(roles)})


def _checked(name: str, value: object, columns: int) -> object:
    allowed: Mapping[str, bool] = {
        "roles": isinstance(value, tuple) and len(value) == columns, "unit": value in TIME_UNITS, "decimal": value in DECIMALS,
        "step": isinstance(value, float | int) and math.isfinite(value) and 0 <= value <= 1e6,
        "missing": isinstance(value, str) and len(value) <= LONGEST_MARKS, "hold": isinstance(value, bool)}
    if not allowed.get(name, False):
        raise KnobError(text("The browser sent a value that a record's file cannot have; nothing was changed."))
    return value


class FitStopped(Exception):
    """Raised in a fit that nobody waits for any more."""


class RecordFitting:
    """One fit on a thread of its own. `told` is called with it now and then, and returns whether the tab is still open."""

    def __init__(self, told: Callable[[RecordFitting], bool], clock: Callable[[], float] = time.monotonic) -> None:
        self._told, self._clock = told, clock
        self._began = self._said = clock()
        self._stopped = False
        self.share = 0.0  # that is done

    @property
    def seconds_left(self) -> float | None:
        """How long it will go on at this pace, None while that is not known."""
        lasted = self._clock() - self._began
        if lasted < KNOWN_AFTER_S or self.share < KNOWN_SHARE:
            return None
        return lasted * (1 - self.share) / self.share

    def stop(self) -> None:
        """End it at its next word; safe from any thread."""
        self._stopped = True

    def hear(self, share: float) -> None:
        """Note the share that is done. Raises FitStopped in a fit that was ended, and KnobError in one that takes too long."""
        now = self._clock()
        if self._stopped:
            raise FitStopped
        if now - self._began > MOST_FIT_S:
            raise KnobError(TOO_LONG)
        self.share = max(self.share, min(share, 1.0))
        if now - self._said >= SAID_EVERY_S:
            self._said = now
            self._stopped = not self._told(self)
