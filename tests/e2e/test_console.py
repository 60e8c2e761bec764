"""The notes' window is the presenter's console: votes are run there, and the page that the hall sees keeps stage, card and results."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

from playwright.sync_api import Page, expect

from observer_lab.classroom.room_store import RoomStore
from observer_lab.lessons import LESSONS
from observer_lab.session.handlers.room import PAUSED

PATIENCE = 180_000  # ms: a busy machine is slow
PATH = LESSONS["separation"].path
PREDICT = next(k for k, scene in enumerate(PATH) if scene.id == "predict")
ARTEFACTS = Path(__file__).parents[2] / "artefacts"
expect.set_options(timeout=PATIENCE)


def shows(page: Page, index: int) -> None:
    expect(page.locator(f".ol-card[data-scene={PATH[index].id}]")).to_be_visible()


def test_a_vote_is_run_from_the_notes_and_the_hall_sees_its_results(still_page: Callable[..., Page], tmp_path: Path,
                                                                    serve: Callable[..., AbstractContextManager[str]]) -> None:
    options = ("--view", "present", "--lesson", "separation", "--room", "--data-dir", str(tmp_path))
    with serve(0, *options) as address:
        store = RoomStore(tmp_path)
        ARTEFACTS.mkdir(exist_ok=True)
        hall, phone = still_page(1366, 768), still_page(390, 844, has_touch=True)
        for page, at in ((hall, f"{address}/?present={store.secret}"), (phone, address)):
            page.set_default_timeout(PATIENCE)
            page.goto(at)
            page.wait_for_selector(".ol-scene")
        hall.locator(".ol-dot").nth(PREDICT).click()
        shows(hall, PREDICT)
        expect(hall.locator(".ol-room")).to_be_visible()
        hall.locator(".ol-more summary").click()
        with hall.expect_popup() as popup:
            hall.locator(".ol-notes").click()
        console = popup.value
        expect(console.locator("#pace")).to_have_text(re.compile("ahead of the plan"))
        for hidden in (".ol-room", ".ol-ask"):
            expect(hall.locator(hidden).first).to_be_hidden()
        expect(console.locator("#room")).to_contain_text("1 here")
        console.get_by_role("button", name="Open the vote").first.click()
        phone.locator(".ol-option").nth(0).click()
        expect(phone.get_by_text("Your answer A is counted.").last).to_be_visible()
        console.get_by_role("button", name="Pause for all").click()
        expect(phone.locator(".ol-freeze")).to_have_text(PAUSED("en"))
        expect(console.locator("#room")).to_contain_text("All pages of the class are paused.")
        phone.locator(".ol-option").nth(1).evaluate("option => option.focus()")
        assert phone.evaluate("document.activeElement === document.body"), "nothing under the sentence takes the focus"
        phone.screenshot(path=ARTEFACTS / "console-paused.png")
        console.get_by_role("button", name="Go on for all").click()
        expect(phone.locator(".ol-freeze")).to_be_hidden()
        phone.locator(".ol-option").nth(0).click()
        assert all(store.cast([(store.votes()[-1].number, f"other{k:05d}", k % 3) for k in range(6)]))
        expect(console.locator("#room")).to_contain_text("7 votes")
        console.get_by_role("button", name="Close the vote").click()
        console.get_by_role("button", name="Discuss").click()
        expect(console.locator("[data-talk]")).to_have_text(re.compile(r"\d:\d\d"))
        console.get_by_role("button", name="Show the counts").click()
        expect(hall.locator(".ol-hall .ol-bar")).to_have_count(3)
        console.screenshot(path=ARTEFACTS / "console.png")
        hall.screenshot(path=ARTEFACTS / "console-hall.png")
        console.locator("summary").first.click()
        console.locator("textarea").fill("How many poles has the loop?")
        console.locator("textarea").press("ArrowRight")
        console.locator("#ask").get_by_role("button", name="Open the vote").click()
        expect(phone.get_by_role("spinbutton", name="your number")).to_be_visible()
        shows(hall, PREDICT)
        console.close()
        expect(hall.locator(".ol-room")).to_be_visible()


def test_a_clicker_turns_the_projected_page_and_no_key_leaves_its_lesson(still_page: Callable[..., Page],
                                                                         serve: Callable[..., AbstractContextManager[str]]) -> None:
    with serve(0, "--view", "present", "--lesson", "separation") as address:
        page = still_page(1366, 768)
        page.set_default_timeout(PATIENCE)
        page.goto(address)
        page.wait_for_selector(".ol-scene")
        for key, index in (("PageDown", 1), ("ArrowRight", 2), ("n", 3), ("PageUp", 2), ("p", 1), ("ArrowLeft", 0)):
            page.keyboard.press(key)
            shows(page, index)
        page.locator(".ol-menu").focus()
        page.keyboard.press("ArrowRight")
        page.locator(".ol-menu").blur()
        page.keyboard.press("PageDown")
        shows(page, 1)
