"""The words on the stage are as large in a window that has changed its shape as in one that has had it from the start."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from client import WireTab

WIDE, TALL = (1280, 720), (400, 900)


def letters(tab: WireTab) -> dict[str, float]:
    """Label → the height of its letters."""
    return {name: node["props"]["font_scene_height"] for name, node in tab.nodes.items() if "font_scene_height" in node["props"]}


@pytest.mark.parametrize(("first", "then"), [(WIDE, TALL), (TALL, WIDE)], ids=["narrower", "wider"])
def test_words_are_as_large_after_a_change_of_the_window_as_from_the_start(enter: Callable[..., WireTab], first: tuple[int, int],
                                                                            then: tuple[int, int]) -> None:
    fresh = enter(canvas=then)
    tab = enter(canvas=first)
    before, wanted = letters(tab), letters(fresh)
    assert before.keys() == wanted.keys() and before != wanted
    tab.look(*then)
    tab.until(lambda: letters(tab) == pytest.approx(wanted, rel=1e-6), "letters of the new size")
