"""A server that is mistreated for minutes, on loopback, while one tab goes on working: what each fault costs that tab, and what is left.

    python tests/benchmarks/soak.py [--connects 1000] [--cuts 120] [--floods 400]

The server is a process of its own whose opening lesson misbehaves at some values of a knob (tests/wire/sick.py) and whose files may
hold no more than 2 kB, as on a full disk. One tab, the witness, moves a slider and waits for the answer, again and again, all the time.
Tabs come and go, at every stage of opening; connections are reset in mid-drag; strangers flood in every way; one sends and never
reads; lessons raise, exit, loop, hoard memory and never come back; the disk is full; the clock is set; the server is killed and
started again.

Threads, sessions, resident memory and its blocks in use are sampled along the connects and cuts, after a collection; their slope
is that of a straight line through all samples but the first fifth, with the 95 % interval of least squares. Verdict lines say
what must hold; the exit status is 1 if one does not.
"""

# ruff: noqa: E402 — the folders of the app and of the protocol client must be found first

from __future__ import annotations

import argparse
import asyncio
import contextlib
import socket
import statistics
import struct
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Awaitable, Callable
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
from scipy.stats import linregress
from scipy.stats import t as student

HERE = Path(__file__).parents[2]
sys.path[:0] = [str(HERE), str(HERE / "tests"), str(HERE / "tests" / "wire"), str(HERE / "tests" / "benchmarks")]

from bench_many import Tab, enter, share  # type: ignore[import-not-found]
from floods import FLOODS, flood_once  # type: ignore[import-not-found]
from sick import BLOCKS as SLEEPS
from sick import EXITS, HOARDS, LABEL, LOOPS, RAISES  # type: ignore[import-not-found]
from ward import BLOCKED, FILES, Ward, connected  # type: ignore[import-not-found]

DELAY = "input delay [ms]"
EVERY = 20  # connects between two samples
LEAK, BLOCKS = 5.0, 10.0  # kB and blocks for each that could hide in what memory varies by; a tab holds 2,500 kB
Verdicts = list[tuple[str, bool]]


# --- who works all the time ---------------------------------------------------------------------------------------------------
class Witness:
    """A tab that moves a slider and waits for its answer; how long that took, by what went on meanwhile."""

    def __init__(self) -> None:
        self.waits: dict[str, list[float]] = {}
        self.during, self.tab = "", None
        self.listeners: list[asyncio.Task[None]] = []

    async def come(self, url: str) -> None:
        """Open the tab."""
        self.tab, _ = await enter(url, False, self.listeners)

    async def work(self) -> None:
        """Move on five times a second, as soon as the last move is answered."""
        value = 0.0
        while True:
            if self.tab is not None:
                value = (value + 6.0) % 48.0
                began, during = time.monotonic(), self.during
                self.tab.send("GuiUpdateMessage", uuid=self.tab.find(DELAY), updates={"value": value})
                await self.tab.answered()
                self.waits.setdefault(during, []).append(1e3 * (time.monotonic() - began))
            await asyncio.sleep(0.2)


# --- those who come and go ------------------------------------------------------------------------------------------------------
async def come_and_go(ward: Ward, k: int) -> None:
    """Open a tab and leave: at once, after looking, in the middle of its page, or when it stands and plays."""
    listeners: list[asyncio.Task[None]] = []
    if k % 4 < 3:
        connection = await connected(ward.url, k % 4 > 0)
        if k % 4 == 2:
            await connection.recv()
        await connection.close()
        return
    tab, _ = await enter(ward.url, False, listeners)
    tab.press("skip")
    await tab.answered()
    await tab._socket.close()
    await asyncio.gather(*listeners, return_exceptions=True)


async def cut(ward: Ward) -> None:
    """Drag a pole and be reset in the middle of it."""
    listeners: list[asyncio.Task[None]] = []
    tab, _ = await enter(ward.url, False, listeners)
    tab.press("skip")
    await tab.answered(rests=True)
    name = "/board/observer/grips"
    for phase, dx in (("start", 0.0), ("update", 0.1), ("update", 0.2)):
        tab.send("SceneNodeDragMessage", phase=phase, name=name, instance_index=None, start_position=(1.9, 1.45, 3.7),
                 start_screen_pos=(0.5, 0.5), end_position=(1.9 + dx, 1.45, 3.7), end_screen_pos=(0.5, 0.5), button="left", modifier=None,
                 owner=tab.nodes[name].get("owner", ""))
    await asyncio.sleep(0)
    plain = tab._socket.transport.get_extra_info("socket")
    plain.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    tab._socket.transport.abort()
    await asyncio.gather(*listeners, return_exceptions=True)


async def flooded(ward: Ward, k: int) -> None:
    """Flood in one of all ways until dropped, from one of so many addresses behind a proxy that none has to wait."""
    first, again = list(FLOODS.values())[k % len(FLOODS)]
    await flood_once(ward.url, first, again, time.monotonic() + 5.0, f"198.51.100.{k % 100 + 1}")


async def never_reads(ward: Ward) -> tuple[float, float]:
    """Send and never read: seconds until it is dropped, and megabytes that it costs at most meanwhile."""
    listeners: list[asyncio.Task[None]] = []
    tab, _ = await enter(ward.url, False, listeners)
    listeners[0].cancel()
    tab._socket.transport.pause_reading()
    before = most = ward.megabytes()
    tabs, began, k = ward.health()["tabs"], time.monotonic(), 0
    while ward.health()["tabs"] >= tabs and time.monotonic() - began < 180:
        k += 1
        for label, value in ((DELAY, 6.0 * (k % 8)), (LABEL, float(k % 9))):
            tab.send("GuiUpdateMessage", uuid=tab.find(label), updates={"value": value})
        most = max(most, ward.megabytes())
        await asyncio.sleep(0.1)
    took = time.monotonic() - began
    tab._socket.transport.abort()
    return took, most - before


async def sicken(ward: Ward, value: float, said: str) -> tuple[float, str]:
    """Let the lesson misbehave: seconds until the sentence came, and the sentence."""
    listeners: list[asyncio.Task[None]] = []
    tab, _ = await enter(ward.url, False, listeners)
    began, notes = time.monotonic(), len(tab.notes)
    tab.send("GuiUpdateMessage", uuid=tab.find(LABEL), updates={"value": value})
    await tab.until(lambda: any(said in note for note in tab.notes[notes:]), 120)
    took, words = time.monotonic() - began, next(note for note in tab.notes[notes:] if said in note)
    if value != SLEEPS:  # the tab goes on
        tab.send("GuiUpdateMessage", uuid=tab.find(LABEL), updates={"value": 3.0})
        await tab.answered(rests=True)
    await tab._socket.close()
    return took, words


# --- the soak ---------------------------------------------------------------------------------------------------------------
def slope(x: list[float], y: list[float]) -> tuple[float, float]:
    """Slope of a straight line and the half-width of its 95 % interval."""
    if len(x) < 4:
        raise SystemExit("too few samples for a slope; ask for more connects and cuts")
    line = linregress(x, y)
    return float(line.slope), float(np.nan_to_num(line.stderr) * student.ppf(0.975, len(x) - 2))


async def quiet(ward: Ward, tabs: int) -> None:
    """Wait until no more tabs are open than that."""
    end = time.monotonic() + 60
    while (await asyncio.to_thread(ward.health))["tabs"] > tabs and time.monotonic() < end:
        await asyncio.sleep(0.05)


async def sampled(ward: Ward, name: str, count: int, once: Callable[[int], Awaitable[None]], verdicts: Verdicts) -> None:
    """Do something so many times, two at once, and say what grows."""
    rows: list[tuple[float, ...]] = []
    for k in range(0, count, EVERY):
        for j in range(k, min(k + EVERY, count), 2):
            await asyncio.gather(*(once(i) for i in range(j, min(j + 2, count))))
        await quiet(ward, 1)
        await asyncio.sleep(0.3)  # threads of tabs that left have ended
        rows.append((float(k + EVERY), *await asyncio.to_thread(ward.sample)))
    kept = np.array(rows[len(rows) // 5:])
    print(f"\n{name}: samples from {kept[0, 0]:.0f} to {kept[-1, 0]:.0f}\n| | first | last | slope for each, 95 % |\n|---|---|---|---|")
    for column, what, unit, most in ((1, "threads", 1.0, 1e-3), (2, "sessions", 1.0, 1e-3), (3, "memory [MB]; slope in kB", 1024.0, LEAK),
                                     (4, "blocks [10³]; slope in blocks", 1000.0, BLOCKS)):
        rise, half = slope(list(kept[:, 0]), list(kept[:, column] * unit))
        print(f"| {what} | {kept[0, column]:.1f} | {kept[-1, column]:.1f} | {rise:+.4f} ± {half:.4f} |", flush=True)
        flat = rise - half <= 0 <= rise + half or rise + half < most
        verdicts.append((f"{name}: {what.split(' ')[0]} do not grow ({rise:+.3f} ± {half:.3f})", flat))


async def soak(ward: Ward, folder: str, connects: int, cuts: int, floods: int) -> Verdicts:
    """Everything, one after another."""
    verdicts: Verdicts = []
    witness = Witness()
    await witness.come(ward.url)
    working = asyncio.create_task(witness.work())
    witness.during = "nothing"
    await asyncio.sleep(8)
    witness.during = "connects"
    await sampled(ward, f"{connects} connects", connects, lambda k: come_and_go(ward, k), verdicts)
    witness.during = "cuts in mid-drag"
    await sampled(ward, f"{cuts} cuts in mid-drag", cuts, lambda _: cut(ward), verdicts)
    witness.during = "floods"
    await sampled(ward, f"{floods} floods", floods, lambda k: flooded(ward, k), verdicts)
    usual, now = (share(witness.waits[during], 0.95) for during in ("nothing", "floods"))
    verdicts.append((f"floods leave the witness within twice its quiet p95 ({now:.0f} ms for {usual:.0f} ms)", now <= 2 * usual))
    print("\n| fault | after [s] | what was said |\n|---|---|---|")
    for name, value, said in (("raises", RAISES, "division"), ("exits", EXITS, "SystemExit"), ("loops", LOOPS, "10 s"),
                              ("hoards memory", HOARDS, "memory"), ("never comes back", SLEEPS, "ended")):
        witness.during = f"a lesson that {name}"
        took, words = await sicken(ward, value, said)
        print(f"| {witness.during} | {took:.1f} | {words} |", flush=True)
        await quiet(ward, 1)
    verdicts.append(("what could not be broken off is counted by /health", (await asyncio.to_thread(ward.health))["stuck"] == 1))
    witness.during = "one that never reads"
    took, held = await never_reads(ward)
    print(f"| one that sends and never reads | {took:.1f} | dropped; it cost {held:.1f} MB at most |", flush=True)
    verdicts.append((f"who never reads is dropped ({took:.0f} s) and bounded ({held:.1f} MB)", took < 120 and held < 60))
    verdicts.append(("the thread that was counted has ended", await _ends(ward)))
    witness.during = "a full disk"
    for k in range(40):
        await asyncio.to_thread(_refused, ward.url, f"evil{k}.example")
    await asyncio.sleep(2)
    told = "".join(ward.said)
    full = (Path(folder) / "observer-lab.log").stat().st_size
    verdicts.append((f"a full disk ({full} bytes) costs one sentence, and the server goes on",
                     told.count("cannot be written") == 1 and "Logging error" not in told and full == FILES))
    witness.during = "a clock that jumps"
    for ahead in (3600.0, -86400.0, 0.0):
        ward.set_clock(ahead)
        await asyncio.sleep(1.5)
    working.cancel()
    print("\n| the witness meanwhile | answers | median [ms] | p95 [ms] |\n|---|---|---|---|")
    for during, waits in witness.waits.items():
        print(f"| {during} | {len(waits)} | {statistics.median(waits):.0f} | {share(waits, 0.95):.0f} |")
    verdicts.append(("the witness was answered during every fault", len(witness.waits) == 12 and not witness.tab.notes))
    await killed(ward, folder, witness, verdicts)
    return verdicts


async def _ends(ward: Ward) -> bool:
    end = time.monotonic() + BLOCKED + 30
    while time.monotonic() < end:
        if not (await asyncio.to_thread(ward.health))["stuck"]:
            return True
        await asyncio.sleep(0.5)
    return False


def _refused(url: str, host: str) -> None:
    request = urllib.request.Request(url, headers={"Host": host})
    with contextlib.suppress(urllib.error.HTTPError):
        urllib.request.urlopen(request, timeout=30)


async def killed(ward: Ward, folder: str, witness: Witness, verdicts: Verdicts) -> None:
    """Kill the server under a tab and start it again at its place: who comes back stands where it was."""
    tab = witness.tab
    tab.send("GuiUpdateMessage", uuid=tab.find(DELAY), updates={"value": 18.0})
    await tab.answered(rests=True)
    await tab.answered(rests=True)
    ward.stop()
    await asyncio.gather(*witness.listeners, return_exceptions=True)
    again = Ward(folder, urlsplit(ward.url).port or 0)
    try:
        listeners: list[asyncio.Task[None]] = []
        back = await _reopened(again.url, tab.kept, listeners)
        verdicts.append((f"after a kill the server is back at {again.url == ward.url and 'its address'}, and the tab at its design",
                         again.url == ward.url and back.widgets[back.find(DELAY)]["value"] == 18.0))
    finally:
        again.stop()


async def _reopened(url: str, kept: str | None, listeners: list[asyncio.Task[None]]) -> Tab:
    """A tab whose browser kept that."""
    tab = Tab(await connected(url, False), False)
    tab.kept = kept
    listeners.append(asyncio.create_task(tab.listen()))
    await tab.answered(rests=True)
    return tab


def main() -> None:
    """Print the tables and the verdicts."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--connects", type=int, default=1000)
    parser.add_argument("--cuts", type=int, default=120)
    parser.add_argument("--floods", type=int, default=400)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        ward = Ward(folder)
        try:
            verdicts = asyncio.run(soak(ward, folder, asked.connects, asked.cuts, asked.floods))
        finally:
            ward.stop()
    print()
    for words, holds in verdicts:
        print(f"{'holds' if holds else 'FAILS'}  {words}")
    sys.exit(not all(holds for _, holds in verdicts))


if __name__ == "__main__":
    main()
