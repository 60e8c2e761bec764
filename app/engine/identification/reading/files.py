"""Read a record from a file by what the file is, or show what it would be as a record."""

from __future__ import annotations

import codecs
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ...systems.errors import EngineError, Phrase, phrase
from ...systems.gates.argument_checks import BOOLEAN, NAME, POSITIVE, choice, instance, names, optional, takes
from ..records import Record
from ..regular import resample
from .columns import chosen
from .mat_tables import mat_table
from .record_reader import Asked, record_in
from .tables import Table
from .text_tables import TextTable

__all__ = ["Column", "RecordPreview", "decoded", "load_record", "preview_record", "read_record", "record_of_bytes", "table_of_bytes"]

MAX_BYTES = 200_000_000
SAMPLE = 4000  # bytes that show whether every second one is zero
MOST_CONTROLS = 0.01  # share of control characters above which a file is no text
ALLOWED = frozenset("\t\n\r\f\x1a")
TIME, INPUT, OUTPUT, UNUSED = "t", "u", "y", ""


@takes(path=instance(str, os.PathLike), time=NAME, inputs=names, outputs=names, step=optional(POSITIVE), missing=names,
       decimal=choice("", ".", ","), hold=BOOLEAN)
def load_record(path: str | os.PathLike[str], *, time: str = "", inputs: Sequence[str] = (), outputs: Sequence[str] = (),
                step: float | None = None, missing: Sequence[str] = (), decimal: str = "", hold: bool = False) -> Record:
    """The record in a file: text with separators, .mat, and with the extra `records` Parquet, MDF and MCAP; see `read_record`.

    Raises EngineError where it cannot be read or where its meaning is open.
    """
    name = Path(path).name
    try:
        if Path(path).exists() and not Path(path).is_file():
            raise OSError
        with open(path, "rb") as file:
            data = file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as problem:
        raise EngineError("The file {name} cannot be read; check its name and place.", name=name) from problem
    asked = Asked(time, tuple(inputs), tuple(outputs), step, tuple(missing), hold)
    return record_of_bytes(name, data, asked, decimal)


def record_of_bytes(name: str, data: bytes, asked: Asked, decimal: str = "") -> Record:
    """The record in the bytes of a file of that name. Raises EngineError."""
    table, notes = table_of_bytes(name, data, asked, decimal)
    return record_in(table, asked).noted(*notes)


def table_of_bytes(name: str, data: bytes, asked: Asked, decimal: str = "") -> tuple[Table, tuple[Phrase, ...]]:
    """The columns in the bytes of a file, and what was done to its letters. Raises EngineError where it holds no table."""
    if len(data) > MAX_BYTES:
        raise EngineError("The file {name} is larger than {size} MB; keep fewer rows or fewer digits.", name=name, size=MAX_BYTES // 10**6)
    if data.startswith(b"PAR1"):
        from .parquet_tables import parquet_table
        return parquet_table(data), ()
    if data.startswith((b"MDF ", b"UnFinMF")):
        from .mdf_tables import mdf_table
        return mdf_table(data, asked), ()
    if data.startswith(b"\x89MCAP0\r\n"):
        from .mcap_tables import mcap_table
        return mcap_table(data, asked), ()
    if data.startswith((b"#ROSBAG", b"SQLite format 3\0")):
        raise EngineError("{name} is a ROS bag in an old form; turn it into MCAP first, as with ros2 bag convert.", name=name)
    if data.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        raise EngineError("{name} is a spreadsheet or an archive; save the sheet as CSV in UTF-8.", name=name)
    if Path(name).suffix.lower() == ".mat" or data[126:128] in (b"IM", b"MI"):
        return mat_table(data, asked), ()
    text, notes = decoded(name, data)
    return _table_of_text(text, decimal), notes


@takes(text=NAME, time=NAME, inputs=names, outputs=names, step=optional(POSITIVE), missing=names,
       decimal=choice("", ".", ","), hold=BOOLEAN)
def read_record(text: str, *, time: str = "", inputs: Sequence[str] = (), outputs: Sequence[str] = (), step: float | None = None,
                missing: Sequence[str] = (), decimal: str = "", hold: bool = False) -> Record:
    """The record in a text of rows, with names and units in a head line as in `u1 [V]`; `notes` of the record say what was done.

    Without choice, t (or time) is the time, u… are the inputs, y… the outputs; `time`, `inputs`, `outputs` choose columns by name or,
    without head line, by number, with a unit as in `time[ms]`. Times: numbers with a unit in the head, Unix times, dates. `step` in s:
    rows are counted instead. `missing`: numbers that mark a missing value, "stuck" for a stuck sensor, "none". `decimal`: the decimal
    sign, where it cannot be found. `hold`: an empty input keeps its last value. Raises EngineError where the meaning is open.

    >>> read_record("t [s],u [V],y [m]\\n" + "".join(f"{k},1,{k * k}\\n" for k in range(9))).dt
    1.0
    """
    return _of_text(text, Asked(time, tuple(inputs), tuple(outputs), step, tuple(missing), hold), decimal)


def _of_text(text: str, asked: Asked, decimal: str) -> Record:
    return record_in(_table_of_text(text, decimal), asked)


def _table_of_text(text: str, decimal: str) -> TextTable:
    if text.lstrip("\ufeff \t\r\n").startswith(("{", "[{", "[[")):
        raise EngineError("This is JSON, as of a plant, and no record: a record is a table of rows over time. Open a plant with --plant.")
    return TextTable(text.lstrip("\ufeff"), decimal)


def decoded(name: str, data: bytes) -> tuple[str, tuple[Phrase, ...]]:
    """The text of a file and what is to be said about it. Raises EngineError where it is no text."""
    kind, note = _encoding(data)
    try:
        text = data.decode(kind)
    except UnicodeDecodeError as problem:
        raise _no_text(name) from problem
    sample = text[:SAMPLE]
    if sum(c < " " and c not in ALLOWED for c in sample) > MOST_CONTROLS * len(sample):
        raise _no_text(name)
    return text.lstrip("\ufeff"), note


def _encoding(data: bytes) -> tuple[str, tuple[Phrase, ...]]:
    if data.startswith(codecs.BOM_UTF8):
        return "utf-8-sig", ()
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16", ()
    start = data[:SAMPLE]
    if start and start[1::2].count(0) > 0.4 * len(start[1::2]) > 0 and not start[::2].count(0):
        return "utf-16-le", ()
    if start and start[::2].count(0) > 0.4 * len(start[::2]) and not start[1::2].count(0):
        return "utf-16-be", ()
    try:
        data.decode("utf-8")
        return "utf-8", ()
    except UnicodeDecodeError:
        return "cp1252", (phrase("The file is not UTF-8; letters such as µ and ° were read as Windows-1252."),)


def _no_text(name: str) -> EngineError:
    return EngineError("The file {name} is not UTF-8 text; save it as CSV in UTF-8.", name=name)


@dataclass(frozen=True)
class Column:
    """A column of a file: its words in the head line, its unit ("" where none is said), and its role t, u, y or ""."""

    words: str
    unit: str
    role: str


@dataclass(frozen=True, eq=False)
class RecordPreview:
    """The columns of a file, and the record at a regular step; where it is None, `problem` says what is wrong or has to be said."""

    columns: tuple[Column, ...]
    record: Record | None = field(default=None, repr=False)
    problem: EngineError | None = None


@takes(name=NAME, data=instance(bytes), time=NAME, inputs=names, outputs=names, step=optional(POSITIVE), missing=names,
       decimal=choice("", ".", ","), hold=BOOLEAN)
def preview_record(name: str, data: bytes, *, time: str = "", inputs: Sequence[str] = (), outputs: Sequence[str] = (),
                   step: float | None = None, missing: Sequence[str] = (), decimal: str = "", hold: bool = False) -> RecordPreview:
    """What the bytes of a file of that name would be as a record; the rest as in `read_record`.

    Raises EngineError where it holds no table at all.

    >>> [column.role for column in preview_record("log.csv", b"t,u,y\\n" + b"".join(b"%d,1,2\\n" % k for k in range(9))).columns]
    ['t', 'u', 'y']
    """
    asked = Asked(time, tuple(inputs), tuple(outputs), step, tuple(missing), hold)
    table, notes = table_of_bytes(name, data, asked, decimal)
    try:
        picked, headings = chosen(table, asked.time, asked.inputs, asked.outputs, asked.step is not None)
    except EngineError as problem:
        given = {asked.time: TIME} | dict.fromkeys(asked.inputs, INPUT) | dict.fromkeys(asked.outputs, OUTPUT)
        return RecordPreview(tuple(Column(heading.words, heading.unit, given.get(heading.words, UNUSED) if heading.words else UNUSED)
                                   for heading in table.headings), problem=problem)
    roles = {k: INPUT for k in picked.inputs} | {k: OUTPUT for k in picked.outputs}
    if picked.time is not None:
        roles[picked.time] = TIME
    columns = tuple(Column(heading.words, headings[k].unit, roles.get(k, UNUSED)) for k, heading in enumerate(table.headings))
    try:
        return RecordPreview(columns, resample(record_in(table, asked).noted(*notes)))
    except EngineError as problem:
        return RecordPreview(columns, problem=problem)
