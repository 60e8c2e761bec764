"""Compile the kernels in the background, once for each machine and version, and cache them.

A kernel is a plain function of arrays and numbers. Numba, where it is installed, compiles it for one signature (float64, C-contiguous,
writable) and keeps the result in the user's cache; until then, or without Numba, `compiled_kernel` says None and the
caller goes its plain way, which gives the same to rounding.
"""

from __future__ import annotations

import hashlib
import importlib.util
import logging
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from types import FunctionType, MappingProxyType
from typing import Any

import numpy as np

from . import clipped, geared, limit_crossings, recursion, sampled, small_matrices

__all__ = ["COMPILE_CACHE", "CompileCache", "as_kernel_array", "compiled_kernel", "kernels_off", "kernels_ready", "prepare_kernels",
           "user_cache"]

log = logging.getLogger(__name__)
Kernel = Callable[..., int]
_1, _2, _3, _4 = ("f8[" + ":," * d + "::1]" for d in range(4))
GROUPS: Mapping[type, str] = MappingProxyType(  # the types of the fields of each group of arguments
    {
        recursion.Target: f"{_2},{_2},i8",
        recursion.Schedule: f"{_3},{_3},{_3},{_3}",
        geared.GearPath: f"{_2},i8[::1],{_2},{_2}",
        geared.Rounding: f"{_2},{_2},f8",
        geared.Clipping: f"{_2},{_2},{_1},{_1},{_1}",
        geared.Play: f"{_1},{_1},{_1},i8[::1],f8",
        sampled.Actuators: f"{_2},{_2},{_2},f8",
        sampled.Rubbing: f"{_2},{_2},{_2},f8,i8,f8",
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
        sampled.friction_steps: (f"{_2},{_2},{_2},{_2}", sampled.Actuators, sampled.Rubbing, "f8"),
    }
)
MODULES = clipped, geared, limit_crossings, recursion, sampled, small_matrices  # their other functions are parts of the kernels
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


def as_kernel_array(array: np.ndarray) -> np.ndarray:
    """An array as the signatures want it: float64, C-contiguous, writable; itself if it is so, else a copy."""
    return np.require(array, float, ["C", "W"])


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
    """The folder of compiled kernels of files with these contents, made if it is not there; None where nothing can be kept.

    Another copy of the lab with the same kernels shares it. Another Numba or a changed kernel has a folder of its own.
    """
    mark = hashlib.sha256(version("numba").encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        mark.update(os.fsencode(source.name) + source.read_bytes())
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


def _at_home(function: Kernel, folder: Path | None) -> Kernel:
    """The same function with a copy of its file in `folder` for its place: Numba keeps compiled code by the place of its file."""
    if folder is None:
        return function
    assert isinstance(function, FunctionType)
    source = Path(function.__code__.co_filename)
    home = folder / source.name
    if not home.exists():
        shutil.copyfile(source, home)
    return FunctionType(function.__code__.replace(co_filename=str(home)), function.__globals__, function.__name__)


def _compiled() -> dict[Kernel, Kernel]:
    from numba import njit
    from numba.core import config as settings
    from numba.extending import register_jitable

    folder, made = cache_folder(), dict[Kernel, Kernel]()
    for module in MODULES:
        for part in vars(module).values():
            if isinstance(part, FunctionType) and part.__module__ == module.__name__ and part not in SIGNATURES:
                register_jitable(**OPTIONS)(part)
    set_at = settings.__dict__
    before, set_at["CACHE_DIR"] = set_at["CACHE_DIR"], "" if folder is None else str(folder)
    try:
        for function, signature in SIGNATURES.items():
            compiler: Any = njit(_signature(signature), cache=folder is not None, **OPTIONS)
            made[function] = compiler(_at_home(function, folder))
    finally:
        set_at["CACHE_DIR"] = before
    if folder is not None:
        (folder / DONE).touch()
    return made
