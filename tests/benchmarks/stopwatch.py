"""What the benchmarks of the engine share: a median of processor time, and a row of their table."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

MOST = 200  # calls


def median(work: Callable[[], object], patience: float = 1.0, least: int = 1) -> float:
    """Median processor seconds of a call (one thread, so a busy machine hardly counts).

    `least` calls and more until `patience` seconds have passed, at most MOST.
    """
    times: list[float] = []
    while len(times) < least or sum(times) < patience:
        began = time.process_time()
        work()
        times.append(time.process_time() - began)
        if len(times) >= MOST:
            break
    return statistics.median(times)


def row(name: str, seconds: float, against: float | None = None, gate: float | None = None) -> None:
    """One line of the table."""
    ratio = "" if against is None else f"{against / seconds:9.1f}×"
    verdict = ""
    if against is not None and gate is not None:
        verdict = f"  gate {gate:g}× {'met' if against >= gate * seconds else 'MISSED'}"
    print(f"{name:56s} {seconds * 1e3:12.3f} ms {ratio}{verdict}", flush=True)
