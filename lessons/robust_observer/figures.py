"""Draw the figures of lesson 15 from an outcome."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, LineFigure, MapFigure, PlaneFigure, Point, TableFigure, over_frequency
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Design, Outcome
from observer_lab.engine.observers import Attempt, Existence
from observer_lab.text import Text, format_number, joined, same, text, text_in

from ..toolkit.latex import pole_words
from .assumptions import ASSUMED_TAB, assumed_figures
from .criterion import criterion_1, of_two, steering, steering_3
from .knobs import COLUMNS, EXAMPLE_FOUR, EXAMPLE_ONE, EXAMPLE_THREE, EXAMPLE_TWO, NORMS, REMARKS, SENSITIVITY_LINES
from .paper_slips import PRINTED_SIZES, claimed_columns, free_columns, remark_3, true_size
from .rank_conditions import ORDERS_TAB, missed, ranks
from .rectangle_map import pair_map
from .steady_figure import steady_figure
from .study import DISPLAY_LIMIT, EXAMPLE_CASES, FREQUENCIES, PAPER, Search, Story

TIME_TAB, J_TAB = text("Time"), text("Criterion J")
WORST_TAB, PAPER_TAB = text("Worst case"), text("Paper")
AXIS = np.linspace(-12.0, -0.05, 160)
KINKS = (-3.0, -5 / 3, -1.0)  # of J in example 1, where LC₁ or MC₁ is zero
POLE_GRID = np.linspace(-12.0, -0.2, 48)
NORM_WEIGHTS = np.linspace(0.0, 3.0, 31)
LARGE_N = 20.0
SIGNAL_LIMIT = 200.0  # signals beyond are drawn at the edge
SHOWN_INPUT, SHOWN_OVER_LATE = 10.0, 3.0  # the least end of the axis of inputs, and times the largest input of the second half
NO_VALUE = same("–")


def figures(outcome: Outcome[Story]) -> FigureSet:
    """Time, criterion, worst case, paper: at most three in a tab."""
    return FigureSet(tab_figures(TIME_TAB, lambda: (_error(outcome), _input(outcome), _output(outcome))),
                 tab_figures(J_TAB, lambda: (_criterion(outcome), _map_of(outcome), _found(outcome))),
                 tab_figures(WORST_TAB, lambda: (_frequency(outcome), _sweep(outcome), steady_figure(outcome, WORST_TAB))),
                 tab_figures(PAPER_TAB, lambda: (_numbers(outcome), ranks(PAPER, outcome, PAPER_TAB, _ranks_told), _slips(outcome))),
                 tab_figures(ORDERS_TAB, lambda: (missed(PAPER, outcome),)),
                 tab_figures(ASSUMED_TAB, lambda: assumed_figures(outcome.design)))


def _edge(values: np.ndarray) -> np.ndarray:
    return np.clip(values, -SIGNAL_LIMIT, SIGNAL_LIMIT)


def _error(outcome: Outcome[Story]) -> LineFigure:
    story, late = outcome.study, outcome.metrics["late_error"]
    steady = story.true.loop.steady()
    t, window = story.true.t, (-5.0, 5.0)
    same_plant = np.array_equal(story.true.e, story.model.e)
    caption = (text("Plant and model agree: e_u decays with the observer's poles, for every v.") if same_plant else
               text("With the true plant the loop is unstable, and e_u grows with it; on the model it decays.")
               if outcome.metrics["slowest_loop"] >= 0 else
               claim(text("With the true plant e_u settles to an amplitude of {steady:.2g}; on the model it decays.", steady=steady),
                     late, below=1.2 * steady + 1e-9, otherwise=text(
                         "With the true plant e_u tends to an amplitude of {steady:.2g}. At the end of this run the start still shows: "
                         "up to {late:.2g}.", steady=steady, late=late)))
    return LineFigure("e_u", text("error of the input, û − Kx in the paper's sign"), t,
                      (Curve(text("true plant"), _edge(story.true.e), "error"),
                       Curve(text("model"), _edge(story.model.e), "reference", "dash", 1.6)),
                      "e_u", window=window, caption=caption, tab=TIME_TAB)


def _input(outcome: Outcome[Story]) -> LineFigure:
    run = outcome.study.true
    given = run.u[:, 0]
    peak, late = float(np.max(np.abs(given))), float(np.max(np.abs(given[len(given) // 2:])))
    shown = round_up_nicely(max(SHOWN_OVER_LATE * late, SHOWN_INPUT))
    caption = text("v = −4 sin(5t + π/2). Largest input given: {peak:.3g}.", peak=min(peak, DISPLAY_LIMIT))
    return LineFigure("input", text("input wanted and given"), run.t,
                      (Curve(text("wanted, −Kx + v"), _edge(given - run.e), "plant"),
                       Curve(text("given"), _edge(given), "estimate", "dash"),
                       Curve(same("v"), run.v, "muted", "dot", 1.4)), "u", window=(-SHOWN_INPUT, SHOWN_INPUT),
                      caption=joined(caption, text("The start is outside the axis.")) if peak > shown else caption, tab=TIME_TAB,
                      most=(-shown, shown))


def _output(outcome: Outcome[Story]) -> LineFigure:
    story = outcome.study
    gap = min(float(np.max(np.abs(story.true.y - story.model.y))), DISPLAY_LIMIT)
    return LineFigure("output", text("measured output y"), story.true.t,
                      (Curve(text("true plant"), _edge(story.true.y[:, 0]), "plant"),
                       Curve(text("model"), _edge(story.model.y[:, 0]), "reference", "dash", 1.6)), "y",
                      window=(-0.5, 0.5), caption=text("The two differ by up to {gap:.2g}.", gap=gap),
                      tab=TIME_TAB)


# --- the criterion ---------------------------------------------------------------------------------------------------
def _poles(design: Design) -> tuple[complex, ...]:
    return design[EXAMPLE_CASES[design["example"]].poles]


def _criterion(outcome: Outcome[Story]) -> PlaneFigure:
    design, J = outcome.design, outcome.metrics["J"]
    poles, search = _poles(design), outcome.study.search
    axis = np.union1d(AXIS, [p.real for p in poles if AXIS[0] <= p.real <= AXIS[-1]])  # the circles stand on the curves
    if design["example"] == EXAMPLE_ONE:
        axis = np.union1d(axis, KINKS)
        known, seen, output = criterion_1(axis, design)
        curves = [Curve(same("J"), known + seen + output, "plant", width=2.4, x=axis),
                  Curve(same("2α|s|"), known, "muted", "dot", 1.4, axis),
                  Curve(same("β|s² + 4s + 3|"), seen, "second", "dash", 1.4, axis),
                  Curve(same("γ|50 + 30s|"), output, "force", "dash", 1.4, axis)]
        title = text("J over the observer pole s")
        words = text("J = {j:.4g} at s = {poles_real:.3g}. The kink of the green part is where M = 0: s = −5/3.",
                     j=J, poles_real=poles[0].real)
    elif poles[0].imag:
        curves = [Curve(same("J"),
                        of_two(axis + 1j * abs(poles[0].imag), axis - 1j * abs(poles[0].imag), design).sum(axis=0), "plant", x=axis)]
        title = text("J over Re s, Im s kept")
        words = text("J = {j:.4g} in the norm {design}.", j=J, design=_norm(design))
    else:
        curves = [Curve(text("s₂ kept"), of_two(axis, np.full_like(axis, poles[1].real), design).sum(axis=0),
                        "plant", x=axis),
                  Curve(text("s₁ kept"), of_two(np.full_like(axis, poles[0].real), axis, design).sum(axis=0),
                        "second", "dash", x=axis)]
        title = text("J while one pole moves")
        words = text("J = {j:.4g} in the norm {design}; J does not include N, which grows where the poles meet.",
                     j=J, design=_norm(design))
    if design["example"] == EXAMPLE_TWO:
        words = joined(words, text("Here W has w = {w:g}; another W gives the same observer another J.", w=design["w12"]))
    top = round_up_nicely(2.2 * max(J, 4.0) if design["example"] != EXAMPLE_ONE else max(float(curves[0].y.max()), 4.0))
    curves = [Curve(c.name, np.minimum(c.y, 1.5 * top), c.role, c.dash, c.width, c.x) for c in curves]
    for end in ("region_low", "region_high"):
        curves.append(Curve(text("region"), np.array([0.0, 1.5 * top]), "reference", "dot", 1.2,
                            np.full(2, design[end])))
    points = tuple(Point(max(p.real, AXIS[0]), min(J, top), "error", "circle") for p in poles)
    return PlaneFigure("criterion", title, tuple(curves), (*points, *_optimum(search, design, top)), "s [rad/s]", "J",
                       (-12.0, 0.0), (0.0, top), caption=joined(words, text("Dotted: the ends of the region.")), tab=J_TAB)


def _norm(design: Design) -> str:
    return "∞" if design["norm"] == "inf" else design["norm"]


def _optimum(search: Search | None, design: Design, top: float) -> tuple[Point, ...]:
    """Where RLO found the least J in the chosen norm."""
    for name, found in search.found if search is not None else ():
        if name == design["norm"]:
            turned = design["example"] == EXAMPLE_TWO and design["w12"]
            return tuple(Point(float(p.real), min(found.value, top), "force", "cross", text("RLO, W = I") if turned else same("RLO"))
                         for p in found.observer.poles)
    return ()


def _map_of(outcome: Outcome[Story]) -> MapFigure:
    return pair_map(outcome, J_TAB) if outcome.design["example"] == EXAMPLE_FOUR else _map(outcome)


def _map(outcome: Outcome[Story]) -> MapFigure:
    """Where J would be less than now: over (s, γ) in example 1, over (s₁, s₂) in example 2."""
    design, now = outcome.design, outcome.metrics["J"]
    poles = _poles(design)
    if design["example"] == EXAMPLE_ONE:
        unit = criterion_1(POLE_GRID, design.with_values(gamma=1.0))
        J = (unit[0] + unit[1])[None] + NORM_WEIGHTS[:, None] * unit[2][None]
        N = np.zeros(J.shape)  # N = −30 for every s
        x, y, labels, mark = POLE_GRID, NORM_WEIGHTS, ("s [rad/s]", "γ"), (poles[0].real, design["gamma"])
        title = text("J over s and γ, against J now")
    else:
        s1, s2 = np.meshgrid(POLE_GRID, POLE_GRID)
        J = of_two(s1, s2, design).sum(axis=0)
        N = steering(s1, s2) if design["example"] != EXAMPLE_THREE else steering_3(s1, s2, design["free"])
        x = y = POLE_GRID
        labels, mark = ("s₁ [rad/s]", "s₂ [rad/s]"), None if poles[0].imag else (poles[0].real, poles[1].real)
        title = text("J over s₁ and s₂, against J now")
    values = np.where(now * 2 < J, 2, np.where(now * (1 + 1e-9) < J, 1, 0))
    values = np.where(N > LARGE_N, 3, values)
    share = float(np.mean(values == 0))
    return MapFigure("map", title, x, y, values,
                     ((text("less than now"), "force"), (text("up to twice"), "second"),
                      (text("more than twice"), "muted"), (same("|N| > 20"), "error")),
                     *labels, marked=mark, tab=J_TAB,
                     caption=text("On {share:.3g} % of the map J would be no larger than {now:.3g}.",
                                  share=100 * share, now=now))


def _found(outcome: Outcome[Story]) -> TableFigure:
    """What algorithm RLO found in each norm, or that it has not run."""
    turned, carts = outcome.design["example"] == EXAMPLE_TWO, outcome.design["example"] == EXAMPLE_FOUR
    columns = (text("norm"), text("order"), text("poles"), text("least J (W = I)") if turned else text("least J"),
               text("orders tried"))
    search: Search | None = outcome.study.search
    rows: list[tuple[Text | str, ...]] = []
    for name in NORMS:
        found = next((f for key, f in search.found if key == name), None) if search is not None else None
        shown = "∞" if name == "inf" else name
        if found is None:
            rows.append((shown, NO_VALUE, NO_VALUE, NO_VALUE, NO_VALUE))
            continue
        tried = ", ".join(f"{a.order}{' ±' if a.pairs else ''}: {_tried(a, carts)}" for a in found.attempts)
        real = not np.any(found.observer.poles.imag)
        poles = pole_words(found.observer.poles) if not real else ", ".join(format_number(p.real, ".5g") for p in found.observer.poles)
        rows.append((shown, str(found.observer.order), poles, f"{found.value:.6g}", tried))
    caption = (text("Not run yet: press the button “Run algorithm RLO”.")
               if search is None or not search.found else
               text("✗ with the share of K that every observer of that order misses, whatever its poles in the region; then the order "
                    "is raised."))
    if carts:
        caption = joined(caption, text("Behind ±: a complex pair. One state exists only with its pole at −11; the left end a decides."))
    return TableFigure("found", text("algorithm RLO inside the region"), columns, tuple(rows),
                       caption=caption, tab=J_TAB)


def _tried(attempt: Attempt, with_J: bool) -> str:
    """What an order came to: the share of K that it misses, or that it exists."""
    return f"✗ {attempt.gap:.2g}" if not attempt.feasible else f"✓ J = {attempt.J:.3g}" if with_J else "✓"


# --- worst case ------------------------------------------------------------------------------------------------------
def _frequency(outcome: Outcome[Story]) -> LineFigure:
    story, peak = outcome.study, outcome.study.peak
    floor = 1e-6
    caption = (text("At some sign pattern of the δ the loop is unstable.") if peak >= DISPLAY_LIMIT else
               text("Worst of the eight sign patterns: {peak:.3g} times v.", peak=peak))
    return over_frequency("gain", text("from v to the error of the input"), FREQUENCIES,
                           (Curve(text("these δ"), np.maximum(story.now, floor), "error"),
                            Curve(text("worst signs"), np.maximum(story.worst, floor), "reference", "dash")),
                           "|e_u/v|", caption=caption, tab=WORST_TAB, window=(1e-2, 1.0))


def _sweep(outcome: Outcome[Story]) -> PlaneFigure:
    """The worst case along the axis, as far as the job has come; now is the dotted line."""
    design, search, now = outcome.design, outcome.study.search, outcome.study.peak
    top = round_up_nicely(1.6 * min(max(now, 1.0), 50.0))
    curves = [Curve(text("now"), np.full(2, min(now, top)), "error", "dot", 1.6, np.array([-12.0, 0.0]))]
    points: tuple[Point, ...] = ()
    caption = text("Run algorithm RLO to draw the worst case along the axis.")
    if search is not None and len(search.s):
        curves.append(Curve(text("worst of eight"), np.minimum(search.worst, 1.5 * top), "plant", x=search.s))
        k = int(np.argmin(search.worst))
        points = (Point(float(search.s[k]), min(float(search.worst[k]), top), "force", "circle"),)
        found = {"worst": search.worst[k], "s": search.s[k]}
        caption = (text("Least worst case so far: {worst:.3g} at s = {s:.3g}; J is least elsewhere.", **found)
                   if design["example"] == EXAMPLE_ONE else
                   text("Least worst case so far: {worst:.3g} at s = {s:.3g} (poles s and s − 1).", **found))
    return PlaneFigure("sweep", text("largest |e_u/v| over the eight sign patterns"),
                       tuple(curves), points, "s [rad/s]", "max |e_u/v|", (-12.0, 0.0), (0.0, top), caption=caption,
                       tab=WORST_TAB)


# --- the paper -------------------------------------------------------------------------------------------------------
def _row(M: np.ndarray) -> str:
    return "; ".join(" ".join(format_number(v, ".4g") if abs(v) > 1e-12 else "0" for v in row) for row in M).replace("-", "−")


def _numbers(outcome: Outcome[Story]) -> TableFigure:
    """Ours in both signs."""
    rows = [(name, _row(outcome.gains[name]), _row(outcome.gains[name] * (-1 if name in "KNM" else 1)))
            for name in ("F", "T", "L", "N", "M", "K")]
    named = f"J (w = {outcome.design['w12']:g})" if outcome.design["example"] == EXAMPLE_TWO else "J"
    rows += [(named, f"{outcome.metrics['J']:.6g}", f"{outcome.metrics['J']:.6g}"),
             ("Σ‖·‖∞", f"{outcome.metrics['error_index']:.6g}", f"{outcome.metrics['error_index']:.6g}")]
    return TableFigure("numbers", text("the observer in both signs"),
                       (text("matrix"), text("here, u = −K x̂"),
                        text("paper, u = +K x̂")), tuple(rows), tab=PAPER_TAB,
                       caption=text("F, T and L do not change; K, N and M do. The last row is an index that includes N and not W."))


def _ranks_told(design: Design, rung: Existence) -> Text:
    if design["example"] == EXAMPLE_THREE:
        return text("T itself is T₀ and Q = I in (12): N = (K − M′C)T⁻¹ for every M′, and M = M′. Three rows of rank 2 leave one column.")
    return claim(text("The {rows} rows of [T; C] have rank {rank}, and with K no more: N and M exist and are fixed.",
                      rows=rung.rows, rank=rung.rank), float(rung.missed), below=1e-9)


def _share(value: float | None) -> Text | str:
    if value is None:
        return text("does not fit")
    return "0" if value < 1e-12 else format_number(value, ".2g")


def _slips(outcome: Outcome[Story]) -> TableFigure:
    """The chosen readings beside what the engine finds."""
    d = outcome.design
    gaps, printed, true = remark_3(d["remark"]), PRINTED_SIZES[d["line"]], true_size(d["line"])
    claimed = claimed_columns(d["columns"])
    rows: tuple[tuple[Text | str, ...], ...] = (
        (text("remark 3: (2b) missed by"), REMARKS[d["remark"]], _share(gaps.dynamics)),
        (text("remark 3: (2c) missed by"), REMARKS[d["remark"]], _share(gaps.output)),
        (text("{lines}: size", lines=SENSITIVITY_LINES[d["line"]]), f"{printed[0]}×{printed[1]}", f"{true[0]}×{true[1]}"),
        (text("M′: columns"), f"{COLUMNS[d['columns']]} = {claimed}", str(free_columns())),
    )
    wrong = (not gaps.met) + (printed != true) + (claimed != free_columns())
    return TableFigure("slips", text("lines of the paper against the engine"),
                       (text_in("robust-observer", "line"), text("as read"), text("engine")), rows, tab=PAPER_TAB,
                       caption=text("Example 2, s = −4, −3. Readings that disagree: {wrong} of 3.", wrong=wrong))
