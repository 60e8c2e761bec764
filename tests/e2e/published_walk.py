"""Walk a published folder as its readers have it: `python tests/e2e/published_walk.py FOLDER [LESSON …] [--whole]`.

It walks all scenes of a lesson from a file, from a plain web server, in a sandboxed frame without storage, and on a phone with touch.
Questions are answered, and axe-core looks at each scene from the web server and on the phone. A line for each walk; the status is 1
where a page reported an error, a request left the folder, or axe-core has found something serious. Without `--whole` the walks are
shared out among the lessons; with it each lesson has all of them.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

from axe_rules import serious
from playwright.sync_api import Browser, Frame, Page, Request, sync_playwright
from published_against_live import at_scene, looks_in, press
from tab import FLAGS, HARMLESS, UNDRAWN, eventually

from observer_lab.course.scenes import Choose
from observer_lab.lessons import LESSONS

PLACES = ("file", "server", "frame", "phone")
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True, "device_scale_factor": 2}
WIDE = {"viewport": {"width": 1366, "height": 768}}
FRAME = '<!doctype html><title>a course</title><iframe sandbox="allow-scripts" width="1340" height="740" src="{}"></iframe>'
CARD_S = 120.0  # s within which the first card stands


@dataclass
class Walk:
    """What a walk found."""

    scenes: int = 0
    complaints: list[str] = field(default_factory=list)
    rules: list[str] = field(default_factory=list)

    def listen(self, page: Page, home: str) -> None:
        """Write down the errors of a page, and its requests to elsewhere."""
        def ask(request: Request) -> None:
            if not request.url.startswith((home, "data:", "blob:", "about:")):
                self.complaints.append(f"a request left: {request.url[:120]}")
        page.on("request", ask)
        page.on("requestfailed", lambda request: self.complaints.append(f"not found: {request.url[:120]}"))
        page.on("pageerror", lambda error: self.complaints.append(error.stack or str(error)))
        page.on("console", lambda said: self.complaints.append(said.text)
                if said.type == "error" and not any(word in said.text for word in HARMLESS) else None)


class Quiet(SimpleHTTPRequestHandler):
    """A plain web server that prints nothing."""

    def log_message(self, format: str, *args: Any) -> None:
        """Print nothing."""


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """The address at which a plain web server gives the folder."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder))) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()


def walked(browser: Browser, folder: Path, home: str, lesson: str, look: str, place: str,
           looks_at: Callable[[Page], Sequence[tuple[str, Any]]] = serious) -> Walk:
    """Walk one lesson in a look such as en-light at one of the places; `home` is where the folder is served."""
    language, _, theme = look.partition("-")
    context = browser.new_context(**(PHONE if place == "phone" else WIDE), reduced_motion="reduce")
    context.add_init_script(f"({UNDRAWN})()")
    page, walk = context.new_page(), Walk()
    root = folder.resolve().as_uri() if place == "file" else home
    walk.listen(page, root)
    address = f"{root}/index.html?lesson={lesson}&lang={language}&theme={theme}"
    if place == "frame":
        page.set_content(FRAME.format(address.replace("&", "&amp;")))
    else:
        page.goto(address)
    shown = _inside(page) if place == "frame" else page
    shown.wait_for_selector(".ol-card", timeout=1000 * CARD_S)
    for k, scene in enumerate(LESSONS[lesson].path):
        if k:
            press(shown, f"scene:{k}")
        at_scene(shown, scene.id)
        if isinstance(scene.do, Choose):
            press(shown, "option:0")
            eventually(shown.locator(".ol-way .ol-next").count, bool, f"the verdict of {scene.id}")
        if place in ("server", "phone"):
            walk.rules += [f"{scene.id}: {rule} {where}" for rule, where in looks_at(page)]
        walk.scenes += 1
    context.close()
    return walk


def _inside(page: Page) -> Frame:
    """The page in the frame of a page."""
    eventually(lambda: len(page.frames), lambda count: count == 2, "a frame")
    return page.frames[1]


def main() -> int:
    """Walk the lessons of the folder."""
    from conftest import chromium

    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("lessons", nargs="*")
    parser.add_argument("--whole", action="store_true", help="each lesson in each look at every place")
    asked = parser.parse_args()
    there = [path.name for path in sorted((asked.folder / "data").iterdir()) if path.is_dir() and path.name in LESSONS]
    scenes = bad = 0
    with sync_playwright() as playwright, served(asked.folder) as home:
        browser = playwright.chromium.launch(args=FLAGS, executable_path=chromium())
        for number, lesson in enumerate(asked.lessons or there):
            looks = looks_in(asked.folder, lesson)
            every = [(look, place) for look in looks for place in PLACES]
            place_of = (number + number // len(looks)) % len(PLACES)  # every look comes to every place in turn
            for look, place in every if asked.whole else [(looks[number % len(looks)], PLACES[place_of])]:
                walk = walked(browser, asked.folder, home, lesson, look, place)
                scenes, bad = scenes + walk.scenes, bad + len(walk.complaints) + len(walk.rules)
                print(f"{lesson} {look} {place}: {walk.scenes} scenes, {len(walk.complaints)} errors and requests to elsewhere, "
                      f"{len(walk.rules)} rules broken {(walk.complaints + walk.rules)[:3] or ''}", flush=True)
    print(f"{scenes} scenes, {bad} faults")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
