"""A .zip of lessons in the browser: a tab opens it, walks a scene of it and has it after a reload; another tab sees nothing of it."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

from own_lessons import first_files, whole_files, zipped
from playwright.sync_api import Page, expect
from tab import ANSWERED, eventually

from observer_lab.classroom.room_store import RoomStore
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


def test_a_class_sees_a_run_each_of_a_lesson_from_a_zip(still_page: Callable[..., Page], tmp_path: Path,
                                                        serve: Callable[..., AbstractContextManager[str]]) -> None:
    files, file = whole_files("leaky-tank"), tmp_path / "mine.zip"
    noisy = files["lesson.toml"].replace("[run]\n", "[run]\nnoise = 0.002\ndisturbance = 1e-6\n")
    file.write_bytes(zipped({"leaky-tank": {**files, "lesson.toml": noisy}}))
    options = ("--view", "guide", "--lessons", str(file), "--lesson", "leaky-tank", "--room", "--data-dir", str(tmp_path))
    with serve(0, *options) as address:
        secret = RoomStore(tmp_path).secret
        presenter, laptop, phone = still_page(), still_page(), still_page(390, 844, has_touch=True)
        for page, at in ((presenter, f"{address}/?present={secret}"), (laptop, address), (phone, address)):
            page.goto(at)
            expect(page.locator(".ol-card[data-scene=meet]")).to_be_visible(timeout=PATIENCE)
        expect(presenter.locator(".ol-seeds")).to_contain_text(phrases.SEED_EACH("en"), timeout=PATIENCE)
        presenter.locator(".ol-seeds button").click(timeout=PATIENCE)
        for page in (laptop, phone):
            expect(page.locator(".ol-own-run")).to_contain_text("Your run", timeout=PATIENCE)
            expect(page.locator(".ol-own-run")).to_contain_text("position", timeout=PATIENCE)
        expect(presenter.locator(".ol-seeds .ol-verdict")).to_be_visible(timeout=PATIENCE)
        assert laptop.locator(".ol-own-run svg").inner_html() != phone.locator(".ol-own-run svg").inner_html()
        if keep := os.environ.get("OBSERVER_LAB_PICTURES"):
            for name, page in {"presenter": presenter, "laptop": laptop, "phone": phone}.items():
                page.screenshot(path=f"{keep}/own-cloud-{name}.png")
