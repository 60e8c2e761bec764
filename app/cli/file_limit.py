"""Let the server hold as many connections as the system permits."""

from __future__ import annotations

from contextlib import suppress

MAX_FILES = 65_536  # files and connections that one process may have open


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
