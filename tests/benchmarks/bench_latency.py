"""From the pointer to the picture: how long after a mouse move the plots and the 3-D stage show what it did.

    python tests/benchmarks/bench_latency.py [--moves 60] [--size 1600x900] [--scale 1] [--lesson separation] [--opens 3]

One tab in headless Chromium on loopback. A slider and a pole are dragged with the mouse, one move at a time, each
after the last has been drawn. The clock starts with the browser's own event and is read in animation frames: "plots"
is the first frame in which a chart holds new data, "stage" the first that begins after the frame in which WebGL drew
the moved scene (without a graphics card that frame is rasterised before the next can begin).
Without a graphics card the 3-D view is rasterised by the processor, which then is most of what is measured, although
the page draws the moving scene with fewer pixels where frames come slowly. `--scale 0.25` draws it with a sixteenth of
the pixels and leaves everything else as it is, nearer to what a graphics card shows.
Where the plant can be pulled, it is grabbed as well; its stage moves by then in any case, because the run plays under a hand.
The benchmark fails where fewer than nine in ten moves changed the plots.
The page's 50 ms throttle of widgets does not bite here, since a move waits for the last.
Before that a fresh browser context opens the lesson `--opens` times, from the address to the moment in which its question stands
uncovered, and draw calls and triangles of a frame are counted by WebGL's renderer. To compare two versions, lay this file over
the older one in a worktree of its own and run both in turn.
"""

# ruff: noqa: E402 — the folders of the app and of the browser tests must be found first

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser, sync_playwright

sys.path[:0] = [str(Path(__file__).parents[2]), str(Path(__file__).parents[1] / "e2e")]

from conftest import chromium, serving  # type: ignore[import-not-found]
from geometry import on_screen  # type: ignore[import-not-found]
from tab import FLAGS, Tab, eventually  # type: ignore[import-not-found]

from observer_lab.course.error_window import find_error_window
from observer_lab.course.knobs import Number
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS, OPENING
from observer_lab.page.column.knob_widgets import label_of
from observer_lab.session.handlers.playback import PLAYBACK_SPEEDS

SETTLE = 200  # ms between two moves
MOVES_A_PULL = 6
PULL_PX = 14.0  # a move of a pull: more than the step to which a force is rounded
MEASURED_SHARE = 0.9  # of the moves that must have changed the plots
WATCH = """() => { window.__measured = new Promise(done => {
  const page = window.__viserMutable;
  const charts = () => Object.values(window.__viserTestpoints.uplots).map(u => u.chart.data);
  const scene = () => { let sum = 0;
    for (const held of Object.values(page.nodeRefFromName)) {
      const node = held && 'current' in held ? held.current : held;
      if (node?.position) sum += node.position.x + 3 * node.position.y + 7 * node.position.z + 11 * node.quaternion.x
        + 13 * node.quaternion.y + 17 * node.scale.z;
    } return sum; };
  const before = charts(), still = scene();
  let start = null, plots = null, stage = null, moved = false;
  const hooked = page.scene.onAfterRender;
  page.scene.onAfterRender = (...all) => {
    hooked(...all);
    if (start === null || moved || scene() === still) return;
    moved = true;
    requestAnimationFrame(() => { stage = performance.now() - start; });
  };
  const input = event => { if (start === null) start = event.timeStamp; };
  addEventListener('pointermove', input, {capture: true});
  const opened = performance.now();
  const frame = () => {
    const now = performance.now();
    if (start !== null) {
      if (plots === null && charts().some((data, i) => data !== before[i])) plots = now - start;
    }
    if ((plots !== null && stage !== null) || now - opened > 5000) {
      removeEventListener('pointermove', input, {capture: true});
      page.scene.onAfterRender = hooked;
      done([plots, stage]);
    } else requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}); }"""
DRAWN = """() => new Promise(done => {
  const page = window.__viserMutable, seen = page.scene.onAfterRender, {gl} = page.scene.__r3f.root.getState();
  page.scene.onAfterRender = (...all) => {
    seen(...all);
    page.scene.onAfterRender = seen;
    const {calls, triangles} = gl.info.render;
    done([calls, triangles]);
  };
  page.requestRender();
})"""
STANDS = """() => {
  const question = document.querySelector('.ol-question'), cover = document.querySelector('.ol-cover');
  return !!question && (!cover || cover.hidden);
}"""
FRAME = """() => new Promise(done => { const times = []; let last = performance.now();
  const step = () => { window.__viserMutable.requestRender?.(); const now = performance.now(); times.push(now - last);
    last = now; times.length < 21 ? requestAnimationFrame(step) : done(times.sort((a, b) => a - b)[10]); };
  requestAnimationFrame(step); })"""


def measured(what: str, times: np.ndarray) -> np.ndarray:
    """The same latencies. Ends the benchmark where too few moves changed anything: then nothing was measured."""
    found = int(np.isfinite(times[:, 0]).sum())
    if found < MEASURED_SHARE * len(times):
        raise SystemExit(f"{what}: {found} of {len(times)} moves changed the plots, so nothing was measured; run it again.")
    return times


def moves(tab: Tab, where: Callable[[], tuple[float, float]], stride: tuple[float, float], count: int) -> np.ndarray:
    """Latencies (count, 2) in ms to plots and stage while something is dragged to and fro; NaN where nothing came.

    What is at `where` is pressed once it stays in its place under the pointer.
    """
    mouse, places = tab.page.mouse, list[tuple[float, float]]()

    def pointed() -> bool:
        places.append(where())
        mouse.move(*places[-1])
        tab.answered()
        return math.dist(where(), places[-1]) < 1.0
    eventually(pointed, bool, "what is dragged stays in its place")
    x, y = places[-1]
    mouse.down()
    tab.answered()
    mouse.move(x + 2 * stride[0], y + 2 * stride[1], steps=2)  # now it holds: a first small move is not yet told from a click
    tab.answered()
    out = []
    for i in range(count):
        reach = 6 - abs(i % 12 - 6)
        tab.page.evaluate(WATCH)
        mouse.move(x - stride[0] * (reach + 1), y - stride[1] * (reach + 1))
        out.append([np.nan if v is None else v for v in tab.page.evaluate("() => window.__measured")])
        tab.page.wait_for_timeout(SETTLE)
    mouse.up()
    tab.answered(rests=True)
    return np.array(out, dtype=float)


def pulls(tab: Tab, lesson: Lesson, count: int) -> np.ndarray:
    """Latencies (count, 2) in ms while the plant is pulled, a few moves at a time: a run plays under the hand, and it ends."""
    stage = lesson.compute(lesson.start()).stage
    assert stage is not None and stage.held
    (grip, _), *_ = stage.held
    stride = PULL_PX * grip.along[0], -PULL_PX * grip.along[2]
    for _ in range(PLAYBACK_SPEEDS.index(1.0)):
        tab.press("slower")
    out = []
    for begun in range(0, count, MOVES_A_PULL):
        stop_where_the_error_lives(tab, lesson)
        out.append(moves(tab, lambda: on_screen(tab, f"/plant/{grip.parts[0]}"), stride, min(MOVES_A_PULL, count - begun)))
    return np.vstack(out)


def stop_where_the_error_lives(tab: Tab, lesson: Lesson) -> None:
    """Stop the run at a moment at which every knob moves the stage."""
    stage = lesson.compute(lesson.start()).stage
    assert stage is not None
    part = find_error_window(stage)
    moment = f"{part.begin + 0.3 * (part.end - part.begin):.2g}"

    def stopped() -> float:
        if tab.button("‖ pause").count():
            tab.press("‖ pause")
        tab.type_number("time t [s]", moment)
        return tab.clock()
    eventually(stopped, lambda t: abs(t - float(moment)) < 0.02 * part.end, "the run stopped")


def opening(browser: Browser, address: str, size: tuple[int, int]) -> float:
    """Seconds from asking for the address to a lesson that stands uncovered, in a browser context without anything kept."""
    context = browser.new_context(viewport={"width": size[0], "height": size[1]})
    page, begun = context.new_page(), time.perf_counter()
    page.goto(address, wait_until="commit")
    page.wait_for_function(STANDS, polling=20)
    took = time.perf_counter() - begun
    context.close()
    return took


def table_row(what: str, times: np.ndarray) -> str:
    median, p95 = np.nanpercentile(times, (50, 95))
    return f"| {what} | {np.isfinite(times).sum()} | {median:.0f} | {p95:.0f} | {np.nanmax(times):.0f} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--moves", type=int, default=60)
    parser.add_argument("--size", default="1600x900")
    parser.add_argument("--scale", type=float, default=1.0, help="device pixels per pixel of the page")
    parser.add_argument("--lesson", default=OPENING)
    parser.add_argument("--opens", type=int, default=3)
    options = parser.parse_args()
    width, height = (int(v) for v in options.size.split("x"))
    lesson = LESSONS[options.lesson]
    with serving() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        opened = [opening(browser, address, (width, height)) for _ in range(options.opens)]
        tab = Tab(browser.new_page(viewport={"width": width, "height": height}, device_scale_factor=options.scale), address)
        tab.choose_lesson(lesson.words["en"].title, lesson.words["en"].question)
        tab.predict("skip")
        tab.reveal()
        slider = next(k for k in lesson.knobs if isinstance(k, Number) and lesson.shown(k, lesson.start()))
        tab.slide(label_of(slider, "en"), times=1)
        tab.answered(rests=True)
        if (asks := tab.page.locator('.ol-again .ol-option[data-value="skip"]')).count():  # a second question holds the stage
            asks.click()
            tab.answered(rests=True)
        stop_where_the_error_lives(tab, lesson)
        idle, (calls, triangles) = tab.page.evaluate(FRAME), tab.page.evaluate(DRAWN)

        def thumb() -> tuple[float, float]:
            box = tab.thumb(label_of(slider, "en")).bounding_box()
            assert box is not None
            return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        rows = [("slider", measured("slider", moves(tab, thumb, (4.0, 0.0), options.moves)))]
        rows.append(("pole", measured("pole", moves(tab, lambda: on_screen(tab, "/board/controller/pole0"), (3.0, 0.0), options.moves))))
        if lesson.compute(lesson.start()).stage.held:  # type: ignore[union-attr]
            rows.append(("grab", measured("grab", pulls(tab, lesson, options.moves))))
        browser.close()
    print(f"{options.lesson} at {options.size}, scale {options.scale:g}, {options.moves} moves each; "
          f"a frame of the 3-D view alone takes {idle:.0f} ms, {calls} draw calls, {triangles} triangles")
    print("from the address to the lesson: " + ", ".join(f"{took:.2f}" for took in opened) + " s\n")
    print("| input → what is redrawn | moves | median [ms] | p95 [ms] | max [ms] |\n|---|---|---|---|---|")
    for name, times in rows:
        print(table_row(f"{name} → plots", times[:, 0]))
        print(table_row(f"{name} → plots and stage", times.max(axis=1)))


if __name__ == "__main__":
    main()
