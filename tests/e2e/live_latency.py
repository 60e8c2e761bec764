"""How soon a line of a running plant is on the page: a simulated device at 83 Hz, lines lost and late, Chromium, memory.

`python tests/e2e/live_latency.py [--seconds 600] [LESSON]` sends the lines of the compiled plant by datagrams to `live --udp --page`.
It prints lines sent, lost and taken, the median and p95 of the time from a line to a picture that holds it, and the memory of the server.
"""

from __future__ import annotations

import argparse
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from conftest import chromium
from playwright.sync_api import sync_playwright
from tab import FLAGS, UNDRAWN

from observer_lab.engine.systems import discretise
from observer_lab.export.devices.folders import device_design
from observer_lab.export.devices.simulator import simulator_files
from observer_lab.lessons import LESSONS
from observer_lab.live.simulated import simulated

LOST, JITTER = 0.01, 0.05
WATCH = """() => {
  window.seen = [];
  let last = '';
  const look = () => {
    const words = document.querySelector('.ol-running p')?.textContent ?? '';
    const found = /Until ([\\d.]+) s/.exec(words);
    if (found && found[1] !== last) { last = found[1]; window.seen.push([Date.now() / 1000, Number(last)]); }
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


def main() -> int:
    """Print the measurement."""
    parser = argparse.ArgumentParser()
    parser.add_argument("lesson", nargs="?", default="noise")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--undrawn", action="store_true", help="without drawing the scene, which software draws slowly")
    options = parser.parse_args()
    lesson, port = LESSONS[options.lesson], free_port()
    outcome = lesson.compute(lesson.start())
    design, s = device_design(lesson, outcome), outcome.run.scenario
    T = design.routine.period
    files = simulator_files(design, s.plant if s.plant.dt else discretise(s.plant, T), s.x0)
    served = subprocess.Popen([sys.executable, "-m", "observer_lab", "live", options.lesson, "--udp", str(port), "--page", "0"],
                              stdout=subprocess.PIPE, text=True)
    assert served.stdout is not None
    address = served.stdout.readline().strip()
    sent: list[tuple[float, float]] = []
    try:
        with sync_playwright() as web, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            browser = web.chromium.launch(executable_path=chromium(), args=FLAGS)
            page = browser.new_page(viewport={"width": 1366, "height": 768})
            if options.undrawn:
                page.add_init_script(f"({UNDRAWN})()")
            page.goto(address)
            page.wait_for_selector(".ol-running", state="attached", timeout=90_000)
            page.evaluate(WATCH)
            count, memory, rest = int(options.seconds / T), [], b""
            with simulated(files, count, lost=LOST, jitter=JITTER, knocks=400) as source:
                while (data := source(5.0)) is not None:
                    *lines, rest = (rest + data).split(b"\n")
                    for line in lines:
                        if line and not line.startswith(b"#"):
                            out.sendto(line + b"\n", ("127.0.0.1", port))
                            sent.append((float(line.split(b",")[0]), time.time()))
                            if len(sent) % 400 == 0:
                                memory.append(resident(served.pid))
            time.sleep(1.5)
            seen = np.array(page.evaluate("window.seen"))
            words = page.locator(".ol-running p").first.inner_text()
            browser.close()
    finally:
        served.terminate()
        served.wait(20)
    times, at = np.array(sent).T
    place = np.searchsorted(seen[:, 1] + 0.005, times)  # the first picture whose time is that of the line or later
    ages = np.array([seen[k, 0] - when for k, when in zip(place, at, strict=True) if k < len(seen)])
    print(f"{count} periods of {T:.4g} s, {len(sent)} lines sent; the page says: {words}")
    print(f"pictures {len(seen)} ({len(seen) / options.seconds:.1f} a second); line to picture: median {1e3 * np.median(ages):.0f} ms, "
          f"p95 {1e3 * np.percentile(ages, 95):.0f} ms; memory {memory[0]:.0f} → {memory[-1]:.0f} MB")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
