"""Draw the figures of lesson 12 that only the platform has: its pairs, their motions, two regulators."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure, over_frequency
from observer_lab.course.lazy import TabFigures, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.text import Text, format_number, same, subscript, text, text_in

from ..toolkit.latex import apart, more
from .balanced_platform import STATE_COUNT, believed, closed_forms, relative, sigmas
from .body import MAX_DRAWN_MOTION, PARTS, share, swing
from .figures import HANKEL_TAB, MOTION_TAB, bars, show
from .platform_study import PlatformStudy, checks, formulas, live, numbers, studied
from .reduced_regulator import PAIRS
from .study import Cut, Setting

LQG_TAB = same("LQG")
REPORT = (1e-12, 1e-6)  # tolerances that the report names
NOTHING_CUT = text("All ten states are kept: there is only one design. Keep fewer and compare.")
PAIR_NAMES = text("height"), text("across"), text("tilt"), text("masses together"), text("masses apart")  # of the kinds of motion
PART_BAR_WIDTH, PART_BAR_GAP = 20.0, 0.19  # px; places from the middle of a part
BAR_WIDTH, ABOVE_BARS = 17.0, 0.8  # px; decades from a bar to the circle above it
LOG_AXIS_FLOOR = 1e-11  # drawn in place of zero on a logarithmic axis


def _further_tabs(outcome: Outcome[PlatformStudy]) -> tuple[TabFigures, ...]:
    return (
        tab_figures(MOTION_TAB, lambda: (_pair(outcome), _motions(outcome), _shapes(outcome))),
        tab_figures(LQG_TAB, lambda: (_spectrum(outcome), _gains(outcome))),
        tab_figures(LQG_TAB, lambda: (_costs(outcome),), "late"),
    )


def _told() -> Curve:
    first, last = np.log10(REPORT)
    return Curve(text("the report's range"), np.array([0.0, 10.5, 10.5, 0.0]), "muted", "dot", 1.6, np.array([first, first, last, last]))


def _sharper(c: Cut) -> Text:
    if c.sharp is None:
        return text("The cut runs between two equal values, where equal values may not be counted once.")
    return text("With equal values counted once it is {sharp}.", sharp=show(c.sharp, 4))


# --- Hankel ------------------------------------------------------------------------------------------------------------
def _staircase(study: PlatformStudy) -> PlaneFigure:
    s, order = study.system, study.order
    values, floor = np.log10(np.maximum(s.hankel, 1e-12)), -10.0
    curves = tuple(Curve(text("kept") if k < order else text("cut"), np.array([floor, max(value, floor)]),
                         "plant" if k < order else "muted", "solid", BAR_WIDTH, np.full(2, k + 1.0)) for k, value in enumerate(values))
    pair = s.motions.index(study.motion)
    points = (Point(2 * pair + 1.5, float(values[2 * pair]) + ABOVE_BARS, "error", "circle"),)
    names = tuple((2 * k + 1.5, PAIR_NAMES[motion.kind]) for k, motion in enumerate(s.motions))
    ratio = s.hankel[:-1] / s.hankel[1:]
    widest = int(np.argmax(ratio))
    after = same("") if widest == 7 else text("; after 8 it is {ratio:.0f}", ratio=ratio[7])
    return PlaneFigure(
        "staircase", text("Hankel singular values"), curves, points, text("what swings in each pair"), "σ",
        (0.3, STATE_COUNT + 0.7), (floor, 5.0), tab=HANKEL_TAB, powers="y", names=names,
        caption=text("The widest gap, a factor of {ratio:.0f}, comes after {widest}{after}. Circle: the pair on the "
                     "stage.",
                     ratio=ratio[widest], widest=widest + 1, after=after))


def _forms(study: PlatformStudy) -> TableFigure:
    s = study.system
    rows = tuple((subscript(f"σ{2 * s.pair(kind) + 1}"), words, show(s.hankel[2 * s.pair(kind)], 4), show(value, 4))
                 for (kind, value), words in zip(closed_forms(s.parameters, s.unit), (
                     "√2 Nz/(4 cz)", "√2 Nz μ²/(m² cp)", "√2 Nθ μ² s² √(s²+h²)/(J² cp)"), strict=True))
    return TableFigure(
        "forms", text("three values from the geometry"),
        (same("σ"), text_in("weak-states", "closed form"), text("exact"), text("form")), rows, tab=HANKEL_TAB,
        caption=text("Nz and Nθ: what one unit of every input lifts and turns. The stiffness kp of the servo is in none of them."))


# --- motions -----------------------------------------------------------------------------------------------------------
def _motions(outcome: Outcome[PlatformStudy]) -> TableFigure:
    s, order, pair = outcome.study.system, int(outcome.design["order"]), int(outcome.design["pair"]) - 1
    rows = []
    for k, motion in enumerate(s.motions):
        held = share(s, motion, order)
        word = text("yes") if held > 0.9 else text("no") if held < 0.1 else text("in part")
        mark = "▶\N{NO-BREAK SPACE}" if k == pair else ""
        rows.append((mark + sigmas(k), motion.name, format_number(motion.frequency, ".3g"), f"{100 * motion.damping:.2f}",
                     show(motion.strength), show(s.hankel[2 * k]), word))
    return TableFigure(
        "motions", text("five motions, ten states"),
        (text("pair"), text("motion"), same("Hz"), same("ζ %"), same("≈ σ"), same("σ"), text("held")),
        tuple(rows), tab=MOTION_TAB,
        caption=text("≈ σ: strength of the mode, ‖Cv‖ ‖wᴴB‖ / 2|Re λ|, from its eigenvectors alone."))


def _pair(outcome: Outcome[PlatformStudy]) -> PlaneFigure:
    """How far each part swings in the pair on the stage, in the plant and in the reduced model."""
    s, order = outcome.study.system, int(outcome.design["order"])
    pair = int(outcome.design["pair"]) - 1
    motion = s.motions[pair]
    plant, model = (np.abs(relative(s.parameters, v) / MAX_DRAWN_MOTION) for v in (motion.shape, believed(s, order, motion.shape)))
    bars = tuple(Curve(name, np.array([0.0, float(value)]), role, "solid", PART_BAR_WIDTH, np.full(2, k + side * PART_BAR_GAP))
                 for name, role, side, shares in ((text("plant"), "plant", -1, plant / plant.max()),
                                                  (text("reduced model"), "muted", 1, model / plant.max()))
                 for k, value in enumerate(shares))
    farthest = Curve(text("the farthest"), np.ones(3), "reference", "dot", 1.4, np.linspace(-0.6, len(PARTS) - 0.4, 3))
    return PlaneFigure("pair", text("what swings in the pair {sigmas}", sigmas=sigmas(pair)), (*bars, farthest), (), "",
                       text("share of the farthest"), (-0.6, len(PARTS) - 0.4), (0.0, 1.1), tab=MOTION_TAB,
                       names=tuple((float(k), name) for k, name in enumerate(PARTS)),
                       caption=text("The model with {order} states holds {held:.0f} % of this motion.", order=order,
                                    held=100 * share(s, motion, order)))


def _shapes(outcome: Outcome[PlatformStudy]) -> MatrixFigure:
    s = outcome.study.system
    shapes = np.stack([np.abs(relative(s.parameters, m.shape)) for m in s.motions], axis=1)
    shapes[2] *= s.parameters.s
    shapes = shapes / shapes.max(axis=0)
    pair = int(outcome.design["pair"]) - 1
    return MatrixFigure(
        "shapes", text("what moves in each pair"), shapes, ("x", "z", "s θ", "p_L", "p_R"),
        tuple(("▶ " if k == pair else "") + sigmas(k) for k in range(PAIRS)), (3,), tab=MOTION_TAB,
        caption=text("A column a pair, {sigmas} first: amplitudes, the largest 1; p_L and p_R as seen from their "
                     "sensors.",
                     sigmas=sigmas(0)))


# --- LQG ---------------------------------------------------------------------------------------------------------------
def _spectrum(outcome: Outcome[PlatformStudy]) -> LineFigure:
    c, f = outcome.study.compared, outcome.study.system.frequencies
    order = outcome.study.order
    curves = [Curve(text("without control"), 1e12 * c.free[:, 0], "muted", width=1.4)]
    if c.full.densities is not None:
        curves.append(Curve(text("LQG on 10 states"), 1e12 * c.full.densities[:, 0], "plant"))
    if c.small.densities is not None and order < STATE_COUNT:
        curves.append(Curve(text("LQG on {order}", order=order), 1e12 * c.small.densities[:, 0], "estimate", "dash"))
    said = (NOTHING_CUT if order == STATE_COUNT else
            text("The two loops differ by {gap} at most, in any output and at any frequency.", gap=apart(c.gap)) if c.gap is not None else
            text("The loop with {order} states is unstable on the platform: rightmost pole {rightmost}.",
                 order=order, rightmost=show(c.small.rightmost, 2)))
    return over_frequency("spectrum", text("velocity VL under ground noise"), f,
                          tuple(Curve(k.name, np.maximum(k.y, LOG_AXIS_FLOOR), k.role, k.dash, k.width) for k in curves),
                          "[(µm/s)²/Hz]", tab=LQG_TAB, window=(1e-6, 1e6), caption=said)


def _gains(outcome: Outcome[PlatformStudy]) -> PlaneFigure:
    c, order = outcome.study.compared, outcome.study.order
    index = np.arange(1.0, PAIRS + 1)
    curves, lowest = [], -10.0
    rows = ((c.full.K, text("K on 10 states"), "plant", -0.3),
            (c.small.K, text("K on {order}", order=order), "estimate", -0.1),
            (c.full.L, text("L on 10 states"), "second", 0.1),
            (c.small.L, text("L on {order}", order=order), "disturbance", 0.3))
    for K, name, role, offset in rows if order < STATE_COUNT else rows[::2]:
        some = K > 0
        x, y = bars(index[some] + offset, np.log10(np.maximum(K[some], 1e-10)), lowest, 0.09)
        curves.append(Curve(name, y, role, x=x, width=2.2))
    return PlaneFigure(
        "gains", text("gains on the k-th pair of balanced states"), tuple(curves), (), "k",
        "‖·‖", (0.4, PAIRS + 0.6), (lowest, 10.0), tab=LQG_TAB, powers="y",
        caption=NOTHING_CUT if order == STATE_COUNT else
        text("On 10 states ‖K‖ is {growth} than on {order}; the last pair's share of it is {k}.",
             growth=more(c.growth), order=order, k=show(float(c.full.K[-1] / np.linalg.norm(c.full.K)), 2)))


def _costs(outcome: Outcome[PlatformStudy]) -> TableFigure:
    c, order = outcome.study.compared, outcome.study.order

    def cell(value: float | None, digits: int = 5) -> str:
        return "—" if value is None else show(value, digits)

    rows = ((text("cost on the platform"), cell(c.full.cost), cell(c.small.cost)),
            (text("force, rms [N]"), cell(c.full.force), cell(c.small.force)),
            (text("rightmost pole [rad/s]"), cell(c.full.rightmost, 3), cell(c.small.rightmost, 3)))
    said = (NOTHING_CUT if order == STATE_COUNT else
            text("An unstable loop has no average cost.") if c.extra is None else
            claim(text("Leaving the states out costs nothing that one could measure."), c.extra, below=1e-7,
                  otherwise=text("With states left out the cost is {extra}.", extra=more(c.extra))))
    return TableFigure("costs", text("two designs on ten states"),
                       (text("design on"), text("10 states"), text("{order} states",
                                                                                                   order=order)),
                       rows, tab=LQG_TAB, caption=said)


PLATFORM_SETTING = Setting(
    studied, lambda s: swing(s.system, s.motion, s.order, s.columns, s.errors, s.rest),
    lambda s: {"K": s.compared.small.design.K, "L": s.compared.small.design.L},
    numbers, checks, formulas, live, _staircase, _further_tabs, lambda s: (_forms(s),), (_told(),), _sharper, LOG_AXIS_FLOOR, (1e-8, 1e4))
