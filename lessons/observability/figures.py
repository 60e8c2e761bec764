"""Draw the figures of lesson 3: O and its rank, rebuilt x(0), ellipse, distances, criteria."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, Figure, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.lesson import Outcome
from observer_lab.engine.structure import Mode
from observer_lab.text import format_number, same, text

from ..toolkit.latex import pole_words
from .cases import label, shown, unit
from .criteria import DET
from .initial_state import SIGMAS_FOR_95_PERCENT, starts_figures
from .knob_sweep import LOWEST, Sweep, decades
from .study import NEARLY_HIDDEN_DISTANCE, Study

MATRIX_TAB, CLOUD_TAB, MODES_TAB = text("Matrix"), text("Ellipsoid"), text("Modes")
CIRCLE_ANGLES_RAD = np.linspace(0.0, 2 * np.pi, 73)
SINGULAR_VALUE_RTOL = 10 * float(np.finfo(float).eps)  # times n and the largest: a smaller singular value has no right digit
HIDDEN = -10.0  # decades: distances at or below are rounding
SHARES = (0.0, 0.04, 0.15, 0.4, 1.0)  # of the run: when the ellipse is drawn
MAX_TABLE_STATES = 8  # rows of the table of states
YES, NO, NO_ANSWER = text("yes"), text("no"), text("says nothing")


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Everything on the right of the stage."""
    found, design = outcome.study, outcome.design
    return (*starts_figures(found.case, found.sensed, found.twins, design["noise"]),
            _matrix(found), _sizes(found, design["tolerance"]), _start(found),
            _ellipses(found), _halves(found), _energy(found),
            _modes(found), *(() if found.sweep is None else (_sweep(found.sweep, found),)), _criteria(found, design["criterion"]))


def _matrix(found: Study) -> MatrixFigure:
    built, plant = found.rebuilt, found.sensed.plant
    names = tuple(("C" if k == 0 else "CA" if k == 1 else f"CA^{k}") for k in range(built.rows) for _ in range(plant.p))
    return MatrixFigure(
        "matrix", text("observability matrix, row by row"), built.matrix, names,
        tuple(label(found.case, i) for i in range(plant.n)), tab=MATRIX_TAB,
        caption=text("{rows} of {n} block rows built: rank {rank} of {n} at this tolerance.",
                     rows=built.rows, n=plant.n, rank=built.rank))


def _sizes(found: Study, rtol: float) -> PlaneFigure:
    built, n = found.rebuilt, found.sensed.plant.n
    top = built.sizes[0] if built.sizes[0] > 0 else 1.0
    levels = decades(built.sizes / top)
    points = tuple(Point(k + 1.0, float(d), "plant" if k < built.rank else "muted", "dot" if k < built.rank else "cross")
                   for k, d in enumerate(levels))
    line = Curve(text("tolerance τ"), np.full(2, np.log10(rtol)), "reference", "dash", 1.6, np.array([0.5, n + 0.5]))
    lost = len(levels) - built.rank
    told = claim(text("{lost} of {count} count as zero; the smallest is {levels:.1g} times the largest.",
                      lost=lost, count=len(levels), levels=10 ** levels[-1]), float(10 ** levels[-1]), above=SINGULAR_VALUE_RTOL * n,
                 otherwise=text("{lost} of {count} count as zero; the smallest is lost in rounding.", lost=lost, count=len(levels)))
    caption = told if built.sizes[0] > 0 else text("No sensor is on: O is zero.")
    return PlaneFigure(
        "sizes", text("singular values of O, σ/σ₁"), (line,), points, "k", "σ/σ₁",
        (0.5, n + 0.5), (LOWEST - 0.5, 0.5), tab=MATRIX_TAB, caption=caption, powers="y")


def _value(value: float) -> str:
    return format_number(value, ".4g")


def _start(found: Study) -> TableFigure:
    case, built, n = found.case, found.rebuilt, found.sensed.plant.n
    every = tuple(range(n))
    true, guess = shown(case, found.start, every), shown(case, built.guess, every)
    table = tuple((unit(case, i), _value(true[i]), _value(guess[i]),
                   text("fixed") if built.share[i] > 1 - 1e-6 else
                   text("not yet") if built.share[i] < 1e-6 else text("partly"))
                  for i in every[:MAX_TABLE_STATES])
    gap = float(np.linalg.norm(built.guess - found.start) / np.linalg.norm(found.start))
    left = n - built.rank
    return TableFigure(
        "start", text("x(0) from y and its derivatives"),
        (text("state"), text("true"), text("rebuilt"), text("by these rows")), table,
        tab=MATRIX_TAB,
        caption=text("Directions of x(0) still open: {left}. The rebuilt start is off by {gap:.2g} of its size.",
                     left=left, gap=gap))


def _ellipses(found: Study) -> PlaneFigure:
    case, s, belief = found.case, found.sensed, found.belief
    pair = case.pair
    curves, last = [], len(s.t) - 1
    for share in SHARES:
        k = round(share * last)
        values, axes = np.linalg.eigh(belief.P[k][np.ix_(pair, pair)])
        ring = (
            SIGMAS_FOR_95_PERCENT[1]
            * (axes * np.sqrt(np.maximum(values, 0.0)))
            @ np.array([np.cos(CIRCLE_ANGLES_RAD), np.sin(CIRCLE_ANGLES_RAD)])
        )
        drawn = shown(case, ring.T + belief.mean[k, list(pair)], pair)
        final = share == SHARES[-1]
        curves.append(Curve(same(f"t = {s.t[k]:.2g} s"), drawn[:, 1], "estimate" if final else "second",
                            "solid" if final else "dash" if share else "dot", 2.6 if final else 1.6, drawn[:, 0]))
    half = shown(case, np.full(2, 3.4), pair)
    true = shown(case, found.start[list(pair)], pair)
    drop = belief.halves[-1]
    return PlaneFigure(
        "ellipses", text("states that the data allow (95 %)"), tuple(curves),
        (Point(float(true[0]), float(true[1]), "plant", "cross", text("true x(0)")),),
        unit(case, pair[0]), unit(case, pair[1]), (-float(half[0]), float(half[0])), (-float(half[1]), float(half[1])),
        tab=CLOUD_TAB,
        caption=text("After {t:.2g} s the longest half axis of the whole ellipsoid is {drop:.2g} of its start, "
                     "the shortest {drop2:.2g}.",
                     t=s.t[-1], drop=drop[0], drop2=drop[-1]))


def _halves(found: Study) -> LineFigure:
    s, halves = found.sensed, found.belief.halves
    n = s.plant.n
    kept = np.unique(np.linspace(0, n - 1, min(n, 6)).round().astype(int))
    roles = ("estimate", "error", "disturbance", "force", "second", "plant")
    curves = tuple(Curve(text("axis {i}", i=i + 1), halves[:, i], role)
                   for i, role in zip(kept, roles, strict=False))
    return LineFigure(
        "halves", text("half axes of the ellipsoid, start = 1"), s.t, curves,
        "σ(t) / σ(0)", log_y=True, window=(1e-3, 1.0),
        tab=CLOUD_TAB,
        caption=text("Shrunk to a tenth: {known} of {n} axes. The readings say nothing about an axis that stays at 1.",
                     known=found.belief.known, n=n))


def _energy(found: Study) -> LineFigure:
    s = found.sensed
    least, most = s.heard[:, 0], s.heard[:, -1]
    return LineFigure(
        "energy", text("eigenvalues of the Gramian W(t)"), s.t,
        (Curve(text("largest"), most, "plant"), Curve(text("smallest"), least, "error", "dash")), "λ(W)",
        log_y=True, window=(1e-6, 1.0), tab=CLOUD_TAB,
        caption=text("At the end: largest {most:.2g}, smallest {least:.1g}. W(t) > 0 is what “y determines x(0)” means.",
                     most=most[-1], least=least[-1]) if least[-1] > s.dust else
        text("At the end: largest {most:.2g}, smallest below rounding. W(t) > 0 is what “y determines x(0)” means.",
             most=most[-1]))


def _bar(mode: Mode) -> str:
    return format_number(mode.distance, ".2g") + " " + "▮" * max(1, round(6 + 1.5 * np.log10(max(mode.distance, 1e-9))))


def _modes(found: Study) -> TableFigure:
    table, counts = [], {"hidden": 0, "near": 0}
    for mode in found.sensed.seen.modes:
        if mode.pole.imag < -1e-9:
            continue
        word = (text("hidden") if not mode.visible else text("nearly hidden") if mode.distance < NEARLY_HIDDEN_DISTANCE
                else text("seen"))
        counts["hidden"] += not mode.visible
        counts["near"] += mode.visible and mode.distance < NEARLY_HIDDEN_DISTANCE
        table.append((pole_words([complex(mode.pole.real, abs(mode.pole.imag))]),
                      _bar(mode) if mode.visible else "0", word))
    n = found.sensed.plant.n
    return TableFigure(
        "modes", text("distance of each mode from being hidden (PBH, typical sizes)"),
        (text("mode"), text("distance"), text("verdict")), tuple(table), tab=MODES_TAB,
        caption=text("Modes hidden: {hidden}, nearly hidden: {near}; meanwhile rank(O) = {rank} of {n}.",
                     hidden=counts["hidden"], near=counts["near"], rank=found.rank, n=n))


def _sweep(sweep: Sweep, found: Study) -> PlaneFigure:
    now = float(decades(np.array([found.weakest.distance]))[0])
    best = float(sweep.along[np.argmax(sweep.distance)])
    name, _, unit = sweep.label.rstrip("]").partition(" [")
    number = format_number(10**best, ".2g") if sweep.log else format_number(best, ".3g")
    words = f"{name} = {number}{unit if unit == '°' else ' ' + unit if unit else ''}"
    return PlaneFigure(
        "sweep", text("one knob moved, all else kept"),
        (Curve(text("weakest mode"), sweep.distance, "plant", "solid", 2.4, sweep.along),
         Curve(same("σ_min/σ_max(O)"), sweep.ratio, "second", "dash", 1.8, sweep.along)),
        (Point(sweep.at, now, "reference", "circle", text("now")),), sweep.label, text("distance, ratio"),
        (float(sweep.along.min()), float(sweep.along.max())), (LOWEST - 0.5, 1.0), tab=MODES_TAB, powers="xy" if sweep.log else "y",
        caption=text("The weakest mode is farthest from hidden at {words}. Both curves count time in "
                     "seconds; in another unit of time they are others.",
                     words=words)
        if np.max(sweep.distance) > HIDDEN else
        text("Some mode stays hidden wherever this knob stands."))


def _criteria(found: Study, chosen: str) -> TableFigure:
    table = tuple((text("▶ {sentence}", sentence=c.text) if c.id == chosen else c.text,
                   c.number, NO_ANSWER if c.says is None else YES if c.says else NO) for c in found.criteria)
    pick = next(c for c in found.criteria if c.id == chosen)
    plant = found.sensed.plant
    caption = (text("C e^(At) is {number} here and has a determinant; a plant may be observable although it is zero.", number=pick.number)
               if pick.id == DET and plant.p == plant.n else
               text("C e^(At) is {number}: it has no determinant, whatever the plant.", number=pick.number) if pick.id == DET else
               text("{number} is below rounding: in double precision it cannot be decided.",
                    number=pick.number) if pick.says is None else
               text("The chosen sentence rests on {number} and says {says}.",
                    number=pick.number, says=text("yes") if pick.says else text("no")))
    return TableFigure("criteria", text("four sentences on trial"),
                       (text("observable if"), text("number"), text("says")), table,
                       tab=MODES_TAB, caption=caption)
