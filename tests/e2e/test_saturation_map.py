"""The saturation lesson's map: computed with a bar, cancelled on demand, and clicked to run a start."""

from __future__ import annotations

from collections.abc import Callable

from geometry import on_screen
from tab import Tab, eventually

from observer_lab.lessons import LESSONS

LESSON = LESSONS["saturation"]
BAR = ".mantine-Progress-root"


def test_the_map_is_cancelled_then_computed_then_clicked(new_tab: Callable[..., Tab]) -> None:
    assert LESSON.job is not None
    start = LESSON.job.label("en")
    tab = new_tab(1280, 760)
    tab.choose_lesson(LESSON.words["en"].title, LESSON.words["en"].question)
    tab.page.locator("button", has_text="Map").last.scroll_into_view_if_needed()

    def cancelled() -> str:  # by quick keys, and again at another limit: a map may be done before the second key, and is not found twice
        tab.slide("force limit [N]", "ArrowRight", 1)
        tab.quick_keys("j", 2)
        tab.answered()
        return tab.notices()
    eventually(cancelled, lambda words: "cancelled" in words, "the cancellation is confirmed")
    tab.page.locator(BAR).first.wait_for(state="detached")
    answers = tab.page.locator('[role="tab"][aria-selected="true"]', has_text="Map")
    assert not answers.count()
    tab.press(start, rests=False)
    answers.wait_for()  # not the bar: a quick map is through before a browser has drawn it
    tab.page.locator(BAR).first.wait_for(state="detached")
    assert tab.button(start).count() == 1
    tab.close_any_notices()
    curves = tab.shown()
    x, y = on_screen(tab, "/map/picture")
    tab.page.mouse.click(x + 25, y - 6)
    eventually(tab.shown, lambda shown: shown != curves, "the clicked start runs")
