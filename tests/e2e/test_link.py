"""The page before the server speaks and after it has fallen silent."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager

import pytest
from playwright.sync_api import Browser, Page
from tab import Tab, eventually

from observer_lab.lessons import LESSONS
from observer_lab.page.words import phrases
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token

SLIDER = "模型刚度误差 [%]"
COVERED = """() => {
  const at = document.elementFromPoint(innerWidth / 2, innerHeight / 2), form = document.elementFromPoint(innerWidth - 60, 60);
  return [at, form].every(e => e?.closest('.ol-cover')) && document.querySelector('.ol-cover').innerText;
}"""

NO_NEWS = "window.Worker = class extends EventTarget { postMessage() {} terminate() {} }"  # a server that never answers


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    context = browser.new_context(viewport={"width": 900, "height": 560}, reduced_motion="reduce")
    yield context.new_page()
    context.close()


def test_a_dead_server_is_said_and_a_living_one_goes_on(page: Page, serve: Callable[..., AbstractContextManager[str]]) -> None:
    """In Chinese: what the page says it has from its own languages, and the new server speaks that of the old one."""
    with serve() as address:
        tab = Tab(page, address, drawn=False)
        tab.press("中文")
        eventually(lambda: page.evaluate("document.documentElement.lang"), lambda code: code == "zh", "the language")
        tab.slide(SLIDER, "ArrowRight", 4)
        tab.answered(rests=True)
        assert not page.locator(".ol-lost").is_visible()
    page.locator(".ol-lost").wait_for(state="visible")
    assert page.locator(".ol-lost").inner_text() == phrases.SERVER_LOST("zh")
    with serve(int(address.rpartition(":")[2])) as again:
        assert again == address
        page.locator(".ol-lost").wait_for(state="hidden")
        page.locator(".ol-cover").wait_for(state="hidden")
        tab.settle()
        eventually(lambda: tab.value(SLIDER), lambda value: value == 4.0, "the design as it was left")
    assert not [line for line in tab.complaints if "ERR_CONNECTION" not in line and "WebSocket" not in line]


@pytest.mark.parametrize("language", ["en", "zh"])
def test_our_name_stands_until_the_lesson_does(page: Page, server: str, language: str) -> None:
    page.add_init_script(f"sessionStorage.setItem('observer-lab-language', {language!r})")
    page.add_init_script(NO_NEWS)
    page.goto(server)
    page.wait_for_selector(".mantine-Paper-root", state="attached")  # viser's own form is laid out by now
    covered = page.evaluate(COVERED)
    assert covered, "viser's form is not covered"
    assert "Observer Lab" in covered and phrases.LOADING(language) in covered and "ws:" not in covered


def test_the_cover_goes_when_the_lesson_stands(tab: Tab) -> None:
    assert tab.page.locator(".ol-cover").is_hidden() and tab.page.locator(".ol-lost").is_hidden()


def test_a_link_survives_a_reload_before_its_first_connection(page: Page, server: str) -> None:
    """The page hides the link from viser until it connects; loaded again before that, it opens the link all the same."""
    lesson = LESSONS["noise"]
    token = write_token(lesson, SavedState(lesson.start(), "en", False))
    page.goto("about:blank")
    page.route("**/health", lambda route: route.abort())
    page.add_init_script("if (!sessionStorage.getItem('met')) window.Worker = class extends EventTarget "
                         "{ constructor() { super(); throw new Error('no connection yet'); } }")
    page.goto(f"{server}#{token}")
    page.wait_for_function("window.observerLabAddress")
    assert page.evaluate("location.hash") == "", "the link is out of the address before the page connects"
    page.evaluate("sessionStorage.setItem('met', '1')")
    page.reload()
    page.wait_for_selector(".ol-question")
    eventually(lambda: page.locator(".ol-question").inner_text(), lambda words: words == lesson.words["en"].question, "the link's lesson")
    kept = "sessionStorage.getItem('observer-lab-address-link')"
    eventually(lambda: page.evaluate(kept), lambda link: link == "", "the link is taken once the server's state stands in the address")
    page.evaluate("history.replaceState(null, '', location.pathname)")
    page.reload()
    eventually(lambda: page.locator(".ol-question").inner_text(), bool, "a lesson")
    assert page.evaluate(kept) == "", "what was taken is not opened again"
