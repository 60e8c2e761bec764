"""A finger instead of a pointer: it takes hold of poles and knobs, and what it presses is large enough for it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from geometry import on_screen
from playwright.sync_api import Browser
from tab import Tab, eventually

SLIDER = "stiffness error in the model [%]"
BESIDE, LEAST = 12.0, 24.0  # px: from the middle of a thumb to a finger that takes it, and of what can be pressed
SMALL = f"""() => [...document.querySelectorAll('button, input:not([type=file]), [role=button]')].filter(each => {{
  const room = each.getBoundingClientRect();
  return room.height && room.top > 0 && room.bottom < innerHeight && Math.min(room.height, room.width) < {LEAST};
}}).map(each => each.outerHTML.slice(0, 300))"""


@pytest.fixture
def telephone(browser: Browser, server: str) -> Iterator[Tab]:
    """A page on a telephone, after its prediction."""
    context = browser.new_context(viewport={"width": 390, "height": 844}, reduced_motion="reduce", has_touch=True, is_mobile=True)
    tab = Tab(context.new_page(), server, drawn=False)
    tab.predict("B")
    tab.answered(rests=True)
    yield tab
    context.close()
    assert not tab.complaints


def draw_a_finger(tab: Tab, x: float, y: float, across: float) -> None:
    """Put a finger down, move it across and lift it."""
    touch = tab.page.context.new_cdp_session(tab.page)
    touch.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [{"x": x, "y": y}]})
    for k in range(1, 9):
        touch.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": [{"x": x + across * k / 8, "y": y}]})
        tab.sent()
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    tab.answered(rests=True)


def test_a_finger_drags_a_pole_and_a_knob_and_finds_what_it_presses(telephone: Tab) -> None:
    tab = telephone
    before, (x, y) = tab.shown(), on_screen(tab, "/board/observer/pole0")
    draw_a_finger(tab, x, y, -40.0)
    eventually(tab.shown, lambda shown: shown != before, "the curves follow the pole")
    for part in ("knobs", "tasks", "predict"):
        tab.page.locator(f".ol-parts button[data-part={part}]").tap()
        assert tab.page.evaluate(SMALL) == []
        if part == "knobs":
            box = tab.thumb(SLIDER).bounding_box()
            assert box is not None and tab.value(SLIDER) == 0
            draw_a_finger(tab, box["x"] + box["width"] / 2, box["y"] + box["height"] / 2 - BESIDE, 40.0)
            eventually(lambda: tab.value(SLIDER), lambda value: value > 0, "the knob follows")


def test_another_lesson_begins_with_its_question_on_a_phone_too(telephone: Tab) -> None:
    telephone.page.locator(".ol-parts button[data-part=tasks]").tap()
    assert not telephone.page.locator(".ol-question").is_visible()
    telephone.key("n")
    eventually(telephone.page.locator(".ol-question").is_visible, bool, "the question of the next lesson")
