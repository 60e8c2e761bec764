"""A person's own record for the lesson about records: `--data FILE`, with its columns."""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .options import CommandError
from .terminal import Progress

if TYPE_CHECKING:
    from ..course.lesson import Design, Lesson, Outcome

RECORD = "record"  # the lesson that takes one
DATA_HELP = "your own record for lesson record: CSV or .mat; with the extra `records` also Parquet, MDF or MCAP"
COLUMNS_HELP = "which columns are time, inputs and outputs, as in `t=time[ms] u=heater y=T1,T2`; by number where the file has no head line"
KINDS = "tuy"
SAID_AFTER_S = 1.0  # s from which on a fit says how far it is
STOPPED = "observer-lab: the fit was stopped before its end; nothing was written."
KEY = re.compile(r"(?:^|[\s,;]+)(\w+)\s*=")


@dataclass(frozen=True)
class ReadingOptions:
    """What is said about a record's file beside its columns: step in s, marks of missing values, decimal sign, inputs that hold."""

    step: float | None = None
    missing: tuple[str, ...] = ()
    decimal: str = ""
    hold: bool = False


def add_record_options(parser: argparse.ArgumentParser) -> None:
    """The options about one's own record."""
    parser.add_argument("--data", metavar="FILE", help=DATA_HELP)
    parser.add_argument("--columns", metavar="LIST", help=COLUMNS_HELP)
    parser.add_argument("--step", type=float, metavar="SECONDS", help="of --data: rows come at this step and no column is the time")
    parser.add_argument("--missing", action="append", default=[], metavar="MARK",
                        help="of --data: a number that marks a missing value; `stuck` for a stuck sensor; `none`")
    parser.add_argument("--decimal", choices=(".", ","), default="", help="of --data: the decimal sign, where it can be either")
    parser.add_argument("--hold", action="store_true", help="of --data: an input keeps its last value where its cell is empty")


def reading_options(options: argparse.Namespace) -> ReadingOptions:
    """What the command line says about a record's file."""
    return ReadingOptions(options.step, tuple(options.missing), options.decimal, options.hold)


def lesson_with(lesson: Lesson, file: str, columns: str | None, how: ReadingOptions, plant: str | None = None) -> Lesson:
    """The lesson record with the record of that file, and the plant of another one. Raises CommandError, in one sentence."""
    from observer_lab.lessons.record.own import with_record

    from ..engine import EngineError, load_plant
    from ..engine.identification import load_record
    from ..plants.examples import EXAMPLES, example
    from ..plants.own_plant import plant_of

    if lesson.id != RECORD:
        raise CommandError(f"--data is for lesson {RECORD}; lesson {lesson.id} takes none.")
    time, inputs, outputs = columns_of(columns or "")
    try:
        record = load_record(file, time=time, inputs=inputs, outputs=outputs, step=how.step, missing=how.missing, decimal=how.decimal,
                             hold=how.hold)
        own = None if plant is None else plant_of(example(plant)) if plant in EXAMPLES else load_plant(plant)
        with fit_told() as tell:
            return with_record(lesson, record, own, progress=tell)
    except EngineError as problem:
        raise CommandError(str(problem)) from problem


@contextmanager
def fit_told(clock: Callable[[], float] = time.monotonic) -> Iterator[Callable[[float], None]]:
    """Say on stderr how far a long fit is and how long it goes on; Ctrl-C leaves one sentence."""
    began, progress = clock(), Progress(100, 0, clock, "parts of the fit")

    def tell(share: float) -> None:
        if clock() - began > SAID_AFTER_S:
            progress.tell(min(int(100 * share), 99))
    try:
        yield tell
    except KeyboardInterrupt:
        progress.end()
        print(STOPPED, file=sys.stderr)
        raise
    progress.end()


def from_record(origin: Lesson, options: argparse.Namespace) -> tuple[Lesson, Design]:
    """The lesson with the record that the options name, and its design. Raises CommandError, in one sentence."""
    if options.state is not None:
        raise CommandError("Give --data without --state: a saved design holds no record.")
    lesson = lesson_with(origin, options.data, options.columns, reading_options(options), options.plant)
    return lesson, design_with(lesson, options.changes)


def columns_of(words: str) -> tuple[str, tuple[str, ...], tuple[str, ...]]:
    """Time, inputs and outputs as `--columns` names them, several of a kind parted by commas. Raises CommandError."""
    found: dict[str, list[str]] = {kind: [] for kind in KINDS}
    places = list(KEY.finditer(words))
    if words.strip() and (not places or places[0].start() or any(place[1] not in found for place in places)):
        raise CommandError(f"--columns takes t=NAME u=NAME,NAME y=NAME; {words[:40]} is none of these.")
    for place, end in zip(places, [*(place.start() for place in places), len(words)][1:], strict=True):
        names = [name.strip() for name in words[place.end():end].split(",")]
        if not all(names):
            raise CommandError(f"--columns takes t=NAME u=NAME,NAME y=NAME; {words[:40]} is none of these.")
        found[place[1]] += names
    if len(found["t"]) > 1:
        raise CommandError("--columns names more than one time; give t=NAME once.")
    return "".join(found["t"]), tuple(found["u"]), tuple(found["y"])


def design_with(lesson: Lesson, changes: Sequence[str]) -> Design:
    """The lesson's start with knobs changed as KNOB=VALUE says. Raises CommandError."""
    from .inputs import changed

    return changed(lesson, lesson.start(), changes)


def print_record(outcome: Outcome) -> None:
    """Say what was read of a record's file."""
    record = outcome.study.found.record
    print("record", record.size, *record.notes, sep="\n  ", flush=True)
