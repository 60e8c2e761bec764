"""Tabs are strangers to each other, and the server stays when a page is loaded again."""

from __future__ import annotations

from collections.abc import Callable

from tab import Tab, eventually

SLIDER = "stiffness error in the model [%]"


def test_two_tabs_do_not_mix(new_tab: Callable[..., Tab]) -> None:
    one, other = new_tab(), new_tab()
    quiet = other.shown()
    before = one.shown()
    one.slide(SLIDER, "ArrowRight", 5)
    eventually(one.shown, lambda shown: shown != before, "the tab's own curves follow its slider")
    one.press("中文")
    eventually(one.question, lambda words: not words.isascii(), "the tab's own language")
    other.answered()
    assert other.shown() == quiet
    assert other.question().isascii()
    assert other.value(SLIDER) == 0.0
    one.page.close()
    other.slide(SLIDER, "ArrowRight", 5)
    eventually(other.shown, lambda shown: shown != quiet, "a tab still answers after another has been closed")


def test_a_page_can_be_reloaded_and_the_server_stays(tab: Tab) -> None:
    question = tab.question()
    tab.slide(SLIDER, "ArrowRight", 5)
    for _ in range(2):
        tab.page.reload()
        tab.settle()
        assert tab.question() == question
    tab.close_any_notices()
    before = tab.shown()
    tab.slide(SLIDER, "ArrowRight", 5)
    eventually(tab.shown, lambda shown: shown != before, "a curve follows the slider after a reload")
