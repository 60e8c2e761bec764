"""`python -m app.engine.kernels` compiles all kernels into the user's cache, at low priority."""

from __future__ import annotations

import os

from .shelf import SHELF

if __name__ == "__main__":
    if hasattr(os, "nice"):
        os.nice(10)
    SHELF.fill()
