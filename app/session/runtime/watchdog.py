"""Interrupt any tab's step that uses too much time or memory; end the tab if that fails.

Python cannot kill a thread. What it can do is raise an error in one, which comes up between two instructions of Python: an
endless loop of a lesson ends so, and the tab goes on with its last good picture. A call into a library that does not come
back hears nothing of that. Then the tab is ended, its place becomes free, and `stuck` counts the thread until it does come
back: whoever looks after the server sees it in `/health` and may start it anew.
"""

from __future__ import annotations

import ctypes
import logging
import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ...course.knobs import KnobError
from ...text import text

log = logging.getLogger(__name__)

MAX_STEP_CPU_S = 10.0  # s of the processor that one step of a tab may take; the slowest of ours takes a tenth of that
MAX_STEP_WALL_S = 60.0  # s by the clock, whether it works or waits
ABANDONED_STEP_CPU_S = 1.0  # s of the processor for a tab that nobody looks at any more
MAX_STEP_GROWTH_BYTES = 1_000_000_000  # bytes by which the process may grow during a step
INTERRUPT_RETRY_S, END_GRACE_S = 2.0, 6.0  # s between two attempts to break a step off, and after the first one until its tab is ended
LOOK_INTERVAL_S = 0.25  # s between two looks, while anybody works
TOO_LONG = text("This takes more than {seconds:.0f} s and was broken off, so that others can go on; everything stays as it was.",
                seconds=MAX_STEP_CPU_S)
TOO_MUCH = text("This takes more memory than there is for one tab and was broken off; everything stays as it was.")
TAB_ENDED = text("The computation cannot be broken off, so this tab has ended; the page reopens with the last design that was shown.")


class StepTimeout(KnobError):
    """Raised in a thread whose step takes too long."""

    def __init__(self) -> None:
        super().__init__(TOO_LONG)


class StepMemoryExceeded(KnobError):
    """Raised in a thread whose step takes too much memory."""

    def __init__(self) -> None:
        super().__init__(TOO_MUCH)


class Step:
    """A step of a tab that is going on: since when, in which thread, how often it was told to end."""

    def __init__(self, left: Callable[[], bool], ended: Callable[[], None]) -> None:
        self.thread = threading.get_ident()
        self.left, self.ended = left, ended
        self.began, self.spent = time.monotonic(), thread_cpu_s(self.thread)
        self.held = 0  # bytes that the process held when it was first looked at
        self.told, self.first = -1e9, 0.0  # when it was told to end, last and first
        self.over = False  # whether its tab was ended


class Watchdog:
    """All steps of a process that are going on. One thread looks at them, and rests while there are none."""

    def __init__(self, longest: float = MAX_STEP_CPU_S, asleep: float = MAX_STEP_WALL_S, grace: float = END_GRACE_S,
                 room: float = MAX_STEP_GROWTH_BYTES) -> None:
        self.longest, self.asleep, self.grace, self.room = longest, asleep, grace, room
        self._steps: dict[int, Step] = {}
        self._lock, self._busy = threading.Lock(), threading.Event()
        self._looks: threading.Thread | None = None

    @property
    def stuck(self) -> int:
        """How many threads go on although their tab was ended."""
        return sum(step.over for step in list(self._steps.values()))

    @contextmanager
    def step(self, left: Callable[[], bool], ended: Callable[[], None]) -> Iterator[None]:
        """A step of a tab in this thread: `left` says whether anybody still looks, `ended` ends the tab.

        May raise StepTimeout, StepMemoryExceeded.
        """
        step = Step(left, ended)
        with self._lock:
            self._steps[step.thread] = step
            if self._looks is None or not self._looks.is_alive():
                self._looks = threading.Thread(target=self._look, name="observer-lab watch", daemon=True)
                self._looks.start()
        self._busy.set()
        try:
            yield
        finally:
            try:
                self._end(step)
            except (StepTimeout, StepMemoryExceeded):  # it came up on the way out, too late to break anything off
                self._end(step)

    def _end(self, step: Step) -> None:
        with self._lock:
            self._steps.pop(step.thread, None)
        if step.told > 0:
            flush_pending_error()  # what has not come up yet belongs to no other step

    def _look(self) -> None:
        while True:
            self._busy.wait()
            time.sleep(LOOK_INTERVAL_S)
            now, grown = time.monotonic(), process_memory_bytes()
            with self._lock:
                if not self._steps:
                    self._busy.clear()
                late = [step for step in self._steps.values() if self._judge(step, now, grown)]
            for step in late:
                log.error("a step of a tab cannot be broken off; its tab is ended")
                threading.Thread(target=step.ended, name="observer-lab end", daemon=True).start()

    def _judge(self, step: Step, now: float, held: int) -> bool:
        """Tell a step to end if it should; whether its tab must be ended."""
        step.held = step.held or held
        limit = ABANDONED_STEP_CPU_S if step.left() else self.longest
        spent = thread_cpu_s(step.thread) - step.spent
        problem = (StepMemoryExceeded if held - step.held > self.room and step is self._oldest() else
                   StepTimeout if spent > limit or now - step.began > self.asleep else None)
        if problem is None and step.told < 0:
            return False
        if now - step.told > INTERRUPT_RETRY_S:
            step.first = step.first or now
            step.told = now
            raise_in_thread(step.thread, problem or StepTimeout)
        late = now - step.first > self.grace and not step.over
        step.over |= late
        return late

    def _oldest(self) -> Step:
        return min(self._steps.values(), key=lambda step: step.began)


def raise_in_thread(thread: int, problem: type[BaseException]) -> None:
    """Let an error come up in a thread, between two of its instructions."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(problem))


def flush_pending_error() -> None:
    """Let an error that still waits for this thread come up here and now, and forget it.

    Python can also take one back unraised. But then every thread goes on looking for it for ever, and under a tracer
    Python 3.11 does nothing else any more: a debugger, a coverage run or a property test stands still in its next call.
    """
    try:
        raise_in_thread(threading.get_ident(), StepTimeout)
        while True:
            pass
    except (StepTimeout, StepMemoryExceeded):
        pass


def thread_cpu_s(thread: int) -> float:
    """Seconds of the processor that a thread has used; by the clock where the system does not say."""
    try:
        return time.clock_gettime(time.pthread_getcpuclockid(thread))
    except (AttributeError, OSError):
        return time.monotonic()


def process_memory_bytes() -> int:
    """Bytes of memory that the process holds, 0 where the system does not say."""
    try:
        return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, IndexError, AttributeError):
        return 0
