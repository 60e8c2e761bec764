"""Run a design's observer beside a plant whose lines come in: `live`."""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
import time
from contextlib import AbstractContextManager, ExitStack
from dataclasses import replace
from typing import IO, TYPE_CHECKING

from ...text import languages
from ..ending import ended_as_by_ctrl_c
from ..options import PLANT_HELP, STATE_HELP, CommandError, seconds, whole_number

if TYPE_CHECKING:
    from ...course.lesson import Design, Lesson, Outcome
    from ...live.lines import LineReader
    from ...live.observer import LiveObserver, Step
    from ...live.sources import Port

HELP = "a design's observer beside a real or simulated plant, line by line"
SHOW_S, WAIT_S = 1.0, 0.2  # between two printed lines, and for bytes at a time
OFF_PERIOD = 0.1  # of the period: lines that come so much more or less often are named
KNOCK_S = 5.0  # between two knocks on the simulated plant of a page
SIMULATED_SAMPLES = 100_000_000


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `live`."""
    parser.add_argument("lesson", metavar="LESSON")
    way = parser.add_mutually_exclusive_group(required=True)
    way.add_argument("--stdin", action="store_true", help="lines from standard input")
    way.add_argument("--udp", type=whole_number(1, 65535, "is no port; give one from 1 to 65535"), metavar="PORT",
                     help="datagrams to this port of this machine")
    way.add_argument("--serial", metavar="PORT", help="a serial port, as /dev/ttyACM0 or COM3")
    way.add_argument("--simulate", action="store_true", help="plant and controller in C, as a process of their own")
    parser.add_argument("--baud", type=whole_number(300, 4_000_000, "is no rate; give one as 115200"), default=115200, metavar="RATE")
    parser.add_argument("--set", action="append", default=[], metavar="KNOB=VALUE", dest="changes", help="set a knob; may be repeated")
    parser.add_argument("--state", metavar="TOKEN|FILE", help=STATE_HELP)
    parser.add_argument("--plant", metavar="FILE", help=PLANT_HELP)
    parser.add_argument("--part", metavar="NAME", help="a part of the design alone, as u1 of fault-diagnosis")
    parser.add_argument("--ts", type=seconds, metavar="SECONDS", help="period of the lines (default: that of the page's run)")
    parser.add_argument("--checksum", action="store_true", help="refuse lines without a checksum")
    parser.add_argument("--record", metavar="FILE", help="write the lines as a table that the lesson record reads")
    parser.add_argument("--seconds", type=seconds, metavar="TIME", help="end after this time")
    parser.add_argument("--page", nargs="?", const=8090, type=whole_number(0, 65535, "is no port; give one from 1 to 65535"),
                        metavar="PORT", help="show it in a browser, on a port of this machine (default %(const)s)")
    parser.add_argument("--lang", choices=languages(), default="en", help="language that the page opens in")
    parser.add_argument("--drive", type=above_zero, metavar="LIMIT",
                        help="let the page send u, within this limit; it needs --page and a button pressed there")
    parser.add_argument("--drive-rate", type=above_zero, default=float("inf"), metavar="PER_S", help="fastest change of u in a second")
    parser.add_argument("--json", action="store_true", help="print each sample with its estimate as a line of JSON")


def above_zero(words: str) -> float:
    """A finite number above 0."""
    try:
        value = float(words)
    except ValueError:
        value = float("nan")
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{words[:40]} is no limit; give a number above 0, in the unit of u")
    return value


def execute(options: argparse.Namespace) -> int:
    """Read lines until they end; prints estimates and what was lost."""
    from ...course.knobs import KnobError
    from ...devices import DeviceError
    from ...engine import EngineError
    from ...export.devices.folders import device_design
    from ...export.devices.words import column_names
    from ...live.lines import LineReader
    from ...live.observer import LiveObserver
    from ...live.sources import SourceError
    from ...study.points import outcome_of
    from ..inputs import find_lesson, fit_lesson, read_design

    if options.drive is not None and (options.page is None or options.stdin):
        raise CommandError("--drive needs --page, whose button switches it on, and a source that takes answers: --serial, --udp or "
                           "--simulate.")
    origin = find_lesson(options.lesson)
    design = read_design(origin, options.plant, options.state, options.changes)
    lesson = fit_lesson(origin, design.plant)
    try:
        outcome = outcome_of(lesson, design, False)
        found = device_design(lesson, outcome, options.ts, options.part)
        observer = LiveObserver(found.routine)
        names = [name.partition(":") for name in column_names(found.routine)[1:]]
        reader = LineReader(tuple(name for kind, _, name in names if kind == "u"), tuple(name for kind, _, name in names if kind == "y"),
                            options.checksum)
        with ExitStack() as open_ones:
            open_ones.enter_context(ended_as_by_ctrl_c())
            read = open_ones.enter_context(_source(options, lesson, outcome))
            if options.page is not None:
                return _on_page(options, lesson, design, read, reader)
            record = open_ones.enter_context(open(options.record, "w", encoding="utf-8", buffering=1)) if options.record else None
            with contextlib.suppress(KeyboardInterrupt):
                _follow(options, read, reader, observer, record)
    except (EngineError, KnobError, DeviceError, SourceError) as problem:
        raise CommandError(str(problem)) from problem
    except OSError as problem:
        raise CommandError(f"{str(options.record)[:80]} cannot be written; choose another place.") from problem
    refused = ", ".join(f"{count} {why}" for why, count in reader.refused.items()) or "none"
    print(f"lines {reader.taken}; lost periods {observer.lost}; out of order {observer.disordered}; jittered {observer.jittered}; "
          f"refused: {refused}; restarts {observer.restarts}", file=sys.stderr)
    own, period = observer.own_step, observer.routine.period
    if own and abs(own - period) > OFF_PERIOD * period:
        print(f"observer-lab: the lines come every {own:.4g} s, the observer works every {period:.4g} s; give --ts {own:.4g}, or send t in "
              f"seconds.", file=sys.stderr)
    return 0


def _on_page(options: argparse.Namespace, lesson: Lesson, design: Design, source: Port, reader: LineReader) -> int:
    from .page import desk_of, show_page

    drive = None if options.drive is None else (options.drive, options.drive_rate)
    desk = desk_of(lesson, design, reader, options.ts, drive, options.part)
    if options.record:
        desk.toggle_record(options.record)
        if not desk.recording:
            raise CommandError(f"{str(options.record)[:80]} cannot be written; choose another place.")
    show_page(lesson, design, desk, source, options.page, options.lang, options.seconds)
    return 0


def _source(options: argparse.Namespace, lesson: Lesson, outcome: Outcome) -> AbstractContextManager[Port]:
    from ...live.sources import from_descriptor, from_serial, from_udp

    if options.stdin:
        return from_descriptor(sys.stdin.fileno())
    if options.udp is not None:
        return from_udp(options.udp)
    if options.serial is not None:
        return from_serial(options.serial, options.baud)
    return _simulated(options, lesson, outcome)


def _simulated(options: argparse.Namespace, lesson: Lesson, outcome: Outcome) -> AbstractContextManager[Port]:
    from ...engine.systems import discretise
    from ...export.devices.c_project import simulator_files
    from ...export.devices.folders import device_design
    from ...live.simulated import simulated

    if outcome.run is None:
        raise CommandError(f"Lesson {lesson.id} has no plain loop to simulate as a device; use --stdin, --udp or --serial.")
    design, s = device_design(lesson, outcome, options.ts, options.part), outcome.run.scenario
    plant = s.plant if s.plant.dt else discretise(replace(s.plant), design.routine.period)
    count = SIMULATED_SAMPLES if options.seconds is None else int(options.seconds / design.routine.period) + 1
    return simulated(simulator_files(design, plant, s.x0), count, driven=options.drive is not None,
                     knocks=0 if options.page is None else max(1, round(KNOCK_S / design.routine.period)))


def _follow(options: argparse.Namespace, read: Port, reader: LineReader, observer: LiveObserver, record: IO[str] | None) -> None:
    if record is not None:
        heads = [*(f"u_{name}" for name in reader.inputs), *(f"y_{name}" for name in reader.readings)]  # as the reader of records asks
        record.write(",".join(["t", *heads]) + "\n")
    begun = shown = time.monotonic()
    while options.seconds is None or time.monotonic() - begun < options.seconds:
        data = read(WAIT_S)
        if data is None:
            return
        for sample in reader.feed(data):
            step = observer.take(sample)
            if step is None:
                continue
            if record is not None:
                record.write(",".join(repr(float(v)) for v in (sample.t, *sample.u, *sample.y)) + "\n")
            if options.json:
                print(_json(step), flush=True)
            elif time.monotonic() - shown >= SHOW_S:
                shown = time.monotonic()
                print(_words(step, observer), flush=True)


def _json(step: Step) -> str:
    def plain(values: object) -> object:
        return None if values is None else [float(v) if abs(float(v)) < float("inf") else None for v in values]  # type: ignore[union-attr]
    s = step.sample
    nis = None if step.nis is None or step.nis != step.nis else step.nis
    return json.dumps({"t": s.t, "u": plain(s.u), "y": plain(s.y), "xhat": plain(step.xhat), "innovation": plain(step.innovation),
                       "nis": nis, "fault": step.fault, "lost": step.lost})


def _words(step: Step, observer: LiveObserver) -> str:
    estimate = "  ".join(f"{name} {value:.4g}" for name, value in zip(observer.routine.x_names, step.xhat, strict=False))
    return f"{step.sample.t:.3f} s  lost {observer.lost}  {estimate}" + ("" if step.nis is None else f"  NIS {step.nis:.3g}")
