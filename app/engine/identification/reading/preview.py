"""Show what a file would be as a record: columns, roles, and the record or what has to be said."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from ...systems.errors import EngineError
from ...systems.gates.argument_checks import BOOLEAN, NAME, POSITIVE, choice, instance, names, optional, takes
from ..records import Record
from ..regular import resample
from .columns import chosen
from .files import table_of_bytes
from .record_reader import Asked, record_in

__all__ = ["Column", "RecordPreview", "preview_record"]

TIME, INPUT, OUTPUT, UNUSED = "t", "u", "y", ""


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
