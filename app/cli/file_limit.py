"""Hold what the system gives a server: files, memory up to a bound, and its data folder alone."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from .options import CommandError, error_cause

MAX_MEMORY_BYTES = 4 * 1024**3  # that one process may write to; what asks for more gets a MemoryError, and the machine stays
MAX_FILES = 65_536  # files and connections that one process may have open
LOCK = ".observer-lab.lock"
WAIT_S = 5.0  # s that a server waits for one before it to end, as at a restart
POLL_S = 0.1


def allow_many_files() -> None:
    """Raise the number of open files to what the system permits, at most MAX_FILES; it is often 1024 at first."""
    try:
        import resource
    except ImportError:  # not on Windows, which has no such bound
        return
    now, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MAX_FILES if most == resource.RLIM_INFINITY else min(MAX_FILES, most)
    if now != resource.RLIM_INFINITY and now < wanted:
        with suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, most))


def bound_memory() -> None:
    """Bound the memory of this process, and of each worker that it forks, at MAX_MEMORY_BYTES; a lower bound of the system stays."""
    try:
        import resource
    except ImportError:
        return
    now, most = resource.getrlimit(resource.RLIMIT_DATA)
    if now == resource.RLIM_INFINITY or now > MAX_MEMORY_BYTES:
        with suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_DATA, (MAX_MEMORY_BYTES, most))


@contextlib.contextmanager
def held_folder(folder: str | None) -> Iterator[None]:
    """Hold a folder for as long as the block lasts, if one is given. Raises CommandError where another server holds it.

    The lock belongs to this process alone and ends with it, however it ends.
    """
    if folder is None or os.name != "posix":
        yield
        return
    import fcntl

    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        file = os.open(Path(folder) / LOCK, os.O_RDWR | os.O_CREAT, 0o600)
    except (OSError, ValueError) as problem:  # a zero byte in a name is refused by Python itself
        raise CommandError(f"{folder[:80]} cannot hold what is kept ({error_cause(problem)}); choose another folder.") from problem
    try:
        end = time.monotonic() + WAIT_S
        while True:
            try:
                fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError as problem:
                if time.monotonic() >= end:
                    raise CommandError(f"{folder[:80]} is in use by another server; end that one, or choose another folder.") from problem
                time.sleep(POLL_S)
            except OSError:  # a file system without locks
                break
        yield
    finally:
        os.close(file)
