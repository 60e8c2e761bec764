"""A page comes back by itself after its network was silent, was cut or its server ended, with what the hand has done meanwhile."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import pytest
from cable import Cable
from playwright.sync_api import Browser, BrowserContext, Page, expect
from tab import Tab, eventually

from observer_lab.classroom.room_store import RoomStore
from observer_lab.lessons import LESSONS
from observer_lab.page.screen.server import LabServer
from observer_lab.page.words import phrases

SLIDER = "stiffness error in the model [%]"
PATH = LESSONS["separation"].path
PREDICT = next(k for k, scene in enumerate(PATH) if scene.id == "predict")
NOTICED_S = 10.0  # s in which a dead network is said
NO_ADDRESS = "() => { window.observerLabAddress.shown = ''; sessionStorage.removeItem('observer-lab-address'); }"  # as on a slow way
COLUMN = "document.querySelector('.ol-question').closest('[data-ol-view]')"
UNFOCUSED = "document.hasFocus = () => false"
expect.set_options(timeout=60_000)
Serve = Callable[..., AbstractContextManager[str]]


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    context = browser.new_context(viewport={"width": 1000, "height": 420}, reduced_motion="reduce")
    context.add_init_script(UNFOCUSED)
    yield context
    context.close()


@pytest.fixture
def cable(server: str) -> Iterator[Cable]:
    with Cable(server) as cable:
        yield cable


def push(tab: Tab, times: int) -> None:
    """Move the slider by keys without waiting for an answer."""
    tab.thumb(SLIDER).focus()
    for _ in range(times):
        tab.page.keyboard.press("ArrowRight")


def scrolled(page: Page) -> float:
    return page.evaluate(f"{COLUMN}.scrollTop")


@pytest.mark.parametrize("kind", ["silent", "lost", "cut"])
def test_an_outage_loses_no_edit_and_moves_no_column(context: BrowserContext, cable: Cable, kind: str) -> None:
    page = context.new_page()
    tab = Tab(page, cable.address, drawn=False)
    tab.slide(SLIDER, "ArrowRight", 3)
    tab.answered(rests=True)
    page.evaluate(f"{COLUMN}.scrollTop = 60")
    cable.become(kind)
    began = time.monotonic()
    push(tab, 2)
    before = scrolled(page)
    expect(page.locator(".ol-lost")).to_be_visible()
    assert time.monotonic() - began < NOTICED_S + 2.0  # of a busy machine
    assert page.locator(".ol-lost").inner_text() == phrases.SERVER_LOST("en")
    push(tab, 1)  # while it is known to be lost
    cable.become("whole")
    expect(page.locator(".ol-lost")).to_be_hidden()
    expect(page.locator(".ol-cover")).to_be_hidden()
    tab.settle()
    eventually(lambda: tab.value(SLIDER), lambda value: value == 6.0, "the design with all that was done")
    eventually(lambda: scrolled(page), lambda top: abs(top - before) <= 2, "the column as it was scrolled")


def test_a_press_before_the_page_is_told_its_address_is_not_lost(context: BrowserContext, serve: Serve) -> None:
    with serve(0, "--view", "present", "--lesson", "separation") as address, Cable(address) as cable:
        page = context.new_page()
        page.goto(cable.address)
        expect(page.locator(".ol-card")).to_have_attribute("data-scene", PATH[0].id)
        page.evaluate(NO_ADDRESS)
        cable.become("silent")
        page.keyboard.press("ArrowRight")
        expect(page.locator(".ol-lost")).to_be_visible()
        cable.become("whole")
        expect(page.locator(".ol-lost")).to_be_hidden()
        expect(page.locator(".ol-card")).to_have_attribute("data-scene", PATH[1].id)


def test_a_long_way_is_no_outage(context: BrowserContext, cable: Cable) -> None:
    page = context.new_page()
    cable.delay = 0.3
    tab = Tab(page, cable.address, drawn=False)
    said = page.evaluate("""() => new Promise(done => {
      const note = document.querySelector('.ol-lost');
      new MutationObserver(() => done(true)).observe(note, {attributes: true});
      let beats = 0;
      const ask = window.observerLabViser.send;
      window.observerLabViser.send = message => { ask(message); if (++beats === 3) setTimeout(done, 2000, false); };
    })""")
    assert not said
    tab.slide(SLIDER, "ArrowRight", 1)
    tab.answered(rests=True)


def test_a_page_whose_attempts_fail_is_loaded_again(context: BrowserContext, server: str) -> None:
    """The last resort: the server answers and no connection opens, whatever the reason; the edits of before are not lost."""
    with Cable(server) as cable:
        page = context.new_page()
        tab = Tab(page, cable.address, drawn=False)
        page.evaluate("window.observerLabViser.reconnect = () => {}; window.stillHere = true")
        page.evaluate("history.replaceState(null, '', location.href)")  # as where the network ends before the page is told its lesson
        cable.become("cut")
        expect(page.locator(".ol-lost")).to_be_visible()
        push(tab, 2)
        page.evaluate(f"{COLUMN}.scrollTop = 60")
        cable.become("whole")
        eventually(lambda: page.evaluate("window.stillHere ?? false"), lambda still: not still, "the page as it is loaded again")
        page.wait_for_selector(".ol-question")
        tab.settle()
        eventually(lambda: tab.value(SLIDER), lambda value: value == 2.0, "the design with what was done")
        eventually(lambda: scrolled(page), lambda top: abs(top - 60) <= 2, "the column as it was scrolled")


def test_a_vote_in_a_silent_network_is_counted(context: BrowserContext, browser: Browser, serve: Serve, tmp_path: Path) -> None:
    with serve(0, "--view", "guide", "--lesson", "separation", "--room", "--data-dir", str(tmp_path)) as address, Cable(address) as cable:
        store = RoomStore(tmp_path)
        phone, presenter = context.new_page(), browser.new_page(viewport={"width": 1366, "height": 768})  # which has the word in a cookie
        presenter.goto(f"{address}/?present={store.secret}")
        phone.goto(cable.address)
        presenter.locator(".ol-dot").nth(PREDICT).click()
        expect(presenter.locator(".ol-card[data-scene=predict]")).to_be_visible()
        presenter.get_by_role("button", name="Open the vote").first.click()
        expect(phone.locator(".ol-option:enabled").nth(1)).to_be_visible()
        cable.become("lost")
        phone.locator(".ol-option").nth(1).click()
        expect(phone.locator(".ol-lost")).to_be_visible()
        cable.become("whole")
        expect(phone.get_by_text("Your answer B is counted.").last).to_be_visible()
        assert store.votes()[-1].counts[:2] == (0, 1) and store.votes()[-1].total == 1
        presenter.context.close()


def test_a_row_of_the_table_of_outages_loses_nothing_and_does_nothing_twice() -> None:
    """A network that swallows for as long as a page needs to give its connection up; the script has the other rows."""
    here = Path(__file__).parent
    done = subprocess.run([sys.executable, "outages.py", "--lengths", "9", "--kinds", "swallow"], cwd=here, capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(here.parent)}, timeout=400)
    assert done.returncode == 0 and done.stdout.count("done twice 0") == 4, done.stdout + done.stderr[-2000:]


def test_no_key_is_lost_while_a_page_is_laid_out_anew_or_has_just_come_back(context: BrowserContext, serve: Serve) -> None:
    with serve(0, "--view", "present", "--lesson", "separation") as address, Cable(address) as cable:
        page = context.new_page()
        page.goto(cable.address)
        page.wait_for_selector(".ol-present")

        def stands_at(scene: int) -> None:
            expect(page.locator(".ol-card")).to_have_attribute("data-scene", PATH[scene].id)
        stands_at(0)
        cable.delay = 0.4
        page.evaluate("document.querySelector('[data-value=theme]').click()")
        for _ in range(3):  # on the page of before: some come to the server when it has laid out another one
            page.wait_for_timeout(300)
            page.keyboard.press("ArrowRight")
        stands_at(3)
        cable.delay = 0.0
        cable.become("cut")
        expect(page.locator(".ol-lost")).to_be_visible()
        page.keyboard.press("ArrowRight")
        cable.become("whole")
        expect(page.locator(".ol-lost")).to_be_hidden()
        page.keyboard.press("ArrowRight")
        stands_at(5)
        page.wait_for_timeout(2000)
        stands_at(5)  # and none is done twice


def test_after_a_restart_with_another_token_the_page_says_what_to_do(context: BrowserContext, serve: Serve) -> None:
    with Cable("http://127.0.0.1:9") as cable:
        page = context.new_page()
        with serve(0, "--token", "the-first-word") as address:
            cable.lead_to(address)
            tab = Tab(page, f"{cable.address}/?token=the-first-word", drawn=False)
        with serve(0, "--token", "another-word", "--allow-host", "127.0.0.1") as address:
            cable.lead_to(address)
            expect(page.locator(".ol-lost")).to_have_text(phrases.OTHER_TOKEN("en"))
            other = context.new_page()
            other.goto(f"{cable.address}/?token=another-word")
            expect(page.locator(".ol-lost")).to_be_hidden()
            tab.answered(rests=True)


def test_a_page_at_rest_goes_on_where_it_was_with_the_hand_that_wakes_it(context: BrowserContext) -> None:
    server = LabServer(LESSONS, port=0, lesson="separation")
    look = server._server.get_event_loop().call_soon_threadsafe
    try:
        page = context.new_page()
        tab = Tab(page, server.url, drawn=False)
        tab.slide(SLIDER, "ArrowRight", 3)
        tab.answered(rests=True)
        server._places._idle = 0.0
        look(server._places.look)
        expect(page.locator(".ol-lost.ol-rests")).to_have_text(phrases.PAGE_RESTS("en"))
        eventually(lambda: len(server.sessions), lambda count: count == 0, "the end of its session")
        server._places._idle = float("inf")
        push(tab, 1)
        expect(page.locator(".ol-lost")).to_be_hidden()
        tab.settle()
        eventually(lambda: tab.value(SLIDER), lambda value: value == 4.0, "the design with what the hand has done")
    finally:
        page.close()
        server.stop()
