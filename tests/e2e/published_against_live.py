"""Compare a published folder with the live page, state by state: `python tests/e2e/published_against_live.py FOLDER [LESSON …]`.

It walks every scene of the lessons in the folder, prints one line for each state, and ends with 1 where one differs, where a page
reported an error, or where a request left the folder.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, Request, sync_playwright
from tab import CURVES, FLAGS, HARMLESS, UNDRAWN, eventually

from observer_lab.course.scenes import Choose, Press
from observer_lab.lessons import LESSONS

SEEN = """() => ({
  card: document.querySelector('.ol-card')?.innerText ?? '', answer: document.querySelector('.ol-answer')?.innerText ?? '',
  way: [...document.querySelectorAll('.ol-way button')].map(each => each.innerText),
  figures: [...document.querySelectorAll('.ol-figure')].filter(each => each.checkVisibility()).map(each => each.innerText),
  captions: [...document.querySelectorAll('.ol-caption')].filter(each => each.checkVisibility()).map(each => each.innerText),
  knobs: [...document.querySelectorAll('[role=slider], input[type=checkbox]')].filter(each => each.checkVisibility())
    .map(each => each.getAttribute('aria-valuenow') ?? String(each.checked)),
  boards: Object.keys(window.__viserMutable?.nodeRefFromName ?? {}).filter(name => name.startsWith('/board/')).sort(),
})"""
PIXEL = 2e-3  # of a curve's range: less than one pixel of a chart
BESIDES = ("mode:",)  # what the published page does not offer


def seen(page: Page) -> dict[str, Any]:
    """What a page shows, with its curves."""
    return {**page.evaluate(SEEN), "curves": page.evaluate(CURVES)}


def differences(live: dict[str, Any], published: dict[str, Any]) -> list[str]:
    """In what two pages differ; curves by less than a pixel do not."""
    out = [name for name in live if name not in ("curves", "way") and live[name] != published[name]]
    if [title for title, _ in live["curves"]] != [title for title, _ in published["curves"]]:
        return [*out, "titles of charts"]
    for (title, ours), (_, theirs) in zip(live["curves"], published["curves"], strict=True):
        if len(ours) != len(theirs) or not all(map(_same_row, ours, theirs)):
            out.append(f"curves of {title}")
    return out


def _same_row(ours: list[float | None], theirs: list[float | None]) -> bool:
    known = [abs(value) for value in ours if value is not None]
    most = PIXEL * max([*known, 1e-12])
    return len(ours) == len(theirs) and all(
        (a is None) == (b is None) and (a is None or b is None or abs(a - b) <= most) for a, b in zip(ours, theirs, strict=True))


def at_scene(page: Page, scene: str) -> None:
    """Wait until the card of a scene stands."""
    eventually(lambda: page.locator(".ol-card").get_attribute("data-scene"), lambda found: found == scene, f"the scene {scene}")


def press(page: Page, value: str) -> None:
    """Press a button of the card, also where something lies over it."""
    page.locator(f'[data-value="{value}"]').first.dispatch_event("click")


def settled(page: Page) -> dict[str, Any]:
    """What a page shows once two looks in a row agree."""
    last: list[dict[str, Any]] = [{}]

    def look() -> bool:
        now = seen(page)
        same, last[0] = now == last[0], now
        page.wait_for_timeout(250)
        return same
    eventually(look, bool, "a page at rest")
    return last[0]


def states(live: Page, published: Page, lesson: str) -> Iterator[tuple[str, list[str]]]:
    """Each state of a lesson and in what the two pages differ there; both stand on its first scene."""
    for k, scene in enumerate(LESSONS[lesson].path):
        for page in (live, published):
            if page.locator(".ol-card").get_attribute("data-scene") != scene.id:
                press(page, f"scene:{k}")
            at_scene(page, scene.id)
        yield f"{lesson}/{scene.id}", differences(settled(live), settled(published))
        if isinstance(scene.do, Choose):
            for page in (live, published):
                press(page, "option:0")
                eventually(lambda page=page: page.locator(".ol-way .ol-next").count(), bool, f"the verdict of {scene.id}")
            yield f"{lesson}/{scene.id}/option 0", differences(settled(live), settled(published))
        elif isinstance(scene.do, Press) and scene.do.button == "kick":
            for page in (live, published):
                page.keyboard.press("k")
                eventually(lambda page=page: page.locator(".ol-way .ol-next").count(), bool, f"the kick of {scene.id}")


def opened(browser: Browser, address: str, complaints: list[str]) -> Page:
    """A page that asks for calm, whose errors and whose requests to elsewhere are written down."""
    context = browser.new_context(viewport={"width": 1366, "height": 768}, reduced_motion="reduce")
    context.add_init_script(f"({UNDRAWN})()")
    page, home = context.new_page(), address.partition("?")[0].rpartition("/")[0]

    def ask(request: Request) -> None:
        if not request.url.startswith((home, "data:", "blob:")):
            complaints.append(f"a request left: {request.url[:120]}")
    page.on("request", ask)
    page.on("pageerror", lambda error: complaints.append(error.stack or str(error)))
    page.on("console", lambda said: complaints.append(said.text)
            if said.type == "error" and not any(word in said.text for word in HARMLESS) else None)
    page.goto(address)
    page.wait_for_selector(".ol-card", timeout=120_000)
    return page


def main(folder: Path, lessons: list[str]) -> int:
    """Compare all lessons of the folder, in English."""
    from conftest import serving

    there = [path.name for path in sorted((folder / "data").iterdir()) if path.is_dir() and path.name in LESSONS]
    bad, count = 0, 0
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(args=FLAGS, executable_path="/usr/bin/chromium-headless-shell")
        for lesson in lessons or there:
            complaints: list[str] = []
            with serving(0, "--view", "guide", "--lesson", lesson) as address:
                live = opened(browser, address, [])
                published = opened(browser, f"{(folder / 'index.html').resolve().as_uri()}?lesson={lesson}&lang=en&theme=light", complaints)
                for state, found in states(live, published, lesson):
                    count, bad = count + 1, bad + bool(found)
                    print(f"{state}: {', '.join(found) or 'equal'}", flush=True)
                for page in (live, published):
                    page.context.close()
            bad += len(complaints)
            print(f"{lesson}: {len(complaints)} errors and requests to elsewhere {json.dumps(complaints)[:400]}", flush=True)
    print(f"{count} states, {bad} differences")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
