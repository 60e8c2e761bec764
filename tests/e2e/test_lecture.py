"""A whole lecture in browsers, as long as its pages need; `lecture_walk.py --whole` takes the fifteen minutes of its plan."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

from lecture_walk import PATIENCE, play
from playwright.sync_api import Page, expect


def test_a_lecture_on_two_presenter_pages_laptop_and_phone_outlives_an_outage(still_page: Callable[..., Page], tmp_path: Path,
                                                                              serve: Callable[..., AbstractContextManager[str]]) -> None:
    expect.set_options(timeout=PATIENCE)

    def opened(address: str, across: int, up: int) -> Page:
        page = still_page(across, up, has_touch=across < 500)
        page.set_default_timeout(PATIENCE)
        page.goto(address)
        return page
    play(serve, opened, tmp_path)
