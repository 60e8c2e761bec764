"""Print a table of outages: how soon each page is back, and edits lost or done twice.

`python tests/e2e/outages.py [--lengths 1 10 60] [--kinds cut lost]` ends with 1 where a page stays away or an edit is not done once.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from cable import Cable
from conftest import chromium
from playwright.sync_api import Browser, Error, Page, sync_playwright
from tab import FLAGS

from observer_lab.classroom.room_store import RoomStore
from observer_lab.lessons import LESSONS

LESSON = "separation"
KINDS = {"swallow": "silent", "cut": "cut", "lost": "lost", "delay": "whole"}  # what the cable becomes
DELAY_S = 1.0  # each way
LENGTHS_S = (1.0, 3.0, 10.0, 30.0, 60.0)
PATIENCE_S = 120.0  # after the end of an outage
POLL_S = 0.1
SCENES = len(LESSONS[LESSON].path)
UNFOCUSED = "document.hasFocus = () => false"  # of a page behind another window
IS_BACK = """() => document.querySelector('.ol-lost')?.hidden && document.querySelector('.ol-cover')?.hidden
  && !!document.querySelector('.ol-card') && !window.observerLabLine.lost"""


@dataclass(frozen=True)
class Row:
    """One page of one outage: seconds from its end until the page is back and shows what was done, and edits that were not done once."""

    kind: str
    length: float
    page: str
    back: float
    wrong: int

    def __str__(self) -> str:
        return f"{self.kind:8} {self.length:6.0f} s  {self.page:10} back after {self.back:5.1f} s, edits lost or done twice {self.wrong}"


class Lecture:
    """A room with a presenter, the notes window, a follower and a phone, each page behind a cable of its own."""

    def __init__(self, browser: Browser, address: str, store: RoomStore, stack: ExitStack) -> None:
        self.store = store
        self.cables = {name: stack.enter_context(Cable(address)) for name in ("presenter", "follower", "phone")}
        self.pages: dict[str, Page] = {}
        for name, cable in self.cables.items():
            size = {"width": 390, "height": 844} if name == "phone" else {"width": 1366, "height": 768}
            context = browser.new_context(viewport=size, reduced_motion="reduce", has_touch=name == "phone")  # type: ignore[arg-type]
            stack.callback(context.close)
            context.add_init_script(UNFOCUSED)
            page = self.pages[name] = context.new_page()
            page.set_default_timeout(1000 * PATIENCE_S)
            page.goto(cable.address + (f"/?present={store.secret}" if name == "presenter" else ""))
            page.wait_for_selector(".ol-card")
        presenter = self.pages["presenter"]
        presenter.wait_for_selector(".ol-notes", state="attached")
        with presenter.expect_popup() as popup:
            presenter.evaluate("document.querySelector('.ol-notes').click()")
        self.notes = popup.value

    @property
    def scene(self) -> int:
        """Where the presenter's page is."""
        return int(self.pages["presenter"].locator(".ol-where span").first.inner_text().split("/")[0]) - 1

    def hands(self) -> int:
        return self.store.presence()[1]

    def become(self, kind: str, whole: bool) -> None:
        for cable in self.cables.values():
            cable.delay = DELAY_S if kind == "delay" and not whole else 0.0
            cable.become("whole" if whole else KINDS[kind])


def until(what: Callable[[], bool], end: float) -> float:
    """When something holds; `end` where it does not until then."""
    while time.monotonic() < end:
        try:
            if what():
                return time.monotonic()
        except Error:  # the page is loaded again
            pass
        time.sleep(POLL_S)
    return end


def outage(lecture: Lecture, kind: str, length: float) -> list[Row]:
    """One outage on all pages at once, with an edit on each: a scene, one scene further by the notes window, and two raised hands."""
    lecture.store.lower_hands()
    until(lambda: lecture.hands() == 0, time.monotonic() + PATIENCE_S)
    target = 4 if lecture.scene < 4 else 1
    presenter = lecture.pages["presenter"]
    lecture.become(kind, whole=False)
    began = time.monotonic()
    presenter.locator(".ol-dot").nth(target).dispatch_event("click")
    lecture.notes.keyboard.press("ArrowRight")
    for name in ("follower", "phone"):
        lecture.pages[name].get_by_role("button", name="Slower, please").dispatch_event("click")
    time.sleep(max(0.0, length - (time.monotonic() - began)))
    lecture.become(kind, whole=True)
    whole = time.monotonic()
    end = whole + PATIENCE_S
    back = {name: until(lambda page=page: page.evaluate(IS_BACK), end) - whole for name, page in lecture.pages.items()}
    right = until(lambda: lecture.scene == target + 1, end) - whole
    raised = until(lambda: lecture.hands() == 2, end) - whole
    time.sleep(2.0)  # in which what is done twice would come
    wrong = int(lecture.scene != target + 1)
    missing = 2 - lecture.hands()
    return [Row(kind, length, "presenter", max(back["presenter"], right), wrong), Row(kind, length, "notes", right, wrong),
            Row(kind, length, "follower", max(back["follower"], raised), int(missing > 0)),
            Row(kind, length, "phone", max(back["phone"], raised), int(missing > 1))]


def rows(kinds: Sequence[str], lengths: Sequence[float]) -> list[Row]:
    """The table, printed as it grows."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        browser = stack.enter_context(sync_playwright()).chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)
        stack.callback(browser.close)
        process = subprocess.Popen([sys.executable, "-m", "observer_lab", "serve", "--port", "0", "--room", "--view", "present", "--lesson",
                                    LESSON, "--data-dir", str(folder)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                                   env={**os.environ, "PYTHONUNBUFFERED": "1", "OBSERVER_LAB_KERNELS": "off"})
        stack.callback(process.wait, 120)
        stack.callback(process.terminate)
        assert process.stdout is not None
        address = process.stdout.readline().strip()
        lecture = Lecture(browser, address, RoomStore(folder), stack)
        found = []
        for length in lengths:
            for kind in kinds:
                for row in outage(lecture, kind, length):
                    print(row, flush=True)
                    found.append(row)
        return found


def main() -> int:
    """Print the table; 1 where something was lost."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lengths", type=float, nargs="+", default=LENGTHS_S, metavar="S")
    parser.add_argument("--kinds", nargs="+", choices=list(KINDS), default=list(KINDS))
    options = parser.parse_args()
    found = rows(options.kinds, options.lengths)
    return int(any(row.wrong or row.back >= PATIENCE_S for row in found))


if __name__ == "__main__":
    sys.exit(main())
