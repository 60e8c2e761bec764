"""Draw the figures of lesson 12: ranks, Hankel values, error, modes, two regulators."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure, over_frequency
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Design, Outcome
from observer_lab.text import format_number, joined, same, subscript, text, text_in

from ..toolkit.shares import apart, more
from .balanced_platform import STATE_COUNT, believed, closed_forms, relative, sigmas
from .body import MAX_DRAWN_MOTION, PARTS, share
from .reduced_regulator import PAIRS
from .study import RELATIVE, REPORT, Ranks, Study

RANK_TAB, HANKEL_TAB = text("Rank"), text("Hankel values")
MOTION_TAB, LQG_TAB = text("Motions"), same("LQG")
NOTHING_CUT = text("All ten states are kept: there is only one design. Keep fewer and compare.")
PAIR_NAMES = text("height"), text("across"), text("tilt"), text("masses together"), text("masses apart")  # of the kinds of motion
PART_BAR_WIDTH, PART_BAR_GAP = 20.0, 0.19  # px; places from the middle of a part
BAR_WIDTH, ABOVE_BARS = 17.0, 0.8  # px; decades from a bar to the circle above it
LEAST = 1e-40  # a singular value drawn in place of zero
LOG_AXIS_FLOOR = 1e-11  # drawn in place of zero on a logarithmic axis
TOLERANCES = np.linspace(-18.0, 0.0, 145)  # log₁₀


def figures(outcome: Outcome[Study]) -> FigureSet:
    """Everything on the right of the stage."""
    return FigureSet(
        tab_figures(RANK_TAB, lambda: (sizes(outcome.design, outcome.study.ranks), _ranks(outcome))),
        tab_figures(HANKEL_TAB, lambda: (_staircase(outcome), _error(outcome), _forms(outcome))),
        tab_figures(MOTION_TAB, lambda: (_pair(outcome), _motions(outcome), _shapes(outcome))),
        tab_figures(LQG_TAB, lambda: (_spectrum(outcome), _gains(outcome))),
        tab_figures(LQG_TAB, lambda: (_costs(outcome),), "late"),
    )


def show(value: float, digits: int = 3) -> str:
    """A number for a table, with a true minus sign and powers of ten."""
    return format_number(value, f".{digits}g")


# --- rank --------------------------------------------------------------------------------------------------------------
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


def _ranks(outcome: Outcome[Study]) -> PlaneFigure:
    first, last = np.log10(REPORT)
    told = Curve(text("the report's range"), np.array([0.0, 10.5, 10.5, 0.0]), "muted", "dot", 1.6, np.array([first, first, last, last]))
    return ranks_over_tolerance(outcome.design, outcome.study.ranks, (told,))


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


# --- Hankel ------------------------------------------------------------------------------------------------------------
def bars(positions: np.ndarray, levels: np.ndarray, floor: float, half: float) -> tuple[np.ndarray, np.ndarray]:
    """One line that goes up and down around every bar."""
    x = (positions[:, None] + half * np.array([-1.0, -1.0, 1.0, 1.0])).ravel()
    y = np.stack([np.full(len(levels), floor), levels, levels, np.full(len(levels), floor)], axis=1).ravel()
    return x, y


def _staircase(outcome: Outcome[Study]) -> PlaneFigure:
    s, order = outcome.study.system, int(outcome.design["order"])
    values, floor = np.log10(np.maximum(s.hankel, 1e-12)), -10.0
    curves = tuple(Curve(text("kept") if k < order else text("cut"), np.array([floor, max(value, floor)]),
                         "plant" if k < order else "muted", "solid", BAR_WIDTH, np.full(2, k + 1.0)) for k, value in enumerate(values))
    pair = int(outcome.design["pair"]) - 1
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


def _error(outcome: Outcome[Study]) -> LineFigure:
    c, s = outcome.study.cut, outcome.study.system
    bound = max(c.bound, LOG_AXIS_FLOOR)
    said = (text("Nothing is cut: no error.") if c.order == STATE_COUNT else
            joined(text("Largest error {peak} at {where} Hz. The bound 2Σσ over all values cut is {bound}.",
                        peak=show(c.peak, 4), where=show(c.where, 3), bound=show(c.bound, 4)),
                   text("The cut runs between two equal values, where equal values may not be counted once.") if c.sharp is None else
                   text("With equal values counted once it is {sharp}.", sharp=show(c.sharp, 4))))
    size = np.sqrt(np.linalg.eigvalsh(s.response @ np.swapaxes(s.response.conj(), 1, 2))[:, -1])
    return over_frequency(
        "error", text("what the model leaves out: σ_max(G − G_r)"),
        s.frequencies,
        (Curve(text("whole plant"), size, "muted", width=1.4),
         Curve(text("error"), np.maximum(c.error, LOG_AXIS_FLOOR), "error"),
         Curve(text("bound 2Σσ"), np.full(len(s.frequencies), bound), "reference", "dash", 1.6)),
        "σ_max", tab=HANKEL_TAB, window=(1e-8, 1e4), caption=said)


def _forms(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study.system
    rows = tuple((subscript(f"σ{2 * s.pair(kind) + 1}"), words, show(s.hankel[2 * s.pair(kind)], 4), show(value, 4))
                 for (kind, value), words in zip(closed_forms(s.parameters, s.unit), (
                     "√2 Nz/(4 cz)", "√2 Nz μ²/(m² cp)", "√2 Nθ μ² s² √(s²+h²)/(J² cp)"), strict=True))
    return TableFigure(
        "forms", text("three values from the geometry"),
        (same("σ"), text_in("weak-states", "closed form"), text("exact"), text("form")), rows, tab=HANKEL_TAB,
        caption=text("Nz and Nθ: what one unit of every input lifts and turns. The stiffness kp of the servo is in none of them."))


# --- motions -----------------------------------------------------------------------------------------------------------
def _motions(outcome: Outcome[Study]) -> TableFigure:
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


def _pair(outcome: Outcome[Study]) -> PlaneFigure:
    """How far each part swings in the pair on the stage, in the plant and in the reduced model."""
    s, order = outcome.study.system, int(outcome.design["order"])
    pair = int(outcome.design["pair"]) - 1
    motion = s.motions[pair]
    plant, model = (np.abs(relative(s.parameters, v) / MAX_DRAWN_MOTION) for v in (motion.shape, believed(s, order, motion.shape)))
    bars = tuple(Curve(name, np.array([0.0, float(value)]), role, "solid", PART_BAR_WIDTH, np.full(2, k + side * PART_BAR_GAP))
                 for name, role, side, shares in ((text("plant"), "plant", -1, plant / plant.max()),
                                                  (text("reduced model"), "estimate", 1, model / plant.max()))
                 for k, value in enumerate(shares))
    farthest = Curve(text("the farthest"), np.ones(3), "reference", "dot", 1.4, np.linspace(-0.6, len(PARTS) - 0.4, 3))
    return PlaneFigure("pair", text("what swings in the pair {sigmas}", sigmas=sigmas(pair)), (*bars, farthest), (), "",
                       text("share of the farthest"), (-0.6, len(PARTS) - 0.4), (0.0, 1.1), tab=MOTION_TAB,
                       names=tuple((float(k), name) for k, name in enumerate(PARTS)),
                       caption=text("The model with {order} states holds {held:.0f} % of this motion.", order=order,
                                    held=100 * share(s, motion, order)))


def _shapes(outcome: Outcome[Study]) -> MatrixFigure:
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
def _spectrum(outcome: Outcome[Study]) -> LineFigure:
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


def _gains(outcome: Outcome[Study]) -> PlaneFigure:
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


def _costs(outcome: Outcome[Study]) -> TableFigure:
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
