"""Sizes on the page."""

from __future__ import annotations

import pytest

from observer_lab.page import web
from observer_lab.page.charts.axes import H, W
from observer_lab.page.charts.print_sizes import (
    ASIDE,
    BAR,
    FRAME_PX,
    LARGE_PRINT_SHARE,
    LEFT_COLUMN_PX,
    RIGHT_COLUMN_PX,
    SHEET_MAX_WIDTH_PX,
    Sizes,
)
from observer_lab.page.charts.text_layout import LARGE_PRINT_PX as LETTER
from observer_lab.page.charts.text_layout import WORDS_PX
from observer_lab.session.state.view import State


@pytest.mark.parametrize("window", [(1024.0, 768.0), (1280.0, 720.0), (1920.0, 1080.0), (3840.0, 2160.0)], ids=str)
def test_in_large_print_every_word_takes_a_fiftieth_of_the_height_and_the_stage_has_its_room(window: tuple[float, float]) -> None:
    sizes = Sizes(State(lecture=True, window=window))
    assert sizes.chart_letter >= window[1] / 50
    assert sizes.left + sizes.right + sizes.run < window[0] and sizes.run >= 0.25 * window[0]
    assert f"{100 * LARGE_PRINT_SHARE:g}vh" in web.file_text("lecture.css")


@pytest.mark.parametrize("across", [900.0, 1024.0, 1280.0, 1366.0, 1920.0, 3840.0])
@pytest.mark.parametrize("up", [560.0, 768.0, 1366.0])
def test_columns_leave_the_stage_two_fifths_of_any_window_and_the_run_covers_none(across: float, up: float) -> None:
    sizes = Sizes(State(window=(across, up)))
    assert not sizes.sheet and across - sizes.left - sizes.right >= 0.4 * across
    assert sizes.left + sizes.right + sizes.run + 2 * BAR <= across + 1e-9
    assert (sizes.left, sizes.right) == (LEFT_COLUMN_PX, RIGHT_COLUMN_PX) or across < 1366


@pytest.mark.parametrize("window, below", [((320.0, 568.0), True), ((390.0, 844.0), True), ((768.0, 1024.0), True), ((896.0, 896.0), True),
                                           ((844.0, 390.0), False), ((683.0, 384.0), False)], ids=str)
def test_a_window_without_room_for_columns_has_a_sheet_below_the_stage_or_beside_it(window: tuple[float, float], below: bool) -> None:
    sizes = Sizes(State(window=window))
    assert sizes.sheet and sizes.below == below
    assert sizes.right == pytest.approx(window[0] if below else ASIDE * window[0])


def test_the_page_and_its_server_agree_where_a_sheet_begins() -> None:
    widest = f"(max-width:{SHEET_MAX_WIDTH_PX / 16:g}em)"
    assert f"@media {widest}{{" in web.file_text("page.css") and f"@media {widest} and (orientation:landscape)" in web.file_text("page.css")
    assert widest.replace(":", ": ") in web.file_text("breadth.js") and f"width:{100 * ASIDE:g}vw" in web.file_text("page.css")


@pytest.mark.parametrize("across", [900.0, 1024.0, 1200.0, 1280.0, 1366.0, 3840.0])
def test_words_of_drawings_are_legible_in_columns_of_any_width(across: float) -> None:
    sizes = Sizes(State(window=(across, 768.0)))
    assert (LETTER if sizes.large_words else WORDS_PX) * (sizes.right - FRAME_PX) / W >= 9.4


@pytest.mark.parametrize("window, listed", [
    ((390.0, 844.0), False), ((844.0, 390.0), False), ((768.0, 1024.0), True), ((900.0, 560.0), True)], ids=str)
def test_a_phone_has_no_keys_however_it_is_held(window: tuple[float, float], listed: bool) -> None:
    assert Sizes(State(window=window)).lists_keys == listed


def test_a_drawing_that_stands_alone_fills_its_column_in_a_hall_and_is_a_square_at_a_desk_but_not_in_a_sheet() -> None:
    hall, desk = (Sizes(State(lecture=large, window=(1920.0, 1080.0))) for large in (True, False))
    assert 0.6 * 1080 < hall.drawing(1) * hall.right / W < 0.8 * 1080
    assert desk.drawing(1) == W
    assert hall.drawing(2) == desk.drawing(2) == H
    assert all(Sizes(State(window=window)).drawing(1) == H for window in ((390.0, 844.0), (844.0, 390.0), (768.0, 1024.0)))


def test_the_figure_of_a_question_is_flatter_beside_its_verdict_where_the_window_is_low() -> None:
    low, high = (Sizes(State(window=window)) for window in ((1280.0, 720.0), (1920.0, 1080.0)))
    assert low.question(answered=True) < low.question() == high.question() == high.question(answered=True)
    hall = Sizes(State(lecture=True, window=(1920.0, 1080.0)))
    assert hall.question(answered=True) < hall.question() < W
    phone = Sizes(State(window=(390.0, 844.0)))
    assert phone.question() == phone.question(answered=True) == H
