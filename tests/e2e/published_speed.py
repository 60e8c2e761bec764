"""Measure a published folder beside the live page: `python tests/e2e/published_speed.py FOLDER [LESSON …]`.

For each lesson the first picture of both, opened in turn; the time from a press to the next scene's card with its stage; and the
memory of the page after the first walk through its scenes and after 200 more changes. The status is 1 where one is worse than asked.
"""

from __future__ import annotations

import argparse
import sys
from functools import partial
from itertools import pairwise
from pathlib import Path
from statistics import median

from playwright.sync_api import Browser, Page, sync_playwright
from published_against_live import at_scene
from tab import FLAGS

from observer_lab.lessons import LESSONS
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token

OPENINGS, CHANGES, MOST_CHANGE_MS, MOST_GROWTH = 5, 200, 200.0, 0.1
SLOWER = 1.1  # times the live page's first picture: two openings of one page differ by that
STANDS = """() => {
  const card = document.querySelector('.ol-card'), cover = document.querySelector('.ol-cover');
  return !!card && !cover?.checkVisibility() && !!window.observerLabViser?.isDrawn() && window.__viserMutable.messageQueue.length === 0;
}"""
CHANGE = """async ([value, wanted]) => {  // ms from a press to the card of a scene, drawn, with all that was said of the stage taken up
  const begun = performance.now();
  document.querySelector(`[data-value="${value}"]`).click();
  for (;;) {
    await new Promise(done => requestAnimationFrame(done));
    const there = document.querySelector('.ol-card')?.dataset.scene === wanted && window.__viserMutable.messageQueue.length === 0;
    if (there || performance.now() - begun > 20000) return performance.now() - begun;
  }
}"""


def first_picture(browser: Browser, address: str) -> float:
    """Seconds from an address to a page that stands, in a browser that was never there."""
    context = browser.new_context(viewport={"width": 1366, "height": 768}, reduced_motion="reduce")
    page = context.new_page()
    page.goto("about:blank")
    begun = page.evaluate("performance.timeOrigin + performance.now()")
    page.goto(address, wait_until="commit")
    page.wait_for_function(STANDS, timeout=120_000, polling="raf")
    taken = page.evaluate("performance.timeOrigin + performance.now()") - begun
    context.close()
    return taken / 1000


def heap(page: Page) -> float:
    """The memory of a page in MB once nothing more can be given back."""
    session = page.context.new_cdp_session(page)
    for _ in range(2):
        session.send("HeapProfiler.collectGarbage")
    return session.send("Runtime.getHeapUsage")["usedSize"] / 1e6


def changes(browser: Browser, address: str, names: list[str]) -> tuple[list[float], float, float]:
    """Milliseconds of each change to a scene that was seen before, and the memory before and after them."""
    page = browser.new_context(viewport={"width": 1366, "height": 768}, reduced_motion="reduce").new_page()
    page.goto(address)
    at_scene(page, names[0])
    press, there_and_back = partial(page.evaluate, CHANGE), [*range(len(names)), *range(len(names) - 2, -1, -1)]
    steps = list(pairwise(there_and_back))
    for _, there in steps:
        press([f"scene:{there}", names[there]])
    before, taken = heap(page), []
    while len(taken) < CHANGES:
        taken += [press([f"scene:{there}", names[there]]) for _, there in steps]
    after = heap(page)
    page.context.close()
    return taken, before, after


def main() -> int:
    """Measure the lessons."""
    from conftest import chromium, serving

    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("lessons", nargs="*", default=["separation"])
    asked, bad = parser.parse_args(), 0
    with sync_playwright() as playwright, serving(0, "--view", "guide") as served:
        browser = playwright.chromium.launch(args=FLAGS, executable_path=chromium())
        for id in asked.lessons:
            lesson = LESSONS[id]
            token = write_token(lesson, SavedState(lesson.start(), "en", mode="guide", scene=lesson.path[0].id))
            published = f"{(asked.folder / 'index.html').resolve().as_uri()}?lesson={id}&lang=en&theme=light&scene={lesson.path[0].id}"
            seen: dict[str, list[float]] = {f"{served}#{token}": [], published: []}
            for k in range(OPENINGS):
                for address in [*seen][:: 1 - 2 * (k % 2)]:  # neither is always the second one
                    seen[address].append(first_picture(browser, address))
            live, ours = map(median, seen.values())
            taken, before, after = changes(browser, published, [scene.id for scene in lesson.path])
            slow = sorted(taken)[int(0.95 * len(taken))]
            print(f"{id}: first picture live {live:.2f} s, published {ours:.2f} s; a scene's change {median(taken):.0f} ms in the median, "
                  f"{slow:.0f} ms in 95 of 100; memory {before:.1f} MB before, {after:.1f} MB after {len(taken)} changes", flush=True)
            bad += ours > SLOWER * live or slow > MOST_CHANGE_MS or after > (1 + MOST_GROWTH) * before
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
