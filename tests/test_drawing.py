"""Small drawings and labels: every word has its own place, and says what is so."""

from __future__ import annotations

import html
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from observer_lab.colours import COLOURS, rgb
from observer_lab.course.figures.gauges import UPPER, Gauge, GaugeFigure, place_of
from observer_lab.course.figures.matrix_figure import FULL, MATRICES, PALE
from observer_lab.course.figures.records import Curve, LineFigure, MapFigure, MatrixFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.knobs import Number
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.page.charts.axes import MARK_CLEAR_PX, PLOT_FRAME, Axes, H, W, clear_of_marks
from observer_lab.page.charts.charts import round_numbers
from observer_lab.page.charts.matrices import short
from observer_lab.page.charts.svg import draw
from observer_lab.page.charts.text_layout import (
    LARGE_PRINT_PX,
    Box,
    curve_key,
    fold_lines,
    place_along_curves,
    place_beside_mark,
    text_width,
)
from observer_lab.page.column.knob_widgets import marks
from observer_lab.text import NO_WORDS, same, squared_unit, symbol, text

TEXT = re.compile(r'<text x="([-\d.]+)" y="([-\d.]+)"[^>]*>([^<]*)</text>')


def height(drawing: str) -> float:
    """The height of a drawing's window."""
    found = re.search(r'viewBox="0 0 \d+ (\d+)"', drawing)
    assert found is not None
    return float(found[1])


def words(drawing: str) -> list[tuple[float, float, str]]:
    """Every word of a drawing that is not turned, with its place."""
    return [(float(x), float(y), text) for x, y, text in TEXT.findall(drawing)]


def plane(*names: str, points: tuple[Point, ...] = ()) -> PlaneFigure:
    line = np.linspace(-1, 1, 5)
    return PlaneFigure("p", same("plane"), tuple(Curve(same(n), line, x=line) for n in names), points, "x", "y")


# --- keys ------------------------------------------------------------------------------------------------------------
def test_the_key_of_many_curves_stands_below_the_axes_and_covers_none() -> None:
    many = ("one", "two", "three", "four", "another")
    drawing = draw(plane(*many), "en")
    places = {text: y for _, y, text in words(drawing)}
    assert all(places[name] > H for name in many) and height(drawing) > max(places.values())


@given(st.lists(st.tuples(st.floats(0.3, 4), st.floats(-3, 3), st.floats(-0.6, 0.6)), min_size=1, max_size=4), st.integers(0, 2))
def test_names_of_few_curves_stand_in_the_frame_apart_and_next_to_their_own(waves: list[tuple[float, float, float]], points: int) -> None:
    x = np.linspace(PLOT_FRAME.left, PLOT_FRAME.right, 80)
    middle, half = (PLOT_FRAME.top + PLOT_FRAME.bottom) / 2, (PLOT_FRAME.bottom - PLOT_FRAME.top) / 2
    curves = [np.column_stack([x, middle + half * (0.35 * np.sin(speed * x / 60 + phase) + shift)]) for speed, phase, shift in waves]
    names = [f"curve {k}" for k in range(len(curves))]
    taken = [Box(150.0 + 60 * k, middle - 6, 162.0 + 60 * k, middle + 6) for k in range(points)]
    places = place_along_curves(curves, names, PLOT_FRAME, taken)
    boxes = [at.box for at in places if at is not None]
    assert len(places) == len(names) and len(boxes) == len(names)
    for k, at in enumerate(boxes):
        assert at.left >= PLOT_FRAME.left and at.right <= PLOT_FRAME.right and at.top >= PLOT_FRAME.top and at.bottom <= PLOT_FRAME.bottom
        assert not any(at.meets(other) for other in [*boxes[:k], *taken])
        away = np.hypot(*(np.maximum(np.maximum(low - curves[k][:, i], curves[k][:, i] - high), 0)
                          for i, (low, high) in enumerate(((at.left, at.right), (at.top, at.bottom)))))
        assert away.min() < 20, "a name far from its curve"


def test_few_curves_need_no_key() -> None:
    assert height(draw(plane("one", "another"), "en")) == H


# --- names of axes ---------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("name, numbers", [
    ("vz [mm/s]", (-0.0005, 0.0005)), ("σ²/σ₀²", (0.0, 1e5)), ("rate of change of all that is seen [m/s]", (0.0, 1.0)),
    ("输入端测量噪声引起的电流的均方根值", (-1e4, 0.0))], ids=str)
def test_a_name_of_an_axis_is_whole_and_clear_of_the_numbers_in_large_print(name: str, numbers: tuple[float, float]) -> None:
    line = np.linspace(-1, 1, 5)
    drawing = draw(PlaneFigure("p", same("plane"), (Curve(same("c"), line, x=line),), (), name * 2, name, y_range=numbers), "en")
    upright = re.findall(r'<text transform="translate\(([\d.]+) ([\d.]+)\) rotate\(-90\)"[^>]*>([^<]*)</text>', drawing)
    for x, y, said in upright:
        assert float(x) + 0.1 >= 1.16 * LARGE_PRINT_PX and abs(float(y) - H / 2) + text_width(said, LARGE_PRINT_PX) / 2 < H / 2 + 12
    right = max(float(x) for x, _, _ in upright) + 0.29 * LARGE_PRINT_PX
    ends = re.findall(r'<text x="([\d.]+)" y="[\d.]+" text-anchor="end">([^<]*)</text>', drawing)
    assert ends and all(float(x) - text_width(said, LARGE_PRINT_PX) > right for x, said in ends)
    assert "".join(said for *_, said in upright).replace(" ", "") == name.replace(" ", "")
    below = [(x, y, said) for x, y, said in words(drawing) if y > H - 10 and said != "c"]
    assert "".join(said for *_, said in below).replace(" ", "") == (name * 2).replace(" ", "")
    assert all(
        x - text_width(said, LARGE_PRINT_PX) / 2 > 0 and x + text_width(said, LARGE_PRINT_PX) / 2 < W and y < height(drawing)
        for x, y, said in below
    )


def lie_on_each_other(p: Box, q: Box) -> bool:
    """Whether the lines of two words do, as `tests/e2e/sight.py` measures them on the page: by more than a third of their height."""
    high = min(p.right, q.right) - max(p.left, q.left), min(p.bottom, q.bottom) - max(p.top, q.top)
    return high[0] > 1.4 and high[1] > 0.3 * min(p.bottom - p.top, q.bottom - q.top)


@given(st.sampled_from((-12.0, -1.0, -0.0123, 0.0, 1e-6, 3.0, 1200.0)), st.sampled_from((1e-3, 0.004, 1.0, 7.3, 12.0, 5e4)),
       st.sampled_from((-200.0, -1.0, 0.0, 0.25)), st.sampled_from((0.5, 2.0, 1e4)), st.sampled_from(("", "x", "y", "xy")), st.booleans(),
       st.sampled_from((float(H), 1.4 * W)))
def test_no_number_of_an_axis_lies_on_another_in_large_print_or_is_cut(left: float, wide: float, low: float, high: float, powers: str,
                                                                       equal: bool, tall: float) -> None:
    x, y = (left, left + wide), (low, low + high)
    x, y = ((-wide, wide) if "x" in powers and wide < 20 else (-2.0, 3.0) if "x" in powers else x), ((-9.0, 1.0) if "y" in powers else y)
    drawing = draw(PlaneFigure("p", same("p"), (), (), "x", "y", x, y, equal and not powers, powers=powers), "en", True, tall)  # type: ignore[arg-type]
    lines = [
        Box(box.left, box.top - 0.44 * LARGE_PRINT_PX, box.right, box.bottom + 0.09 * LARGE_PRINT_PX) for _, box in boxes(drawing, True)[1:]
    ]
    assert not [(p, q) for i, p in enumerate(lines) for q in lines[:i] if lie_on_each_other(p, q)]
    assert len(lines) >= 4 and all(box.left >= 0 and box.right <= W for box in lines)


def test_the_key_of_a_map_stands_below_the_axes_as_patches() -> None:
    grid = np.arange(3.0)
    drawing = draw(MapFigure("m", same("map"), grid, grid, np.zeros((3, 3)), ((same("in"), "plant"),), "x", "y"), "en")
    assert next(y for _, y, text in words(drawing) if text == "in") > H
    assert '<rect x=' in drawing.rsplit("<text", 1)[0][-160:]


def test_two_curves_of_one_name_are_told_once() -> None:
    assert [text for *_, text in words(draw(plane("band", "band", "line"), "en"))].count("band") == 1


def test_a_plane_without_names_needs_no_room_for_a_key() -> None:
    assert height(draw(plane(""), "en")) == H


def test_a_long_key_goes_on_in_the_next_row_inside_the_drawing() -> None:
    names = [f"a rather long name {k}" for k in range(7)]
    drawing = draw(plane(*names), "en")
    told = [(x, y, text) for x, y, text in words(drawing) if text in names]
    assert len({y for _, y, _ in told}) > 1 and max(y for _, y, _ in told) < height(drawing)
    assert all(x > 0 and x + text_width(text) <= W + 1 for x, _, text in told)


# --- names of marks --------------------------------------------------------------------------------------------------
def test_the_name_of_a_mark_at_the_right_edge_is_not_cut() -> None:
    x = next(w[0] for w in words(draw(plane("", points=(Point(1.0, 0.0, name=same("the present one")),)), "en"))
                      if w[2] == "the present one")
    assert x <= W - 12


def test_names_of_marks_that_crowd_do_not_lie_on_each_other() -> None:
    taken: list[Box] = []
    for k in range(4):
        name = place_beside_mark(200.0 + 3 * k, 120.0, "yours", PLOT_FRAME, taken, np.zeros((0, 2)))
        assert not any(name.box.meets(other) for other in taken)
        taken.append(name.box)


def test_a_chinese_word_is_as_wide_as_its_characters_are_high() -> None:
    assert text_width("观测器", 10.0) == pytest.approx(30.0) and text_width("abc", 10.0) < 20.0 and text_width("x̂") == text_width("x")


PIECES = "not", "computed", "yet:", "→", "θ(0) [°]", "尚未计算：", "请按旋钮下方的按钮", "再看，"


@given(st.lists(st.sampled_from(PIECES), min_size=1, max_size=9), st.sampled_from(("", " ", "   ")), st.floats(6.0, 60.0))
def test_words_are_folded_into_lines_that_fit_and_lose_nothing(parts: list[str], between: str, most: float) -> None:
    said = between.join(parts)
    lines = fold_lines(said, most).split("\n")
    assert re.sub(r"\s", "", "".join(lines)) == re.sub(r"\s", "", said)
    assert all(text_width(line, 1.0) <= most or not re.search(r"\s|[\u2e80-\uffee][^，：]", line) for line in lines)
    assert not any(line.startswith(("，", "：")) for line in lines[1:])
    assert len(lines) == 1 or text_width(said, 1.0) > most


# --- matrices --------------------------------------------------------------------------------------------------------
def test_a_matrix_of_one_row_leaves_no_empty_area() -> None:
    assert height(draw(MatrixFigure("m", same("O"), np.ones((1, 6)), ("C",)), "en")) < 110


def test_a_small_matrix_shows_its_entries_and_the_names_of_its_columns() -> None:
    shown = [text for *_, text in words(draw(MatrixFigure("m", same("O"), np.array([[1.0, 0.0], [-2.5, 4.0]]), ("C", "CA"),
                                                          ("x1", "theta")), "en"))]
    assert {"1", "0", "−2.5", "4", "x₁", "θ", "C", "CA"} <= set(shown)


def test_cells_of_categories_have_their_colours_a_key_and_frames_around_lit_rows() -> None:
    """A cell without a category stays white, whatever its entry; one whose entry is zero is pale."""
    kinds = np.array([[0, -1], [1, 1]])
    figure = MatrixFigure("m", same("faults"), np.array([[1.0, 3.0], [0.0, 2.5]]), ("a", "b"), ("p", "q"), (), NO_WORDS, MATRICES,
                          ((same("expected"), "force"), (same("seen"), "error")), kinds, (1,))
    drawing = draw(figure, "en")
    fills = re.findall(r'<rect [^>]*fill="(#\w+)"[^>]*><title>', drawing)
    force, error = (np.array(rgb(COLOURS[role])) for role in ("force", "error"))
    assert [rgb(fill) for fill in fills] == [tuple(np.rint(255 + (full - 255) * depth)) for full, depth in (
        (force, FULL), (force, 0.0), (error, PALE), (error, FULL))]
    assert {"expected", "seen", "3", "0", "2.5"} <= {text for *_, text in words(drawing)}
    assert drawing.count('fill="none"') == 1
    assert [where for where, _ in figure.parts()][-2:] == ["category.1", "category.2"]


def test_a_block_carries_the_name_of_its_category_and_an_empty_one_a_zero() -> None:
    kinds = np.kron(np.array([[0, 1], [-1, 0]]), np.ones((2, 2), dtype=int))
    figure = MatrixFigure("m", same("loop"), np.triu(np.ones((4, 4))), (), (), (2,), NO_WORDS, MATRICES,
                          ((same("A − BK"), "plant"), (same("BK"), "force")), kinds)
    assert [text for *_, text in words(draw(figure, "en"))][-4:] == ["A − BK", "BK", "0", "A − BK"]
    mixed = replace(figure, kinds=np.arange(16).reshape(4, 4) % 2)
    assert not list(mixed.block_names())


def test_names_of_many_narrow_columns_are_turned_upright_and_lie_above_the_cells() -> None:
    drawing = draw(MatrixFigure("m", same("A"), np.eye(20), columns=tuple(f"column {k}" for k in range(20))), "en")
    assert drawing.count("rotate(-90)") == 20
    first = float(re.findall(r'<rect x="[\d.]+" y="([\d.]+)"', drawing)[0])
    assert first > 30 + text_width("column 19", 9.0)


@pytest.mark.parametrize(("name", "shown"), [("x1", "x₁"), ("z12", "z₁₂"), ("theta", "θ"), ("omega", "ω"), ("force 1", "force 1"),
                                             ("state1", "state1"), ("7", "7"), ("vx", "vx"), ("", "")])
def test_a_signal_is_named_as_in_a_formula(name: str, shown: str) -> None:
    assert symbol(name) == shown


@pytest.mark.parametrize("rows, columns", [(1, 6), (2, 2), (6, 6), (8, 8), (10, 5), (20, 20)], ids=str)
def test_no_word_of_a_matrix_in_large_print_is_smaller_than_another_or_lies_on_one(rows: int, columns: int) -> None:
    entries = np.random.default_rng(rows).choice((0.0, 1.0, -0.997, 0.00709, -2.63e-7, -1230.0, 12.0), (rows, columns))
    names = ("sideslip", "x1", "滚转角速度", "yaw rate", "theta")
    beside, above = (tuple(names[k % 5] for k in range(count)) for count in (rows, columns))
    drawing = draw(MatrixFigure("m", same("a long title of a matrix that has a long title"), entries, beside, above, (1,)), "en", True)
    assert {float(size) for size in re.findall(r'<text [^>]*font-size="([\d.]+)"', drawing)} == {LARGE_PRINT_PX}
    said = boxes(drawing, True)
    assert len(said) > rows and not [(a, b) for i, (a, p) in enumerate(said) for b, q in said[:i] if p.meets(q)]


def test_an_entry_keeps_the_digits_it_has_room_for_and_its_power_of_ten_below() -> None:
    assert short(0.00709, 3.5, 2) == ["0.0071"] and short(0.00709, 9.0, 2) == ["0.00709"] and short(-2.63e-7, 3.4, 2) == ["−2.63·", "10⁻⁷"]
    assert short(-2.63e-7, 2.5, 2) == ["−3·", "10⁻⁷"] and short(0.0, 1.0, 2) == ["0"] and short(-2.63e-7, 1.0, 2) == []


def test_the_key_in_large_print_is_as_large_as_other_words_and_goes_on_in_the_next_row() -> None:
    told = curve_key([(f"a name {k}", "#000000", "solid") for k in range(6)], W, 0.0, large=True)[0]
    assert {float(size) for size in re.findall(r'font-size="([\d.]+)"', told)} == {LARGE_PRINT_PX}
    assert all(x + text_width(text, LARGE_PRINT_PX) <= W + 1 for x, _, text in words(told.replace("<text", "\n<text")))


def boxes(drawing: str, large: bool) -> list[tuple[str, Box]]:
    """What every word of a drawing covers, in usual or in large print."""
    out = []
    for look, said in re.findall(r"<text ([^>]*)>([^<]*)</text>", drawing):
        found = dict(re.findall(r'([-\w]+)="([^"]*)"', look))
        if not said.strip():
            continue
        size = 14.6 if large and "font-size" not in found else float(found.get("font-size", 11))
        wide = text_width(html.unescape(said), size)
        if turned := re.match(r"translate\(([-\d.]+) ([-\d.]+)\) rotate\(-90\)", found.get("transform", "")):
            x, end = float(turned[1]), float(turned[2]) + (wide / 2 if found.get("text-anchor") == "middle" else 0.0)
            out.append((said, Box(x - 0.72 * size, end - wide, x + 0.2 * size, end)))
            continue
        left = float(found["x"]) - wide * {"start": 0.0, "middle": 0.5, "end": 1.0}[found.get("text-anchor", "start")]
        out.append((said, Box(left, float(found["y"]) - 0.72 * size, left + wide, float(found["y"]) + 0.2 * size)))
    return out


@pytest.mark.parametrize("language", ["en", "zh"])
@pytest.mark.parametrize("lesson", LESSONS.values(), ids=lambda lesson: lesson.id)
def test_every_drawing_of_a_lesson_can_be_drawn_and_no_words_lie_on_words(lesson: Lesson, language: str) -> None:
    """Nor does an axis count logarithms: powers of ten stand there as such."""
    for figure in lesson.figures(lesson.compute(lesson.start())):
        if isinstance(figure, LineFigure):
            continue
        for large in (False, True):
            drawing = draw(figure, language, large)
            assert figure.title(language)[:4] in drawing and "log₁₀" not in drawing
            said = boxes(drawing, large)
            assert not [(a, b) for i, (a, p) in enumerate(said) for b, q in said[:i] if p.meets(q)], (figure.id, large)


# --- sliders that move in decades ------------------------------------------------------------------------------------
def test_a_slider_says_its_ends_with_a_true_minus_and_one_in_decades_has_a_mark_at_each() -> None:
    knob = Number("tau", "", text("tolerance"), low=5e-4, high=0.1, default=0.05, scale="log")
    assert marks(knob, "en") == ((-3.301, "0.0005"), -3.0, -2.0, (-1.0, "0.1"))
    assert marks(replace(knob, low=1e-12, high=1.5e6), "en")[::19] == ((-12.0, "10⁻¹²"), (6.176, "1.5·10⁶"))
    assert marks(Number("x", "", text("place"), "m", low=-0.5, high=2.0), "en") == ((-0.5, "−0.5"), (2.0, "2"))


# --- tables ----------------------------------------------------------------------------------------------------------
def test_a_mark_and_its_word_stand_in_one_line_and_numbers_of_one_cell_part_behind_their_dot() -> None:
    drawn = draw(TableFigure("t", same("t"), (same("question"), same("verdict")), (("● yes", "0.007\u00a0·\u00a0>12"),)), "en")
    assert '<td class="ol-tied">● yes</td>' in drawn and "<td>0.007\u00a0·<wbr>\u00a0&gt;12</td>" in drawn
    assert "<td>2·<wbr>10⁻¹⁶</td>" in draw(TableFigure("t", same("t"), (same("gap"),), (("2·10⁻¹⁶",),)), "en")


# --- gauges ----------------------------------------------------------------------------------------------------------
def gauge(at: float, verdict: str = "passes") -> GaugeFigure:
    one = Gauge(same("mean"), at, (0.36, 0.64), "4", ("3", "5"), "3 … 5", same(verdict), "right" if 0.36 <= at <= 0.64 else "wrong")
    return GaugeFigure("g", same("tests"), (one,), (same("test"), same("value"), same("band"), same("verdict")))


def test_a_gauge_says_its_number_its_verdict_and_the_ends_of_its_band() -> None:
    assert {"mean", "4 · passes", "3", "5"} <= {said for _, _, said in words(draw(gauge(0.5), "en"))}
    assert gauge(0.5).table() == (["test", "value", "band", "verdict"], [("mean", "4", "3 … 5", "passes")])


def test_a_number_beyond_its_track_is_an_arrow_at_that_end() -> None:
    assert "ol-needle" in draw(gauge(0.5), "en") and "ol-beyond" not in draw(gauge(0.5), "en")
    left, right = (re.search(r'ol-beyond" points="([-\d.]+)', draw(gauge(at), "en")) for at in (-4.0, 4.0))
    assert left is not None and right is not None and float(left[1]) < 20 and float(right[1]) > W - 20


@pytest.mark.parametrize("large", [False, True])
def test_a_long_verdict_of_a_gauge_stands_below_it_inside_the_drawing(large: bool) -> None:
    drawing = draw(gauge(0.5, "not judged: it assumes white innovations of covariance S and more"), "en", large=large)
    size = LARGE_PRINT_PX if large else 11.0
    found = words(drawing)
    assert "4" in [said for _, _, said in found]
    below = [(x, y, said) for x, y, said in found if "judged" in said or "covariance" in said]
    assert below and all(x + text_width(said, size) <= W and y <= height(drawing) for x, y, said in below)


@given(st.floats(1e-300, 1e300), st.floats(1e-6, 1e6), st.floats(1.01, 1e3))
def test_a_gauges_needle_lies_in_its_band_exactly_where_the_number_does(value: float, low: float, ratio: float) -> None:
    at = place_of(value, low, low * ratio, UPPER)
    if not 1 - 1e-9 < value / low < 1 + 1e-9 and not 1 - 1e-9 < value / (low * ratio) < 1 + 1e-9:
        assert (UPPER[0] <= at <= UPPER[1]) == (low <= value <= low * ratio)


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
def test_a_number_without_a_logarithm_is_left_of_its_gauge(value: float) -> None:
    assert place_of(value, 0.1, 1.0) < 0


# --- axes of charts --------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("low", "high"), [(0.0, 2e-5), (-3e-9, 1e-9), (0.0, 5e-4), (-1.0, 2.0), (0.0, 15.0), (-2e7, 2e7), (0.0, 0.02)])
def test_no_two_numbers_on_an_axis_read_alike(low: float, high: float) -> None:
    at, names = round_numbers(low, high, 5)
    assert len(at) >= 3 and len(set(names)) == len(at) and all(len(name) <= 9 for name in names)
    assert names[at.index(0.0)] == "0"


def test_numbers_on_an_axis_have_true_minus_signs_and_one_power_of_ten() -> None:
    assert round_numbers(-1.0, 1.0, 4)[1] == ("−1", "−0.5", "0", "0.5", "1")
    assert round_numbers(0.0, 2e-5, 4)[1] == ("0", "0.5·10⁻⁵", "1·10⁻⁵", "1.5·10⁻⁵", "2·10⁻⁵")


@pytest.mark.parametrize(("unit", "shown"), [("A", "A²"), ("m/s", "(m/s)²"), ("", "1"), ("m s", "(m s)²")])
def test_the_square_of_a_unit_has_brackets_only_where_it_needs_them(unit: str, shown: str) -> None:
    assert squared_unit(unit) == shown


# --- marks, levels and maps ----------------------------------------------------------------------------------------------
@given(st.lists(st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)), min_size=1, max_size=6), st.booleans(), st.sampled_from((H, 2 * H)))
def test_no_mark_touches_the_frame_and_one_within_the_axes_stands_in_its_place(
        marks: list[tuple[float, float]], equal: bool, high: int) -> None:
    spans = [clear_of_marks((-1.0, 1.0), [mark[k] for mark in marks], long) for k, long in enumerate((W, high))]
    axes = Axes(spans[0], spans[1], equal, ("x", "a name of the other axis"), high=high)
    frame = axes.frame
    for mark in marks:
        x, y = axes.held(*mark)
        assert frame.left + MARK_CLEAR_PX <= x + 1e-9 and x - 1e-9 <= frame.right - MARK_CLEAR_PX
        assert frame.top + MARK_CLEAR_PX <= y + 1e-9 and y - 1e-9 <= frame.bottom - MARK_CLEAR_PX
        if max(map(abs, mark)) <= 1.0:
            assert (x, y) == pytest.approx(axes.at(*mark))


def test_levels_in_a_table_are_drawn_and_not_written() -> None:
    drawing = draw(TableFigure("t", same("modes"), (same("distance"),), (("0.12 ▮▮▮",), ("0",))), "en")
    assert "▮" not in drawing and drawing.count('class="ol-level" style="--parts:3"') == 1


def test_no_map_paints_in_the_colour_of_the_estimate() -> None:
    maps = [figure for lesson in LESSONS.values() if lesson.pick is not None
            for figure in lesson.figures(lesson.compute(lesson.start())) if isinstance(figure, MapFigure)]
    assert maps and not [figure.id for figure in maps if "estimate" in [role for _, role in figure.categories]]
