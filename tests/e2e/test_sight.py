"""What an eye would measure, on a few lessons, from a phone to a wall; `python tests/benchmarks/bench_sight.py` measures all of them."""

from __future__ import annotations

import pytest
from sight import look
from tab import Tab, eventually

from lessons import LESSONS

WALL = 3840, 2160


@pytest.mark.parametrize("name, size, large", [
    ("separation", (1366, 768), True), ("weak-states", (390, 844), False)], ids=str)
def test_the_first_knob_is_in_view_and_words_are_large_enough(walking: Tab, name: str, size: tuple[int, int], large: bool) -> None:
    tab, words = walking, LESSONS[name].words["en"]
    tab.open_lesson(words.title, words.question, size)
    tab.predict("skip")
    if large:
        tab.press("large print")
    tab.answered(rests=True)
    seen = look(tab, large)
    assert seen.knob == ""
    assert seen.hall == ()
    assert seen.cut == ()
    if large:
        assert seen.one_over <= 50.0, f"{seen.smallest}: {seen.words} px"
        tab.page.set_viewport_size({"width": WALL[0], "height": WALL[1]})
        tab.answered(rests=True)
        wall = eventually(lambda: look(tab, large), lambda it: it.one_over <= 50.0, "words of a wall")
        assert (wall.knob, wall.hall, wall.cut) == ("", (), ())
        for key in "oeh":  # the dialogs: all lessons, take it with you, the keys
            tab.key(key)
            tab.page.wait_for_selector(".mantine-Modal-content")
            seen = look(tab)
            assert seen.one_over <= 50.0, f"{key}: {seen.smallest}: {seen.words} px"
            tab.key(key)
            tab.page.wait_for_selector(".mantine-Modal-content", state="detached")
    if size[0] < 576:
        assert seen.screens <= 2.0, "a part of the lesson takes more than one screen of scrolling"
    if large:
        tab.press("large print")
