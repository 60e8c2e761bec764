"""A lecture with many followers: how soon each sees the presenter's knob, and how soon all votes are acknowledged.

    python tests/benchmarks/bench_room.py [--followers 100] [--moves 40] [--workers 2] [--redis]

The server is a process of its own with its workers, on loopback; presenter and followers are protocol clients in this one. A
move counts for a follower when the batch arrives whose card shows its value or a later one. All followers of one kind get the
same bytes, so each batch is read once. The price is the processor's time of the server's processes for each follower and move.

Each follower votes once, on its own connection and with its own ballot; the time runs from the first vote to the last
acknowledgement. In lesson kalman they vote once more while the presenter's page computes a run for each of them and shows the cloud.
`--redis` keeps the room in a Redis server of its own. The load of the machine is printed: the figures hold for a quiet one.
"""

# ruff: noqa: E402 — the folders of the app and of the protocol client must be found first

from __future__ import annotations

import argparse
import asyncio
import os
import re
import subprocess
import sys
import tempfile
import time
from contextlib import nullcontext
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import numpy as np
from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol

HERE = Path(__file__).parents[2]
sys.path[:0] = [str(HERE), str(HERE / "tests"), str(HERE / "tests" / "wire")]

from client import PATIENCE, WirePage, unpack  # type: ignore[import-not-found]
from redis_server import redis_serving  # type: ignore[import-not-found]

from observer_lab.classroom.kept_room import open_room
from observer_lab.course.scenes import Choose
from observer_lab.lessons import LESSONS

LESSON, NAME, KNOB = "duality", "sensor", "sensor turned by [°]"
CLOUD_LESSON = "kalman"
EVERY_S = 0.25  # s between two moves
TICK = os.sysconf("SC_CLK_TCK")
SHOWN = re.compile(r"<dd>(-?[\d.]+) °</dd>")
HAND, VOTE = re.compile(r'"hand": "([^"]+)"'), re.compile(r'data-room="vote:(\d+):0"')


class Tab(WirePage):  # type: ignore[misc]
    """A tab whose messages are read as they come."""

    def __init__(self, socket: ClientConnection) -> None:
        super().__init__(plays=True)
        self.socket, self.sources = socket, list[str]()

    def send_raw(self, data: bytes | str) -> None:
        self._sending = asyncio.ensure_future(self.socket.send(data))

    async def read(self, seen: Any = None) -> None:
        async for data in self.socket:
            if seen is not None:
                seen(data)
            for message in unpack(data)[0]:
                self.sources.append(message.get("source", ""))
                self.take(message)

    async def until(self, condition: Any) -> None:
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, "it never came"
            await asyncio.sleep(0.01)

    def part(self, opening: str) -> str:
        return next((str(w["props"]["content"]) for w in self.widgets.values()
                     if str(w["props"].get("content")).startswith(opening)), "")


async def enter(url: str, path: str = "", word: str = "") -> Tab:
    place = urlsplit(url)
    headers = [("Authorization", f"Bearer {word}")] if word else []
    socket = await connect(f"ws://{place.netloc}{path}", subprotocols=[Subprotocol(f"viser-v{version('viser')}")], max_size=None,
                           compression=None, additional_headers=headers, open_timeout=PATIENCE)
    tab = Tab(socket)
    tab.look()
    return tab


def seconds_of(process: int) -> float:
    """The processor's time of a process and its children so far."""
    family, total = [process], 0.0
    for each in family:
        children = Path(f"/proc/{each}/task/{each}/children").read_text(encoding="ascii").split()
        family += map(int, children)
        fields = Path(f"/proc/{each}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
        total += (int(fields[11]) + int(fields[12])) / TICK
    return total


class Watch:
    """When each follower got which value. The same bytes are read once."""

    def __init__(self) -> None:
        self.read: dict[bytes, tuple[float | None, list[dict[str, Any]]]] = {}

    def look(self, data: bytes) -> tuple[float | None, list[dict[str, Any]]]:
        """The value that a batch shows, and those of its messages that concern one follower."""
        if data not in self.read:
            messages = unpack(data)[0]
            found = [SHOWN.search(str(m.get("updates", {}).get("content", ""))) for m in messages]
            own = [m for m in messages if m["type"] in ("NotificationShowMessage", "RunJavascriptMessage")]
            self.read[data] = next((float(each[1]) for each in found if each), None), own
        return self.read[data]


class Follower:
    """One connection of a class: what it has seen, where it votes, and how many of its votes are acknowledged."""

    def __init__(self, tab: Tab, watch: Watch) -> None:
        self.tab, self._watch = tab, watch
        self.seen: list[tuple[float, float]] = []
        self.hand, self.batches, self.counted, self.told = "", 0, 0, 0.0

    async def read(self) -> None:
        async for data in self.tab.socket:
            now = time.perf_counter()
            self.batches += 1
            value, own = self._watch.look(data)
            if value is not None:
                self.seen.append((now, value))
            for message in own:
                if "// room.js" in message.get("source", "") and (found := HAND.search(message["source"])):
                    self.hand = found[1]
                if "is counted" in message.get("props", {}).get("body", ""):
                    self.counted, self.told = self.counted + 1, now

    def vote(self, number: str, option: int, ballot: str) -> None:
        self.tab.send("GuiUpdateMessage", uuid=self.hand, updates={"value": f"vote:{number}:{option}:{ballot}"})


class Lecture:
    """A presenter, one follower whose page is read whole, and the class."""

    def __init__(self, presenter: Tab, first: Tab, followers: list[Follower]) -> None:
        self.presenter, self.first, self.followers = presenter, first, followers

    def ask(self, value: str) -> None:
        hand = re.search(r'data-to="([^"]+)"', self.presenter.part('<div class="ol-head'))
        assert hand is not None
        self.presenter.send("GuiUpdateMessage", uuid=hand[1], updates={"value": value})

    async def open_scene(self, lesson: str, number: int) -> None:
        name = LESSONS[lesson].path[number].id
        self.ask(f"scene:{number}")
        for tab in (self.presenter, self.first):
            await tab.until(lambda tab=tab: f'data-scene="{name}"' in tab.part('<section class="ol-card'))

    async def vote(self, ballot: str) -> tuple[float, int]:
        """Seconds from the first vote of the class to its last acknowledgement, and how many never got one."""
        self.ask("vote:open")
        await self.first.until(lambda: VOTE.search(self.first.part('<section class="ol-card')))
        found = VOTE.search(self.first.part('<section class="ol-card'))
        assert found is not None
        before, begun = sum(each.counted for each in self.followers), time.perf_counter()
        for k, each in enumerate(self.followers):
            each.vote(found[1], k % 2, f"{ballot}{k:06d}")
        end = time.monotonic() + PATIENCE
        while (counted := sum(each.counted for each in self.followers) - before) < len(self.followers) and time.monotonic() < end:
            await asyncio.sleep(0.01)
        return max(each.told for each in self.followers) - begun, len(self.followers) - counted


def question_of(lesson: str) -> int:
    """The first scene of a lesson that asks for a prediction and shows none of its numbers before."""
    return next(k for k, each in enumerate(LESSONS[lesson].path) if isinstance(each.do, Choose))


async def measure(url: str, word: str, process: int, options: argparse.Namespace) -> dict[str, float]:
    presenter = await enter(url, word=word)
    tasks = [asyncio.ensure_future(presenter.read())]
    await presenter.until(lambda: presenter.part('<div class="ol-head'))
    first, watch = await enter(url), Watch()
    tasks.append(asyncio.ensure_future(first.read()))
    lecture = Lecture(presenter, first, [])
    await lecture.open_scene(LESSON, next(k for k, each in enumerate(LESSONS[LESSON].path) if NAME in each.knobs))
    for _ in range(options.followers):
        lecture.followers.append(Follower(await enter(url), watch))
        tasks.append(asyncio.ensure_future(lecture.followers[-1].read()))
    while not all(each.hand and each.batches >= 2 for each in lecture.followers):
        await asyncio.sleep(0.05)
    await asyncio.sleep(3.0)
    asked, before = [], seconds_of(process)
    for k in range(1, options.moves + 1):
        value = float(k % 2 * 40 + k % 37 + 1)
        asked.append((time.perf_counter(), value))
        presenter.send("GuiUpdateMessage", uuid=presenter.find(KNOB), updates={"value": value})
        await asyncio.sleep(EVERY_S)
    await asyncio.sleep(3.0)
    spent = seconds_of(process) - before
    waits, lost = waits_of(asked, lecture.followers)
    await lecture.open_scene(LESSON, question_of(LESSON))
    voted, unvoted = await lecture.vote("plain")
    lecture.ask("vote:close")
    lecture.ask(f"lesson:{CLOUD_LESSON}")
    await presenter.until(lambda: CLOUD_LESSON in str(presenter.kept) and "ol-seeds" in presenter.part('<section class="ol-seeds'))
    await lecture.open_scene(CLOUD_LESSON, question_of(CLOUD_LESSON))
    begun = time.perf_counter()
    lecture.ask("seeds")
    voted_beside, unvoted_beside = await lecture.vote("cloud")
    await presenter.until(lambda: "average NEES" in presenter.part('<section class="ol-seeds'))
    cloud = time.perf_counter() - begun
    for task in tasks:
        task.cancel()
    for tab in (presenter, first, *(each.tab for each in lecture.followers)):
        await tab.socket.close()
    known = waits[~np.isnan(waits)]
    if not known.size:
        sys.exit("Nothing was measured: no follower has seen a move of the knob.")
    return {"followers": options.followers, "median ms": 1e3 * float(np.median(known)), "p95 ms": 1e3 * float(np.percentile(known, 95)),
            "moves not seen by the next one's": float(np.isnan(waits).mean()), "last move lost": lost,
            "server ms per follower and move": 1e3 * spent / options.moves / options.followers, "votes s": voted, "votes lost": unvoted,
            "votes beside a cloud s": voted_beside, "votes beside a cloud lost": unvoted_beside, "cloud of the class s": cloud}


def waits_of(asked: list[tuple[float, float]], followers: list[Follower]) -> tuple[np.ndarray, int]:
    """Seconds from each move to each follower, NaN where the next move came first; how many never saw the last one."""
    waits, lost = [], 0
    for each in followers:
        for k, (t, value) in enumerate(asked):
            came = next((at for at, which in each.seen if at >= t and which == value), None)
            lost += came is None and k + 1 == len(asked)
            waits.append(np.nan if came is None else came - t)
    return np.array(waits), lost


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, usual in (("followers", 100), ("moves", 40), ("workers", 2)):
        parser.add_argument(f"--{name}", type=int, default=usual)
    parser.add_argument("--redis", action="store_true", help="keep the room in a Redis server")
    options = parser.parse_args()
    load = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as folder, redis_serving(Path(folder)) if options.redis else nullcontext() as redis:
        command = [sys.executable, "-m", "observer_lab", "serve", "--room", "--port", "0", "--data-dir", folder, "--lesson", LESSON,
                   "--view", "guide", "--workers", str(options.workers), "--max-sessions", "1000",
                   *(() if redis is None else ("--room-store", redis.address))]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=HERE) as server:
            assert server.stdout is not None
            url, told = server.stdout.readline().strip(), server.stdout.readline()
            try:
                found = asyncio.run(measure(url, told.partition("?present=")[2].strip(), server.pid, options))
            finally:
                server.terminate()
        kept = open_room(Path(folder) if redis is None else redis.address)
        found["votes in the store"] = sum(vote.total for vote in kept.votes())
        kept.close()
    found |= {"load before": load, "load after": os.getloadavg()[0]}
    for name, value in found.items():
        print(f"{name:36} {value:.4g}")
    missing = {name: value for name, value in found.items() if name.endswith("lost") and value}
    if missing or not found["votes in the store"]:
        sys.exit(f"The run does not count: {missing or 'no vote is in the store'}.")


if __name__ == "__main__":
    main()
