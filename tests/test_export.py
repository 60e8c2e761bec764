"""Exports: what is drawn and written is what the records hold, in every kind of figure and file, every time alike."""

import csv
import json
import warnings
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib._pylab_helpers import Gcf
from matplotlib.colors import to_hex, to_rgb

from observer_lab.colours import COLOURS
from observer_lab.course.figures.gauges import Gauge, GaugeFigure
from observer_lab.course.figures.ranges import LOG_AXIS_FLOOR
from observer_lab.course.figures.records import (
    MATRICES,
    Curve,
    Figure,
    LineFigure,
    MapFigure,
    MatrixFigure,
    PlaneFigure,
    Point,
    TableFigure,
    over_frequency,
)
from observer_lab.course.lesson import Check, Design, Outcome
from observer_lab.engine import Plant, Scenario, simulate
from observer_lab.export.data.data import HEADER, csv_rows, plain, run_record, save_csv
from observer_lab.export.figures import fonts
from observer_lab.export.figures.figure import SUFFIXES, ExportError, draw_page, save_figures
from observer_lab.export.figures.style import text_width_em, wrap
from observer_lab.text import label_in_language, same, text

T = np.linspace(0.0, 2.0, 120)
F = np.geomspace(0.1, 100.0, 90)
CAPTION = text("At the end of the run the estimate has caught up with the truth.")
TIME = LineFigure("time", text("height of the deck"), T, (
    Curve(text("true"), np.cos(3 * T)), Curve(text("estimate"), np.exp(-T) * 0.3, "estimate", "dash"),
    Curve(text("limit"), np.full(120, 1.5), "reference", "dot", 1.4),
    Curve(text("limit"), np.full(120, -1.5), "reference", "dot", 1.4)), "z [mm]", caption=CAPTION)
LOG = LineFigure("log", text("estimation error"), T, (Curve(same("‖e‖"), -np.exp(-9 * T), "error"),), "‖x − x̂‖",
                 log_y=True)
FREQUENCY = over_frequency("frequency", text("spectrum"), F, (
    Curve(text("open loop"), 1 / F**2, "reference"), Curve(text("closed loop"), 1e-3 / F, "force", "dot")),
    "PSD [(m/s)²/Hz]")
PLANE = PlaneFigure("plane", text("poles"), (Curve(same("path"), np.sin(T), "error", x=np.cos(T)),), (
    Point(-1.0, 0.5), Point(-1.0, -0.5), Point(-2.0, 0.0, "estimate", "circle", text("start")),
    Point(0.5, 0.0, "error", "bolt"), Point(9.0, 0.0, "force", "dot")), "Re s", "Im s", (-3.0, 1.0), (-1.0, 1.0), unstable=True)
MATRIX = MatrixFigure("matrix", text("loop"), np.array([[1.0, -1e-3], [0.0, 7.25]]), ("x1", "e1"), ("x1", "e1"), (1,))
CELLS = MatrixFigure("cells", text("loop"), np.array([[1.0, 0.0], [2.0, 3.0]]), ("x1", "e1"), ("x1", "e1"), (), CAPTION, MATRICES,
                     ((text("true"), "plant"), (text("estimate"), "error")), np.array([[0, -1], [1, 1]]), (1,))
MAP = MapFigure("map", text("starts"), np.linspace(-1, 1, 12), np.linspace(0, 3, 9),
                np.where(np.arange(9)[:, None] == 8, -1, np.arange(12) // 6),
                ((text("recovers"), "force"), (text("lost"), "estimate")), "x", "e", (0.3, 1.0))
TABLE = TableFigure("table", text("poles"), (text("true"), text("estimate")),
                    (("−1", "−1.0"), (text("unstable"), "$3"), ("✓", "✗")))
GAUGES = GaugeFigure("gauges", text("tests after 2 s"), (
    Gauge(text("mean of NIS"), 0.5, (0.36, 0.64), "4", ("3.6", "4.4"), "3.6 … 4.4", text("passes")),
    Gauge(text("mean of NEES"), 3.0, (0.36, 0.64), "60.6", ("3.8", "8.7"), "3.8 … 8.7", text("flagged"), "wrong")),
    (text("value"), text("value"), text("band"), text("verdict")))
KINDS: tuple[Figure, ...] = (TIME, LOG, FREQUENCY, PLANE, MATRIX, CELLS, MAP, TABLE, GAUGES)
MAGIC = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}


def axes_of(figure: Figure):
    return draw_page([figure]).axes[0]


def curves(axes):
    return [line for line in axes.lines if line.get_gid() is None and line.get_linewidth() > 0.7]


PAGES = [*(pytest.param((figure,), "en", id=figure.id) for figure in KINDS), pytest.param(KINDS, "zh", id="all-zh")]


@pytest.mark.slow
@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize(("figures", "language"), PAGES)
def test_every_kind_becomes_every_file_with_the_same_bytes_each_time(figures, language, suffix, tmp_path: Path) -> None:
    one, two = tmp_path / f"one{suffix}", tmp_path / f"two{suffix.upper()}"
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # no missing glyph, no limit that had to be ignored
        if language == "zh" and fonts.chinese_font() is None:
            warnings.simplefilter("ignore")
        save_figures(figures, one, language)
        save_figures(figures, two, language)
    assert one.read_bytes().startswith(MAGIC[suffix])
    assert one.read_bytes() == two.read_bytes()
    assert len(one.read_bytes()) > 2000


def test_a_page_holds_all_figures_in_order_and_their_words() -> None:
    page = draw_page(KINDS, "zh")
    assert [axes.get_gid() for axes in page.axes] == [figure.id for figure in KINDS]
    told = "".join(text.get_text() for text in page.texts)
    for figure in KINDS:
        assert figure.title("zh") in told
    assert CAPTION("zh") in told and "(a)" in told and "(g)" in told


def test_figures_do_not_overlap_on_the_page() -> None:
    boxes = [axes.get_position() for axes in draw_page(KINDS).axes]
    for i, box in enumerate(boxes):
        assert 0 <= box.x0 < box.x1 <= 1 and 0 <= box.y0 < box.y1 <= 1
        assert not any(box.overlaps(other) for other in boxes[:i])


@pytest.mark.parametrize("figure", [TIME, LOG, FREQUENCY], ids=lambda f: f.id)
def test_drawn_curves_are_the_records_curves(figure) -> None:
    axes = axes_of(figure)
    drawn = curves(axes)
    assert len(drawn) == len(figure.curves)
    log = figure.log_y
    assert axes.get_yscale() == ("log" if log else "linear")
    for line, curve in zip(drawn, figure.curves, strict=True):
        assert np.array_equal(line.get_xdata(), figure.x)
        assert np.array_equal(line.get_ydata(), np.maximum(np.abs(curve.y), LOG_AXIS_FLOOR) if log else curve.y)
        assert to_hex(line.get_color()).upper() == COLOURS[curve.role].upper()
        assert line.get_linestyle() == ("-" if curve.dash == "solid" else "--")


def test_dashes_differ_between_dash_dot_and_solid() -> None:
    styles = {str(line._unscaled_dash_pattern) for line in curves(axes_of(TIME))[:3]}
    assert len(styles) == 3


def test_marks_stand_where_the_record_says_and_on_the_edge_when_beyond_it() -> None:
    axes = axes_of(PLANE)
    marks = {line.get_gid(): line for line in axes.lines if line.get_gid()}
    assert np.array_equal(marks["plant-cross"].get_xydata(), [[-1.0, 0.5], [-1.0, -0.5]])
    assert np.array_equal(marks["estimate-circle"].get_xydata(), [[-2.0, 0.0]])
    assert np.array_equal(marks["force-dot"].get_xydata(), [[1.0, 0.0]])
    assert to_hex(marks["estimate-circle"].get_color()).upper() == COLOURS["estimate"]
    assert len({line.get_marker() for line in marks.values()} | {"o"}) >= 3
    shaded = [patch for patch in axes.patches if to_hex(patch.get_facecolor()).upper() == COLOURS["unstable"]]
    assert len(shaded) == 1 and shaded[0].get_x() == 0.0


def test_an_equal_plane_has_one_scale_and_still_shows_its_ranges() -> None:
    figure = PlaneFigure("e", same("e"), (), (Point(0, 0),), "x", "y", (-1.0, 3.0), (-5.0, 5.0), equal=True)
    axes = axes_of(figure)
    (x0, y0), (x1, y1) = axes.transData.transform([(0, 0), (1, 1)])
    assert x1 - x0 == pytest.approx(y1 - y0, rel=1e-9)
    assert axes.get_xlim()[0] <= -1.0 and axes.get_xlim()[1] >= 3.0
    assert axes.get_ylim()[0] <= -5.0 and axes.get_ylim()[1] >= 5.0


def test_zero_is_white_and_a_larger_entry_is_darker() -> None:
    image = axes_of(MATRIX).images[0].get_array()
    assert np.array_equal(image[1, 0], (1.0, 1.0, 1.0))
    assert np.allclose(image[1, 1], to_rgb(COLOURS["plant"]))
    assert image[1, 1].sum() < image[0, 0].sum() < image[0, 1].sum() < 3.0


def test_a_maps_cells_have_their_categorys_colour_and_unknown_ones_are_white() -> None:
    axes = axes_of(MAP)
    image = axes.images[0].get_array()
    for k, (_, role) in enumerate(MAP.categories):
        colour = 1 - 0.75 * (1 - np.array(to_rgb(COLOURS[role])))
        assert np.allclose(image[MAP.values == k], colour)
    assert (MAP.values == -1).any() and np.all(image[MAP.values < 0] == 1.0)
    assert axes.images[0].get_extent()[:2] == pytest.approx([-1 - 1 / 11, 1 + 1 / 11])
    assert {"recovers", "lost"} <= {text.get_text() for text in axes.texts}


def test_a_table_writes_every_cell_in_the_language_asked_for() -> None:
    cells = [text.get_text() for text in draw_page([TABLE], "zh").axes[0].texts]
    assert cells == ["真实", "估计", "−1", "−1.0", "不稳定", r"\$3", "✓", "✗"]


def test_a_direct_label_stands_nearest_to_its_own_curve() -> None:
    axes = axes_of(TIME)
    assert axes.get_legend() is None
    lines = {line.get_label(): line for line in curves(axes) if not str(line.get_label()).startswith("_")}
    for name, own in lines.items():
        text = next(t for t in axes.texts if t.get_text() == name)
        box = text.get_window_extent()

        def away(line, box=box) -> float:
            x, y = line.get_data()
            fine = np.linspace(x[0], x[-1], 4000)
            points = line.get_transform().transform(np.column_stack([fine, np.interp(fine, x, y)]))
            gap = np.maximum(np.maximum(box.min - points, points - box.max), 0)
            return float(np.hypot(*gap.T).min())
        nearest = min(curves(axes), key=away)
        assert nearest.get_label() in (name, "_") and nearest.get_color() == own.get_color()
        assert away(nearest) > 0, f"{name} is struck through"


def test_names_that_find_no_room_go_to_a_legend() -> None:
    crowd = tuple(Curve(same(f"output number {k}"), np.sin(9 * T) + 0.001 * k) for k in range(6))
    axes = axes_of(LineFigure("crowd", same("crowd"), T, crowd))
    assert [text.get_text() for text in axes.get_legend().get_texts()] == [c.name("en") for c in crowd]
    assert not axes.texts


def test_nan_infinity_and_huge_values_are_drawn_all_the_same(tmp_path: Path) -> None:
    wild = np.where(T > 1, np.inf, 1e300) * np.where(T > 1.5, np.nan, 1.0)
    figures = [LineFigure("a", same("a"), T, (Curve(same("y"), wild),)),
               LineFigure("b", same("b"), T, (Curve(same("y"), wild),), log_y=True),
               PlaneFigure("c", same("c"), (Curve(same("y"), wild, x=wild),), (Point(float("nan"), float("inf")),))]
    save_figures(figures, tmp_path / "wild.png")
    assert (tmp_path / "wild.png").stat().st_size > 2000


def test_another_suffix_and_an_empty_page_are_refused_in_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(ExportError, match=r"\.png, \.svg, \.pdf"):
        save_figures([TIME], tmp_path / "x.gif")
    with pytest.raises(ExportError, match="no figure"):
        save_figures([], tmp_path / "x.png")
    assert not list(tmp_path.iterdir())


def test_drawing_leaves_matplotlibs_settings_and_pyplots_list_of_figures_alone() -> None:
    before = dict(matplotlib.rcParams), list(Gcf.figs)  # another test may have left figures of its own
    draw_page([TIME, TABLE], "zh")
    assert (dict(matplotlib.rcParams), list(Gcf.figs)) == before


def test_without_a_chinese_font_the_figure_is_drawn_with_one_clear_warning(monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setattr(fonts, "chinese_font", lambda: None)
    with pytest.warns(fonts.MissingFontWarning, match="install one"), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph")
        save_figures([LOG], tmp_path / "boxes.png", "zh")
    assert (tmp_path / "boxes.png").exists()


def test_the_font_of_last_resort_is_not_taken_for_chinese(monkeypatch) -> None:
    last = [entry for entry in fonts.font_manager.fontManager.ttflist if "CJK" not in entry.name]
    monkeypatch.setattr(fonts.font_manager.fontManager, "ttflist", last)
    monkeypatch.setattr(fonts.font_manager, "findSystemFonts", lambda: [])
    found = fonts.chinese_font.__wrapped__()
    assert found is None or "Last Resort" not in found


@pytest.mark.parametrize("text", [CAPTION("en") * 4, CAPTION("zh") * 4, "the error e leaves its law 观测器误差，仍然收敛。" * 3],
                         ids=["en", "zh", "both"])
def test_wrapped_captions_lose_no_letter_and_fit(text: str) -> None:
    lines = wrap(text, 20.0)
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")
    assert all(text_width_em(line) <= 21.0 for line in lines) and len(lines) > 1
    assert not any(line[0] in "，。" for line in lines)


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_csv_read_back_is_the_record_to_the_last_bit(tmp_path: Path) -> None:
    save_csv(KINDS, tmp_path / "data.csv")
    rows = rows_of(tmp_path / "data.csv")
    assert tuple(rows[0]) == HEADER
    axes = {row["figure"]: (row["x_axis"], row["y_axis"]) for row in rows}
    assert axes["time"] == (TIME.x_label, label_in_language(TIME.y_label, "en")) and axes["matrix"] == ("", "")

    def series(figure: str, name: str, column: str = "y") -> list[float]:
        return [float(row[column]) for row in rows if (row["figure"], row["series"]) == (figure, name)]
    assert np.array_equal(series("time", "true"), TIME.curves[0].y)
    assert np.array_equal(series("time", "true", "x"), T)
    assert np.array_equal(series("time", "limit (2)"), TIME.curves[3].y)
    assert np.array_equal(series("log", "‖e‖"), LOG.curves[0].y)
    assert np.array_equal(series("frequency", "open loop", "x"), F)
    assert np.array_equal(series("plane", "path", "x"), np.cos(T))
    assert series("plane", "plant cross", "x") == [-1.0, -1.0] and series("plane", "start", "x") == [-2.0]
    entries = {(float(r["y"]), float(r["x"])): float(r["value"]) for r in rows if r["figure"] == "matrix"}
    assert entries == {(i, j): v for (i, j), v in np.ndenumerate(MATRIX.matrix)}
    cells = [(r["series"], float(r["x"]), float(r["y"]), float(r["value"])) for r in rows if r["figure"] == "map"]
    assert [c[3] for c in cells] == MAP.values.ravel().tolist()
    assert {(c[0], c[3]) for c in cells} == {("recovers", 0.0), ("lost", 1.0), ("", -1.0)}
    assert [r["value"] for r in rows if r["figure"] == "table"] == ["−1", "−1.0", "unstable", "$3", "✓", "✗"]


def test_csv_keeps_what_is_not_finite_readable() -> None:
    odd = LineFigure("odd", same("odd"), T[:3], (Curve(same("y"), np.array([np.nan, np.inf, 5e-324])),))
    written = [repr(row[4]) for row in csv_rows([odd])]
    assert written == ["nan", "inf", "5e-324"]


def test_a_run_as_json_is_strict_complete_and_exact() -> None:
    plant = Plant(np.array([[0, 1], [-1, -0.5]]), np.array([[0], [1]]), np.array([[1, 0]]))
    run = simulate(Scenario(plant, L=[[1.5], [-0.75]], x0=[1, 0], xhat0=[0, 0], horizon=1.0))
    design = Design("a-lesson", (("poles", (-1 + 2j, -1 - 2j)), ("speed", 2.0), ("on", True)))
    outcome = Outcome(design, {"L": np.array([[1.5], [-0.75]])}, {"observer": np.array([-1 - 0j, -1 + 0.25j])},
                      {"worst": np.inf, "size": np.float64(0.1)}, (Check("c", same("holds"), bool(np.True_), np.nan),), run)
    record = run_record(design, outcome)
    back = json.loads(json.dumps(record, allow_nan=False))
    assert list(back) == ["lesson", "knobs", "gains", "poles", "metrics", "never", "checks", "series"]
    assert back["knobs"] == {"poles": [[-1, 2], [-1, -2]], "speed": 2.0, "on": True}
    assert back["poles"] == {"observer": [[-1, 0], [-1, 0.25]]}
    assert back["metrics"] == {"worst": None, "size": 0.1}
    assert back["checks"][0]["holds"] is True and back["checks"][0]["value"] is None
    for name in ("t", "x", "xhat", "e", "u_asked", "u_applied", "y", "yhat"):
        assert np.array_equal(back["series"][name], getattr(run, name))


def test_plain_takes_any_number_to_what_json_has() -> None:
    assert plain({"a": (1 + 2j, np.int64(3), np.array([np.nan, 1.0]), None, "x")}) == {"a": [[1.0, 2.0], 3, [None, 1.0], None, "x"]}
