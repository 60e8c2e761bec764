"""A person's own record for the lesson about records: `--data FILE`, with its columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .options import CommandError

if TYPE_CHECKING:
    from ..course.lesson import Design, Lesson

RECORD = "record"  # the lesson that takes one
DATA_HELP = "your own record for lesson record: a CSV file with columns t, u…, y… (units as in `u1 [V]`)"
COLUMNS_HELP = "which columns are time, inputs and outputs, as in `t=time,u=gas rate,y=CO2`; may name several of each"
KINDS = "tuy"


def lesson_with(lesson: Lesson, file: str, columns: str | None) -> Lesson:
    """The lesson record with the record of that file. Raises CommandError, in one sentence."""
    from observer_lab.lessons.record.own import with_record

    from ..engine import EngineError
    from ..engine.identification import load_record

    if lesson.id != RECORD:
        raise CommandError(f"--data is for lesson {RECORD}; lesson {lesson.id} takes none.")
    time, inputs, outputs = columns_of(columns or "")
    try:
        return with_record(lesson, load_record(file, time=time, inputs=inputs, outputs=outputs))
    except EngineError as problem:
        raise CommandError(str(problem)) from problem


def columns_of(words: str) -> tuple[str, tuple[str, ...], tuple[str, ...]]:
    """Time, inputs and outputs as `--columns` names them. Raises CommandError."""
    found: dict[str, list[str]] = {kind: [] for kind in KINDS}
    for part in filter(None, (part.strip() for part in words.split(","))):
        kind, equals, name = part.partition("=")
        if not equals or kind.strip() not in found or not name.strip():
            raise CommandError(f"--columns takes t=NAME,u=NAME,y=NAME; {part[:40]} is none of these.")
        found[kind.strip()].append(name.strip())
    if len(found["t"]) > 1:
        raise CommandError("--columns names more than one time; give t=NAME once.")
    return "".join(found["t"]), tuple(found["u"]), tuple(found["y"])


def design_with(lesson: Lesson, changes: Sequence[str]) -> Design:
    """The lesson's start with knobs changed as KNOB=VALUE says. Raises CommandError."""
    from .inputs import changed

    return changed(lesson, lesson.start(), changes)
