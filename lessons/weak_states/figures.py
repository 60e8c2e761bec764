"""Draw the figures of lesson 12 on any plant: ranks, Hankel values, error of the model."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import Curve, LineFigure, PlaneFigure, Point, over_frequency
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Design, Outcome
from observer_lab.text import format_number, joined, text

from .study import RELATIVE, Ranks, S, Setting, norms

RANK_TAB, HANKEL_TAB, MOTION_TAB = text("Rank"), text("Hankel values"), text("Motions")
LEAST = 1e-40  # a singular value drawn in place of zero
TOLERANCES = np.linspace(-18.0, 0.0, 145)  # log₁₀
FLOOR_SHARE = 1e-17  # of the largest value: the least that is drawn
WIDE = 1e100  # a gain beyond it is a pole on the axis


def figures(here: Setting[S], outcome: Outcome[S]) -> FigureSet:
    """Everything on the right of the stage."""
    d, study = outcome.design, outcome.study
    return FigureSet(
        tab_figures(RANK_TAB, lambda: (sizes(d, study.ranks), ranks_over_tolerance(d, study.ranks, here.told))),
        tab_figures(HANKEL_TAB, lambda: (here.staircase(study), error(here, study), *here.beside(study))),
        *here.more(outcome),
    )


def show(value: float, digits: int = 3) -> str:
    """A number for a table, with a true minus sign and powers of ten."""
    return format_number(value, f".{digits}g")


def sizes(d: Design, r: Ranks) -> PlaneFigure:
    """The singular values of both matrices, the tolerance between them."""
    n, against = len(r.reached), d["measure"] == RELATIVE
    reached, seen = (np.log10(np.maximum(v / max(v[0], LEAST) if against else v, LEAST)) for v in (r.reached, r.seen))
    index, level = np.arange(1.0, n + 1), np.log10(d["tolerance"])
    line = Curve(text("tolerance"), np.full(2, level), "reference", "dash", 1.6, np.array([0.5, n + 0.5]))
    curves = (Curve(text("controllability"), reached, "force", x=index),
              Curve(text("observability"), seen, "estimate", "dash", x=index), line)
    points = [Point(float(k), float(v), role, "dot" if v > level else "circle")
              for values, role in ((reached, "force"), (seen, "estimate")) for k, v in zip(index, values, strict=True)]
    low, high = min(reached[-1], seen[-1], level), max(reached[0], seen[0], level)
    return PlaneFigure(
        "sizes", text("singular values of both matrices"), curves, tuple(points), "k",
        "σ/σ₁" if against else "σ", (0.5, n + 0.5), (float(low - 1), float(high + 1)),
        tab=RANK_TAB, powers="y",
        caption=text("Time in units of {clock} s: smallest over largest {reached} and {seen}.",
                     clock=show(r.clock), reached=show(r.reached[-1] / max(r.reached[0], LEAST), 2),
                     seen=show(r.seen[-1] / max(r.seen[0], LEAST), 2)))


def ranks_over_tolerance(d: Design, r: Ranks, more: tuple[Curve, ...] = ()) -> PlaneFigure:
    """Both ranks as the tolerance says them."""
    n = len(r.reached)
    steps = np.array([r.at(10.0**level, d["measure"]) for level in TOLERANCES], dtype=float)
    now = r.at(d["tolerance"], d["measure"])
    curves = (Curve(text("controllability"), steps[:, 0], "force", x=TOLERANCES),
              Curve(text("observability"), steps[:, 1], "estimate", "dash", x=TOLERANCES), *more)
    points = [Point(float(np.log10(d["tolerance"])), float(rank), role, "circle")
              for rank, role in zip(now, ("force", "estimate"), strict=True)]
    return PlaneFigure(
        "ranks", text("rank against tolerance"), curves, tuple(points),
        "τ", text("rank"), (-18.0, 0.0), (0.0, n + 1.5), tab=RANK_TAB, powers="x",
        caption=text("At this tolerance: rank {now} of controllability, {now2} of observability, of {states}.",
                     now=now[0], now2=now[1], states=n))


def bars(positions: np.ndarray, levels: np.ndarray, floor: float, half: float) -> tuple[np.ndarray, np.ndarray]:
    """One line that goes up and down around every bar."""
    x = (positions[:, None] + half * np.array([-1.0, -1.0, 1.0, 1.0])).ravel()
    y = np.stack([np.full(len(levels), floor), levels, levels, np.full(len(levels), floor)], axis=1).ravel()
    return x, y


def error(here: Setting[S], study: S) -> LineFigure:
    """σ_max of the plant and of what the model leaves out, with the bound."""
    c, s = study.cut, study.system
    gains = np.where(np.isfinite(s.response).all(axis=(1, 2)), np.minimum(norms(s.response), WIDE), np.nan)
    least = here.floor or max(float(np.nanmax(gains, initial=0.0)), 1e-300) * FLOOR_SHARE
    sure = [v for v in (c.bound, c.peak) if v > least]
    largest = float(np.nanmax(gains, initial=least))
    window = here.window or (max(least, min([*sure, largest]) / 100), 10 * max([*sure, largest]))
    curves = [Curve(text("whole plant"), np.maximum(gains, least), "muted", width=1.4),
              Curve(text("error"), np.maximum(c.error, least), "error")]
    if sure or here.window:
        curves.append(Curve(text("bound 2Σσ"), np.full(len(s.frequencies), max(c.bound, least)), "reference", "dash", 1.6))
    said = (text("Nothing is cut: no error.") if c.order == s.most else
            joined(text("Largest error {peak} at {where} Hz. The bound 2Σσ over all values cut is {bound}.",
                        peak=show(c.peak, 4), where=show(c.where, 3), bound=show(c.bound, 4)), here.sharper(c)))
    return over_frequency("error", text("what the model leaves out: σ_max(G − G_r)"), s.frequencies, tuple(curves), "σ_max",
                          tab=HANKEL_TAB, window=window, caption=said)
