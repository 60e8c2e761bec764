"""A .zip of lessons in the browser: a tab opens it, walks a scene of it and has it after a reload; another tab sees nothing of it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

from own_lessons import first_files, whole_files, zipped
from playwright.sync_api import Page, expect
from tab import ANSWERED, eventually

from observer_lab.page.words import phrases

PATIENCE = 60_000  # ms: a busy machine is slow
HOSTILE = "<img src=x onerror=window.hacked=1>"


def open_course(page: Page, newcomer: bool = False) -> None:
    """The page of lessons, at its part for own ones; it opens by itself before a newcomer."""
    if not newcomer:
        page.locator(".ol-menu").click(timeout=PATIENCE)
    page.get_by_role("tab", name=phrases.OWN_LESSONS("en")).click(timeout=PATIENCE)


def upload(page: Page, file: Path) -> None:
    """Choose a file with the button of the page of lessons."""
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name=phrases.UPLOAD_LESSONS("en")).click(timeout=PATIENCE)
    chooser.value.set_files(file)


def test_a_tab_opens_its_own_lessons_and_walks_a_scene(still_page: Callable[..., Page], tmp_path: Path,
                                                       serve: Callable[..., AbstractContextManager[str]]) -> None:
    file, hostile = tmp_path / "mine.zip", {"lesson.md": f"{first_files('bad')['lesson.md']}\n{HOSTILE}\n"}
    file.write_bytes(zipped({"leaky-tank": whole_files("leaky-tank"), "bad": {**first_files("bad"), **hostile}}))
    page, other, complaints = still_page(), still_page(), list[str]()
    page.on("pageerror", lambda error: complaints.append(str(error)))
    with serve(0, "--view", "guide", "--allow-lessons") as address:
        page.goto(address)
        other.goto(address)
        open_course(page, newcomer=True)
        upload(page, file)
        meet = page.locator(".ol-card[data-scene=meet]")
        expect(meet).to_be_visible(timeout=PATIENCE)
        expect(page.get_by_text("bad in mine.zip cannot be read.")).to_be_visible(timeout=PATIENCE)
        expect(page.locator(".ol-answer")).not_to_contain_text("reaches the block")
        page.get_by_role("button", name=phrases.PLAY("en")).first.click(timeout=PATIENCE)
        expect(page.locator(".ol-answer")).to_contain_text("reaches the block", timeout=PATIENCE)
        page.locator(".ol-way button").last.click(timeout=PATIENCE)
        expect(page.locator(".ol-card[data-scene=guess]")).to_be_visible(timeout=PATIENCE)
        eventually(lambda: page.evaluate(ANSWERED, True), lambda said: said is True, "the scene is there and kept")
        page.reload()
        expect(page.locator(".ol-card[data-scene=guess]")).to_be_visible(timeout=PATIENCE)
        open_course(page)
        expect(page.locator(".ol-cards").last.get_by_text("Leaky-tank")).to_be_visible(timeout=PATIENCE)
        page.locator(".ol-cards:visible .ol-do[data-value=bad]").click(timeout=PATIENCE)
        expect(page.get_by_text("may begin HTML").first).to_be_visible(timeout=PATIENCE)
        open_course(other, newcomer=True)
        assert "Leaky-tank" not in other.content() and page.evaluate("window.hacked") is None
    assert not complaints
