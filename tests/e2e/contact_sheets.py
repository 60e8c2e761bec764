"""Draw a contact sheet of every scene of every lesson, to be looked at, and say what breaks the law of the path.

Each scene is measured as it is entered. A question is then answered wrongly, by the option that is refuted at greatest length, a
button is pressed; the card with what it says then is measured and drawn too. With several sizes, as in `--size 1366x768,390x844`,
the window changes in each scene; with `--law` nothing is drawn, which is quicker.

`python tests/e2e/contact_sheets.py FOLDER [--lang en|zh] [--size 1366x768] [--dark] [--present] [--hall] [--law] [LESSON …]`
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, ViewportSize, sync_playwright

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1])]

from conftest import chromium, serving
from sight import question_faults
from tab import ANSWERED, DRAWN, FLAGS, UNDRAWN, eventually

from observer_lab.course.guiding.predictions import prediction_of
from observer_lab.course.lesson import Lesson
from observer_lab.course.scenes import Choose, Press, Scene, entry_values
from observer_lab.lessons import LESSONS
from observer_lab.page.guide.guide_panel import BUTTONS
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token

PATIENCE = 60_000  # ms
ACROSS, SHARE = 4, 0.45  # pictures in a row of a sheet; their size
PHONE = 897  # px: narrower windows have a sheet below the stage
LEAST = {True: 0.4, False: 0.6}  # share of the window for the stage, on a phone and elsewhere
SHARP = "() => window.__viserMutable.scene.__r3f.root.getState().viewport.dpr >= devicePixelRatio"
MEASURE = """() => {
  const box = name => document.querySelector(name).getBoundingClientRect(), stage = box('canvas[data-engine]');
  const column = document.querySelector('.ol-card').closest('.mantine-ScrollArea-viewport');
  const card = ['.ol-card', '.ol-answer', '.ol-way'].map(box), sheet = innerWidth < 897 ? box('.ol-head').top : stage.height;
  return {stage: stage.width * Math.min(stage.height, sheet) / (innerWidth * innerHeight),
          bottom: Math.max(...card.map(r => r.bottom)) - innerHeight, right: Math.max(...card.map(r => r.right)) - innerWidth,
          left: Math.min(...card.map(r => r.left)), top: Math.min(...card.map(r => r.top)),
          scrolls: column.scrollHeight - column.clientHeight,
          cut: [...document.querySelectorAll('.ol-formula')].filter(each => each.scrollWidth > each.clientWidth + 1).length};
}"""


def breaches(page: Page, hall: bool) -> list[str]:
    """What of stage, card and question's figure breaks the law now."""
    found = page.evaluate(MEASURE)
    least = LEAST[page.evaluate("innerWidth") < PHONE]
    bad = [f"stage {found['stage']:.2f}"] if found["stage"] < least else []
    bad += [f"{side} by {found[side]:.0f} px" for side in ("bottom", "right") if found[side] > 0]
    bad += question_faults(page, hall)
    bad += [f"the column scrolls by {found['scrolls']:.0f} px"] if found["scrolls"] > 2 and least == LEAST[False] and not hall else []
    bad += ["a formula is cut"] if found["cut"] else []
    return bad + [f"{side} by {-found[side]:.0f} px" for side in ("left", "top") if found[side] < 0]


def lasting_breaches(page: Page, hall: bool) -> list[str]:
    """The breaches that remain after the columns have taken the width of a new window."""
    with suppress(AssertionError):
        eventually(lambda: breaches(page, hall), lambda bad: not bad, "a card in sight", patience=6)
    return breaches(page, hall)


def answer(page: Page, lesson: Lesson, scene: Scene, language: str) -> bool:
    """Answer a scene's question by the wrong option of the longest verdict, or press the button it asks for; whether there is one."""
    if isinstance(scene.do, Choose):
        asked = prediction_of(lesson, scene, language)
        options, refutations, right = asked.options, asked.refutations, asked.answer
        wrong = max((k for k in range(len(options)) if k != right), key=lambda k: len(refutations[k]) if k < len(refutations) else 0)
        page.locator(".ol-option").nth(wrong).click(timeout=PATIENCE)
        page.wait_for_selector(".ol-answer .ol-wrong", timeout=PATIENCE)
    elif isinstance(scene.do, Press) and scene.do.button in BUTTONS:
        page.locator("button", has_text=BUTTONS[scene.do.button](language)).first.click(timeout=PATIENCE)
        page.wait_for_selector(".ol-way .ol-next", timeout=PATIENCE)
    else:
        return False
    return True


def scenes(page: Page, address: str, lesson: Lesson, asked: argparse.Namespace) -> Iterator[tuple[str, list[str], Image.Image | None]]:
    """Every scene of a lesson in every size, entered and answered: the size, the breaches, which are printed, and the picture."""
    mode = "present" if asked.present else "guide"
    hall = asked.present or asked.hall
    start = lesson.start()
    entered = lesson.apply(start, entry_values(lesson.path, 0, start))
    first = SavedState(entered, asked.lang, hall, mode=mode, scene=lesson.path[0].id)
    page.goto(f"{address}#{write_token(lesson, first)}")
    for k, scene in enumerate(lesson.path):
        page.wait_for_selector(".ol-dot", timeout=PATIENCE)
        page.locator(".ol-dot").nth(k).click(timeout=PATIENCE)
        page.wait_for_selector(f".ol-card[data-scene={scene.id}]", timeout=PATIENCE)
        for when in ("entered", "answered"):
            if when == "answered" and not answer(page, lesson, scene, asked.lang):
                break
            for size in asked.size.split(","):
                if asked.size != size:
                    page.set_viewport_size(window(size))
                eventually(lambda: page.evaluate(ANSWERED, True), lambda said: said is True, "a page at rest")
                bad = lasting_breaches(page, hall)
                if bad:
                    print(f"{size} {lesson.id} {scene.id}, {when}: {', '.join(bad)}", flush=True)
                yield size, bad, None if asked.law else picture(page)


def window(size: str) -> ViewportSize:
    """The window of a size such as 1366x768."""
    wide, high = map(int, size.split("x"))
    return {"width": wide, "height": high}


def picture(page: Page) -> Image.Image:
    """The page, its stage drawn once."""
    page.evaluate("window.observerLabDraws = true")
    eventually(lambda: page.evaluate(DRAWN) and page.evaluate(SHARP), bool, "a scene drawn with all its pixels")
    taken = page.screenshot()
    page.evaluate("window.observerLabDraws = false")
    return Image.open(BytesIO(taken))


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
    parser.add_argument("--hall", action="store_true")
    parser.add_argument("--law", action="store_true")
    asked = parser.parse_args()
    asked.folder.mkdir(parents=True, exist_ok=True)
    views, broken = Counter[str](), Counter[str]()
    with serving(0, "--view", "guide") as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=FLAGS)
        for id in asked.lessons:
            page = browser.new_page(viewport=window(asked.size.split(",")[0]), reduced_motion="reduce",
                                    color_scheme="dark" if asked.dark else "light")
            page.add_init_script(f"({UNDRAWN})()")
            pictures: dict[str, list[Image.Image]] = {}
            for size, bad, drawn in scenes(page, address, LESSONS[id], asked):
                views[size] += 1
                broken[size] += bool(bad)
                if drawn is not None:
                    pictures.setdefault(size, []).append(drawn)
            page.close()
            for size, drawn_ones in pictures.items():
                look = "".join(f"-{word}" for word in ("dark", "present", "hall") if getattr(asked, word))
                name = f"{id}-{asked.lang}-{size}{look}.png"
                sheet(drawn_ones).save(asked.folder / name)
            print(f"{id}: {dict(views)} views so far", flush=True)
        browser.close()
    for size in views:
        print(f"{size}: {views[size]} views of scenes, {broken[size]} break the law of the path")


if __name__ == "__main__":
    main()
