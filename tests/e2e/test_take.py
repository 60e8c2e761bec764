"""A link is copied in one browser and opened in another; reload, back and a bad link do what a person expects."""

from __future__ import annotations

import pytest
from playwright.sync_api import Browser
from tab import Tab, eventually

STIFFNESS = {"en": "stiffness believed wrong by [%]", "zh": "模型刚度误差 [%]"}


def open_link(browser: Browser, link: str) -> Tab:
    return Tab(browser.new_context(viewport={"width": 900, "height": 560}).new_page(), link, drawn=False)


def address(tab: Tab) -> str:
    """What stands in the address bar now; Playwright's own copy of it is older."""
    return tab.page.evaluate("location.href")


@pytest.mark.parametrize("language", ["en", "zh"])
def test_a_link_copied_in_one_browser_opens_the_same_in_another(tab: Tab, browser: Browser, language: str) -> None:
    if language == "zh":
        tab.press("中文")
    tab.slide(STIFFNESS[language])
    tab.answered(rests=True)
    before = address(tab)
    tab.page.get_by_role("tab").nth(1).press("Enter")
    eventually(lambda: address(tab), lambda url: url != before, "the tab in the address bar")
    tab.key("e")
    tab.page.locator(".ol-copy").click()
    assert tab.page.locator(".ol-code").count() == 1
    link = eventually(lambda: tab.page.locator(".ol-link").input_value(), lambda words: words.startswith(tab.address), "a link")
    other = open_link(browser, link)
    assert address(other) == address(tab) and other.value(STIFFNESS[language]) == tab.value(STIFFNESS[language]) == 3
    assert other.question() == tab.question()
    assert other.page.locator(".ol-option:enabled").count() == 4  # nothing is predicted yet
    first = other.question()
    other.key("n")
    other.answered(rests=True)
    assert eventually(other.question, lambda words: words != first, "another lesson")
    other.page.go_back()
    eventually(other.question, lambda words: words == first, "the lesson before")
    eventually(lambda: other.value(STIFFNESS[language]), lambda value: value == 3, "its design")
    other.page.reload()
    other.settle()
    assert other.value(STIFFNESS[language]) == 3 and address(other) == link
    other.page.evaluate("location.hash = '1.AAAA'")
    eventually(lambda: address(other), lambda url: url == link, "the address bar as before")
    assert other.notices() and not other.complaints
    other.page.context.close()
