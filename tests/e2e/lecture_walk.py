"""Give a lecture in browsers: two presenter pages, the notes, a laptop and a phone; peer instruction, an outage, a pause.

`python tests/e2e/lecture_walk.py --whole` takes the fifteen minutes that its lecture is planned for; without, as long as the pages need.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path

from cable import Cable
from playwright.sync_api import Page, expect, sync_playwright

from observer_lab.classroom.room_store import RoomStore
from observer_lab.cli import main as observer_lab
from observer_lab.lessons import LESSONS

ROOT = Path(__file__).parents[2]
ARTEFACTS = ROOT / "artefacts"
GUIDE, _, _ = (ROOT / "assets" / "lessons" / "README.md").read_text(encoding="utf-8").partition("## A nonlinear plant")
MINUTES = (3.0, 8.0, 4.0)  # of the stops
PATIENCE = 180_000  # ms: a busy machine is slow
OUTAGE_S, LONG_OUTAGE_S = 2.0, 60.0
OTHERS = 6  # of the class, whose votes are written down as another worker does
RIGHT = ".ol-right,.ol-true"  # an option that is said to be right
Open = Callable[[str, int, int], Page]  # an address and a size
Serve = Callable[..., AbstractContextManager[str]]


class Walk:
    """The pages of a lecture, and what is seen on them."""

    def __init__(self, serve: Serve, opened: Open, folder: Path, minutes: float, stack: ExitStack) -> None:
        """`minutes` is how long it takes at least; the pages come in one after another."""
        self.begun, self.minutes = time.monotonic(), minutes
        self.lesson, self.scenes = packed(folder)
        last = LESSONS["separation"].path[3].id
        self.stops = [*self.scenes, last]
        talk = folder / "talk.toml"
        talk.write_text("\n".join([f'title = "A lecture"\nminutes = {sum(MINUTES):g}', *(
            f'[[stops]]\nlesson = "{lesson}"\nscene = "{scene}"\nminutes = {most:g}\nnote = "the note of {scene}"'
            for lesson, scene, most in zip((self.lesson, self.lesson, "separation"), self.stops, MINUTES, strict=True))]))
        self.kept = folder / "kept"
        self.kept.mkdir()
        address = stack.enter_context(serve(0, "--view", "present", "--lessons", str(folder / "lessons.zip"), "--lecture", str(talk),
                                            "--room", "--data-dir", str(self.kept), "--workers", "2"))
        self.store = RoomStore(self.kept)
        self.cables = [stack.enter_context(Cable(address)) for _ in range(3)]
        tablet, laptop, phone = (cable.address for cable in self.cables)
        self.projector = opened(f"{address}/?present={self.store.secret}", 1366, 768)
        self.tablet = opened(f"{tablet}/?present={self.store.secret}", 1180, 820)
        self.laptop, self.phone = opened(laptop, 1366, 768), opened(phone, 390, 844)
        self.pages = (self.projector, self.tablet, self.laptop, self.phone)
        for page in self.pages:
            page.wait_for_selector(".ol-card")
        self.projector.locator(".ol-more summary").click()
        with self.projector.expect_popup() as popup:
            self.projector.locator(".ol-notes").click()
        self.console = popup.value

    def at(self, share: float) -> None:
        """Wait until this share of the planned time has passed."""
        time.sleep(max(0.0, self.begun + 60.0 * share * self.minutes - time.monotonic()))

    def all_show(self, stop: int) -> None:
        for page in self.pages:
            expect(page.locator(f".ol-card[data-scene={self.stops[stop]}]")).to_be_visible()

    def press(self, name: str) -> None:
        """A button of the console."""
        self.console.get_by_role("button", name=name).first.click()

    def vote(self, page: Page, option: int) -> None:
        before = page.get_by_text(f"Your answer {'ABCDE'[option]} is counted.").count()
        page.locator(".ol-option").nth(option).click()
        expect(page.get_by_text(f"Your answer {'ABCDE'[option]} is counted.")).to_have_count(before + 1)

    def nothing_is_told(self) -> None:
        """No page says which option is right, and none that the hall or the class sees has counts."""
        for page in self.pages:
            expect(page.locator(RIGHT)).to_have_count(0)
        for page in (self.laptop, self.phone):
            expect(page.locator(".ol-bar")).to_have_count(0)
        expect(self.projector.locator(".ol-hall .ol-bar")).to_have_count(0)

    def others(self, options: int) -> None:
        number = self.store.votes()[-1].number
        assert all(self.store.cast([(number, f"other{number}x{k:05d}", k % options) for k in range(OTHERS)]))
        expect(self.console.locator("#room")).to_contain_text(f"{OTHERS + 2} votes")

    def peer_instruction(self, outage: float) -> None:
        """Open, close, counts, discuss, again, reveal; in the discussion the network is cut under three of the pages."""
        self.press("Open the vote")
        for page, option in ((self.laptop, 0), (self.phone, 1)):
            self.vote(page, option)
        options = self.phone.locator(".ol-option").count()
        self.others(options)
        self.nothing_is_told()
        self.press("Close the vote")
        expect(self.console.get_by_role("button", name="Show the counts")).to_be_visible()
        self.nothing_is_told()
        self.at(0.3)
        self.press("Show the counts")
        for page, where in ((self.projector, ".ol-hall .ol-bar"), (self.laptop, ".ol-bar"), (self.phone, ".ol-bar")):
            expect(page.locator(where)).to_have_count(options)
        for page in self.pages:
            expect(page.locator(RIGHT)).to_have_count(0)
        self.press("Hide the counts")
        self.press("Discuss")
        for page in (self.console, self.projector, self.phone):
            expect(page.locator("[data-talk]").last).to_have_text(re.compile(r"\d:\d\d"))
        self.at(0.4)
        for cable in self.cables:
            cable.become("cut")
        for page in (self.tablet, self.laptop, self.phone):
            expect(page.locator(".ol-lost")).to_be_visible()
        self.press("Ask again")
        time.sleep(outage)
        for cable in self.cables:
            cable.become("whole")
        for page in (self.tablet, self.laptop, self.phone):
            expect(page.locator(".ol-lost")).to_be_hidden()
        self.at(0.5)
        for page in (self.laptop, self.phone):
            expect(page.locator(".ol-option:enabled").nth(1)).to_be_visible()
            self.vote(page, 1)
        self.others(options)
        self.nothing_is_told()
        self.press("Close the vote")
        self.press("Reveal the answer")
        for page in (self.laptop, self.phone):
            expect(page.locator(".ol-right")).to_be_visible()
        for page in (self.projector, self.tablet):
            expect(page.locator(".ol-hall .ol-poll")).to_have_count(2)
        one, two = self.store.votes()[-2:]
        assert (one.round, two.round, one.total, two.total) == (1, 2, OTHERS + 2, OTHERS + 2) and two.counts[1] == one.counts[1] + 1
        self.keep_pictures("reveal")

    def pause(self) -> None:
        self.press("Pause for all")
        for page in (self.laptop, self.phone):
            expect(page.locator(".ol-freeze")).to_be_visible()
        expect(self.projector.locator(".ol-freeze")).to_have_count(0)
        self.phone.locator(".ol-do").first.evaluate("button => button.focus()")
        assert self.phone.evaluate("document.activeElement === document.body"), "nothing under the sentence takes the focus"
        self.at(0.7)
        self.press("Go on for all")
        for page in (self.laptop, self.phone):
            expect(page.locator(".ol-freeze")).to_be_hidden()

    def typed_question(self) -> None:
        """Typed in the console, whose arrow keys are the field's then; the class answers with a number."""
        self.console.locator("#ask summary").first.click()
        field = self.console.locator("#ask textarea")
        field.fill("How many poles has the loop?")
        field.press("ArrowRight")
        self.console.locator("#ask").get_by_role("button", name="Open the vote").click()
        expect(self.phone.get_by_role("spinbutton", name="your number")).to_be_visible()
        self.all_show(2)
        self.press("Close the vote")
        expect(self.phone.get_by_role("spinbutton")).to_have_count(0)

    def keep_pictures(self, name: str) -> None:
        """For people to look at."""
        ARTEFACTS.mkdir(exist_ok=True)
        for of, page in (("hall", self.projector), ("console", self.console), ("phone", self.phone)):
            page.screenshot(path=ARTEFACTS / f"lecture-{name}-{of}.png", timeout=PATIENCE)


def packed(folder: Path) -> tuple[str, list[str]]:
    """Pack the guide's own lesson into lessons.zip: its id, the scene before its question, and the scene of the question."""
    blocks = {kind: re.findall(rf"```{kind}\n(.*?)```", GUIDE, re.DOTALL) for kind in ("sh", "toml", "markdown")}
    name = blocks["sh"][0].split()[2]
    assert observer_lab(["new-lesson", name, "--folder", str(folder / "lessons")]) == 0
    for file, kind in (("lesson.toml", "toml"), ("lesson.md", "markdown")):
        place = folder / "lessons" / name / file
        place.write_text("\n".join([place.read_text(encoding="utf-8"), *blocks[kind]]), encoding="utf-8")
    assert observer_lab(["list", "--lessons", str(folder / "lessons"), "--zip", str(folder / "lessons.zip")]) == 0
    return name, re.findall(r"^## scene (\w+)", GUIDE, re.MULTILINE)[:2]


def play(serve: Serve, opened: Open, folder: Path, minutes: float = 0.0, outage: float = OUTAGE_S) -> None:
    """The whole lecture. Raises AssertionError where a page does not show what it must."""
    with ExitStack() as stack:
        walk = Walk(serve, opened, folder, minutes, stack)
        walk.all_show(0)
        expect(walk.console.locator("#note")).to_have_text(f"the note of {walk.stops[0]}")
        for hidden in (".ol-room", ".ol-ask"):
            expect(walk.projector.locator(hidden).first).to_be_hidden()
        walk.at(0.2)
        walk.console.keyboard.press("ArrowRight")
        walk.all_show(1)
        expect(walk.console.locator("#pace")).to_have_text(re.compile("plan"))
        walk.peer_instruction(outage)
        walk.pause()
        walk.at(0.75)
        walk.tablet.keyboard.press("PageDown")
        walk.all_show(2)
        walk.projector.keyboard.press("PageUp")
        walk.all_show(1)
        expect(walk.phone.locator(".ol-right")).to_be_visible()
        walk.tablet.keyboard.press("PageDown")
        walk.all_show(2)
        walk.typed_question()
        walk.at(1.0)
        sheet = folder / "sheet.csv"
        assert observer_lab(["lecture-sheet", str(walk.kept), "--lessons", str(folder / "lessons.zip"), "-o", str(sheet)]) == 0
        lines = [line for line in sheet.read_text(encoding="utf-8").splitlines() if "Vote 1" in line or "Vote 2" in line]
        assert len(lines) >= 2, "both votes are on the sheet"


def main() -> int:
    """Play it; 1 where something did not hold."""
    from conftest import chromium, serving
    from tab import FLAGS

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--whole", action="store_true", help="take the fifteen minutes, with an outage of one")
    whole = parser.parse_args().whole
    expect.set_options(timeout=PATIENCE)
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), headless=True, args=FLAGS)

        def opened(address: str, across: int, up: int) -> Page:
            page = browser.new_context(viewport={"width": across, "height": up}, reduced_motion="reduce", has_touch=across < 500).new_page()
            page.set_default_timeout(PATIENCE)
            page.goto(address)
            return page
        play(serving, opened, Path(folder), sum(MINUTES) if whole else 0.0, LONG_OUTAGE_S if whole else OUTAGE_S)
        browser.close()
    print(f"the lecture has held, in {time.monotonic() - began:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
