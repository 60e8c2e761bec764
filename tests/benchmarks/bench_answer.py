"""What the app itself adds to a drag: from a browser's message to the answer on the socket, without a browser.

    python tests/benchmarks/bench_answer.py [--moves 60] [--lesson separation]

A protocol client on loopback moves a slider; timed until the first new plot data and until the last scene message.
"""

# ruff: noqa: E402 — the folders of the app and of the wire tests must be found first

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).parents[2]), str(Path(__file__).parents[1]), str(Path(__file__).parents[1] / "wire")]

from client import WireTab  # type: ignore[import-not-found]

from observer_lab.course.knobs import Number
from observer_lab.lessons import LESSONS, OPENING
from observer_lab.page.column.knob_widgets import label_of
from observer_lab.page.screen.server import LabServer

PATIENCE = 0.25  # s to listen after each move


def measure(tab: WireTab, label: str, values: np.ndarray) -> tuple[list[float], list[float]]:
    """Milliseconds to the first plot data and to the last scene message, for every value."""
    uuid, plots, scene = tab.find(label), [], []
    for value in values:
        start = time.perf_counter()
        tab.send("GuiUpdateMessage", uuid=uuid, updates={"value": float(value)})
        first = last = None
        while time.perf_counter() - start < PATIENCE:
            seen = len(tab.messages)
            tab._receive(0.005)
            now = 1000 * (time.perf_counter() - start)
            for message in tab.messages[seen:]:
                if message["type"] == "GuiUpdateMessage" and "data" in message["updates"]:
                    first = now if first is None else first
                elif not message["type"].startswith(("Gui", "Run")):
                    last = now
        plots += [] if first is None else [first]
        scene += [] if last is None else [last]
    return plots, scene


def main() -> None:
    """Measure and print one table."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--moves", type=int, default=60)
    options.add_argument("--lesson", default=OPENING, choices=list(LESSONS))
    asked = options.parse_args()
    lesson = LESSONS[asked.lesson]
    knob = next(k for k in lesson.knobs if isinstance(k, Number) and k.scale == "linear" and lesson.shown(k, lesson.start()))
    server = LabServer(LESSONS, port=0, lesson=asked.lesson)
    try:
        with WireTab(server.url) as tab:
            label = label_of(knob, "en")
            tab.until(lambda: tab.has(label), "the lesson", 30)
            tab.press("skip")
            tab.until(lambda: "Play or pause" in tab.commands, "its commands", 30)
            tab.command("Play or pause")  # a moment that a person has chosen stays: what comes is the answer, no loop
            tab.settle()
            walk = knob.low + (knob.high - knob.low) * (0.5 + 0.4 * np.sin(np.arange(asked.moves)))
            plots, scene = measure(tab, label, walk)
    finally:
        server.stop()
    print(f"\n{asked.lesson}: {knob.name} moved {asked.moves} times\n")
    print("| message in → message out | median [ms] | p95 [ms] |\n|---|---|---|")
    for name, times in (("first plot data", plots), ("last scene message", scene)):
        if times:
            print(f"| {name} | {np.median(times):.0f} | {np.percentile(times, 95):.0f} |")


if __name__ == "__main__":
    main()
