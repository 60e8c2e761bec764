"""Make all threads allocate from one memory arena where the C library is glibc."""

from __future__ import annotations

import ctypes
from contextlib import suppress

M_ARENA_MAX = -8  # in glibc's malloc.h


def share_one_arena() -> None:
    """Let all threads take memory from one place, where the C library is glibc.

    It gives each new thread a place of its own, up to eight for each core, and what a tab's thread leaves free there waits for
    a thread that may never come: 5 to 12 kB for each tab that came and went, beside 0.4. One interpreter runs one thread
    at a time, so nobody waits for the one place.
    """
    with suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, 1)
