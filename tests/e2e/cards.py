"""The pictures on the page of all lessons, as lessons/<id>/card.webp: the stage where plant and ghost stand apart, or a figure.

    python tests/e2e/cards.py [--lesson separation]
"""

# ruff: noqa: E402 — the folders of the app and of the browser tests must be found first

from __future__ import annotations

import argparse
import io
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parents[2]), str(Path(__file__).parent)]

from conftest import chromium, serving  # type: ignore[import-not-found]
from matplotlib.figure import Figure
from PIL import Image
from playwright.sync_api import sync_playwright
from tab import FLAGS, Tab, eventually  # type: ignore[import-not-found]

from observer_lab.colours import COLOURS
from observer_lab.course.error_window import find_error_window
from observer_lab.course.figures.records import PlaneFigure
from observer_lab.lessons import LESSONS
from observer_lab.page.charts.style_sheet import clock_decimals
from observer_lab.page.replay.transport import step_of

WINDOW = (1366, 768)
SIZE = (300, 225)  # px of a card's picture
TOP = 104  # px above what it shows
QUALITY = 62
FIGURES = {"lqg": ("rings", {"case": "doyle", "recovery": 4.0})}  # lessons whose figure says more than their stage, and at which knobs
LINES = {"solid": "-", "dash": "--", "dot": ":"}
BETWEEN = """() => {  // where the stage lies bare: right of the left column, left of the figures
  const boxes = [...document.querySelectorAll('.mantine-Paper-root')].map(paper => paper.getBoundingClientRect());
  return [Math.max(0, ...boxes.filter(box => box.left < 300).map(box => box.right)),
          Math.min(innerWidth, ...boxes.filter(box => box.left > 800).map(box => box.left))];
}"""


def take(tab: Tab, name: str) -> Image.Image:
    """The stage of a lesson at the moment in which the error is largest."""
    lesson = LESSONS[name]
    tab.choose_lesson(lesson.words["en"].title, lesson.words["en"].question)
    tab.predict("skip")
    stage = lesson.compute(lesson.start()).stage
    horizon = 0.0 if stage is None else float(stage.t[-1])
    part = None if stage is None else find_error_window(stage, 0.0)
    moment = 0.0 if part is None else max(part.peak, part.begin + 0.03 * (part.end - part.begin))

    def shown() -> bool:
        """Whether the stage shows that moment, as near as the clock tells."""
        return stage is None or abs(tab.clock() - moment) <= step_of(horizon) + 0.1 ** clock_decimals(horizon) + 0.005 * moment

    def shot() -> bytes:
        """The page, if it shows the moment before and after it is taken: what played until now may go on over what is typed."""
        if stage is not None:
            tab.type_number("time t [s]", f"{moment:.3g}")
        tab.page.evaluate("document.activeElement.blur()")
        tab.key("2")
        tab.page.evaluate("window.observerLabDraws = true")
        tab.drawn()
        before, seen = shown(), tab.page.screenshot()
        tab.page.evaluate("window.observerLabDraws = false")
        return seen if before and shown() else b""
    picture = Image.open(io.BytesIO(eventually(shot, bool, f"the moment {moment:.3g} s")))
    left, right = tab.page.evaluate(BETWEEN)
    bottom = TOP + (right - left) * SIZE[1] / SIZE[0]
    return picture.crop((int(left), TOP, int(right), int(bottom))).resize(SIZE, Image.Resampling.LANCZOS).convert("RGB")


def draw(name: str) -> Image.Image:
    """The figure of a lesson that says most, without words."""
    id, values = FIGURES[name]
    lesson = LESSONS[name]
    outcome = lesson.compute(lesson.apply(lesson.start(), values))
    figure = next(f for f in lesson.figures(outcome) if f.id == id)
    assert isinstance(figure, PlaneFigure)
    sheet = Figure(figsize=(SIZE[0] / 100, SIZE[1] / 100), dpi=100)
    axes = sheet.add_axes((0.0, 0.0, 1.0, 1.0), aspect="equal")
    for curve in figure.curves:
        axes.plot(curve.x, curve.y, LINES[curve.dash], color=COLOURS[curve.role], lw=0.8 * curve.width)
    for point in figure.points:
        axes.plot(point.x, point.y, "x", color=COLOURS[point.role], ms=9, mew=2.5)
    axes.set(xlim=(-2.75, 0.5), ylim=figure.y_range)
    axes.axis("off")
    saved = io.BytesIO()
    sheet.savefig(saved)
    return Image.open(saved).convert("RGB")


def main() -> None:
    """Take them all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lesson", choices=list(LESSONS), action="append")
    options = parser.parse_args()
    with serving() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        for name in options.lesson or LESSONS:
            path = LESSONS[name].place.picture
            assert path is not None
            if name in FIGURES:
                draw(name).save(path, quality=QUALITY, method=6)
                continue
            context = browser.new_context(viewport={"width": WINDOW[0], "height": WINDOW[1]}, reduced_motion="reduce")
            take(Tab(context.new_page(), address, drawn=False), name).save(path, quality=QUALITY, method=6)
            print(f"{path.name} of {name}: {path.stat().st_size} bytes", flush=True)
            context.close()
        browser.close()


if __name__ == "__main__":
    main()
