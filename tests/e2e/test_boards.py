"""Poles are dragged with the mouse on the boards of the stage."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from geometry import drag, on_board, on_screen
from tab import Tab, eventually


def pair_of(tab: Tab, board: str, pole: int, count: int = 6) -> int:
    """The pole that mirrors another one in the real axis."""
    x, y = on_board(tab, board, pole)
    return next(i for i in range(count) if i != pole and abs(on_board(tab, board, i)[0] - x) < 1e-5
                and abs(on_board(tab, board, i)[1] + y) < 1e-5)


def test_dragging_a_pole_changes_its_gain_and_not_the_other(new_tab: Callable[..., Tab]) -> None:
    tab = new_tab(1280, 760)
    tab.predict("skip")
    eventually(tab.equations, lambda words: len(words) == 3 and all(words), "the live equations")
    for board, gain in (("controller", 1), ("observer", 2)):
        before, curves, place, twin = tab.equations(), tab.shown(), on_board(tab, board, 0), pair_of(tab, board, 0)
        drag(tab, on_screen(tab, f"/board/{board}/pole0"), (-18.0, 14.0))
        after = eventually(tab.equations, lambda words, old=before, i=gain: words[i] != old[i], f"the gain of the {board}")
        assert after[3 - gain] == before[3 - gain], "the other expert's gain must not change"
        assert tab.shown() != curves
        assert on_board(tab, board, 0) != place
        assert pair_of(tab, board, 0) == twin, "a complex pair moves as one"


def test_undo_takes_a_drag_back(new_tab: Callable[..., Tab]) -> None:
    tab = new_tab(1280, 760)
    tab.predict("skip")
    before = eventually(tab.equations, lambda words: len(words) == 3 and all(words), "the live equations")
    drag(tab, on_screen(tab, "/board/controller/pole0"), (-15.0, 10.0), steps=3)
    eventually(tab.equations, lambda words: words != before, "the gain follows the pole")
    tab.answered(rests=True)
    tab.key("z")
    eventually(tab.equations, lambda words: words == before, "one undo takes the whole drag back")


HEIGHT = "() => window.__viserMutable.camera.position.y"  # of the camera above the floor: the page's own y points up
TARGET = "() => window.__viserMutable.cameraControl.getTarget(window.__viserMutable.camera.position.clone()).y"
CANVAS = "() => { const box = window.__viserMutable.canvas.getBoundingClientRect(); return [box.x, box.y, box.width]; }"
SIGHT = "() => window.__viserMutable.camera.matrixWorldInverse.toArray()"


def test_a_hand_that_misses_the_cross_by_twenty_pixels_still_holds_it(new_tab: Callable[..., Tab]) -> None:
    """The pole goes with the hand: it does not jump to it, and the camera stays."""
    tab = new_tab(1280, 760)
    tab.predict("skip")
    for board, pole in (("controller", 0), ("observer", 0)):
        x, y = on_screen(tab, f"/board/{board}/pole{pole}")
        seen = tab.page.evaluate(SIGHT)
        drag(tab, (x - 19.0, y), (2.0, -20.0))
        tab.answered(rests=True)
        to = min((on_screen(tab, f"/board/{board}/pole{i}") for i in range(6)), key=lambda at: abs(at[0] - x - 2) + abs(at[1] - y + 20))
        assert abs(to[0] - x - 2.0) < 4.0 and abs(to[1] - y + 20.0) < 4.0, f"the {board}'s pole went from {(x, y)} to {to}"
        assert tab.page.evaluate(SIGHT) == pytest.approx(seen)


def test_the_camera_stays_above_the_floor_and_a_button_brings_it_back(new_tab: Callable[..., Tab]) -> None:
    tab = new_tab(1280, 760)
    for _ in range(2):  # the first word on a canvas that the panels have narrowed
        tab.press("whole view")
        tab.drawn()
    before = tab.page.evaluate(SIGHT)
    left, top, width = tab.page.evaluate(CANVAS)
    empty = (left + width / 2, top + 30.0)
    drag(tab, empty, (120.0, -500.0), steps=8)
    tab.page.mouse.move(*empty)
    tab.page.mouse.down(button="right")
    tab.page.mouse.move(empty[0], empty[1] - 400.0, steps=8)
    tab.page.mouse.up(button="right")
    tab.drawn()
    assert tab.page.evaluate(SIGHT) != pytest.approx(before), "the camera has moved"
    assert tab.page.evaluate(HEIGHT) > 0.0 and tab.page.evaluate(TARGET) > 0.0
    tab.press("whole view")
    eventually(lambda: tab.page.evaluate(SIGHT), lambda seen: seen == pytest.approx(before, rel=1e-3, abs=1e-3), "the view as it was")


def test_the_discs_swell_once_when_a_pointer_comes(new_tab: Callable[..., Tab]) -> None:
    tab = new_tab(1280, 760, own=True)
    tab.predict("skip")
    assert tab.page.evaluate("window.observerLabPulse") == "waits"
    tab.page.mouse.move(*on_screen(tab, "/board/observer/pole0"))
    eventually(lambda: tab.page.evaluate("window.observerLabPulse"), lambda said: said == "told", "the pulse")


def test_poles_are_held_until_a_prediction_is_made(new_tab: Callable[..., Tab]) -> None:
    tab = new_tab(1280, 760)
    before, place = tab.shown(), on_board(tab, "observer", 0)
    drag(tab, on_screen(tab, "/board/observer/pole0"), (-15.0, 10.0), steps=3)
    tab.answered(rests=True)
    assert tab.shown() == before and on_board(tab, "observer", 0) == place
