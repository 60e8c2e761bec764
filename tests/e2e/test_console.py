"""A clicker turns the projected page. What the notes' window does is played by `lecture_walk.py`."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager

from playwright.sync_api import Page, expect

from observer_lab.lessons import LESSONS

PATIENCE = 180_000  # ms: a busy machine is slow
PATH = LESSONS["separation"].path
expect.set_options(timeout=PATIENCE)


def shows(page: Page, index: int) -> None:
    expect(page.locator(f".ol-card[data-scene={PATH[index].id}]")).to_be_visible()


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
