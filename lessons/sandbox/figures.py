"""Draw the figures of lesson 19; an analysis that does not apply shows its reason."""

from __future__ import annotations

from itertools import accumulate
from typing import TypeVar

import numpy as np

from observer_lab.course.figures.diagram import DIAGRAM
from observer_lab.course.figures.gauges import LOWER, MIDDLE, UPPER, Gauge, GaugeFigure, place_of
from observer_lab.course.figures.records import Curve, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.engine import autonomous_error
from observer_lab.engine.design import typical_rate
from observer_lab.engine.simulation import Run
from observer_lab.engine.structure import Controllability, Mode, Observability
from observer_lab.plants import Model
from observer_lab.text import NO_WORDS, Text, format_number, joined, same, text

from ..toolkit.diagram import loop
from ..toolkit.figures import ERROR_TAB, TIME_TAB, error_figure, input_figure, state_figures
from ..toolkit.latex import pole_words, tiny
from .analyses import Refusal, Structure
from .loop_figures import (
    LOOP_TAB,
    LOWEST,
    NOISE_TAB,
    ROBUST_TAB,
    STRUCTURE_TAB,
    VERDICT_TAB,
    blocks,
    certificate_table,
    decades,
    empty_plane,
    gain_figure,
    margin_table,
    nis_figure,
    recovery_plane,
    sensitivity_figure,
    spectrum,
    valley,
    why,
)
from .study import LEAST_DISK, MOST_ERROR, NIS_SHARE, RECOVERY_LEVELS, Study, frequencies, times_the_least

LEAST_SIZE = -3.0  # decades: the foot of the figure of singular values, where none and no tolerance lies below it
LOST = 1e-10  # of the plant's size: the staircase takes a smaller coupling for rounding
HEADS = (text("question"), text("value"), text("band"), text("verdict"))


def figures(model: Model, outcome: Outcome[Study]) -> FigureSet:
    """Verdicts; structure; the run; loop; noise; robustness."""
    study, run, design, plant = outcome.study, outcome.run, outcome.design, model.plant
    assert run is not None
    limit = design["u_max"] if design["limited"] else None
    return FigureSet(
        tab_figures(VERDICT_TAB, lambda: (lights(study.rows), numbers(study)), "late"),
        tab_figures(VERDICT_TAB, lambda: (modes_plane(study.structure),)),
        tab_figures(TIME_TAB, lambda: state_figures(model, run)), tab_figures(ERROR_TAB, lambda: error_figures(model, run, limit)),
        tab_figures(STRUCTURE_TAB, lambda: (sizes_plane(study.structure, design["tolerance"]), decomposition_map(study.structure, plant.n),
                                     hankel_plane(study.structure))),
        tab_figures(LOOP_TAB, lambda: (spectrum(study.loop, plant.dt), blocks(study.loop, plant, study.meter),
                                certificate_table(study.certificates))),
        tab_figures(NOISE_TAB, lambda: (valley(study.noise, design["belief"]), nis_figure(study.trial, plant.p), gain_figure(study.trial))),
        tab_figures(ROBUST_TAB, lambda: (
            sensitivity_figure(study.margins, study.recovered, frequencies(plant_rate=typical_rate(plant), dt=plant.dt)),
            margin_table(study.margins, plant), recovery_plane(study.steps, len(RECOVERY_LEVELS), study.refused))),
        tab_figures(DIAGRAM, lambda: (loop(plant, run, outcome.gains["L"], outcome.gains["K"]),)))


MOST_MODES = 6  # places of the figure of modes
BAR_PX, BAR_SHIFT = 15.0, 0.17  # px across a bar; places from the middle of two bars to each
YES, NO, NOT_APPLICABLE = text("● yes"), text("○ no"), text("— not here")
T = TypeVar("T")


# --- verdicts ----------------------------------------------------------------------------------------------------------
def lights(rows: tuple[tuple[Text, bool | None, Text], ...]) -> TableFigure:
    """Every analysis with its light and what it rests on."""
    lit, dark = (sum(row[1] is value for row in rows) for value in (True, False))
    return TableFigure(
        "lights", text("what can be said of this plant and loop"),
        (text("question"), text("verdict"), text("rests on")),
        tuple((name, NOT_APPLICABLE if holds is None else YES if holds else NO, said) for name, holds, said in rows), tab=VERDICT_TAB,
        caption=text("{lit} yes, {dark} no, {count} without an answer here.",
                     lit=lit, dark=dark, count=len(rows) - lit - dark))


def modes_plane(found: Structure) -> PlaneFigure:
    """Two bars for each mode, the weakest mode first: its distance from being unobservable, and from being uncontrollable."""
    title = text("modes, and how far from hidden (PBH, units divided out)")
    for report in (found.seen, found.reached):
        if isinstance(report, Refusal):
            return empty_plane("modes", title, VERDICT_TAB, why(report))
    assert isinstance(found.seen, Observability) and isinstance(found.reached, Controllability)
    pairs = [(a, b) for a, b in _paired(found.seen.modes, found.reached.modes) if a.pole.imag >= -1e-12 * abs(a.pole)]
    pairs.sort(key=lambda pair: min(p.margin if p.visible else -1.0 for p in pair))
    shown, left = pairs[:MOST_MODES], max(len(pairs) - MOST_MODES, 0)
    lost, low = float(np.log10(LOST)), float(np.log10(LOST)) - 2.0
    curves = [Curve(name, np.array([low, _level(pair[side], low)]), role, "solid", BAR_PX, np.full(2, k + shift))
              for side, (name, role, shift) in enumerate(((text("seen by y"), "estimate", -BAR_SHIFT),
                                                          (text("reached by u"), "plant", BAR_SHIFT)))
              for k, pair in enumerate(shown)]
    tops = tuple(Point(k + shift, _level(pair[side], low), role, "dot" if pair[side].visible else "bolt")
                 for side, (role, shift) in enumerate((("estimate", -BAR_SHIFT), ("plant", BAR_SHIFT))) for k, pair in enumerate(shown))
    right = max(len(shown), 1) - 0.4
    curves.append(Curve(text("below: lost in rounding"), np.full(2, lost), "reference", "dash", 1.6, np.array([-0.6, right])))
    more = text("The {left} others are farther from hidden.", left=left) if left > 0 else NO_WORDS
    if left == 1:
        more = text("The other one is farther from hidden.")
    hidden, fixed = len(found.seen.unobservable), len(found.reached.uncontrollable)
    names = tuple((float(k), same(pole_words([complex(a.pole.real, abs(a.pole.imag))]))) for k, (a, _) in enumerate(shown))
    return PlaneFigure("modes", title, tuple(curves), tops, "", text("distance over the size of the plant"), (-0.6, right), (low, 0.5),
                       tab=VERDICT_TAB, powers="y", names=names, caption=joined(
                           text("Hidden from y: {hidden}. Out of reach of u: {fixed}.", hidden=hidden, fixed=fixed), more))


def _level(mode: Mode, low: float) -> float:
    """The decade of a mode's margin, the foot of the figure where it is hidden."""
    return max(float(np.log10(max(mode.margin, 1e-300))), low) if mode.visible else low


def _paired(seen: tuple[Mode, ...], reached: tuple[Mode, ...]) -> list[tuple[Mode, Mode]]:
    left, out = list(reached), []
    for mode in seen:
        twin = min(left, key=lambda other: abs(other.pole - mode.pole))
        left.remove(twin)
        out.append((mode, twin))
    return out


# --- structure ---------------------------------------------------------------------------------------------------------
def sizes_plane(found: Structure, rtol: float) -> PlaneFigure:
    """Singular values of O and of the controllability matrix against the tolerance."""
    title = text("singular values of O and [B, AB, …], σ/σ₁")
    points, said = [], []
    for report, role, mark in ((found.seen, "second", "dot"), (found.reached, "plant", "cross")):
        if isinstance(report, Refusal):
            return empty_plane("sizes", title, STRUCTURE_TAB, why(report))
        values = report.singular_values
        levels = decades(values / values[0]) if values[0] > 0 else np.full(len(values), LOWEST)
        points += [Point(k + 1.0, float(v), role, mark) for k, v in enumerate(levels)]  # type: ignore[arg-type]
        rank = report.matrix_rank(rtol) if values[0] > 0 else 0
        said.append((rank, report.rank))
    n = len(said) and found.seen.matrix.shape[1]  # type: ignore[union-attr]
    low = max(min(LEAST_SIZE, np.log10(rtol), *(point.y for point in points)), LOWEST) - 0.2
    line = Curve(text("tolerance τ"), np.full(2, np.log10(rtol)), "force", "dash", 2.4, np.array([0.5, n + 0.5]))
    (o, o_true), (c, c_true) = said
    return PlaneFigure("sizes", title, (line,), tuple(points), "k", "σ/σ₁", (0.5, n + 0.5), (low, 0.2), tab=STRUCTURE_TAB,
                       powers="y",
                       caption=text("At this tolerance rank(O) = {o} (dots) and rank[B, AB, …] = {c} (crosses) of "
                                    "{n}; the staircase finds {o_true} and {c_true}.",
                                    o=o, c=c, n=n, o_true=o_true, c_true=c_true))


def decomposition_map(found: Structure, plant_states: int) -> MatrixFigure:
    """Kalman decomposition as a heat map with its blocks."""
    d, title = found.decomposition, text("Kalman decomposition")
    if isinstance(d, Refusal):
        return MatrixFigure("decomposed", title, np.zeros((1, 1)), caption=why(d), tab=STRUCTURE_TAB)
    whole = np.block([[d.A, d.B], [d.C, np.zeros((len(d.C), d.B.shape[1]))]])
    edges = tuple(k for k in accumulate(d.sizes) if 0 < k < plant_states)
    both, reached, seen, neither = d.sizes
    rows = (*(f"z{i + 1}" for i in range(plant_states)), *(f"y{i + 1}" for i in range(len(d.C))))
    columns = (*(f"z{i + 1}" for i in range(plant_states)), *(f"u{i + 1}" for i in range(d.B.shape[1])))
    return MatrixFigure("decomposed", title, whole, rows, columns, (*edges, plant_states), tab=STRUCTURE_TAB, caption=text(
        "Reached and seen: {both}; reached only: {reached}; seen only: {seen}; neither: {neither}. From u to y "
        "only the first block acts.",
        both=both, reached=reached, seen=seen, neither=neither))


def hankel_plane(found: Structure) -> PlaneFigure:
    """Hankel singular values of the stable part."""
    values, title = found.hankel, text("Hankel singular values, σ/σ₁")
    if isinstance(values, Refusal):
        return empty_plane("hankel", title, STRUCTURE_TAB, why(values))
    levels = decades(values / values[0]) if values[0] > 0 else np.full(len(values), LOWEST)
    strong = int(np.count_nonzero(levels > -2))
    aside = (text("Unstable states, set aside first: {kept}.", kept=found.kept)
             if found.kept else NO_WORDS)
    return PlaneFigure("hankel", title, (), tuple(Point(k + 1.0, float(v), "plant", "dot") for k, v in enumerate(levels)), "k",
                       "σ/σ₁", (0.5, len(values) + 0.5), (min(float(levels.min()), -3.0) - 0.5, 0.5), tab=STRUCTURE_TAB, powers="y",
                       caption=joined(text("{strong} of {count} are above a hundredth of the largest: about so many states matter "
                                           "between u and y.", strong=strong, count=len(values)), aside))


# --- loop --------------------------------------------------------------------------------------------------------------
def error_figures(model: Model, run: Run, limit: float | None) -> tuple[LineFigure, ...]:
    """Error beside its promise; inputs."""
    return (error_figure(run, autonomous_error(run)), input_figure(run, model, limit))


def numbers(study: Study) -> GaugeFigure:
    """Distances to hidden modes, the observer's error, NIS and the disk margin, each beside what is accepted."""
    trial, margins = study.trial, study.margins
    return GaugeFigure("numbers", text("one number for each question"), (
        _distance(text("distance to unobservability"), study.structure.seen),
        _distance(text("distance to uncontrollability"), study.structure.reached),
        _error(times_the_least(study.noise)),
        _refused(text("NIS of the Kalman filter, on average"), trial) if isinstance(trial, Refusal) else
        _nis(trial.expected, trial.test.dof),
        _refused(text("disk margin α"), margins) if isinstance(margins, Refusal) else _disk(margins.together)),
        HEADS, text("Green: the band that is accepted. A number outside it has an arrow or a needle in another colour."), VERDICT_TAB)


def _distance(name: Text, report: Observability | Controllability | Refusal) -> Gauge:
    if isinstance(report, Refusal):
        return _refused(name, report)
    weakest = report.weakest
    hidden = any(not mode.visible for mode in report.modes)
    if weakest is None or weakest.margin <= 0 or hidden:
        return Gauge(name, -1.0, UPPER, "0", (tiny(LOST), "1"), f"> {tiny(LOST)}", _verdict(False), "wrong")
    at = min(max(place_of(weakest.margin, LOST, 1.0, UPPER), UPPER[0]), 1.0)
    return Gauge(name, at, UPPER, format_number(weakest.margin, ".2g"), (tiny(LOST), "1"), f"> {tiny(LOST)}", _verdict(True))


def _error(ratio: float | Refusal) -> Gauge:
    name = text("error over the Kalman filter's")
    if isinstance(ratio, Refusal):
        return _refused(name, ratio)
    held = ratio < MOST_ERROR
    return Gauge(name, place_of(max(ratio, 1.0), 1.0, MOST_ERROR, LOWER), LOWER, format_number(ratio, ".3g"), ("1", f"{MOST_ERROR:g}"),
                 f"< {MOST_ERROR:g}", _verdict(held), _role(held))


def _nis(expected: float, outputs: int) -> Gauge:
    low, high = (1 - NIS_SHARE) * outputs, (1 + NIS_SHARE) * outputs
    held = abs(expected / outputs - 1) < NIS_SHARE
    ends = format_number(low, ".3g"), format_number(high, ".3g")
    return Gauge(text("NIS of the Kalman filter, on average"), place_of(expected, low, high), MIDDLE, format_number(expected, ".3g"), ends,
                 f"{ends[0]} … {ends[1]}", _verdict(held), _role(held))


def _disk(alpha: float) -> Gauge:
    held = alpha >= LEAST_DISK
    return Gauge(text("disk margin α"), min(place_of(alpha, LEAST_DISK, 2.0, UPPER), 1.0), UPPER, format_number(alpha, ".3g"),
                 (f"{LEAST_DISK:g}", "2"), f"≥ {LEAST_DISK:g}", _verdict(held), _role(held))


def _refused(name: Text, refusal: Refusal) -> Gauge:
    return Gauge(name, None, UPPER, "—", ("", ""), same("—"), refusal.text, "muted")


def _verdict(held: bool) -> Text:
    return text("passes") if held else text("flagged")


def _role(held: bool) -> str:
    return "right" if held else "wrong"
