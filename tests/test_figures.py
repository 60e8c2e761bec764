"""Figure records: calm axes, finite data, thin curves, tables."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from laws import each, holds_for_all

from observer_lab.colours import COLOURS, WORDS_SHARE, for_words
from observer_lab.course.figures.curves import thin_samples
from observer_lab.course.figures.ranges import LOG_AXIS_FLOOR, axis_range, legal_range, round_up_nicely, steady_range
from observer_lab.course.figures.records import (
    SPECTRUM,
    Curve,
    LineFigure,
    MapFigure,
    MatrixFigure,
    PlaneFigure,
    Point,
    TableFigure,
    figure_below,
    finite,
    over_frequency,
    same_axis,
    same_key,
    tab_names,
)
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.page import web
from observer_lab.page.charts.charts import what_is_shared
from observer_lab.text import same, text

quick = settings(max_examples=200, derandomize=True, database=None)
sane = st.floats(-1e9, 1e9)
anything = st.floats(allow_nan=True, allow_infinity=True)


def time_figure(*series: list[float], log: bool = False, window: tuple[float, float] | None = None) -> LineFigure:
    n = max((len(s) for s in series), default=1)
    return LineFigure("x", same("x"), np.arange(float(n)), tuple(Curve(same("y"), np.array(s, dtype=float)) for s in series),
                      log_y=log, window=window)


# --- finite, nice, thin ----------------------------------------------------------------------------------------------
@quick
@given(st.lists(anything, min_size=1, max_size=20))
def test_drawn_values_are_finite_and_small_enough(values: list[float]) -> None:
    drawn = finite(np.array(values))
    assert np.all(np.isfinite(drawn)) and np.all(np.abs(drawn) <= 1e12)
    kept = np.array([math.isfinite(v) and abs(v) <= 1e12 for v in values])
    assert np.array_equal(drawn[kept], np.array(values)[kept])


def test_what_diverges_is_clipped_towards_its_own_side_and_the_input_is_untouched() -> None:
    values = np.array([np.nan, np.inf, -np.inf, 1e300, 1.0])
    assert finite(values).tolist() == [0.0, 1e12, -1e12, 1e12, 1.0]
    assert np.isnan(values[0])


@quick
@given(st.floats(1e-30, 1e30))
def test_a_nice_number_is_round_and_the_least_that_is_enough(value: float) -> None:
    n = round_up_nicely(value)
    assert value <= n * (1 + 1e-8) and n <= 2.5 * value * (1 + 1e-8)
    assert min(abs(n / 10 ** math.floor(math.log10(n * (1 + 1e-12))) - s) for s in (1, 2, 2.5, 5, 10)) < 1e-6


@each("value", [0.0, -1.0, float("nan"), float("inf")])
def test_a_nice_number_for_nothing_is_one(value: float) -> None:
    assert round_up_nicely(value) == 1.0


@quick
@given(st.integers(1, 5000), st.integers(1, 600))
def test_thinning_keeps_both_ends_the_order_and_the_pairs(n: int, points: int) -> None:
    t = np.arange(float(n))
    a, b, c = thin_samples(t, 2 * t, t**2, points=points)
    assert a[0] == 0 and a[-1] == n - 1 and np.all(np.diff(a) > 0)
    assert len(a) <= points + 1
    assert np.array_equal(b, 2 * a) and np.array_equal(c, a**2)


# --- axes ------------------------------------------------------------------------------------------------------------
@quick
@given(st.lists(st.lists(sane, min_size=3, max_size=3), min_size=1, max_size=3))
def test_a_linear_axis_holds_all_data_and_zero(series: list[list[float]]) -> None:
    low, high = axis_range(time_figure(*series))
    assert low < high and low <= 0 <= high
    assert all(low <= v <= high for s in series for v in s)


@quick
@given(st.lists(st.floats(1e-9, 1e9), min_size=1, max_size=6))
def test_a_logarithmic_axis_runs_over_whole_decades_around_the_data(values: list[float]) -> None:
    low, high = axis_range(time_figure(values, log=True))
    assert 0 < low < high and high >= max(values) * (1 - 1e-9)
    for end in (low, high):
        assert math.log10(end) == pytest.approx(round(math.log10(end)), abs=1e-9)
    assert math.log10(high / low) <= 9 + 1e-9
    if math.log10(high / min(values)) < 9:
        assert low <= min(values) * (1 + 1e-9)


@each("log", [False, True])
@each("series", [[[0.0, 0.0]], [[np.nan, np.nan]], [[np.inf, -np.inf]], [[1e300, 0.0]], [[1e-300, 0.0]],
                 [[5e-324]], [[-5e-324]], [], [[]], [[-1e-15, 1e-15]]])
def test_an_axis_is_a_finite_range_whatever_the_data(series: list[list[float]], log: bool) -> None:
    low, high = axis_range(time_figure(*series, log=log))
    assert math.isfinite(low) and math.isfinite(high) and low < high
    assert not log or low >= LOG_AXIS_FLOOR / 10


def test_an_axis_ends_at_the_most_that_a_figure_shows_and_keeps_its_window() -> None:
    figure = time_figure([-100.0, 50.0])
    assert axis_range(replace(figure, most=(-15.0, 15.0))) == (-20.0, 20.0)
    assert axis_range(replace(figure, most=(-500.0, 500.0))) == axis_range(figure)
    low, high = axis_range(replace(figure, most=(-1.0, 1.0), window=(-10.0, 10.0)))
    assert low <= -10 and 10 <= high < 50


def test_the_window_is_always_inside() -> None:
    low, high = axis_range(time_figure([0.1, 0.2], window=(-3.0, 4.0)))
    assert low <= -3 and high >= 4
    low, high = axis_range(time_figure([1.0, 2.0], log=True, window=(1e-4, 1e3)))
    assert low <= 1e-4 and high >= 1e3


@quick
@given(st.lists(st.lists(sane, min_size=2, max_size=4), min_size=1, max_size=8), st.booleans())
def test_while_a_knob_moves_the_axis_stays_put(runs: list[list[float]], log: bool) -> None:
    first = steady_range(time_figure(runs[0], log=log), None, False)
    for run in runs:
        assert steady_range(time_figure(run, log=log), first, False) == first


@quick
@given(st.lists(sane, min_size=2, max_size=4), st.lists(sane, min_size=2, max_size=4), st.booleans())
def test_a_resting_axis_shows_everything_and_then_stays(before: list[float], now: list[float], log: bool) -> None:
    last = steady_range(time_figure(before, log=log), None, True)
    figure = time_figure(now, log=log)
    wanted, reached = axis_range(figure), steady_range(figure, last, True)
    assert reached in (last, wanted)
    assert reached[0] <= wanted[0] * (1.01 if wanted[0] > 0 else 1) and wanted[1] <= reached[1] * 1.01
    assert steady_range(figure, reached, True) == reached


@quick
@given(st.lists(st.tuples(st.lists(sane, min_size=1, max_size=4), st.booleans(), st.booleans()), min_size=1, max_size=8))
def test_a_range_is_legal_for_the_figure_as_it_is_now_whatever_it_was(steps: list[tuple[list[float], bool, bool]]) -> None:
    """A knob that turned a chart logarithmic while it moved left it a range from zero: 17 of 64 positions were refused."""
    last = None
    for values, log, resting in steps:
        figure = time_figure(values, log=log)
        last = steady_range(figure, last, resting)
        assert legal_range(*last, log)
    assert steady_range(figure, last, False) == last


@pytest.mark.parametrize("bad", [(0.0, 1.0), (-1.0, 1.0), (1.0, 1.0), (2.0, 1.0), (math.nan, 1.0), (0.0, math.inf)])
def test_a_range_that_the_figure_cannot_have_is_not_kept(bad: tuple[float, float]) -> None:
    for resting in (False, True):
        assert steady_range(time_figure([1.0, 2.0], log=True), bad, resting) == axis_range(time_figure([1.0, 2.0], log=True))


def test_a_resting_axis_tightens_when_the_data_have_become_small() -> None:
    assert steady_range(time_figure([0.0, 1.0]), (0.0, 100.0), True) == axis_range(time_figure([0.0, 1.0]))
    assert steady_range(time_figure([0.0, 60.0]), (0.0, 100.0), True) == (0.0, 100.0)


@pytest.mark.parametrize("data, log, last, tightens", [
    ([0.0, 2.4], False, (0.0, 10.0), False), ([0.0, 1.9], False, (0.0, 10.0), True),  # 4 and 5 times what the data need
    ([1.0, 50.0], True, (1.0, 1e5), False), ([1.0, 50.0], True, (1.0, 1e6), True)])  # 2.5 and 3 times their decades
def test_a_resting_axis_keeps_four_times_the_range_of_the_data_or_two_and_a_half_times_their_decades(
        data: list[float], log: bool, last: tuple[float, float], tightens: bool) -> None:
    figure = time_figure(data, log=log)
    assert steady_range(figure, last, True) == (axis_range(figure) if tightens else last)


def test_a_spectrum_is_logarithmic() -> None:
    figure = over_frequency("f", same("f"), np.array([1.0, 10.0]), (Curve(same("y"), np.array([3e-3, 20.0])),))
    assert axis_range(figure) == pytest.approx((1e-3, 100.0))


# --- tables, tabs ----------------------------------------------------------------------------------------------------
def test_a_table_holds_what_is_drawn() -> None:
    t, y = np.array([0.0, 1.0]), np.array([2.0, 3.0])
    curve = Curve(text("speed"), y)
    assert LineFigure("a", same("a"), t, (curve, curve)).table() == (["t [s]", "speed", "speed (2)"], [(0, 2, 2), (1, 3, 3)])
    assert over_frequency("a", same("a"), t, (curve,)).table() == (["f [Hz]", "speed"], [(0, 2), (1, 3)])
    plane = PlaneFigure("a", same("a"), (Curve(same("c"), y, x=t),), (Point(5.0, 6.0),), "Re", "Im")
    assert plane.table() == (["series", "Re", "Im"], [("c", 0, 2), ("c", 1, 3), ("plant cross", 5, 6)])
    assert MatrixFigure("a", same("a"), np.eye(2), columns=("x", "y")).table() == (["", "x", "y"], [("0", 1, 0), ("1", 0, 1)])
    grid = MapFigure("a", same("a"), t, y, np.array([[0, 1], [0, -1]]), ((same("in"), "plant"), (same("out"), "plant")), "p", "q")
    assert grid.table() == (["p", "q", "category"], [(0, 2, "in"), (1, 2, "out"), (0, 3, "in"), (1, 3, "")])
    assert TableFigure("a", same("a"), (same("x"), same("y")), (("1", same("2")),)).table() == (["x", "y"], [("1", "2")])


def test_a_plane_without_anything_still_has_its_heads() -> None:
    assert PlaneFigure("a", same("a")).table() == (["series", "x", "y"], [])


def test_tabs_come_in_the_order_in_which_figures_name_them() -> None:
    one, two = text("one"), text("two")
    figures = [TableFigure(str(i), same("t"), (), (), tab=tab) for i, tab in enumerate((two, one, two))]
    assert tab_names(figures) == [two, one]


# --- figures that stand under each other -------------------------------------------------------------------------------
def lines(id: str, end: float = 1.0, names: tuple[str, ...] = ("a", "b"), said: str = "so") -> LineFigure:
    t = np.linspace(0.0, end, 5)
    return LineFigure(id, same(id), t, tuple(Curve(same(name), t) for name in names), caption=same(said))


def test_stacked_signals_share_their_axis_their_key_and_their_caption() -> None:
    first, second, third = lines("x"), lines("v"), lines("e", names=("a",))
    assert [what_is_shared(first, second), what_is_shared(second, third), what_is_shared(third, first), what_is_shared(third, None)] == [
        "-stacked-keyless", "-stacked", "-stacked-keyless", ""]
    assert what_is_shared(first, lines("v", end=2.0)) == "-keyless", "another length of time is another axis"
    assert figure_below((first, second), first) is second and figure_below((first, second), second) is None
    assert figure_below((first, replace(second, tab=SPECTRUM)), first) is None


def test_whatever_a_figure_leaves_out_is_said_in_its_tab() -> None:
    """The last figure of every tab has its axis, its key and its caption; those above lack only what one below has."""
    def law(lesson: Lesson) -> None:
        figures = lesson.figures(lesson.compute(lesson.start()))
        for figure in figures:
            told, under = {(c.name, c.role, c.dash) for c in getattr(figure, "curves", ())}, figure_below(figures, figure)
            while same_key(figure, under):
                assert isinstance(under, LineFigure) and told <= {(c.name, c.role, c.dash) for c in under.curves}
                figure, under = under, figure_below(figures, under)
            assert not same_key(figure, under) and not (under is None and same_axis(figure, under))
    holds_for_all(LESSONS.values(), law, lambda lesson: lesson.id)


@each("role", ["plant", "estimate", "error", "force", "disturbance", "second", "right", "wrong"])
def test_words_in_a_colour_have_contrast_on_paper(role: str) -> None:
    """At least 4.5 by WCAG 2.1, 1.4.3; with the share that the page's script mixes."""
    def light(colour: str) -> float:
        parts = (int(colour[k:k + 2], 16) / 255 for k in (1, 3, 5))
        return float(np.dot([0.2126, 0.7152, 0.0722], [c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]))
    assert (light(COLOURS["paper"]) + 0.05) / (light(for_words(COLOURS[role])) + 0.05) >= 4.5
    assert f"mixed(stroke, {f'{WORDS_SHARE:g}'.removeprefix('0')}, 0)" in web.file_text("names.js")
