"""The pictures of the README, both in assets/: a scene of the guide, and a pole dragged in the lab with the ghost following.

    python tests/e2e/pictures.py [--only screenshot|drag]

The drag is one of the page itself, stopped at a moment of the run; the pointer is drawn in, since no screenshot shows it.
"""

# ruff: noqa: E402 — the folders of the app and of the browser tests must be found first

from __future__ import annotations

import argparse
import io
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).parents[2]), str(Path(__file__).parent)]

from conftest import ROOT, chromium, serving  # type: ignore[import-not-found]
from geometry import on_screen  # type: ignore[import-not-found]
from PIL import Image, ImageDraw
from playwright.sync_api import Page, sync_playwright
from tab import DRAWN, FLAGS, Tab, eventually  # type: ignore[import-not-found]

from observer_lab.course.scenes import entry_values
from observer_lab.lessons import LESSONS
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token

LESSON, SCENE, BOARD, MOMENT = "separation", "drag", "observer", "0.15"
WINDOW, SIZE = (1366, 768), (860, 484)  # px of the page, and of the moving picture
WAY = (-9 + 6j, -3 + 4.5j, -1.5 + 6j, -3 + 9j, -8 + 9j, -14 + 8j, -17 + 5j, -12 + 4.5j, -9 + 6j)  # of the pole
BETWEEN, PAUSE = 4, 130  # pictures from one place of the way to the next, ms from one picture to the next
QUALITY, MOST = 40, 400_000  # of the moving picture; bytes of either
SHADOWS = "localStorage.setItem('observer-lab-light', 'full')"  # as where a graphics card draws
PATIENCE, LETTERED = 60_000, 5000  # ms; until the labels of the stage stand, which come after their boards
POINTER = ((0, 0), (0, 17), (4, 13), (7, 20), (10, 19), (7, 12), (12, 12))


def opened(tab: Tab) -> None:
    """The lesson, predicted and stopped at the moment."""
    words = LESSONS[LESSON].words["en"]
    tab.choose_lesson(words.title, words.question)
    tab.predict("B")
    tab.reveal()

    def stopped() -> float:
        if tab.button("‖ pause").count():
            tab.press("‖ pause")
        tab.type_number("time t [s]", MOMENT)
        return tab.clock()
    eventually(stopped, lambda t: t == float(MOMENT), "the run stopped at the moment")
    tab.page.evaluate("document.activeElement.blur()")
    tab.close_any_notices()
    tab.drawn()


def guide(page: Page, address: str) -> Image.Image:
    """A scene of the guide as it is entered, with the hand that shows where to drag."""
    lesson = LESSONS[LESSON]
    k = next(k for k, scene in enumerate(lesson.path) if scene.id == SCENE)
    entered = lesson.apply(lesson.start(), entry_values(lesson.path, k, lesson.start()))
    page.goto(f"{address}#{write_token(lesson, SavedState(entered, 'en', False, mode='guide', scene=SCENE))}")
    page.wait_for_selector(f".ol-card[data-scene={SCENE}]", timeout=PATIENCE)
    page.wait_for_selector(".ol-hand:not([hidden])", state="attached", timeout=PATIENCE)
    page.wait_for_function("window.observerLabViser.scene().environment !== null", timeout=PATIENCE)
    page.wait_for_timeout(LETTERED)
    page.evaluate(DRAWN)
    return Image.open(io.BytesIO(page.screenshot())).convert("RGB")


def drag(tab: Tab) -> list[Image.Image]:
    """Pictures of the page while its pole goes along the way."""
    board = next(b for b in LESSONS[LESSON].compute(LESSONS[LESSON].start()).boards if b.id == BOARD)
    seen = np.array([on_screen(tab, f"/board/{BOARD}/pole{k}") for k in range(len(board.poles))])
    known = np.array([(1.0, pole.real, pole.imag) for pole in board.poles])
    onto = np.linalg.lstsq(known, seen, rcond=None)[0]  # (1, Re, Im) → pixel: the board is flat and nearly faces the camera
    corners = np.array([(1.0, s.real, s.imag) for s in WAY]) @ onto
    steps = [a + (b - a) * share for a, b in pairwise(corners) for share in np.linspace(0, 1, BETWEEN, endpoint=False)]
    mouse, pictures = tab.page.mouse, []
    mouse.move(*steps[0])
    tab.page.wait_for_function("window.observerLabPulse === 'told'")
    mouse.down()
    for x, y in steps:
        mouse.move(x, y)
        tab.answered()
        tab.drawn()
        picture = Image.open(io.BytesIO(tab.page.screenshot())).convert("RGB")
        ImageDraw.Draw(picture).polygon([(x + dx, y + dy) for dx, dy in POINTER], fill="white", outline="black")
        pictures.append(picture.resize(SIZE, Image.Resampling.LANCZOS))
    mouse.up()
    return pictures


def main() -> None:
    """Make what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=("screenshot", "drag"))
    only = parser.parse_args().only
    with serving() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        if only != "drag":
            page = browser.new_page(viewport={"width": 1366, "height": 768}, reduced_motion="reduce")
            page.add_init_script(SHADOWS)
            path = ROOT / "assets" / "screenshot.png"
            guide(page, address).save(path, optimize=True)
            assert path.stat().st_size < MOST, f"{path.stat().st_size} bytes"
            page.close()
        if only != "screenshot":
            page = browser.new_page(viewport={"width": WINDOW[0], "height": WINDOW[1]})
            page.add_init_script(SHADOWS)
            tab = Tab(page, address)
            opened(tab)
            tab.page.locator("[data-dock-region=right] [data-dock-tab]").first.click()
            first, *others = drag(tab)
            path = ROOT / "assets" / "drag.webp"
            first.save(path, save_all=True, append_images=others, duration=PAUSE, loop=0, quality=QUALITY, method=6)
            assert path.stat().st_size < MOST, f"{path.stat().st_size} bytes"
            tab.page.close()
        browser.close()


if __name__ == "__main__":
    main()
