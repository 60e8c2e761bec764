"""A short class in three browsers: room, vote, a copy of one's own and back, and a restart of the server."""

from __future__ import annotations

import socket
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

from playwright.sync_api import Browser, Page, expect

from observer_lab.classroom.room_store import RoomStore

PATIENCE = 60_000  # ms: a busy machine is slow
ARTEFACTS = Path(__file__).parents[2] / "artefacts"
PREDICT = 3  # the scene of the first prediction
Serve = Callable[..., AbstractContextManager[str]]


def opened(browser: Browser, address: str, size: tuple[int, int]) -> Page:
    context = browser.new_context(viewport={"width": size[0], "height": size[1]}, reduced_motion="reduce")
    page = context.new_page()
    page.goto(address)
    page.wait_for_selector(".ol-scene", timeout=PATIENCE)
    return page


def shows(page: Page, scene: str) -> None:
    expect(page.locator(f".ol-card[data-scene={scene}]")).to_be_visible(timeout=PATIENCE)


def vote(page: Page, option: int, letter: str) -> None:
    page.locator(".ol-option").nth(option).click(timeout=PATIENCE)
    expect(page.get_by_text(f"Your answer {letter} is counted.").last).to_be_visible(timeout=PATIENCE)


def test_a_class_votes_tries_for_itself_comes_back_and_survives_a_restart(browser: Browser, serve: Serve, tmp_path: Path) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    options = ("--view", "guide", "--lesson", "separation", "--room", "--data-dir", str(tmp_path), "--exact-port")
    pages: list[Page] = []
    try:
        with serve(port, *options) as address:
            secret = RoomStore(tmp_path).secret
            laptop = opened(browser, address, (1366, 768))
            pages.append(laptop)
            expect(laptop.get_by_text("The lecture has not begun yet.")).to_be_visible(timeout=PATIENCE)
            presenter, phone = opened(browser, f"{address}/?present={secret}", (1366, 768)), opened(browser, address, (390, 844))
            pages += [presenter, phone]
            assert secret not in presenter.url, "the word leaves the address bar"
            for page in (presenter, laptop, phone):
                shows(page, "recall")
            presenter.get_by_text("The audience's link and its code").click(timeout=PATIENCE)
            expect(presenter.locator(".ol-code")).to_be_visible()
            expect(presenter.get_by_text(f"{address}/", exact=True)).to_be_visible()
            presenter.get_by_text("The audience's link and its code").click()
            presenter.locator(".ol-dot").nth(PREDICT).click(timeout=PATIENCE)
            for page in (laptop, phone):
                shows(page, "predict")
                expect(page.locator(".ol-option:enabled")).to_have_count(0)
            presenter.get_by_role("button", name="Open the vote").click(timeout=PATIENCE)
            vote(laptop, 0, "A")
            vote(phone, 1, "B")
            vote(laptop, 1, "B")
            expect(presenter.locator(".ol-poll")).to_contain_text("fewer than 5 votes", timeout=PATIENCE)
            expect(presenter.locator(".ol-here")).to_contain_text("2 here", timeout=PATIENCE)
            assert presenter.locator(".ol-bar").count() == 0 and RoomStore(tmp_path).votes()[-1].counts == (0, 2, 0)
            presenter.get_by_role("button", name="Close the vote").click(timeout=PATIENCE)
            for page in (laptop, phone):
                expect(page.locator(".ol-option.ol-right")).to_have_count(1, timeout=PATIENCE)
                tree = page.locator(".ol-card").aria_snapshot()
                assert "heading" in tree and tree.count("button") == 3, tree
            expect(presenter.locator(".ol-option.ol-right")).to_have_count(1, timeout=PATIENCE)
            presenter.get_by_role("button", name="Ask again").click(timeout=PATIENCE)
            vote(phone, 1, "B")
            for page in (presenter, laptop, phone):
                expect(page.locator(".ol-right, .ol-say")).to_have_count(0, timeout=PATIENCE)
            for name, page in (("presenter", presenter), ("laptop", laptop), ("phone", phone)):
                ARTEFACTS.mkdir(exist_ok=True)
                page.screenshot(path=ARTEFACTS / f"room-{name}.png")
            laptop.get_by_role("link", name="Try it myself").click(timeout=PATIENCE)
            back = laptop.get_by_role("link", name="Back to the lecture")
            expect(back).to_be_visible(timeout=PATIENCE)
            shows(laptop, "predict")
            laptop.locator(".ol-dot").nth(PREDICT + 1).click(timeout=PATIENCE)
            shows(laptop, "why")
            shows(presenter, "predict")
            back.click()
            shows(laptop, "predict")
        with serve(port, *options):
            for page in (laptop, phone, presenter):
                expect(page.locator(".ol-lost")).to_be_hidden(timeout=PATIENCE)
                expect(page.locator(".ol-cover")).to_be_hidden(timeout=PATIENCE)
                shows(page, "predict")
            presenter.get_by_role("button", name="Close the vote").click(timeout=PATIENCE)
            expect(laptop.locator(".ol-poll")).to_have_count(2, timeout=PATIENCE)
            presenter.get_by_text("Ask the class a question of your own").click(timeout=PATIENCE)
            presenter.locator(".ol-ask textarea").fill("How many poles has the loop?")
            presenter.locator(".ol-ask").get_by_role("button", name="Open the vote").click()
            phone.get_by_role("spinbutton", name="your number").fill("12")
            phone.get_by_role("button", name="Send").click(timeout=PATIENCE)
            expect(phone.get_by_text("Your answer 12 is counted.")).to_be_visible(timeout=PATIENCE)
            for name, page in (("presenter", presenter), ("phone", phone)):
                page.screenshot(path=ARTEFACTS / f"room-typed-{name}.png")
            assert [each.counts for each in RoomStore(tmp_path).votes()] == [(0, 2, 0), (0, 1, 0), (1,)]
    finally:
        for page in pages:
            page.context.close()
