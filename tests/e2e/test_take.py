"""A link is copied in one browser and opened in another; reload, back and a bad link do what a person expects; files come."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from contextlib import AbstractContextManager

from all_replays import state_in
from playwright.sync_api import Browser, Locator
from tab import Tab, eventually

from observer_lab.lessons import LESSONS
from observer_lab.page.words import phrases
from observer_lab.session.state.token import read_token

STIFFNESS = {"en": "stiffness error in the model [%]", "zh": "模型刚度误差 [%]"}


def open_link(browser: Browser, link: str) -> Tab:
    return Tab(browser.new_context(viewport={"width": 900, "height": 560}, reduced_motion="reduce").new_page(), link, drawn=False)


def address(tab: Tab) -> str:
    """What stands in the address bar now; Playwright's own copy of it is older."""
    return tab.page.evaluate("location.href")


def kept(tab: Tab, button: Locator) -> bytes:
    """The file that a press on a button brings."""
    with tab.page.expect_download() as download:
        button.click()
    return download.value.path().read_bytes()


def test_the_address_names_the_figure_that_opened_by_itself(tab: Tab) -> None:
    """No hand is on the page when the answer's figure opens: the choice is made without a pointer or a key."""
    tab.unfold(phrases.PREDICTION("en"))
    eventually(lambda: tab.page.evaluate("document.querySelector('.ol-option')?.click() === undefined"), bool, "an option")
    eventually(lambda: read_token(address(tab).partition("#")[2], LESSONS).tab, lambda name: name == "Poles", "the tab in the address")


def test_a_link_copied_in_one_browser_opens_the_same_in_another(tab: Tab, browser: Browser) -> None:
    """In Chinese, which the link carries; before the prediction it is all there is, as files would hold the answer."""
    language = "zh"
    tab.press("中文")
    tab.key("c")
    tab.slide(STIFFNESS[language])
    tab.unfold(phrases.COMPARE(language))
    (pin,) = tab.page.locator(".ol-pin").all_text_contents()
    assert pin.startswith("A") and "3" in pin
    tab.unfold(phrases.TIMELINE(language))
    for step, stiffness in (("last", 0), ("first", 3)):  # the start, and back to the latest step
        tab.page.evaluate(f"document.querySelector('.ol-steps li:{step}-child button').click()")
        tab.answered(rests=True)
        assert tab.value(STIFFNESS[language]) == stiffness
    before = address(tab)
    tab.page.get_by_role("tab").nth(1).press("Enter")
    eventually(lambda: address(tab), lambda url: url != before, "the tab in the address bar")
    tab.key("e")
    tab.page.locator(".ol-copy").click()
    assert tab.page.locator(".ol-code").count() == 1
    link = eventually(lambda: tab.page.locator(".ol-link").input_value(), lambda words: words.startswith(tab.address), "a link")
    assert tab.page.locator(".mantine-Modal-content").get_by_role("tab").count() == 1
    other = open_link(browser, link)
    assert address(other) == address(tab) and other.value(STIFFNESS[language]) == tab.value(STIFFNESS[language]) == 3
    assert other.question() == tab.question()
    assert other.page.locator(".ol-veil").count() == 1  # nothing is predicted yet
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
    assert other.notices()
    other.press("English")
    english = eventually(lambda: address(other), lambda url: url != link, "a link of its own for another language")
    assert other.question() == LESSONS["separation"].words["en"].question and not other.complaints
    other.page.context.close()
    eventually(tab.close_a_dialog, lambda left: left == 0, "the dialog closed")
    tab.page.evaluate("link => { location.href = link; }", english)  # where the page stands already
    eventually(tab.question, lambda words: words == LESSONS["separation"].words["en"].question, "the question in English")
    eventually(lambda: tab.value(STIFFNESS["en"]), lambda value: value == 3, "its design")


def test_what_a_browser_keeps_is_there_in_a_new_tab_after_the_server_was_restarted(
        serve: Callable[..., AbstractContextManager[str]], browser: Browser) -> None:
    context = browser.new_context(viewport={"width": 900, "height": 560}, reduced_motion="reduce")
    with serve() as address:
        tab = Tab(context.new_page(), address, drawn=False)
        tab.predict("A")
        tab.slide(STIFFNESS["en"])
        tab.key("c")
        tab.page.get_by_role("button", name="My designs").click()
        tab.row("name").locator("input").fill("mine")
        tab.answered()
        tab.press("keep this design under that name")
        tab.slide(STIFFNESS["en"])
        tab.answered(rests=True)
        tab.unfold(phrases.COMPARE("en"))
        before = tab.page.locator(".ol-pin").all_text_contents()
        tab.key("e")
        link = tab.page.locator(".ol-link").input_value()
        tab.page.locator(".mantine-Modal-content").get_by_role("tab").nth(1).click()
        assert f"state {link.rpartition('#')[2]}\n" in kept(tab, tab.page.get_by_text("CSV", exact=True)).decode("utf-8-sig")
        assert kept(tab, tab.page.locator(".ol-snapshot")).startswith(b"\x89PNG")
        tab.page.locator(".mantine-Modal-content").get_by_role("tab").nth(3).click()
        played = kept(tab, tab.page.get_by_role("button", name="The run as a page")).decode()
        assert played.rstrip().endswith("</html>") and read_token(state_in(played), LESSONS).design["stiffness_error"] == 6
        tab.page.locator(".mantine-Modal-content").get_by_role("tab").last.click()
        code = kept(tab, tab.page.get_by_role("button", name=phrases.DEVICE_C("en")))
        assert "separation-c/lab.c" in zipfile.ZipFile(io.BytesIO(code)).namelist()
        tab.page.close()
    with serve(int(address.rpartition(":")[2])) as again:
        assert again == address
        tab = Tab(context.new_page(), address, drawn=False)
        for folder in (phrases.COMPARE("en"), phrases.MY_DESIGNS("en")):
            tab.unfold(folder)
        assert tab.page.locator(".ol-pin").all_text_contents() == before and len(before) == 2
        assert tab.value(STIFFNESS["en"]) == 6 and tab.page.locator(".ol-veil").count() == 0
        tab.page.evaluate("""document.querySelector('[data-value="kept mine"]').click()""")
        tab.answered(rests=True)
        assert tab.value(STIFFNESS["en"]) == 3 and not tab.complaints
        tab.page.evaluate("""[...document.querySelectorAll('button')].find(b => b.textContent.startsWith('forget all')).click()""")
        eventually(lambda: tab.page.locator(".ol-pin").count(), lambda count: count == 0, "nothing is kept")
        tab.answered(rests=True)
        assert tab.page.locator(".ol-veil").count() == 1
        assert "mine" not in tab.page.evaluate("JSON.stringify([{...localStorage}, {...sessionStorage}])")
    context.close()
