"""How soon the ghost stands where a line of a running plant puts it: a simulated device, lines lost and late, Chromium, memory.

`python tests/e2e/live_latency.py [--seconds 600] [--ts 0.008] [LESSON]` sends the lines of the compiled plant to `live --udp --page`.
Where the ghost must stand after each line is computed here, and the page is asked in each of its frames where it stands.
It prints lines sent, lost and taken, median and p95 of the time from a line to the ghost and to the words, and the server's memory.
"""

from __future__ import annotations

import argparse
import socket
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
from conftest import chromium
from playwright.sync_api import sync_playwright
from tab import FLAGS, UNDRAWN

from observer_lab.course.lesson import Stage
from observer_lab.devices import Routine
from observer_lab.engine.systems import discretise
from observer_lab.export.devices.c_project import simulator_files
from observer_lab.export.devices.folders import device_design
from observer_lab.lessons import LESSONS
from observer_lab.live.lines import LineReader
from observer_lab.live.observer import LiveObserver
from observer_lab.live.simulated import simulated

LOST, JITTER = 0.01, 0.05
SLOWEST_S = 0.01  # between lines, where the lesson's run allows it
WATCH = """node => {  // when the ghost came to stand where, and when the page said which time
  window.moved = [];
  window.seen = [];
  let stood = '', last = '';
  const look = () => {
    const {x, y, z} = window.observerLabViser.node(node)?.position ?? {}, now = Date.now() / 1000, stands = `${x},${y},${z}`;
    if (x !== undefined && stands !== stood) { stood = stands; window.moved.push([now, x, y, z]); }
    const found = /Until ([\\d.]+) s/.exec(document.querySelector('.ol-running p')?.textContent ?? '');
    if (found && found[1] !== last) { last = found[1]; window.seen.push([now, Number(last)]); }
    requestAnimationFrame(look);
  };
  look();
}"""


def free_port() -> int:
    """A port for datagrams that nobody listens on now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as door:
        door.bind(("127.0.0.1", 0))
        return door.getsockname()[1]


def resident(pid: int) -> float:
    """Memory of a process in MB."""
    words = Path(f"/proc/{pid}/status").read_text()
    return int(words.partition("VmRSS:")[2].split()[0]) / 1024


def ghost_places(stage: Stage, routine: Routine, lines: list[bytes]) -> tuple[str, np.ndarray]:
    """The part of the ghost that is moved most, and where each line puts it, (N, 3)."""
    observer = LiveObserver(routine)
    reader = LineReader(("u",) * len(routine.u_names), ("y",) * len(routine.y_names))
    rest, places = stage.x[0, len(routine.x_names):], []
    parts = [part.name for part in stage.body.parts if part.twin]
    for sample in reader.feed(b"".join(line + b"\n" for line in lines)):
        step = observer.take(sample)
        assert step is not None
        poses = stage.body.pose([*step.xhat.tolist(), *rest.tolist()], stage.body.gain)
        places.append([poses[part].position for part in parts])
    found = np.array(places)
    most = int(np.argmax(found.std(axis=0).sum(axis=1)))
    return f"/ghost/{parts[most]}", found[:, most]


def ages_of(at: np.ndarray, shown: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """Seconds from each line to the first moment at which it or a later one was shown, NaN where none was."""
    upto = np.maximum.accumulate(lines)
    place = np.searchsorted(upto, np.arange(len(at)))
    return np.append(shown, np.nan)[place] - at


def told(name: str, ages: np.ndarray, pictures: int, seconds: float) -> str:
    """One line of figures."""
    median, *tail = 1e3 * np.nanpercentile(ages, [50, 95, 99])
    return f"{name}: {pictures / seconds:.1f} a second; from the line median {median:.0f} ms, p95 {tail[0]:.0f} ms, p99 {tail[1]:.0f} ms"


def main() -> int:
    """Print the measurement."""
    parser = argparse.ArgumentParser()
    parser.add_argument("lesson", nargs="?", default="arm")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--ts", type=float, help="s between lines (default: as the lesson's run allows, at 100 Hz or more)")
    parser.add_argument("--undrawn", action="store_true", help="without drawing the scene, which software draws slowly")
    options = parser.parse_args()
    lesson, port = LESSONS[options.lesson], free_port()
    outcome = lesson.compute(lesson.start())
    s = outcome.run.scenario
    T = options.ts or s.dt * max(1, int(SLOWEST_S / s.dt))
    design = device_design(lesson, outcome, T)
    files = simulator_files(design, s.plant if s.plant.dt else discretise(s.plant, T), s.x0)
    count, memory, sent, at = int(options.seconds / T), list[float](), list[bytes](), list[float]()
    with simulated(files, min(count, 4000), lost=0.0, jitter=0.0, paced=False, knocks=400) as source:  # to know which part is moved
        early = b""
        while (data := source(5.0)) is not None:
            early += data
    node, _ = ghost_places(outcome.stage, design.routine, [line for line in early.split(b"\n") if line])
    served = subprocess.Popen([sys.executable, "-m", "observer_lab", "live", options.lesson, "--udp", str(port), "--page", "0",
                               "--ts", str(T)], stdout=subprocess.PIPE, text=True)
    assert served.stdout is not None
    address = served.stdout.readline().strip()
    try:
        with sync_playwright() as web, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            browser = web.chromium.launch(executable_path=chromium(), args=FLAGS)
            page = browser.new_page(viewport={"width": 1366, "height": 768})
            if options.undrawn:
                page.add_init_script(f"({UNDRAWN})()")
            page.goto(address)
            page.wait_for_selector(".ol-running", state="attached", timeout=90_000)
            page.evaluate(WATCH, node)
            rest = b""
            with simulated(files, count, lost=LOST, jitter=JITTER, knocks=400) as source:
                while (data := source(5.0)) is not None:
                    *lines, rest = (rest + data).split(b"\n")
                    for line in lines:
                        if line and not line.startswith(b"#"):
                            out.sendto(line + b"\n", ("127.0.0.1", port))
                            sent.append(line)
                            at.append(time.time())
                            if len(sent) % 400 == 0:
                                memory.append(resident(served.pid))
            time.sleep(1.5)
            moved, seen = np.array(page.evaluate("window.moved")), np.array(page.evaluate("window.seen"))
            words = page.locator(".ol-running p").first.inner_text()
            browser.close()
    finally:
        served.terminate()
        served.wait(20)
    stood = [tuple(place) for place in ghost_places(outcome.stage, design.routine, sent)[1].tolist()]
    often = Counter(stood)
    places = {place: k for k, place in enumerate(stood) if often[place] == 1}  # a ghost at rest does not say which line put it there
    known = [(when, places[x, y, z]) for when, x, y, z in moved if (x, y, z) in places]
    times = np.array([float(line.split(b",")[0]) for line in sent])
    ghost = ages_of(np.array(at), *np.array(known).T)[[often[place] == 1 for place in stood]]
    said = ages_of(np.array(at), seen[:, 0], np.searchsorted(times, seen[:, 1] + 0.005, side="right") - 1)
    print(f"{count} periods of {T:.4g} s, {len(sent)} lines sent; the page says: {words}")
    print(told(f"ghost ({node}, {len(moved) - len(known)} of {len(moved)} places unknown)", ghost, len(known), options.seconds))
    print(told("words", said, len(seen), options.seconds))
    print(f"memory {memory[0]:.0f} → {memory[-1]:.0f} MB")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
