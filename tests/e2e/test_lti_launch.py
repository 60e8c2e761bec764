"""A launch in a real browser: a platform of another site logs in by a form, and the lesson opens, in a window and in its frame."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from lti_platform import LearningPlatform, pem
from playwright.sync_api import Page, expect

from observer_lab.course.handin.ledger import Ledger
from observer_lab.lessons import LESSONS
from observer_lab.page.access.addresses import listen
from observer_lab.page.access.tokens import AccessToken
from observer_lab.page.lti.doors import LtiDoors
from observer_lab.page.lti.keys import ToolKeys
from observer_lab.page.lti.settings import read_settings
from observer_lab.page.screen.server import LabServer

PATIENCE = 180_000  # ms: a busy machine is slow
LESSON = "duality"


@contextmanager
def lab_for(platform: LearningPlatform, folder: Path, framed: bool) -> Iterator[str]:
    """The address of a lab that this platform opens. `localhost` is another site than the 127.0.0.1 of the platform."""
    listener = listen("127.0.0.1", 0)
    port = listener.getsockname()[1]
    address = f"http://localhost:{port}"
    settings = read_settings(platform.toml(address), lambda name: pem("lab"))
    doors = LtiDoors(settings, ToolKeys(settings.private_key), Ledger(folder), LESSONS, None, port, time.time)
    server = LabServer(LESSONS, listener=listener, access=AccessToken("the-word-of-this-lab", port), doors=doors, sealed=True,
                       frames=(platform.url,) if framed else ())
    yield address
    server.stop()


@pytest.mark.parametrize("framed", [False, True], ids=["window", "frame"])
def test_a_launch_of_another_site_opens_the_lesson(still_page: Callable[..., Page], tmp_path: Path, framed: bool) -> None:
    platform = LearningPlatform()
    with lab_for(platform, tmp_path, framed) as lab:
        page = still_page(1000, 700)
        page.set_default_timeout(PATIENCE)
        refused = page.goto(lab)
        assert refused is not None and refused.status == 401, "nobody comes in without a launch"
        course = platform.show_course(lab, LESSON)
        page.goto(f"{course}/{'frame' if framed else 'link'}")
        if not framed:
            page.get_by_role("link", name="Lesson").click()
        shown = page.frame_locator("iframe") if framed else page
        expect(shown.locator(".ol-question")).to_have_text(LESSONS[LESSON].words["en"].question, timeout=PATIENCE)
        if not framed:
            assert page.url.startswith(f"{lab}/") and "token" not in page.url
            page.reload()
            expect(page.locator(".ol-question")).to_have_text(LESSONS[LESSON].words["en"].question, timeout=PATIENCE)
        page.close()
    platform.close()
