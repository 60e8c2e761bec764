"""Sizes on the page."""

from __future__ import annotations

import pytest

from app.tab.picture import State
from app.view import page
from app.view.axes import H, W
from app.view.sizes import LARGE, Sizes


@pytest.mark.parametrize("window", [(1024.0, 768.0), (1280.0, 720.0), (1920.0, 1080.0), (3840.0, 2160.0)], ids=str)
def test_in_large_print_every_word_takes_a_fiftieth_of_the_height_and_the_stage_has_its_room(window: tuple[float, float]) -> None:
    sizes = Sizes(State(lecture=True, window=window))
    assert sizes.chart_letter >= window[1] / 50
    assert sizes.left + sizes.right + sizes.run < window[0] and sizes.run >= 0.25 * window[0]
    assert f"{100 * LARGE:g}vh" in page.source("lecture.css")


@pytest.mark.parametrize("width", [1024.0, 1100.0, 1366.0, 2560.0])
def test_in_normal_print_the_panel_of_the_run_covers_no_column(width: float) -> None:
    sizes = Sizes(State(window=(width, 600.0)))
    assert sizes.left + sizes.right + sizes.run < width


def test_a_drawing_that_stands_alone_fills_its_column_in_a_hall_and_is_a_square_at_a_desk_but_not_on_a_phone() -> None:
    hall, desk = (Sizes(State(lecture=large, window=(1920.0, 1080.0))) for large in (True, False))
    assert 0.6 * 1080 < hall.drawing(1) * hall.right / W < 0.8 * 1080
    assert desk.drawing(1) == W
    assert hall.drawing(2) == desk.drawing(2) == Sizes(State(window=(390.0, 844.0))).drawing(1) == H
