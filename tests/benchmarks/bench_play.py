"""What a second of a playing run costs the browser, beside the same page whose cursor is a rule for all of its elements.

`PYTHONPATH=. python tests/benchmarks/bench_play.py [LESSON …]`: for each lesson the milliseconds of the page's main thread in a second
of play, those of them spent on styles, and the frames in that second; then the same page with a style sheet that is written anew
whenever the clock moves, in the same minute. The scene's drawing is left out: without a graphics card it would cover all the rest.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1] / "e2e"))

from conftest import chromium, serving
from playwright.sync_api import CDPSession, sync_playwright
from tab import FLAGS, Tab

from observer_lab.lessons import LESSONS

SECONDS = 3.0  # s of play that are watched
COUNT = "() => { window.frames_ = 0; const next = () => { window.frames_ += 1; requestAnimationFrame(next); }; next(); }"
RULE = """() => {
  const sheet = document.head.appendChild(document.createElement('style'));
  new MutationObserver(() => {
    const rule = `:root{--as-a-rule:${document.querySelector('.ol-clock').dataset.share}}`;
    if (sheet.textContent !== rule) sheet.textContent = rule;
  }).observe(document.body, {childList: true, subtree: true});
}"""


class Cost(NamedTuple):
    """Of a second of play: ms of the page's main thread, ms of them for styles, frames."""

    busy: float
    styles: float
    frames: float


def cost(tab: Tab, told: CDPSession) -> Cost:
    """What the page does while the run plays from its beginning."""
    def now() -> tuple[float, float, float, float]:
        seen = {each["name"]: each["value"] for each in told.send("Performance.getMetrics")["metrics"]}
        return seen["TaskDuration"], seen["RecalcStyleDuration"], tab.page.evaluate("window.frames_"), time.monotonic()
    tab.press("reset")
    tab.press("▶ play", rests=False)
    before = now()
    time.sleep(SECONDS)
    busy, styles, frames, passed = (b - a for a, b in zip(before, now(), strict=True))
    return Cost(1000 * busy / passed, 1000 * styles / passed, frames / passed)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("lessons", nargs="*", default=["lqg", "noise", "separation"], metavar="LESSON")
    lessons = parser.parse_args().lessons
    print("| lesson | page, styles, frames | with a rule for all | styles, old : new |\n|---|---|---|---|")
    with serving() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        for lesson in lessons:
            found = []
            for as_a_rule in (False, True):
                page = browser.new_page(viewport={"width": 1366, "height": 768}, reduced_motion="reduce")
                tab, words = Tab(page, address, drawn=False), LESSONS[lesson].words["en"]
                told = page.context.new_cdp_session(page)
                told.send("Performance.enable")
                tab.choose_lesson(words.title, words.question)
                tab.predict("skip")
                page.evaluate(COUNT)
                if as_a_rule:
                    page.evaluate(RULE)
                found.append(cost(tab, told))
                page.close()
            ours, theirs = found
            print(f"| {lesson} | " + " | ".join(f"{c.busy:.0f} ms, {c.styles:.0f} ms, {c.frames:.0f}" for c in found)
                  + f" | {theirs.styles / ours.styles:.0f} |", flush=True)
        browser.close()


if __name__ == "__main__":
    main()
