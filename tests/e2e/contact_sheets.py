"""Draw a contact sheet of every scene of every lesson, to be looked at, and say what breaks the law of the path.

`python tests/e2e/contact_sheets.py FOLDER [--lang en|zh] [--size 1366x768] [--dark] [--present] [LESSON …]`
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1])]

from conftest import chromium, serving
from tab import FLAGS

from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token

PATIENCE = 60_000  # ms
ACROSS, SHARE = 4, 0.45  # pictures in a row of a sheet; their size
PHONE = 897  # px: narrower windows have a sheet below the stage
LEAST = {True: 0.4, False: 0.6}  # share of the window for the stage, on a phone and elsewhere
MEASURE = """() => {
  const box = name => document.querySelector(name).getBoundingClientRect(), stage = box('canvas[data-engine]');
  const card = ['.ol-card', '.ol-answer', '.ol-way'].map(box), sheet = innerWidth < 897 ? box('.ol-head').top : stage.height;
  return {stage: stage.width * Math.min(stage.height, sheet) / (innerWidth * innerHeight),
          bottom: Math.max(...card.map(r => r.bottom)) - innerHeight, right: Math.max(...card.map(r => r.right)) - innerWidth,
          left: Math.min(...card.map(r => r.left)), top: Math.min(...card.map(r => r.top))};
}"""


def scenes(page: Page, address: str, lesson: Lesson, language: str, mode: str) -> Iterator[tuple[str, Image.Image]]:
    """Every scene of a lesson as it is entered: its id and its picture. What breaks the law is printed."""
    first = SavedState(lesson.start(), language, mode == "present", mode=mode, scene=lesson.path[0].id)
    page.goto(f"{address}#{write_token(lesson, first)}")
    for k, scene in enumerate(lesson.path):
        page.wait_for_selector(".ol-dot", timeout=PATIENCE)
        page.locator(".ol-dot").nth(k).click(timeout=PATIENCE)
        page.wait_for_selector(f".ol-card[data-scene={scene.id}]", timeout=PATIENCE)
        page.wait_for_timeout(700)
        found = page.evaluate(MEASURE)
        least = LEAST[page.evaluate("innerWidth") < PHONE]
        bad = [f"stage {found['stage']:.2f}"] if found["stage"] < least else []
        bad += [f"{side} by {found[side]:.0f} px" for side in ("bottom", "right") if found[side] > 0]
        bad += [f"{side} by {-found[side]:.0f} px" for side in ("left", "top") if found[side] < 0]
        if bad:
            print(f"{lesson.id} {scene.id}: {', '.join(bad)}", flush=True)
        yield scene.id, Image.open(BytesIO(page.screenshot()))


def sheet(pictures: list[Image.Image]) -> Image.Image:
    """The pictures in rows, smaller."""
    wide, high = (round(SHARE * side) for side in pictures[0].size)
    rows = -(-len(pictures) // ACROSS)
    whole = Image.new("RGB", (ACROSS * (wide + 6), rows * (high + 6)), "white")
    for k, picture in enumerate(pictures):
        small = picture.convert("RGB").resize((wide, high), Image.Resampling.LANCZOS)
        whole.paste(small, (k % ACROSS * (wide + 6), k // ACROSS * (high + 6)))
    return whole


def main() -> None:
    """Draw the sheets that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("folder", type=Path)
    parser.add_argument("lessons", nargs="*", default=list(LESSONS))
    parser.add_argument("--lang", default="en")
    parser.add_argument("--size", default="1366x768")
    parser.add_argument("--dark", action="store_true")
    parser.add_argument("--present", action="store_true")
    asked = parser.parse_args()
    wide, high = map(int, asked.size.split("x"))
    asked.folder.mkdir(parents=True, exist_ok=True)
    with serving(0, "--view", "guide") as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=FLAGS)
        for id in asked.lessons:
            page = browser.new_page(viewport={"width": wide, "height": high}, reduced_motion="reduce",
                                    color_scheme="dark" if asked.dark else "light")
            found = list(scenes(page, address, LESSONS[id], asked.lang, "present" if asked.present else "guide"))
            name = f"{id}-{asked.lang}-{asked.size}{'-dark' if asked.dark else ''}{'-present' if asked.present else ''}.png"
            sheet([picture for _, picture in found]).save(asked.folder / name)
            print(f"{name}: {len(found)} scenes", flush=True)
            page.close()
        browser.close()


if __name__ == "__main__":
    main()
