"""A class draws its prediction with finger and keys; the cloud of all drawings stands in the figure, in the hall, and under the run."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

from playwright.sync_api import Page, expect

from observer_lab.classroom.room_store import RoomStore
from observer_lab.lessons import LESSONS

PATIENCE = 180_000  # ms: a busy machine is slow
PREDICT = next(k for k, scene in enumerate(LESSONS["virtual-sensor"].path) if scene.id == "predict")
OTHERS = 6
expect.set_options(timeout=PATIENCE)


def test_drawings_of_a_class_become_a_cloud_under_the_run(still_page: Callable[..., Page], tmp_path: Path,
                                                          serve: Callable[..., AbstractContextManager[str]]) -> None:
    options = ("--view", "guide", "--lesson", "virtual-sensor", "--room", "--data-dir", str(tmp_path))
    with serve(0, *options) as address:
        store = RoomStore(tmp_path)
        presenter, phone = still_page(1366, 768), still_page(390, 844, has_touch=True)
        for page, at in ((presenter, f"{address}/?present={store.secret}"), (phone, address)):
            page.set_default_timeout(PATIENCE)
            page.goto(at)
            page.wait_for_selector(".ol-scene")
        presenter.locator(".ol-dot").nth(PREDICT).click()
        presenter.get_by_role("button", name="Let the class draw").click()
        plane, send = phone.locator(".ol-sketch svg"), phone.locator(".ol-sketch").get_by_role("button", name="Send")
        expect(send).to_be_disabled()
        plane.focus()
        plane.press("ArrowUp")
        for _ in range(30):
            plane.press("ArrowRight")
        plane.press("ArrowDown")
        expect(send).to_be_enabled()
        plane.press("Enter")
        expect(phone.get_by_text("Your drawing is counted.")).to_be_visible()
        expect(presenter.locator(".ol-poll")).to_contain_text("1 vote")
        vote = store.votes()[-1]
        assert all(store.cast([(vote.number, f"other{k:05d}", tuple(1 - k / 10 - i / 80 for i in range(40))) for k in range(OTHERS)]))
        presenter.get_by_role("button", name="Close the vote").click()
        presenter.get_by_role("button", name="Show the counts").click()
        for page in (presenter, phone):
            expect(page.locator(".ol-drawings path").nth(OTHERS)).to_be_visible()
        assert len(set(store.votes()[-1].counts)) > 1 and store.votes()[-1].total == OTHERS + 1
        figure = presenter.locator("[data-figure=question]")
        expect(figure).not_to_contain_text("the copy's error")
        presenter.get_by_role("button", name="Reveal the answer").click()
        expect(figure).to_contain_text("the copy's error")
        expect(phone.locator(".ol-right")).to_be_visible()
        presenter.locator('[data-value="mode:present"]').first.click()
        expect(presenter.locator(".ol-hall .ol-drawings path").nth(OTHERS)).to_be_visible()
        hall = presenter.locator(".ol-hall .ol-poll svg").bounding_box()
        assert hall is not None and hall["height"] < 768, "the hall sees it whole"
