"""What the benchmarks beside peers share: a median, and a row of their table."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

MOST = 200  # calls


@dataclass(frozen=True)
class Row:
    """Some work: seconds of ours and of the peer, the ratio wanted (or `bound`, the seconds), what both say against a reference."""

    work: str
    ours: float
    peer: str = ""
    theirs: float = float("nan")
    goal: float | None = None
    bound: float | None = None
    said: str = ""
    limit: str = ""  # what a profile shows to stand in the way of the goal

    @property
    def met(self) -> bool | None:
        """Whether the goal is met, None where there is none."""
        if self.bound is not None:
            return self.ours <= self.bound
        return None if self.goal is None else self.theirs >= self.goal * self.ours

    def markdown(self) -> str:
        """The row of the table."""
        ratio = f"{self.theirs / self.ours:.3g}×" if self.theirs == self.theirs else "–"
        peer = f"{self.peer} {1e3 * self.theirs:.3g}" if self.theirs == self.theirs else self.peer or "–"
        goal = f"≤ {1e3 * self.bound:g} ms" if self.bound is not None else "–" if self.goal is None else f"{self.goal:g}×"
        met = {None: "", True: " met", False: " **missed**"}[self.met]
        return f"| {self.work} | {1e3 * self.ours:.3g} | {peer} | {ratio} | {goal}{met} | {self.said} |"


HEAD = "| work | ours [ms] | peer [ms] | ratio | goal | against a reference |\n|---|---|---|---|---|---|"


def median(work: Callable[..., object], patience: float = 0.6, least: int = 3, *, wall: bool = False,
           each: Callable[[int], object] | None = None) -> float:
    """Median seconds of a call, after one to warm up: of the processor (one thread, so a busy machine hardly counts), or by the wall.

    `least` calls and more until `patience` seconds have passed, at most MOST. `each`: makes the argument of call k, outside the time;
    with a new one in each call no answer can be kept from the call before.
    """
    clock = time.perf_counter if wall else time.process_time
    times: list[float] = []
    spent = -1 if least > 1 else 0
    while len(times) < least or sum(times) < patience:
        given = () if each is None else (each(spent + 1),)
        began = clock()
        work(*given)
        if spent >= 0:
            times.append(clock() - began)
        spent += 1
        if len(times) >= MOST:
            break
    return statistics.median(times)
