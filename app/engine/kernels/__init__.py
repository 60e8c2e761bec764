"""Define recursions as plain functions of arrays that Numba compiles where installed.

Nothing here is needed for an answer: each has a plain way beside it, in the room that calls it.
"""

from .compile_cache import COMPILE_CACHE, as_kernel_array, compiled_kernel, kernels_off, kernels_ready, prepare_kernels, user_cache
from .sampled import Actuators, Rubbing, friction_steps
from .threads import run_in_threads

__all__ = [
    "COMPILE_CACHE",
    "Actuators",
    "Rubbing",
    "as_kernel_array",
    "compiled_kernel",
    "friction_steps",
    "kernels_off",
    "kernels_ready",
    "prepare_kernels",
    "run_in_threads",
    "user_cache",
]
