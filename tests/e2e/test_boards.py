"""Poles are dragged with the mouse on the boards of the stage."""

from __future__ import annotations

from collections.abc import Callable

from geometry import drag, on_board, on_screen
from tab import Tab, eventually


def pair_of(tab: Tab, board: str, pole: int, count: int = 6) -> int:
    """The pole that mirrors another one in the real axis."""
    x, y = on_board(tab, board, pole)
    return next(i for i in range(count) if i != pole and abs(on_board(tab, board, i)[0] - x) < 1e-5
                and abs(on_board(tab, board, i)[1] + y) < 1e-5)


def test_dragging_a_pole_changes_its_gain_and_not_the_other(new_tab: Callable[..., Tab]) -> None:
    tab = new_tab(1280, 760)
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
    before = eventually(tab.equations, lambda words: len(words) == 3 and all(words), "the live equations")
    drag(tab, on_screen(tab, "/board/controller/pole0"), (-15.0, 10.0), steps=3)
    eventually(tab.equations, lambda words: words != before, "the gain follows the pole")
    tab.answered(rests=True)
    tab.key("z")
    eventually(tab.equations, lambda words: words == before, "one undo takes the whole drag back")
