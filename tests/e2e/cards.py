"""The pictures on the page of lessons: card.webp and, for two seconds of the run, loop.webp in each lesson's folder; the opening's two.

    python tests/e2e/cards.py [--lesson separation] [--opening]
"""

# ruff: noqa: E402 — the folders of the app and of the tests must be found first

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path[:0] = [str(Path(__file__).parents[2]), str(Path(__file__).parent), str(Path(__file__).parents[1] / "tab")]

import numpy as np
from conftest import chromium  # type: ignore[import-not-found]
from fakes import Tab  # type: ignore[import-not-found]
from PIL import Image
from playwright.sync_api import Page, sync_playwright
from tab import FLAGS  # type: ignore[import-not-found]

from observer_lab.course.error_window import find_error_window
from observer_lab.course.figures.records import MapFigure
from observer_lab.lessons import LESSONS
from observer_lab.page.replay.replay import replay
from observer_lab.page.stage.body_extent import reach
from observer_lab.page.stage.viewpoint import CAMERAS, USUAL_HALF_WIDTH, USUAL_HEIGHT
from observer_lab.session.state.view import Picture

SIZE, FRAMES, SECONDS = (300, 225), 16, 2.0  # px of a card's picture; frames of a loop and how long they last
OPENING, LARGE, MANY, LONG, SHOWN = "saturation", (960, 380), 40, 4.0, 4.4  # its lesson, px, frames, s that they last, s of the run
CAUGHT = {"fed": "applied", "angle0": 12.0, "error0": 12.0, "u_max": 10.0, "observer_poles": (-6 - 2j, -6 + 2j, -5 - 1.5j, -5 + 1.5j)}
HERE = Path(__file__).parents[2] / "app/page/web/pictures"
QUALITY = {SIZE: 50, LARGE: 52}
AIM, LIFT, NEARER, NEAREST = 0.45, 0.8, 0.9, 0.25  # the middle, of a body's height; the eye, of the plant's view
BARE = """html:root body{display:block}.ol-replay-head,.ol-replay-bar,.ol-replay-side{display:none!important}
#root{position:fixed!important;inset:0!important;width:100vw!important;height:100vh!important}"""
WORDLESS = """() => observerLabViser.scene().traverse(part => {
  if (part.material?.fragmentShader?.includes('vAlpha')) part.visible = false;
})"""
SET = """async t => {
  const time = document.querySelector('.ol-replay-time');
  time.value = t;
  time.dispatchEvent(new Event('input'));
  const page = window.__viserMutable;
  for (let k = 0; k < 3; k += 1) await new Promise(done => {
    observerLabViser.afterFrame(done);
    page.requestRender();
    observerLabViser.drawFrame();
  });
}"""


def picture_of(name: str, values: Mapping[str, object]) -> Picture:
    """The lab's picture of a lesson, without boards and maps."""
    tab = Tab(LESSONS, name, insists=True)
    tab.set(**values)
    tab.rest()
    shown = tab.picture
    return replace(shown, outcome=replace(shown.outcome, boards=()),
                   figures=tuple(figure for figure in shown.figures if not isinstance(figure, MapFigure)))


def eye_of(picture: Picture, size: tuple[int, int]) -> tuple[float, ...]:
    """Position and target from which the body fills the picture."""
    stage = picture.outcome.stage
    assert stage is not None
    half, high = reach(stage)
    scale = max(half / USUAL_HALF_WIDTH * min(1.0, 1.33 * size[1] / size[0]), high / USUAL_HEIGHT, NEAREST)
    (_, away, up), aim = CAMERAS["plant"][0], AIM * high
    return 0.0, NEARER * scale * away, aim + NEARER * LIFT * scale * (up - 1.0), 0.0, 0.0, aim


def moments(picture: Picture) -> list[float]:
    """The moments of a loop: where plant and ghost stand apart, and on until they meet."""
    stage = picture.outcome.stage
    assert stage is not None
    part = find_error_window(stage, 0.0)
    return [float(t) for t in np.linspace(part.begin, part.end, FRAMES)]


def frames(page: Page, folder: Path, picture: Picture, at: Sequence[float], size: tuple[int, int]) -> list[Image.Image]:
    """The stage at these moments."""
    path = folder / "replay.html"
    path.write_text(replay(picture, "", eye_of(picture, size)), encoding="utf-8")
    page.set_viewport_size({"width": 2 * size[0], "height": 2 * size[1]})
    page.goto(path.as_uri())
    page.add_style_tag(content=BARE)
    page.wait_for_function("document.querySelector('.ol-replay-wait')?.hidden && window.observerLabViser.isDrawn()", timeout=120_000)
    page.wait_for_timeout(1500)
    taken = []
    for t in at:
        page.evaluate(SET, t)
        page.evaluate(WORDLESS)
        page.evaluate(SET, t)
        shot = Image.open(io.BytesIO(page.screenshot(timeout=120_000))).convert("RGB")
        taken.append(shot.resize(size, Image.Resampling.LANCZOS))
    return taken


def save(taken: Sequence[Image.Image], still: Path, loop: Path, seconds: float) -> None:
    """Write the still picture, in which plant and ghost stand well apart, and the loop."""
    first = taken[1]
    first.save(still, quality=QUALITY[first.size], method=6)
    taken[0].save(loop, save_all=True, append_images=taken[1:], duration=round(1000 * seconds / len(taken)), loop=0,
                  quality=QUALITY[first.size], method=6)
    print(f"{loop}: {still.stat().st_size} and {loop.stat().st_size} bytes", flush=True)


def main() -> None:
    """Take them all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lesson", choices=list(LESSONS), action="append")
    parser.add_argument("--opening", action="store_true")
    options = parser.parse_args()
    with TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        page = browser.new_context(reduced_motion="reduce").new_page()
        for name in options.lesson or ([] if options.opening else LESSONS):
            card, picture = LESSONS[name].place.picture, picture_of(name, {})
            assert card is not None
            save(frames(page, Path(folder), picture, moments(picture), SIZE), card, card.with_name("loop.webp"), SECONDS)
        if options.opening or not options.lesson:
            shown = frames(page, Path(folder), picture_of(OPENING, CAUGHT), [SHOWN * k / MANY for k in range(MANY)], LARGE)
            save(shown, HERE / "opening.webp", HERE / "opening-loop.webp", LONG)
        browser.close()


if __name__ == "__main__":
    main()
