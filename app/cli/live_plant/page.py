"""Show a running plant in browsers: the page of a design beside the plant's lines."""

from __future__ import annotations

import contextlib
import threading
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..options import CommandError, error_cause

if TYPE_CHECKING:
    from ...course.lesson import Design, Lesson
    from ...live.desk import LiveDesk
    from ...live.lines import LineReader
    from ...live.sources import Port
    from ...page.screen.server import LabServer

HOST = "127.0.0.1"
POSE_S, TAB_S = 0.02, 0.002  # between two places of the ghost, and as much more for each tab
LOOK_S, QUIET_S = 0.1, 0.05  # between two looks whether a tab takes a picture; for bytes at a time
MOST_TABS = 40


def show_page(lesson: Lesson, design: Design, desk: LiveDesk, source: Port, port: int, language: str, seconds: float | None) -> None:
    """Serve the page and follow the lines until they end, or the time is over. Raises CommandError where the port is taken."""
    from ...live.lesson import live_lesson
    from ...page.access.addresses import listen
    from ...page.access.shared_counters import SharedCounters, WorkerSlot
    from ...page.screen.server import LabServer

    live = live_lesson(lesson, design, desk)
    try:
        listener = listen(HOST, port)
    except OSError as problem:
        raise CommandError(f"The page cannot listen on port {port} ({error_cause(problem)}); choose another with --page PORT.") from problem
    server = LabServer({live.id: live}, HOST, 0, live.id, language, insists=True, listener=listener,
                       slot=WorkerSlot(SharedCounters(1, MOST_TABS), 0))
    try:
        print(server.url, flush=True)
        server.prepare()
        ended = threading.Event()
        following = threading.Thread(target=_follow, args=(desk, source, server, seconds, ended), name="observer-lab live", daemon=True)
        following.start()
        with contextlib.suppress(KeyboardInterrupt):
            server.wait(ended.is_set)
        ended.set()
        following.join(2.0)
    finally:
        server.stop()


class Tabs:
    """The tabs of a live page; each is told of lines once it has shown what it was told before."""

    def __init__(self, desk: LiveDesk, server: LabServer) -> None:
        self._desk, self._server = desk, server
        self._waiting: set[int] = set()  # tabs that have not shown the last lines yet
        self.present: set[int] = set()

    def count(self) -> None:
        """See who has come and who has left."""
        present = set(self._server.sessions)
        for tab in self.present - present:
            self._desk.leave(tab)
            self._waiting.discard(tab)
        self.present = present

    def tell(self, whole: bool) -> None:
        """Lines have come: give those a picture that take one, or move their ghosts."""
        from ...session.commands.files import LinesCame

        takes = self._desk.wants if whole else self._desk.moves
        for tab, session in list(self._server.sessions.items()):
            if tab not in self._waiting and takes(tab):
                self._waiting.add(tab)
                session.post(LinesCame(tab, partial(self._waiting.discard, tab), whole))


def _follow(desk: LiveDesk, source: Port, server: LabServer, seconds: float | None, ended: threading.Event) -> None:
    """Take the lines, answer the device, and tell the tabs."""
    tabs = Tabs(desk, server)
    begun = moved = looked = time.monotonic()
    fresh = False  # whether a line has come since the ghost was moved
    try:
        while not ended.is_set() and (seconds is None or time.monotonic() - begun < seconds):
            data = source(QUIET_S if not fresh else POSE_S / 4)
            if data is None:
                return
            fresh |= _take(desk, source, data)
            now = time.monotonic()
            if now - looked >= LOOK_S:
                looked = now
                tabs.count()
                tabs.tell(True)
            if fresh and now - moved >= POSE_S + TAB_S * len(tabs.present):
                moved, fresh = now, False
                tabs.tell(False)
    finally:
        ended.set()


def _take(desk: LiveDesk, source: Port, data: bytes) -> bool:
    """Whether a line came; what is to be sent is sent."""
    answer, came = b"", False
    for sample in desk.reader.feed(data):
        _, answer = desk.take(sample)
        came = True
    answer = answer if came else desk.idle()
    if answer and source.send is not None:
        source.send(answer)
    return came


def desk_of(lesson: Lesson, design: Design, reader: LineReader, ts: float | None, drive: tuple[float, float] | None,
            part: str | None = None) -> LiveDesk:
    """What the tabs share. Raises DeviceError, and CommandError where a design that feeds nothing back is to drive."""
    from ...export.devices.folders import device_design
    from ...live.desk import LiveDesk
    from ...live.drive import Drive, feedback_of
    from ...study.points import outcome_of

    routine = device_design(lesson, outcome_of(lesson, design, False), ts, part).routine
    if drive is not None and feedback_of(routine) is None:
        raise CommandError(f"Lesson {lesson.id} feeds nothing back with these settings, so it cannot drive a plant; leave --drive out.")
    return LiveDesk(routine, design, lambda outcome: device_design(lesson, outcome, ts, part).routine, reader, time.monotonic, Path.cwd(),
                    None if drive is None else Drive(*drive))
