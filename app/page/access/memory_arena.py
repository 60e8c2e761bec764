"""Let all threads share one memory arena, and say how much memory the process has."""

from __future__ import annotations

import ctypes
import os
from contextlib import suppress
from pathlib import Path

M_ARENA_MAX = -8  # in glibc's malloc.h


def share_one_arena() -> None:
    """Let all threads take memory from one place, where the C library is glibc.

    It gives each new thread a place of its own, up to eight for each core, and what a tab's thread leaves free there waits for
    a thread that may never come: 5 to 12 kB for each tab that came and went, beside 0.4. One interpreter runs one thread
    at a time, so nobody waits for the one place.
    """
    with suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, 1)


def resident_bytes() -> int:
    """The memory that this process has of the machine's; 0 where the system does not say it in /proc."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    except (OSError, ValueError, IndexError):
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")
