"""A newcomer plays: load, choose, drag. How far the ghost has moved on the screen within the first drag, and how far against its plant.

    python tests/e2e/newcomer.py [--lesson separation] [--size 1366x768]

The drag is that of the slowest pole on the board whose discs swell, else of a pole on another board, else of the first key knob
that is a slider. The ghost is watched in the browser itself: the corners of its parts, projected to the screen in every frame
that is drawn. Exit status 1 where it has moved by less than 20 px in a lesson that has a ghost which ever leaves its plant. One that
hardly moves by nature is to be left by its plant as far; its share is the reason in the table.
"""

# ruff: noqa: E402 — the folders of the app and of the browser tests must be found first

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[2]), str(Path(__file__).parent)]

import numpy as np
from conftest import chromium, serving  # type: ignore[import-not-found]
from geometry import on_screen  # type: ignore[import-not-found]
from playwright.sync_api import sync_playwright
from tab import FLAGS, Tab  # type: ignore[import-not-found]

from observer_lab.course.error_window import apart
from observer_lab.course.knobs import Number
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.page.column.knob_widgets import label_of
from observer_lab.page.stage.drag_handles import OBSERVER_BOARD

WANTED = 20.0  # px
STILL = 0.05  # of the plant's motion
NEVER = 1e-3  # stage units: a ghost that is never farther from its plant than this is not seen
WATCH = """() => {
  const page = window.__viserMutable, paths = {}, apart = {}, seen = page.scene.onAfterRender;
  const found = name => {
    const held = page.nodeRefFromName[name];
    return held && 'current' in held ? held.current : held;
  };
  const corners = (node, view) => {
    const out = [];
    node?.traverse(part => {
      if (!part.geometry) return;
      if (!part.geometry.boundingBox) part.geometry.computeBoundingBox();
      const {min, max} = part.geometry.boundingBox;
      for (let corner = 0; corner < 8; corner += 1) {
        const at = min.clone().set(corner & 1 ? min.x : max.x, corner & 2 ? min.y : max.y, corner & 4 ? min.z : max.z)
          .applyMatrix4(part.matrixWorld).project(page.camera);
        out.push([(at.x + 1) / 2 * view.width, (1 - at.y) / 2 * view.height]);
      }
    });
    return out;
  };
  const look = () => {
    const view = page.canvas.getBoundingClientRect();
    for (const name of Object.keys(page.nodeRefFromName).filter(each => each.startsWith('/ghost/'))) {
      const body = corners(found(name.replace('/ghost/', '/plant/')), view);
      corners(found(name), view).forEach(([x, y], corner) => {
        (paths[name + corner] ??= []).push([x, y]);
        if (body[corner]) (apart[name + corner] ??= []).push([x - body[corner][0], y - body[corner][1]]);
      });
    }
  };
  page.scene.onAfterRender = (...all) => { seen(...all); look(); };
  look();
  const farthest = ways => Math.max(0, ...Object.values(ways).map(path => Math.max(...path.map(
    ([x, y]) => Math.hypot(x - path[0][0], y - path[0][1])))));
  window.ghostMoved = () => [farthest(paths), farthest(apart)];
}"""


def has_a_ghost(lesson: Lesson) -> bool:
    """Whether the lesson opens with a ghost that leaves its plant."""
    stage = lesson.compute(lesson.start()).stage
    return stage is not None and stage.xhat is not None and bool(apart(stage)[1].max() > NEVER)


def stands_still(lesson: Lesson) -> str:
    """How far the ghost of the first run moves where it hardly does, by nature; nothing of any other."""
    stage = lesson.compute(lesson.start()).stage
    if stage is None or stage.xhat is None:
        return ""
    share = float(np.max(np.ptp(stage.xhat, axis=0) / np.maximum(np.ptp(stage.x, axis=0), 1e-300)))
    return f"the ghost moves {100 * share:.1f} % as far as the plant" if share < STILL else ""


def drag_something(tab: Tab, lesson: Lesson) -> str:
    """One drag to the left and to the right, of some seconds: of a pole, else of the first knob that is a slider; what it was."""
    outcome, mouse = lesson.compute(lesson.start()), tab.page.mouse
    boards = [b for b in outcome.boards if b.knob is not None and b.poles]
    if boards:
        board = next((b for b in boards if f"/board/{b.id}/" == OBSERVER_BOARD), boards[0])
        slowest = max(range(len(board.poles)), key=lambda i: board.poles[i].real)
        what, (x, y) = f"a pole of {board.id}", on_screen(tab, f"/board/{board.id}/pole{slowest}")
    else:
        shown = [k for k in lesson.knobs if isinstance(k, Number) and lesson.shown(k, lesson.start())]
        knob = next((k for k in shown if k.name in lesson.keys), shown[0])
        thumb = tab.thumb(label_of(knob, "en"))
        thumb.scroll_into_view_if_needed()
        box = thumb.bounding_box()
        assert box is not None
        what, (x, y) = knob.name, (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    mouse.move(x, y)
    mouse.down()
    for i in range(1, 21):
        swing = math.sin(2 * math.pi * i / 20)  # to the left, back, and to the right
        mouse.move(x - 80 * swing, y - 30 * abs(swing))
        tab.page.wait_for_timeout(150)
    mouse.up()
    return what


def play(tab: Tab, lesson: Lesson) -> tuple[str, float, float]:
    """Choose the first sentence, see the evidence begin, drag: what was dragged, and how far the ghost moved meanwhile in px, on the
    screen and against its plant."""
    tab.choose_lesson(lesson.words["en"].title, lesson.words["en"].question)
    tab.predict("A")
    tab.answered(rests=True)
    tab.drawn()
    tab.page.evaluate(WATCH)
    what = drag_something(tab, lesson)
    moved, against = tab.page.evaluate("() => window.ghostMoved()")
    return what, float(moved), float(against)


def main() -> int:
    """Play every lesson and print one table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lesson", choices=list(LESSONS), action="append")
    parser.add_argument("--size", default="1366x768")
    options = parser.parse_args()
    width, height = (int(v) for v in options.size.split("x"))
    failed = 0
    print("| lesson | dragged | the ghost moved [px] | against its plant [px] | |\n|---|---|---|---|---|")
    with serving() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        for name in options.lesson or LESSONS:
            context = browser.new_context(viewport={"width": width, "height": height}, reduced_motion="no-preference")
            what, moved, against = play(Tab(context.new_page(), address, drawn=False), LESSONS[name])
            context.close()
            still = stands_still(LESSONS[name])
            fails = has_a_ghost(LESSONS[name]) and (against if still else moved) <= WANTED
            failed += fails
            said = "too little" if fails else still if still else "" if has_a_ghost(LESSONS[name]) else "no ghost"
            print(f"| {name} | {what} | {moved:.0f} | {against:.0f} | {said} |", flush=True)
        browser.close()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
