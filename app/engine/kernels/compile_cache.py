"""Compile the kernels in the background, once for each machine and version, and cache them.

A kernel is a plain function of arrays and numbers. Numba, where it is installed, compiles it for one signature (float64 or complex128,
C-contiguous, writable) and keeps the result in the user's cache; until then, or without Numba, `compiled_kernel` says None and the
caller goes its plain way, which gives the same to rounding.
"""

from __future__ import annotations

import hashlib
import importlib.util
import logging
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from . import (
    bounds,
    clipped,
    decoupling_search,
    delayed,
    filter_bank,
    friction,
    geared,
    intermittent,
    limit_crossings,
    recursion,
    sampled,
    scan,
    small_matrices,
    spectra,
    tape,
)

__all__ = ["COMPILE_CACHE", "CompileCache", "as_kernel_array", "compiled_kernel", "kernels_off", "kernels_ready", "prepare_kernels",
           "user_cache"]

log = logging.getLogger(__name__)
Kernel = Callable[..., int]
_1, _2, _3, _4, _5 = ("f8[" + ":," * d + "::1]" for d in range(5))
_C3 = "c16[:,:,::1]"
GROUPS: Mapping[type, str] = MappingProxyType(  # the types of the fields of each group of arguments
    {
        tape.Tape: f"i8[:,::1],{_1},i8[::1]",
        recursion.Target: f"{_2},{_2},i8",
        recursion.Schedule: f"{_3},{_3},{_3},{_3}",
        geared.GearPath: f"{_2},i8[::1],{_2},{_2}",
        geared.Rounding: f"{_2},{_2},f8",
        geared.Clipping: f"{_2},{_2},{_1},{_1},{_1}",
        geared.Play: f"{_1},{_1},{_1},i8[::1],f8",
        delayed.LateInput: f"{_2},{_2},f8,i8",
        delayed.Reading: f"{_2},{_2},{_1},{_1}",
        friction.Actuators: f"{_2},{_2},{_2},f8",
        friction.Rubbing: f"{_2},{_2},{_2},f8,i8,f8",
    }
)
SIGNATURES: Mapping[Kernel, tuple[str | type, ...]] = MappingProxyType(  # the arguments in turn: types, or a group of them
    {
        recursion.mean_steps: (f"{_2},{_2},{_3},{_1},{_2},{_2},{_2},{_2},{_2}",),
        recursion.joseph_steps: (f"{_2},{_2},{_2},{_2},{_2},b1[:,::1]", recursion.Target, recursion.Schedule),
        recursion.root_steps: (f"{_2},{_2},{_2},{_2},{_2},{_2},b1[:,::1]", recursion.Target, recursion.Schedule),
        clipped.march: (
            f"{_2},i8[::1],i8,{_3},{_2},{_2},{_1},i8[::1],b1[::1],i8[::1],{_2},{_2},{_3},i8[:,::1],{_4},{_3},{_3},{_3},{_1},f8,i8,i8",
        ),
        geared.contact_steps: (geared.GearPath, f"{_3},{_2}", geared.Rounding, geared.Clipping, geared.Play, "i8,f8,i8,i8"),
        sampled.sampled_steps: (f"{_2},{_3},{_2},{_2},f8,b1,{_3},{_1},i8,i8",),
        delayed.delayed_steps: (_2, delayed.LateInput, f"{_2},{_2},{_2}", delayed.Reading, "f8,i8,i8"),
        scan.scan_steps: (f"{_2},{_2},{_2}",),
        friction.friction_steps: (f"{_2},{_2},{_2},{_2}", friction.Actuators, friction.Rubbing, "f8"),
        spectra.density_steps: (f"{_C3},{_C3},{_C3},{_2},{_2}",),
        decoupling_search.decoupling_search_steps: (f"{_2},{_2},f8,{_2},f8,f8,i8",),
        intermittent.lossy_covariance_steps: (f"{_2},{_2},{_2},{_2},{_2},{_1},{_3}",),
        filter_bank.filter_bank_steps: (
            tape.Tape,
            tape.Tape,
            f"{_1},{_2},{_2},{_1},{_2},{_2},{_1},{_1},{_3},{_3},{_2},{_2},{_1},{_2},{_2},{_3},{_3},{_2},{_3},i8[::1],f8",
            f"{_3},{_4},{_3},{_5},{_4},b1[:,:,::1],{_3},{_3},{_3},{_4},{_3},{_5},{_4},{_3},{_5},{_3},{_5}",
        ),
        bounds.slope_steps: (tape.Tape, tape.Tape, f"f8,i8,{_2},{_2},{_3},{_3}"),
        bounds.bound_steps: (f"{_2},{_3},{_2},{_3},{_3},{_3}",),
        bounds.square_steps: (f"{_2},{_3},{_1}",),
    }
)
KERNELS = (
    small_matrices.triangle,
    small_matrices.times,
    small_matrices.product,
    small_matrices.put,
    small_matrices.turn,
    small_matrices.symmetrise,
    small_matrices.factor,
    small_matrices.solve_upper,
    small_matrices.solve_both,
    recursion.there,
    recursion.stacked,
    clipped.length2,
    clipped.mode_at,
    clipped.slack_of,
    clipped.stays,
    clipped.careful,
    clipped.blurred,
    limit_crossings.piece,
    limit_crossings.first_exit,
    geared.holds,
    spectra.divided,
    tape.run_lanes,
    tape.flow_lanes,
    filter_bank.straight,
    filter_bank.drawn,
    filter_bank.centre,
    filter_bank.spread,
    filter_bank.gained,
    filter_bank.joseph_form,
    filter_bank.told,
    bounds.corrected,
    decoupling_search.index_at,
)
OPTIONS: Mapping[str, Any] = MappingProxyType({"nogil": True, "error_model": "numpy", "fastmath": {"contract"}})
KERNELS_VARIABLE = "OBSERVER_LAB_KERNELS"  # "off" in the environment: the plain ways only
DONE = "complete"  # a file in the cache that says that all kernels are in it
LOCK = "lock"  # a file in the cache that one process at a time holds, to compile


class CompileCache:
    """The kernels compiled so far in this process. What stands on it changes how fast an answer comes, never the answer."""

    def __init__(self) -> None:
        self.made: dict[Kernel, Kernel] = {}
        self.lock = threading.Lock()

    def fill(self) -> bool:
        """Compile all kernels, or take them from the user's cache, in this thread; False where Numba is not installed."""
        if importlib.util.find_spec("numba") is None:
            return False
        with self.lock:
            if len(self.made) < len(SIGNATURES):
                self.made = _compiled()
        return True

    @contextmanager
    def holding(self, made: Mapping[Kernel, Kernel]) -> Iterator[None]:
        """Other forms of the kernels for as long as this lasts, in every thread: none, or the plain functions themselves.

        >>> with COMPILE_CACHE.holding({}):
        ...     compiled_kernel(clipped.march) is None
        True
        """
        made, self.made = self.made, dict(made)
        try:
            yield
        finally:
            self.made = made


COMPILE_CACHE = CompileCache()


def compiled_kernel(function: Kernel) -> Kernel | None:
    """The compiled form of a kernel if it is ready, else None."""
    return COMPILE_CACHE.made.get(function)


def kernels_off() -> bool:
    """Whether the environment asks for the plain ways only."""
    return os.environ.get(KERNELS_VARIABLE) == "off"


def kernels_ready() -> bool:
    """Whether the kernels are compiled, so that runs by the thousand come at once."""
    return bool(COMPILE_CACHE.made)


def as_kernel_array(array: np.ndarray, *, kind: type = float) -> np.ndarray:
    """An array as the signatures want it: float64 (or complex128), C-contiguous, writable; itself if it is so, else a copy."""
    return np.require(array, kind, ["C", "W"])


def prepare_kernels() -> threading.Thread:
    """Compile the kernels in the background, unless OBSERVER_LAB_KERNELS is "off"; the thread that sees to it.

    What is not yet in the user's cache is compiled by a process of its own, at low priority, so that this one stays free
    to answer.
    """
    thread = threading.Thread(target=_prepare, name="kernels", daemon=True)
    thread.start()
    return thread


def _prepare() -> None:
    if kernels_off() or importlib.util.find_spec("numba") is None:
        return
    try:
        folder = cache_folder()
        if folder is not None and not (folder / DONE).exists():
            with _alone(folder):
                if not (folder / DONE).exists():
                    _compile_beside()
        COMPILE_CACHE.fill()
    except Exception as problem:  # whatever a compiler of another version may say: all goes on the plain way
        log.warning("no kernels, so that some runs take longer: %s", problem)


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """While this lasts no other process of this machine compiles into that folder; they wait. Where nothing can be locked all go on."""
    with ExitStack() as held:
        with suppress(ImportError, OSError):  # Windows; a full disk, a network's folder
            import fcntl

            fcntl.flock(held.enter_context((folder / LOCK).open("w")), fcntl.LOCK_EX)
        yield


def _compile_beside() -> None:
    subprocess.run([sys.executable, "-P", "-m", "observer_lab.engine.kernels"], check=False,
                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def user_cache() -> Path:
    """The folder in which this system keeps what the lab can compute anew; it may not be there yet."""
    if sys.platform == "win32":
        home = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        home = Path.home() / "Library" / "Caches"
    else:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return home / "observer-lab"


def cache_folder() -> Path | None:
    """Where compiled kernels of these very files are kept, made if it is not there; None where nothing can be kept.

    Another copy of the lab, another Numba or a file written anew has a folder of its own: Numba takes nothing from the cache then.
    """
    here = Path(__file__).resolve().parent
    mark = hashlib.sha256(os.fsencode(here) + version("numba").encode())
    for source in sorted(here.glob("*.py")):
        mark.update(os.fsencode(source.name) + str(source.stat().st_mtime_ns).encode() + source.read_bytes())
    folder = user_cache() / f"kernels-{mark.hexdigest()[:16]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None


def _signature(arguments: tuple[str | type, ...]) -> Any:
    """What Numba compiles a kernel for: a whole number from these types, a group of them as its named tuple."""
    from numba import types
    from numba.core.sigutils import normalize_signature

    found: list[Any] = []
    for each in arguments:
        named, _ = normalize_signature(f"i8({each if isinstance(each, str) else GROUPS[each]})")
        found += named if isinstance(each, str) else [types.BaseTuple.from_types(named, each)]
    return types.int64(*found)


def _compiled() -> dict[Kernel, Kernel]:
    from numba import njit
    from numba.core import config as settings
    from numba.extending import register_jitable

    folder, made = cache_folder(), dict[Kernel, Kernel]()
    for part in KERNELS:
        register_jitable(**OPTIONS)(part)
    set_at = settings.__dict__
    before, set_at["CACHE_DIR"] = set_at["CACHE_DIR"], "" if folder is None else str(folder)
    try:
        for function, signature in SIGNATURES.items():
            compiler: Any = njit(_signature(signature), cache=folder is not None, **OPTIONS)
            made[function] = compiler(function)
    finally:
        set_at["CACHE_DIR"] = before
    if folder is not None:
        (folder / DONE).touch()
    return made
