"""A lesson from the first question to a solved task without touching the mouse."""

from __future__ import annotations

from tab import Tab, eventually

SLIDER = "stiffness believed wrong by [%]"
FOCUS = "() => (document.activeElement?.textContent || document.activeElement?.getAttribute('aria-label') || '').trim()"
IS_THUMB = """label => {
  const held = document.activeElement;
  if (held?.getAttribute('role') !== 'slider') return false;
  const name = Array.from(document.querySelectorAll('label')).find(l => l.textContent === label);
  return name !== undefined && held.closest('[id="' + name.htmlFor + '"]') !== null;
}"""
ON_PAGE = "() => document.activeElement?.blur()"
REACH = 80  # presses of Tab within which everything in the left column must be reachable


def walk_to(tab: Tab, there: str, argument: str | None = None, wanted: object = True) -> None:
    """Press Tab until the focus is where it should be."""
    for _ in range(REACH):
        tab.page.keyboard.press("Tab")
        if tab.page.evaluate(there, argument) == wanted:
            return
    raise AssertionError(f"{argument or wanted} is not reached with {REACH} presses of Tab")


def test_the_whole_lesson_by_keyboard_alone(tab: Tab) -> None:
    walk_to(tab, FOCUS, wanted="B")
    tab.key("Enter")
    eventually(tab.clock, lambda t: t > 0.0, "the choice of a prediction starts the run")
    walk_to(tab, IS_THUMB, SLIDER)
    before = tab.shown()
    tab.key("ArrowRight", 16)
    eventually(lambda: tab.value(SLIDER), lambda v: v == 16.0, "the arrows move the slider")
    eventually(tab.shown, lambda shown: shown != before, "a curve follows")
    tab.key("t", 2)
    eventually(tab.notices, lambda words: "ratio" in words, "the first task is checked and says what is missing")
    tab.key("z")
    eventually(lambda: tab.value(SLIDER), lambda v: v != 16.0, "undo")
    tab.key("y")
    eventually(lambda: tab.value(SLIDER), lambda v: v == 16.0, "redo")
    tab.key("r")
    eventually(lambda: tab.value(SLIDER), lambda v: v == 0.0, "reset")


def test_playing_by_keys(tab: Tab) -> None:
    tab.predict("B")
    eventually(tab.clock, lambda t: t > 0.0, "a prediction starts the run")
    tab.page.evaluate(ON_PAGE)
    tab.key("Space")
    eventually(lambda: tab.button("▶ play").count(), lambda n: n == 1, "space pauses")
    tab.pause(4)
    still = tab.clock()
    tab.pause(4)
    assert tab.clock() == still
    tab.key("0")
    eventually(tab.clock, lambda t: t == 0.0, "0 goes back to the start")
    before = tab.shown()
    tab.key("k")
    eventually(tab.shown, lambda shown: shown != before, "K kicks the plant")
    eventually(tab.clock, lambda t: t > 0.0, "and plays")
    tab.key("h")
    listed = tab.page.locator(".ol-keys")
    listed.wait_for()
    for label in ("Undo", "Play or pause", "Check the first unsolved task", "Next lesson"):
        assert label in listed.inner_text(), "H lists every key"
    tab.press("close")
    listed.wait_for(state="detached")
