"""Run several worker processes behind one address and restart those that fail.

A worker is forked from a process that has loaded all and started nothing, so that it stands at once. A WebSocket stays with the
worker that was handed it; a tab that connects anew may come to another, and brings what it had from the browser's storage.
"""

from __future__ import annotations

import logging
import os
import selectors
import signal
import socket
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from ..page.access.shared_counters import SharedCounters
from ..page.access.socket_handoff import READY, can_send_connections, send_connection
from .options import CommandError

log = logging.getLogger(__name__)

ENDINGS = (signal.SIGINT, signal.SIGTERM)
STOP_TIMEOUT_S = 5.0  # s in which all have stopped
MIN_RESTART_DELAY_S, MAX_RESTART_DELAY_S = 0.5, 30.0  # s between the end of a worker and the next one in its place; doubled each time
HEALTHY_LIFETIME_S = 60.0  # s after which an end has nothing to do with the one before
REAP_INTERVAL_S = 0.02  # s between two looks at who has ended
STUCK_TIMEOUT_S, SILENT_TIMEOUT_S = (
    30.0,
    90.0,
)  # s with a thread that nothing can break off, and without a sign of life, after which it is started anew
CHECK_INTERVAL_S = 5.0  # s between two looks at that
END_POLL_S = 0.1  # s within which an end that was asked for is heard
NOT_HERE = "This system cannot share one address among processes; leave out --workers (Linux can)."


def can_fork_workers() -> bool:
    """Whether this system is one on which workers are known to do well: on others processes that have loaded numerics are not forked,
    or no connection is handed on."""
    return sys.platform.startswith("linux") and hasattr(os, "fork") and can_send_connections()


@dataclass
class Worker:
    """A place in the crew and the process that fills it: None while there is none. One that has no channel is leaving."""

    number: int  # from 0
    process: int | None = None
    channel: socket.socket | None = None
    handed: int = 0
    last: int = 0  # when it was handed the last connection, by their count
    stands: bool = False
    well: float = 0.0  # when it was last seen without a thread that is stuck
    pause: float = field(default=MIN_RESTART_DELAY_S / 2)
    due: float = 0.0  # when the next process begins, or this one must have left, on the clock of the machine


class WorkerPool:
    """The workers behind a listening socket. `work` is what a worker does with its number and its channel, in a process of its own."""

    def __init__(self, listener: socket.socket, tally: SharedCounters, work: Callable[[int, socket.socket], None],
                 stuck: float = STUCK_TIMEOUT_S, silent: float = SILENT_TIMEOUT_S, check: float = CHECK_INTERVAL_S) -> None:
        self._listener, self._tally, self._work = listener, tally, work
        self._stuck, self._silent, self._check = stuck, silent, check
        self._workers = [Worker(number) for number in range(tally.workers)]
        self._selector = selectors.DefaultSelector()
        self._count = 0
        self._told = False

    def run(self, stand: Callable[[], None], ended: Callable[[], bool] = lambda: False) -> None:
        """Look after them until interrupted, or until `ended` says so; `stand` is called once, when all take connections. Raises
        CommandError where one ends before that."""
        self._listener.setblocking(False)
        try:
            for worker in self._workers:
                self._begin(worker)
            while not ended():
                self._turn(stand)
        finally:
            for ending in ENDINGS:
                signal.signal(ending, signal.SIG_IGN)  # it is ending already
            self._end()

    def _turn(self, stand: Callable[[], None]) -> None:
        now = time.monotonic()
        for worker in self._workers:
            if worker.process is None and now >= worker.due:
                self._begin(worker)
            elif worker.process is not None and worker.channel is None:
                self._reap(worker, worker.process, now)
            elif worker.process is not None and worker.stands:
                self._examine(worker, worker.process, now)
        due = [worker.due - now if worker.process is None else REAP_INTERVAL_S for worker in self._workers if worker.channel is None]
        for key, _ in self._selector.select(max(0.0, min([*due, self._check, END_POLL_S]))):
            if key.data is None:
                self._take()
            else:
                self._hear(key.data)
        if not self._told and all(worker.stands for worker in self._workers):
            self._told = True
            stand()

    def _examine(self, worker: Worker, process: int, now: float) -> None:
        """End one that does not answer, or that a thread burns; its tabs come back to the others, with what they showed last."""
        figures = self._tally.of(worker.number)
        worker.well = worker.well if figures.stuck else now
        if now - worker.well > self._stuck or now - figures.beat > self._silent:
            what = "is stuck" if figures.stuck else "does not answer"
            log.error("worker %d %s and is ended", worker.number + 1, what)
            os.kill(process, signal.SIGTERM)
            self._forget_worker(worker)

    def _begin(self, worker: Worker) -> None:
        ours, theirs = socket.socketpair()
        self._tally.begin(worker.number)
        sys.stdout.flush()
        signal.pthread_sigmask(signal.SIG_BLOCK, ENDINGS)  # none may come between the fork and what catches it
        process = os.fork()
        if process == 0:
            ours.close()
            os._exit(self._live(worker.number, theirs))
        worker.process, worker.channel, worker.handed, worker.last, worker.stands = process, ours, 0, 0, False
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDINGS)
        theirs.close()
        ours.setblocking(False)
        self._selector.register(ours, selectors.EVENT_READ, worker)

    def _live(self, number: int, channel: socket.socket) -> int:
        """All of a worker's life; its exit status."""
        try:
            self._selector.close()
            for held in [self._listener, *(other.channel for other in self._workers)]:
                if held is not None:
                    held.close()
            signal.pthread_sigmask(signal.SIG_UNBLOCK, ENDINGS)
            self._work(number, channel)
        except KeyboardInterrupt:
            pass
        except BaseException:
            log.exception("worker %d", number + 1)
            return 1
        finally:
            logging.shutdown()
        return 0

    def _take(self) -> None:
        """Hand the next connection to who has fewest, of those to who has fewest tabs, and of those to who has waited longest."""
        standing = [worker for worker in self._workers if worker.stands]
        if not standing:
            return
        try:
            connection, _ = self._listener.accept()
        except (BlockingIOError, ConnectionAbortedError):  # it has left
            return
        except OSError:  # too many files are open, which passes
            time.sleep(REAP_INTERVAL_S)
            return
        with connection:
            self._count += 1
            for worker in sorted(standing, key=self._load):
                if worker.channel is not None and send_connection(worker.channel, connection):
                    worker.handed, worker.last = worker.handed + 1, self._count
                    return

    def _load(self, worker: Worker) -> tuple[int, int, int]:
        figures = self._tally.of(worker.number)
        return worker.handed - figures.ended, figures.tabs, worker.last

    def _hear(self, worker: Worker) -> None:
        assert worker.channel is not None
        try:
            said = worker.channel.recv(64)
        except BlockingIOError:
            return
        except OSError:
            said = b""
        if READY in said:
            worker.stands, worker.well = True, time.monotonic()
            self._tally.beat(worker.number)
            self._tally.stand(worker.number, True)
            self._listen()
        if not said:
            self._forget_worker(worker)

    def _forget_worker(self, worker: Worker) -> None:
        assert worker.channel is not None
        self._selector.unregister(worker.channel)
        worker.channel.close()
        worker.channel, worker.stands, worker.due = None, False, time.monotonic() + STOP_TIMEOUT_S
        self._tally.stand(worker.number, False)
        self._listen()

    def _reap(self, worker: Worker, process: int, now: float) -> None:
        ended, status = os.waitpid(process, os.WNOHANG)
        if not ended:
            if now >= worker.due:
                os.kill(process, signal.SIGKILL)
            return
        worker.process, status = None, os.waitstatus_to_exitcode(status)
        if not self._told:
            raise CommandError(f"Worker {worker.number + 1} has ended before all stood (status {status}); the log says why.")
        lived = now - self._tally.of(worker.number).since
        worker.pause = MIN_RESTART_DELAY_S if lived > HEALTHY_LIFETIME_S else min(2 * worker.pause, MAX_RESTART_DELAY_S)
        worker.due = now + worker.pause
        log.warning("worker %d has ended (status %d) and is started again in %.3g s", worker.number + 1, status, worker.pause)

    def _listen(self) -> None:
        """Take connections as long as somebody serves them; the others wait."""
        listens, wanted = self._listener in self._selector.get_map(), any(worker.stands for worker in self._workers)
        if wanted and not listens:
            self._selector.register(self._listener, selectors.EVENT_READ, None)
        elif listens and not wanted:
            self._selector.unregister(self._listener)

    def _end(self) -> None:
        self._listener.close()
        left = {worker.process for worker in self._workers if worker.process is not None}
        for process in left:
            os.kill(process, signal.SIGTERM)
        end = time.monotonic() + STOP_TIMEOUT_S
        while left and time.monotonic() < end:
            left -= {process for process in left if os.waitpid(process, os.WNOHANG)[0]}
            time.sleep(REAP_INTERVAL_S)
        for process in left:
            os.kill(process, signal.SIGKILL)
            os.waitpid(process, 0)
