"""Share one running plant among the tabs of a live page: lines, observer, record, drive."""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, Any

import numpy as np

from ..course.figures.records import Figure
from ..course.figures.scene import Stage
from ..course.lesson import Design, Outcome
from ..devices import DeviceError, Routine
from ..engine import EngineError
from ..text import Text, same, text
from .drive import Drive, feedback_of, input_line
from .lines import LineReader, Sample
from .observer import LiveObserver, Step
from .rows import Rows

__all__ = ["LiveDesk", "record_head", "record_row"]

STRIPS_S, PICTURE_S = 0.5, 0.5  # between two drawings of the strips, and two pictures, at least; body and ghost move with the lines
LOST_PICTURE_S, REST = 2.0, 0.3  # after which a picture counts as lost; share of the time of drawing in which a page rests
HIDDEN_S = 1.0  # without a picture drawn for so long, a page is hidden or behind: its ghost waits
SILENT_PERIODS, SILENT_S = 3.0, 1.0  # without a line for so long, the page says so: periods, and s at least
COUNTS = text("Until {t:.2f} s: {taken} taken, {lost} lost, {jittered} late by more than a quarter period, {refused} refused.")
WAITING = text("No line has come yet; the observer works every {period:.4g} s.")
SILENT = text("No line for {seconds:.1f} s. The ghost stands where the last line left it; the page goes on with the next one.")
ANEW = text("The observer has begun again {count} times, after a long gap, a reset of the device or a lost estimate.")
OTHER_DESIGN = text("Another tab has changed the observer; move a knob here to use this page's design.")
REFUSED = text("The observer is still that of the design before: {why}")
RECORDING = text("Recording to {file}: {rows} rows.")
RECORDED = text("Recorded: {file}, {rows} rows. Lesson record reads it.")
NO_ROOM = text("The record cannot be written; check the folder in which the command was started.")
DRIVING = text("This page drives the plant: |u| is at most {limit:.3g}.")
IDLE = text("Nothing is sent to the plant but u = 0.")
PAGE_GONE = text("The page that drove was gone, so u = 0 now. Press the button to drive again.")
OTHER_SIGNALS = text("It has other signals or another period. Start the command again with this design.")
INPUT_ONLY = text("Input only: nothing is sent to the plant.")


def record_head(reader: LineReader) -> str:
    """The head of a record, as the reader of records asks."""
    return ",".join(["t", *(f"u_{name}" for name in reader.inputs), *(f"y_{name}" for name in reader.readings)]) + "\n"


def record_row(sample: Sample) -> str:
    """A row of a record, each number so that it reads back as the same."""
    return ",".join(repr(float(v)) for v in (sample.t, *sample.u, *sample.y)) + "\n"


@dataclass
class Picture:
    """The last picture that a tab was given: its number, when it was sent, when the page had drawn it, since when it owes one."""

    number: int = 0
    sent: float = float("-inf")
    drawn: float = float("-inf")
    owing: float = float("inf")


class LiveDesk:
    """What all tabs of a live page share; every method may be called on any thread."""

    def __init__(self, routine: Routine, design: Design, routine_of: Callable[[Outcome[Any]], Routine], reader: LineReader,
                 clock: Callable[[], float], folder: Path, drive: Drive | None = None) -> None:
        self.reader, self.drive = reader, drive
        self.observer = LiveObserver(routine)
        self._routine_of, self._clock, self._folder = routine_of, clock, folder
        self._lock, self._rows = threading.RLock(), Rows()
        self._feedback, self._driven = feedback_of(routine), design
        self._told: dict[Hashable, Design] = {}
        self._problem: Text | None = None
        self._came = clock()
        self._record: IO[str] | None = None
        self._file, self._written, self._broken, self._recorded = "", 0, False, float("-inf")
        self._pictures: dict[Hashable, Picture] = {}
        self._strips: tuple[float, Sequence[Figure]] = (float("-inf"), ())

    # --- lines -----------------------------------------------------------------------------------------------------
    def take(self, sample: Sample) -> tuple[Step | None, bytes]:
        """One line: its step, and the line that is sent to the device, b"" where nothing is."""
        with self._lock:
            step, now = self.observer.take(sample), self._clock()
            if step is None:
                return None, b""
            self._came = now
            self._rows.take(step)
            self._write(sample)
            return step, self._input(now)

    def idle(self) -> bytes:
        """What is sent while no line comes: u = 0 once the page that drove is gone."""
        with self._lock:
            if self.drive is None or self.drive.driver is None or self.drive.runs(self._clock()):
                return b""
            return input_line(np.zeros(len(self.observer.routine.u_names)))

    def _input(self, now: float) -> bytes:
        if self.drive is None or self._feedback is None:
            return b""
        K, r = self._feedback
        return input_line(self.drive.input(r - K @ self.observer.predicted, self.observer.routine.period, now))

    # --- tabs ------------------------------------------------------------------------------------------------------
    def shown(self, tab: Hashable, outcome: Outcome[Any]) -> tuple[Outcome[Any], Sequence[Figure]]:
        """The outcome of a tab with the plant as it is now, and the strips. A tab whose design has changed changes the observer."""
        with self._lock:
            before = self._told.setdefault(tab, outcome.design)
            if before != outcome.design:
                self._told[tab] = outcome.design
                self._change(outcome)
            routine, now = self.observer.routine, self._clock()
            if now - self._strips[0] >= STRIPS_S or not self._strips[1]:
                self._strips = now, self._rows.figures(routine)
            picture = self._pictures.setdefault(tab, Picture())
            picture.number, picture.sent, picture.owing = picture.number + 1, now, min(picture.owing, now)
            return replace(outcome, stage=self._rows.stage(outcome.stage, routine), run=None), self._strips[1]

    def stage(self, outcome: Outcome[Any]) -> Stage | None:
        """The body of a tab's outcome on the rows that are there now."""
        with self._lock:
            return self._rows.stage(outcome.stage, self.observer.routine)

    def number(self, tab: Hashable) -> int:
        """Of the last picture of a tab; the page says it once it is drawn."""
        return self._pictures.get(tab, Picture()).number

    def wants(self, tab: Hashable) -> bool:
        """Whether a tab takes another picture: it has drawn the last one and had time to rest, or is silent for long."""
        with self._lock:
            last, now = self._pictures.get(tab, Picture()), self._clock()
            took = last.drawn - last.sent
            rested = took >= 0 and now - last.drawn >= took * REST
            return now - last.sent > (PICTURE_S if rested else LOST_PICTURE_S)

    def moves(self, tab: Hashable) -> bool:
        """Whether a tab takes its ghost's place now: its page draws what it is given."""
        with self._lock:
            last = self._pictures.get(tab)
            return last is not None and self._clock() - last.owing < HIDDEN_S

    def _change(self, outcome: Outcome[Any]) -> None:
        try:
            routine, before = self._routine_of(outcome), self.observer.routine
            if (routine.y_names, routine.u_names) != (before.y_names, before.u_names) or routine.period != before.period:
                raise DeviceError(OTHER_SIGNALS)
            self.observer.change(routine)
        except (DeviceError, EngineError) as problem:
            self._problem = problem.text if isinstance(problem, DeviceError) else same(str(problem))
            return
        self._problem, self._driven, self._feedback = None, outcome.design, feedback_of(routine)

    def said(self, tab: Hashable) -> tuple[Text, ...]:
        """The sentences of the page about lines, observer, record and drive."""
        with self._lock:
            o, now = self.observer, self._clock()
            silent = now - self._came
            lines = [WAITING.format(period=o.routine.period) if not o.steps else COUNTS.format(
                taken=self.reader.taken, t=o.last_time, lost=o.lost, jittered=o.jittered,
                refused=sum(self.reader.refused.values()) + o.disordered)]
            if silent > max(SILENT_S, SILENT_PERIODS * o.routine.period):
                lines.append(SILENT.format(seconds=silent))
            if o.restarts:
                lines.append(ANEW.format(count=o.restarts))
            if self._problem is not None:
                lines.append(REFUSED.format(why=self._problem))
            elif self._told.get(tab, self._driven) != self._driven:
                lines.append(OTHER_DESIGN)
            if self._broken:
                lines.append(NO_ROOM)
            elif self._file:
                lines.append((RECORDING if self._record else RECORDED).format(file=self._file, rows=self._written))
            return tuple([*lines, self._drive_words(now)])

    def _drive_words(self, now: float) -> Text:
        if self.drive is None:
            return INPUT_ONLY
        if self.drive.runs(now):
            return DRIVING.format(limit=self.drive.limit)
        return PAGE_GONE if self.drive.ended == "page" else IDLE

    # --- buttons ---------------------------------------------------------------------------------------------------
    @property
    def recording(self) -> bool:
        """Whether the lines are written to a file."""
        return self._record is not None

    @property
    def can_drive(self) -> bool:
        """Whether the page may send u."""
        return self.drive is not None

    @property
    def driving(self) -> bool:
        """Whether a page sends u now."""
        with self._lock:
            return self.drive is not None and self.drive.runs(self._clock())

    def toggle_record(self, file: str | None = None) -> None:
        """Begin a new file, or end the present one."""
        with self._lock:
            if self._record is not None:
                self._record.close()
                self._record = None
                return
            path = self._free_file() if file is None else Path(file)
            try:
                self._record = path.open("w", encoding="utf-8", buffering=1)  # a row is on the disk before the next one comes
                self._record.write(record_head(self.reader))
            except OSError:
                self._broken = True
                return
            self._file, self._written, self._broken, self._recorded = str(file or path.name), 0, False, float("-inf")

    def toggle_drive(self, tab: Hashable) -> None:
        """Let this tab drive, or nobody."""
        with self._lock:
            if self.drive is None:
                return
            if self.drive.runs(self._clock()):
                self.drive.switch_off()
            else:
                self.drive.switch_on(tab, self._clock())

    def hear(self, tab: Hashable, number: int) -> None:
        """A sign of life of a tab, with the number of the picture that it has drawn."""
        with self._lock:
            last = self._pictures.get(tab)
            if last is not None and number == last.number and last.drawn < last.sent:
                last.drawn, last.owing = self._clock(), float("inf")
            if self.drive is not None:
                self.drive.hear(tab, self._clock())

    def leave(self, tab: Hashable) -> None:
        """A tab is closed; where it drove, nobody does."""
        with self._lock:
            self._told.pop(tab, None)
            self._pictures.pop(tab, None)
            if self.drive is not None and self.drive.driver == tab:
                self.drive.switch_off("page")

    def _free_file(self) -> Path:
        return next(path for k in range(1, 100_000) if not (path := self._folder / f"live-{k}.csv").exists())

    def _write(self, sample: Sample) -> None:
        if self._record is None:
            return
        if sample.t <= self._recorded:  # the device was switched on again: times of a record rise
            self._record.close()
            self._record = None
            return
        self._recorded = sample.t
        try:
            self._record.write(record_row(sample))
            self._written += 1
        except OSError:
            self._record, self._broken = None, True
