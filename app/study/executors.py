"""Run a study in this process, in several processes, or on a Dask scheduler.

Each executor takes chunks of runs and yields their rows as they come, in any order.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import islice
from typing import Any

from .plan import Row, Study, StudyError, programs
from .points import run_chunk

LARGEST_CHUNK = 50  # runs that a kill may cost, for each worker
CHUNKS_PER_WORKER = 3  # chunks for each worker that are handed out at once
CONNECT_TIMEOUT_S = 20  # s for a scheduler to answer
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
INSTALL = "Workers behind a scheduler are reached by Dask, which is not installed; python -m pip install 'observer-lab[study]' brings it."

Part = tuple[int, ...]  # numbers of runs


def parts_of(missing: Sequence[int], workers: int) -> list[Part]:
    """The runs in chunks: small enough that all workers end at about the same time."""
    size = min(max(len(missing) // (8 * workers), 1), LARGEST_CHUNK)
    return [tuple(missing[k:k + size]) for k in range(0, len(missing), size)]


def cores() -> int:
    """How many processes can work at once."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


# --- this machine --------------------------------------------------------------------------------------------------------
def in_process(study: Study, missing: Sequence[int]) -> Iterator[list[Row]]:
    """One chunk after another, here."""
    for part in parts_of(missing, 1):
        yield run_chunk(study, part)[1]


def on_processes(study: Study, missing: Sequence[int], workers: int) -> Iterator[list[Row]]:
    """On processes of their own, each with one thread. Raises StudyError where one of them dies."""
    for name in THREADS:
        os.environ[name] = "1"  # what a new process reads before numpy is loaded
    parts = iter(parts_of(missing, workers))
    others = multiprocessing.active_children()
    pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), initializer=settle)
    waiting: set[Future[Any]] = set()
    try:
        while True:
            waiting |= {pool.submit(run_chunk, study, part) for part in islice(parts, CHUNKS_PER_WORKER * workers - len(waiting))}
            if not waiting:
                return
            done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()[1]
    except BrokenProcessPool as problem:
        raise StudyError("A worker process has died, perhaps for want of memory; try fewer with --workers.") from problem
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            if process in others:
                continue
            if waiting:  # somebody has stopped us: what is not written down will be computed again
                process.terminate()
            process.join()


def settle() -> None:
    """Make a worker leave Ctrl-C to its parent, and leave when the parent has gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def leave() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)
    threading.Thread(target=leave, daemon=True).start()


# --- other machines --------------------------------------------------------------------------------------------------------
def on_dask(study: Study, missing: Sequence[int], address: str) -> Iterator[list[Row]]:
    """On the workers of a Dask scheduler, which must have this very version of the lab. Raises StudyError."""
    try:
        from distributed import Client, as_completed  # type: ignore[import-not-found]
    except ImportError as problem:
        raise StudyError(INSTALL) from problem
    try:
        client = Client(address, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as problem:
        raise StudyError(f"No Dask scheduler answers at {address[:80]}; give an address such as tcp://127.0.0.1:8786.") from problem
    try:
        workers = sum(client.nthreads().values())
        if not workers:
            raise StudyError(f"The scheduler at {address[:80]} has no workers; start some with dask worker {address[:80]}.")
        parts = iter(parts_of(missing, workers))
        going = as_completed([client.submit(run_chunk, study, part, pure=False) for part in islice(parts, CHUNKS_PER_WORKER * workers)],
                             loop=client.loop)
        for future in going:
            made_by, rows = future.result()
            if made_by != programs():
                raise StudyError(f"A worker has other versions ({_listed(made_by)}) than this machine ({_listed(programs())}), so "
                                 "that the last digits would differ; install the same everywhere.")
            part = next(parts, None)
            if part is not None:
                going.add(client.submit(run_chunk, study, part, pure=False))
            yield rows
    except (StudyError, GeneratorExit, KeyboardInterrupt):
        raise
    except Exception as problem:  # a scheduler that has gone, workers without the lab: each raises what it likes
        why = " ".join(f"{type(problem).__name__}: {problem}".split())[:160]
        raise StudyError(f"The workers at {address[:80]} have failed ({why}); see that each has Observer Lab installed, and go on "
                         "with the same command.") from problem
    finally:
        client.close()


def _listed(versions: dict[str, str]) -> str:
    return ", ".join(f"{name} {number}" for name, number in versions.items())
