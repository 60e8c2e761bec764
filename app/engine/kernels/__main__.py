"""Compile all kernels into the user's cache: `python -m observer_lab.engine.kernels`."""

from __future__ import annotations

import os

from .compile_cache import COMPILE_CACHE

if __name__ == "__main__":
    if hasattr(os, "nice"):
        os.nice(10)
    COMPILE_CACHE.fill()
