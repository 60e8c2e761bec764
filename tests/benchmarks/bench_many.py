"""Many tabs on one process or several: how soon each hand is answered while others play, open and rest.

    python tests/benchmarks/bench_many.py [--tabs 100] [--playing 30] [--dragging 10] [--seconds 10] [--workers 1]
        [--worker-timeout 90] [--scripts]

The server is a process of its own, or as many as there are workers and one, on loopback; the tabs are protocol clients in this
one, without a browser. They open one after another, rest, and then work at once: players play the run again and again; hands move
a slider 20 times a second, as often as a page lets them, whether the last move has been answered or not. While they work, two
more tabs open.

A picture is known by the data of its first chart, which one tab learns beforehand for every value that a hand may give; so
every answer is told from every other, and data that belong to no value of this tab's own, or come in another order, are
cross-talk. A move counts as answered when the first data of its own value or of a later one are there. Tabs say, as a page
does, that they move between poses by themselves; with `--scripts` they do not, and are sent every pose.
"""

# ruff: noqa: E402 — the folders of the app and of the protocol client must be found first

from __future__ import annotations

import argparse
import asyncio
import json
import os
import re
import statistics
import subprocess
import sys
import time
import urllib.request
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol

HERE = Path(__file__).parents[2]
sys.path[:0] = [str(HERE), str(HERE / "tests"), str(HERE / "tests" / "wire")]

from client import PATIENCE, WirePage, unpack  # type: ignore[import-not-found]

KNOB = "stiffness error in the model [%]"
EVERY = 0.05  # s between two moves of a hand
MOST_VALUES = 600  # a hand that has given them all begins again: half a minute later, so that no answer is taken for a later one
APART = 37  # values from where one hand begins to where the next does
LATER = 2  # tabs that open while the others work
MOVES = ("SetPositionMessage", "SetOrientationMessage")
TICK = os.sysconf("SC_CLK_TCK")
PLAYED = re.compile(r'"times": \[([^]]+)]')  # what a page is told to play by itself


class Tab(WirePage):  # type: ignore[misc]
    """A tab whose messages are read as they come."""

    def __init__(self, socket: ClientConnection, scripts: bool) -> None:
        super().__init__(plays=not scripts)
        self._socket = socket
        self._sending: set[asyncio.Future[None]] = set()
        self.batches = self.messages = self.poses = 0
        self.chart: str | None = None
        self.seen: list[tuple[float, int]] = []  # when data of the first chart came, and which
        self._questions = 0
        self.look()

    def send_raw(self, data: bytes | str) -> None:
        """Send anything at all."""
        sending = asyncio.ensure_future(self._socket.send(data))
        self._sending.add(sending)
        sending.add_done_callback(self._sending.discard)

    async def listen(self) -> None:
        """Take whatever comes until the connection is closed."""
        async for data in self._socket:
            messages, arrays = unpack(data)  # type: ignore[arg-type]
            moved = 0
            for message in messages:
                kind = message["type"]
                if kind in MOVES:
                    moved = 1
                elif kind == "RunJavascriptMessage" and message["source"].startswith("// play.js"):
                    moved += sum(times.count(",") + 1 for times in PLAYED.findall(message["source"]))
                elif kind == "GuiUplotMessage" and self.chart is None:
                    self.chart = message["uuid"]
                elif kind == "GuiUpdateMessage" and message["uuid"] == self.chart and "data" in message["updates"]:
                    self.seen.append((time.monotonic(), _fingerprint(message, arrays)))
                self.take(message)
            self.poses += moved
            self.batches += 1
            self.messages += len(messages)

    async def until(self, condition: Any, patience: float = PATIENCE) -> None:
        """Wait for something to come."""
        end = time.monotonic() + patience
        while not condition():
            assert time.monotonic() < end, f"it never came; last notes: {self.notes[-3:]}"
            await asyncio.sleep(0.005)

    async def answered(self, rests: bool = False) -> None:
        """Wait until all is answered, and the knobs rest if that is asked."""
        self._questions += 1
        asked = None
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            seen = self.mark()
            if seen is not None:
                if seen[0] != asked:
                    asked = seen[0]
                    self.send("GuiUpdateMessage", uuid=asked, updates={"value": self._questions})
                if seen[1] >= self._questions and (seen[2] or not rests):
                    return
            await asyncio.sleep(0.005)
        raise AssertionError("no answer to everything")


def _fingerprint(message: dict[str, Any], arrays: list[bytes]) -> int:
    """A number that tells a chart's data from all others."""
    return hash(b"".join(arrays[part["__binary_index"]] for part in message["updates"]["data"]))


@dataclass
class Hand:
    """A tab whose slider is dragged: when which of the `values` was sent, by its place among them."""

    tab: Tab
    start: int
    sent: list[float] = field(default_factory=list)

    async def drag(self, values: list[float], until: float) -> None:
        """Move on every EVERY seconds; a hand waits for nothing."""
        uuid, due = self.tab.find(KNOB), time.monotonic()
        while due < until:
            await asyncio.sleep(max(0.0, due - time.monotonic()))
            self.sent.append(time.monotonic())
            self.tab.widgets[uuid]["value"] = self.value(values, -1)  # what is moved shows it at once
            self.tab.send("GuiUpdateMessage", uuid=uuid, updates={"value": self.value(values, -1)})
            due = max(due + EVERY, time.monotonic() - EVERY)

    def value(self, values: list[float], which: int) -> float:
        """The value of the move of that number, -1 for the last."""
        return values[(self.start + (len(self.sent) + which if which < 0 else which)) % len(values)]

    def judge(self, known: dict[int, int], count: int) -> tuple[list[float], list[str]]:
        """How long after each move the first data of it or of a later one came, inf for never; and what was wrong with data not its."""
        waits, last, strange = [float("inf")] * len(self.sent), -1, list[str]()
        for came, seen in self.tab.seen:
            move = -1 if seen not in known else max(last, 0) + (known[seen] - self.start - max(last, 0)) % count
            if not last <= move < len(self.sent) or came < self.sent[move]:
                strange.append("of no known value" if seen not in known else f"of move {move} after {last}" if move < last else
                               f"of move {move}, of {len(self.sent)}" if move >= len(self.sent) else
                               f"{1e3 * (self.sent[move] - came):.1f} ms before its move")
                continue
            for k in range(last + 1, move + 1):
                waits[k] = came - self.sent[k]
            last = max(last, move)
        return waits, strange


class Server:
    """`observer-lab serve` on a free port, and what the operating system says of it."""

    def __init__(self, most: int, workers: int, timeout: int) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "observer_lab", "serve", "--port", "0", "--max-sessions", str(2 * most), "--workers", str(workers),
             "--worker-timeout", str(timeout), "--view", "lab"],
            cwd=HERE, text=True, stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": str(HERE), "OBSERVER_LAB_KERNELS": "off", "PYTHONUNBUFFERED": "1"})
        assert self._process.stdout is not None
        found = None
        while found is None:
            line = self._process.stdout.readline()
            assert line, "the server did not start"
            found = re.search(r"http://[\d.]+:\d+", line)
        self.url = found[0]

    def replaced(self) -> int:
        """How many workers had to be started again."""
        with urllib.request.urlopen(f"{self.url}/health", timeout=20) as answer:
            return sum(worker["starts"] - 1 for worker in json.load(answer).get("workers", []))

    def stop(self) -> None:
        """End it."""
        self._process.terminate()
        self._process.wait(20)

    def _processes(self) -> list[Path]:
        """Its process and those that it has started."""
        mine = Path(f"/proc/{self._process.pid}")
        children = (mine / "task" / mine.name / "children").read_text(encoding="ascii").split()
        return [mine, *(Path(f"/proc/{child}") for child in children)]

    def megabytes(self) -> float:
        """Memory that it holds now, what processes share counted once."""
        texts = [(process / "smaps_rollup").read_text(encoding="ascii") for process in self._processes()]
        return sum(int(re.findall(r"\nPss:\s+(\d+)", text)[0]) for text in texts) / 1024

    def busy(self) -> dict[str, float]:
        """Seconds of the processor that each of its threads has used."""
        found = {}
        for task in (task for process in self._processes() for task in (process / "task").iterdir()):
            values = (task / "stat").read_text(encoding="ascii").rpartition(")")[2].split()
            found[task.name] = (int(values[11]) + int(values[12])) / TICK
        return found


async def enter(url: str, scripts: bool, listeners: list[asyncio.Task[None]]) -> tuple[Tab, float]:
    """A tab, and the seconds until its first complete picture stood and a question was answered."""
    began, place = time.monotonic(), urlsplit(url).netloc
    socket = await connect(f"ws://{place}", subprotocols=[Subprotocol(f"viser-v{version('viser')}")], compression=None,
                           max_size=None, open_timeout=PATIENCE, ping_interval=None)
    tab = Tab(socket, scripts)
    listeners.append(asyncio.create_task(tab.listen()))
    await tab.answered()
    return tab, time.monotonic() - began


async def learn(tab: Tab, values: list[float]) -> dict[int, int]:
    """Which data belong to which value: one after another, each answered."""
    known: dict[int, int] = {}
    uuid = tab.find(KNOB)
    for k, value in enumerate(values):
        tab.seen.clear()
        tab.send("GuiUpdateMessage", uuid=uuid, updates={"value": value})
        await tab.until(lambda: tab.seen)
        known[tab.seen[0][1]] = k
    await tab.answered(rests=True)
    return known


async def play(tab: Tab, until: float) -> None:
    """Press play whenever the run stands."""
    while time.monotonic() < until:
        if tab.offers("▶ play"):
            tab.press("▶ play")
            await tab.answered()
        await asyncio.sleep(0.1)


def share(values: list[float], part: float) -> float:
    """The value below which that part of all lie."""
    return sorted(values)[min(int(part * len(values)), len(values) - 1)] if values else float("nan")


async def measure(server: Server, tabs: int, playing: int, dragging: int, seconds: float, scripts: bool) -> list[tuple[str, str]]:
    """The rows of the table."""
    listeners: list[asyncio.Task[None]] = []
    count = min(int(seconds / EVERY), MOST_VALUES) + 2 * APART
    values = [round(-29.0 + 58.0 * k / count, 3) for k in range(count)]
    teacher, first = await enter(server.url, scripts, listeners)
    known = await learn(teacher, values)
    before = server.megabytes()
    entered = [await enter(server.url, scripts, listeners) for _ in range(tabs - 1)]
    everyone, opening = [teacher, *(tab for tab, _ in entered)], [took for _, took in entered]
    for tab in everyone:
        await tab.answered(rests=True)
    each = (server.megabytes() - before) / max(tabs - 1, 1)

    # at rest
    await asyncio.sleep(1.0)
    idle, heard, began = server.busy(), sum(tab.messages for tab in everyone), time.monotonic()
    await asyncio.sleep(3.0)
    rest = time.monotonic() - began
    still, unasked = server.busy(), sum(tab.messages for tab in everyone) - heard
    used = [(still[name] - idle.get(name, 0.0)) / rest for name in still]

    # at work
    players = everyone[:playing]
    hands = [Hand(tab, APART * k % count) for k, tab in enumerate(everyone[playing:playing + dragging])]
    workers = [*players, *(hand.tab for hand in hands)]
    for tab in workers:
        tab.press("skip")
    for tab in workers:
        await tab.answered(rests=True)
    for tab in workers:
        tab.seen.clear()
    poses, silent = [tab.poses for tab in players], sum(tab.messages for tab in everyone[playing + dragging:])
    busy, began = server.busy(), time.monotonic()
    end = began + seconds
    late: list[float] = []

    async def come_later() -> None:
        for _ in range(LATER):
            await asyncio.sleep(seconds / (LATER + 1))
            late.append((await enter(server.url, scripts, listeners))[1])
    await asyncio.gather(*(play(tab, end) for tab in players), *(hand.drag(values, end) for hand in hands),
                         *([come_later()] if workers else []))
    worked = time.monotonic() - began
    after = server.busy()
    load = sum(after[name] - busy.get(name, 0.0) for name in after) / worked
    frames = [(tab.poses - had) / worked for tab, had in zip(players, poses, strict=True)]
    others = sum(tab.messages for tab in everyone[playing + dragging:]) - silent
    for hand in hands:
        await hand.tab.answered(rests=True)
    judged = [hand.judge(known, count) for hand in hands]
    waits = [wait for each_wait, _ in judged for wait in each_wait]
    lost = sum(known.get(hand.tab.seen[-1][1] if hand.tab.seen else 0, -1) != (hand.start + len(hand.sent) - 1) % count
               or abs(hand.tab.value(KNOB) - hand.value(values, -1)) > 1e-6 for hand in hands)
    for task in listeners:
        task.cancel()
    ms = [1e3 * wait for wait in waits]
    strange = sum(len(wrong) for _, wrong in judged)
    if dragging and all(wait == float("inf") for wait in ms):
        sys.exit("Nothing was measured: no move of a hand was answered.")
    if playing and not sum(frames):
        sys.exit("Nothing was measured: no player has seen a pose.")
    if lost or strange:
        said = ", ".join([what for _, wrong in judged for what in wrong][:3])
        sys.exit(f"The run does not count: {lost} final values are lost, {strange} data are of others ({said}).")
    return [
        ("tabs (playing + dragging)", f"{tabs} ({playing} + {dragging})"),
        ("move of a hand → data of the first chart, median / p95", f"{share(ms, 0.5):.0f} / {share(ms, 0.95):.0f} ms"),
        ("moves; unanswered; final values lost; data of others",
         f"{len(ms)}; {ms.count(float('inf'))}; {lost}; {strange}"),
        ("poses that a player sees in a second, median / least", f"{statistics.median(frames):.1f} / {min(frames):.1f}" if frames else "–"),
        ("opening: the first; one after another, median / p95", f"{first:.2f} s; {share(opening, 0.5):.2f} / {share(opening, 0.95):.2f} s"),
        ("opening while others work", ", ".join(f"{took:.2f}" for took in late) + " s" if late else "–"),
        ("memory of a tab at rest", f"{each:.1f} MB"),
        ("messages in a second to all tabs at rest", f"{unasked / rest:.2g}"),
        ("messages to tabs at rest while others work", f"{others}"),
        ("threads; processor at rest, all / the busiest thread", f"{len(still)}; {100 * sum(used):.1f} / {100 * max(used):.1f} %"),
        ("processor at work", f"{100 * load:.0f} %"),
    ]


def main() -> None:
    """Run the benchmark and print its table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    for name, usual in (("--tabs", 100), ("--playing", 30), ("--dragging", 10), ("--workers", 1),
                        ("--worker-timeout", 90)):
        parser.add_argument(name, type=int, default=usual)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--scripts", action="store_true", help="the tabs are scripts, which are sent every pose")
    asked = parser.parse_args()
    if asked.playing + asked.dragging > asked.tabs:
        parser.error("more tabs work than there are")
    server = Server(asked.tabs + LATER, asked.workers, asked.worker_timeout)
    try:
        rows = asyncio.run(measure(server, asked.tabs, asked.playing, asked.dragging, asked.seconds, asked.scripts))
        rows.append(("workers started again", str(server.replaced())))
    finally:
        server.stop()
    print("| figure | value |\n|---|---|")
    for name, value in rows:
        print(f"| {name} | {value} |")


if __name__ == "__main__":
    main()
