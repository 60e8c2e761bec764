"""Recursions that NumPy cannot fuse, as plain functions of arrays that Numba compiles where it is installed.

Nothing here is needed for an answer: each has a plain way beside it, in the room that calls it.
"""

from .rubbed import rubbed_steps
from .shares import in_shares
from .shelf import SHELF, given, kernel, prepare_kernels, ready

__all__ = ["SHELF", "given", "in_shares", "kernel", "prepare_kernels", "ready", "rubbed_steps"]
