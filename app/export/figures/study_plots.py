"""Draw the results of a study: counts, a line with a band, or a map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap, LogNorm, Normalize
from matplotlib.figure import Figure as Page
from matplotlib.ticker import MaxNLocator

from ...colours import COLOURS
from ...text import Text
from .figure import ABOUT, DPI, SUFFIXES
from .style import INK_COLOUR, RULE_COLOUR, SMALL_PT, TITLE_PT, escape_mathtext, export_style

__all__ = ["MAX_SURVEYS", "PlotAxis", "StudyPlot", "save_study_plots"]

MAX_SURVEYS = 12  # surveys on a page
LOG_AXIS_RATIO = 1e4  # numbers that lie further apart are drawn over decades
SURVEY_WIDTH_IN, SURVEY_HEIGHT_IN, CAPTION_HEIGHT_IN = 3.55, 2.5, 0.3  # of a survey, and of the caption below all of them, in inches
SHADES = LinearSegmentedColormap.from_list(  # light to dark, also in grey
    "shades", [COLOURS[role] for role in ("print-pale", "print-light", "plant", "print-dark")])


@dataclass(frozen=True, eq=False)
class PlotAxis:
    """An axis of a survey: its name with the unit, and its values; words instead of numbers stand in `names`."""

    label: Text
    values: np.ndarray
    log: bool = False
    names: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class StudyPlot:
    """One number over what varies: `middle`, `low` and `high` have the shape of the sides; `sample` is all runs of it.

    A `share` lies between 0 and 1. NaN is left white.
    """

    title: Text
    sides: tuple[PlotAxis, ...]
    middle: np.ndarray
    low: np.ndarray
    high: np.ndarray
    sample: np.ndarray
    share: bool = False


def save_study_plots(surveys: Sequence[StudyPlot], kind: str, language: str, caption: Text, token: str) -> bytes:
    """The surveys on one page as "png", "svg" or "pdf", the same bytes for the same records; at most two sides each."""
    metadata = dict(SUFFIXES[f".{kind}"]["metadata"]) | ({ABOUT[kind]: token} if token else {})
    across = min(len(surveys), 2)
    down = math.ceil(len(surveys) / across)
    out = BytesIO()
    with export_style(language):
        size = (across * SURVEY_WIDTH_IN, down * SURVEY_HEIGHT_IN + CAPTION_HEIGHT_IN)
        page = Page(figsize=size, dpi=DPI, facecolor="white", layout="constrained")
        FigureCanvasAgg(page)
        page.get_layout_engine().set(rect=(0.0, CAPTION_HEIGHT_IN / size[1], 1.0, 1 - CAPTION_HEIGHT_IN / size[1]))  # type: ignore[union-attr]
        places = page.subplots(down, across, squeeze=False).ravel()
        for axes, survey in zip(places, surveys, strict=False):
            axes.set_title(escape_mathtext(survey.title(language)), fontsize=TITLE_PT, color=INK_COLOUR)
            (_counts, _band, _map)[len(survey.sides)](page, axes, survey, language)
        for axes in places[len(surveys):]:
            axes.set_axis_off()
        page.text(0.1 / size[0], 0.09 / size[1], escape_mathtext(caption(language)), fontsize=SMALL_PT, color=INK_COLOUR)
        page.savefig(out, format=kind, dpi=DPI, metadata=metadata)
    return out.getvalue()


def _counts(page: Page, axes: Axes, survey: StudyPlot, language: str) -> None:
    known = survey.sample[np.isfinite(survey.sample)]
    axes.hist(known, bins=int(np.clip(math.sqrt(len(known)), 5, 40)), color=COLOURS["plant"], range=(0.0, 1.0) if survey.share else None)
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))


def _band(page: Page, axes: Axes, survey: StudyPlot, language: str) -> None:
    side, = survey.sides
    x, middle, low, high = _at(side), *(np.where(np.isfinite(each), each, np.nan) for each in (survey.middle, survey.low, survey.high))
    if side.names:
        axes.errorbar(x, middle, yerr=np.maximum([middle - low, high - middle], 0.0), fmt="o", markersize=3.6, color=COLOURS["plant"],
                      elinewidth=1.0)
    else:
        axes.fill_between(x, low, high, color=COLOURS["plant"], alpha=0.22, linewidth=0.0)
        axes.plot(x, middle, color=COLOURS["plant"], linewidth=1.2, marker="." if len(x) < 30 else "", markersize=3.0)
    if survey.share:
        axes.set_ylim(-0.03, 1.03)
    elif _lowest(np.concatenate([low, high])):
        axes.set_yscale("log")
    _label(axes, side, language, "x")


def _map(page: Page, axes: Axes, survey: StudyPlot, language: str) -> None:
    down, across = survey.sides  # the last one varies fastest
    values, lowest = np.ma.masked_invalid(survey.middle), 0.0 if survey.share else _lowest(survey.middle)
    norm = Normalize(0.0, 1.0) if survey.share else LogNorm(lowest, float(values.max())) if lowest else None
    shown = axes.pcolormesh(_edges(across), _edges(down), np.ma.maximum(values, lowest) if lowest else values, cmap=SHADES, norm=norm,
                            rasterized=True)
    bar = page.colorbar(shown, ax=axes, pad=0.02)
    bar.outline.set_linewidth(0.5)  # type: ignore[operator]
    bar.outline.set_edgecolor(RULE_COLOUR)  # type: ignore[operator]
    _label(axes, across, language, "x")
    _label(axes, down, language, "y")


def _lowest(values: np.ndarray) -> float:
    """The least positive value, where none is negative and they lie decades apart; else 0."""
    known = values[np.isfinite(values)]
    positive = known[known > 0]
    return float(positive.min()) if len(positive) and np.all(known >= 0) and positive.max() > LOG_AXIS_RATIO * positive.min() else 0.0


def _label(axes: Axes, side: PlotAxis, language: str, which: str) -> None:
    axis = axes.xaxis if which == "x" else axes.yaxis
    axis.set_label_text(escape_mathtext(side.label(language)))
    if side.names:
        axis.set_ticks(range(len(side.names)), [escape_mathtext(name) for name in side.names])
    elif side.log:
        (axes.set_xscale if which == "x" else axes.set_yscale)("log")


def _at(side: PlotAxis) -> np.ndarray:
    return np.arange(len(side.names), dtype=float) if side.names else side.values


def _edges(side: PlotAxis) -> np.ndarray:
    """Where the cells around the values begin and end: halfway between neighbours."""
    at = np.log(side.values) if side.log and not side.names else _at(side)
    half = np.diff(at) / 2 if len(at) > 1 else np.array([0.5])
    edges = np.concatenate([[at[0] - half[0]], at[:-1] + half[:len(at) - 1], [at[-1] + half[-1]]])
    return np.exp(edges) if side.log and not side.names else edges
