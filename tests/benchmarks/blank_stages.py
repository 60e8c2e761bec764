"""Look for pictures in which the stage is blank: act on a page, take a picture at once, and see whether anything stands on the stage.

    python tests/benchmarks/blank_stages.py [--pictures 500] [--minutes 10] [--size 1000x600]

The acts are those that change the resolution of the scene or lay the page out anew: a move of the pointer over the stage, keys of a
slider, playing, a new size of the window, another theme, another lesson. The ground of the stage is a gradient from top to bottom, so a
blank stage has rows of one colour. Beside the pictures every frame of the browser is watched: a canvas that got another size and was
not drawn before the frame was shown is blank for as long as that frame. Ends with status 1 where one of either was found, or where the
time was over before the pictures were taken.
"""

# ruff: noqa: E402 — the folders of the app and of the browser tests must be found first

from __future__ import annotations

import argparse
import random
import sys
import time
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

sys.path[:0] = [str(Path(__file__).parents[2]), str(Path(__file__).parents[1] / "e2e")]

from conftest import ARTEFACTS, chromium, serving  # type: ignore[import-not-found]
from tab import FLAGS, Tab  # type: ignore[import-not-found]

EMPTY = 2.0  # grey levels: a picture in which no row varies more shows nothing but its ground
WATCH = """() => {
  const page = window.__viserMutable, canvas = page.canvas, seen = page.scene.onAfterRender;
  if (canvas.observerLabWatched) return;
  canvas.observerLabWatched = true;
  const found = window.observerLabBlank ??= {frames: 0, sizes: 0, blank: 0};
  const own = Object.getOwnPropertyDescriptor(HTMLCanvasElement.prototype, 'width');
  let cleared = null;  // the frame before which the canvas got another size, and after which it has not been drawn
  Object.defineProperty(canvas, 'width', {
    get() { return own.get.call(this); },
    set(value) { own.set.call(this, value); cleared ??= found.frames; found.sizes += 1; }});
  page.scene.onAfterRender = (...all) => { seen?.(...all); cleared = null; };
  const frame = () => {
    if (cleared !== null && found.frames > cleared) found.blank += 1;  // a whole frame has passed, and was shown, since then
    found.frames += 1;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}"""
STAGE = """() => { const box = window.__viserMutable.canvas.getBoundingClientRect();
  return {x: box.x + box.width * .1, y: box.y + box.height * .3, width: box.width * .8, height: box.height * .35}; }"""


def act(tab: Tab, lot: random.Random, size: tuple[int, int]) -> str:
    """Do something that changes how the stage is drawn, and do not wait for it; what was done."""
    page, what = tab.page, lot.choices(("pointer", "key", "play", "size", "theme", "lesson"), (6, 4, 3, 6, 1, 1))[0]
    box = page.evaluate(STAGE)
    if what == "pointer":
        page.mouse.move(box["x"] + box["width"] * lot.random(), box["y"] + box["height"] * lot.random())
        page.mouse.wheel(0, lot.choice((-40, 40)))
    elif what == "key":
        page.keyboard.press(lot.choice(("1", "2", "k")))
    elif what == "play":
        page.keyboard.press("Space")
    elif what == "size":
        page.set_viewport_size({"width": size[0] + lot.randrange(-60, 60), "height": size[1] + lot.randrange(-30, 30)})
    elif what == "theme":
        page.keyboard.press("d")
    else:
        page.keyboard.press(lot.choice(("n", "p")))
    page.wait_for_timeout(lot.choice((0, 0, 10, 30, 100, 400, 480)))
    return what


def is_blank(picture: bytes) -> bool:
    """Whether no row of a picture of the stage varies."""
    grey = np.asarray(Image.open(BytesIO(picture)).convert("L")).astype(float)
    return float(grey.std(axis=1).max()) < EMPTY


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pictures", type=int, default=500)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--size", default="1000x600")
    options = parser.parse_args()
    size, lot, end = tuple(int(v) for v in options.size.split("x")), random.Random(1), time.monotonic() + 60 * options.minutes
    taken, blank = 0, list[str]()
    with serving() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        tab = Tab(browser.new_page(viewport={"width": size[0], "height": size[1]}), address)
        tab.predict("skip")
        while taken < options.pictures and time.monotonic() < end:
            tab.page.evaluate(WATCH)
            what = act(tab, lot, (size[0], size[1]))
            picture = tab.page.screenshot(clip=tab.page.evaluate(STAGE), type="png")
            taken += 1
            if is_blank(picture):
                blank.append(f"picture {taken}, after {what}")
                ARTEFACTS.mkdir(exist_ok=True)
                (ARTEFACTS / f"blank-{taken}.png").write_bytes(picture)
        frames = tab.page.evaluate("window.observerLabBlank")
        browser.close()
    print(f"{taken} pictures, {len(blank)} blank: {blank}; {frames['frames']} frames, {frames['sizes']} new sizes of the canvas, "
          f"{frames['blank']} frames shown without a drawing")
    raise SystemExit(bool(blank) or frames["blank"] > 0 or taken < options.pictures)


if __name__ == "__main__":
    main()
