"""Draw the figures of lesson 5: the run, dual quantities side by side, ellipses."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.optimize import linear_sum_assignment

from observer_lab.course.figures.diagram import DIAGRAM
from observer_lab.course.figures.ranges import round_up_nicely
from observer_lab.course.figures.records import Curve, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Design, Outcome
from observer_lab.engine import Plant
from observer_lab.text import NO_WORDS, Text, format_number, joined, same, symbol, text

from ..toolkit.diagram import loop
from ..toolkit.figures import ERROR_TAB, TIME_TAB, error_figure, input_figure, state_figures
from ..toolkit.latex import pole_words
from .dual_quantities import Setting, Twins, weights_of
from .finite_horizon import HORIZON_TAB, horizon_figure

DUAL_TAB, ELLIPSES_TAB, TURNED_TAB = text("Dual quantities"), text("Ellipses"), text("Transposed matrix")
DIAGONAL, ABOVE, BELOW = range(3)  # categories of the entries of a matrix
MOST_ROWS, MOST_ENTRIES, MOST_TURNED = 12, 6, 4  # of a table, places of a figure of bars, states of a matrix beside its transpose
BAR_PX, BAR_SHIFT = 17.0, 0.16  # px across a bar; places from the middle of two bars to each
CIRCLE_ANGLES_RAD = np.linspace(0.0, 2 * np.pi, 121)
LOCUS_TAB = text("Root locus")
LOW, HIGH = 1e-6, 1e6  # the ratios of the weights
SAMPLES, FEWEST = 1200, 97  # samples of the locus times states, so that its corners are sharp; and at least


def figures(here: Setting, outcome: Outcome[Twins]) -> FigureSet:
    """The run; gains, Riccati solutions and the pairing beside their twins; both ellipses."""
    run, twins, design = outcome.run, outcome.study, outcome.design
    assert run is not None
    return FigureSet(
        tab_figures(TIME_TAB, lambda: state_figures(here.model, run, 2)),
        tab_figures(ERROR_TAB, lambda: (error_figure(run), input_figure(run, here.model))),
        tab_figures(DUAL_TAB, lambda: (_gain_table(outcome, twins), _riccati_bars(here, outcome, twins),
                                 _pairing(twins, twins.pairing_gap))),
        tab_figures(TURNED_TAB, lambda: (_turned(here, twins),)),
        tab_figures(LOCUS_TAB, lambda: locus_figures(here, design)),
        tab_figures(HORIZON_TAB, lambda: (_horizon(here, design, twins),)),
        tab_figures(ELLIPSES_TAB, lambda: (*_ellipses(here, design["window"], twins, twins.mirror_gap), _mirrored(here, twins))),
        tab_figures(DIAGRAM, lambda: (loop(here.model.plant, run, outcome.gains["L"], outcome.gains["K"]),)))


def _entry(value: float) -> str:
    return format_number(value, ".6g")


def _gain_table(outcome: Outcome[Twins], twins: Twins) -> TableFigure:
    wide = twins.L.shape[1] > 1
    names = (symbol(f"L{i + 1}{j + 1}" if wide else f"L{i + 1}") for i, j in np.ndindex(twins.L.shape))
    rows = tuple((name, _entry(float(a)), _entry(float(b)), format_number(abs(a - b), ".0e")) for name, a, b in zip(
        names, twins.L.ravel(), twins.K_dual.T.ravel(), strict=True))[:MOST_ROWS]
    left, right = (pole_words(outcome.poles[side].tolist()) for side in ("controller", "observer"))
    return TableFigure(
        "gains", text("one gain, found twice"),
        (same(""), text("L, own equation"), text("K_dᵀ of (Aᵀ, Cᵀ)"),
         text("difference")), rows, tab=DUAL_TAB,
        caption=text("Left board: {left}. Right board: {right}.", left=left, right=right))


def _turned(here: Setting, twins: Twins) -> MatrixFigure:
    """A − LC beside the loop matrix of the transposed plant: what lies above the diagonal of one lies below that of the other."""
    A, C = twins.plant.A, twins.plant.C
    at = np.arange(min(len(A), MOST_TURNED))
    own, twin = (A - twins.L @ C)[np.ix_(at, at)], (A.T - C.T @ twins.K_dual)[np.ix_(at, at)]
    places = at[None, :] - at[:, None]
    kinds = np.select([places == 0, places > 0], [DIAGONAL, ABOVE], BELOW)
    middle = (len(at) - 1) // 2
    heads = [same(words if k == middle else "") for words in ("A − LC", "Aᵀ − CᵀK_d") for k in at]
    return MatrixFigure(
        "turned", text("a matrix and its transpose"), np.hstack([own, twin]), tuple(same(str(k + 1)) for k in at), tuple(heads), (len(at),),
        text("The second matrix is the first one, mirrored in its diagonal, to {gap:.0e}.", gap=float(np.abs(own - twin.T).max())),
        TURNED_TAB, ((text("on the diagonal"), "muted"), (text("above it in A − LC"), "estimate"), (text("below it in A − LC"), "second")),
        np.hstack([kinds, kinds.T]))


def _riccati_bars(here: Setting, outcome: Outcome[Twins], twins: Twins) -> PlaneFigure:
    """The entries of P beside those of S of the transposed plant, two bars each."""
    places = [(i, j) for i, j in np.ndindex(twins.P.shape) if i <= j][:MOST_ENTRIES]
    both = (text("P of LQE (W, V)"), twins.P, "estimate", -BAR_SHIFT), (text("S of LQR on (Aᵀ, Cᵀ)"), twins.S_dual, "plant", BAR_SHIFT)
    curves = tuple(Curve(name, np.array([0.0, float(M[at])]), role, "solid", BAR_PX, np.full(2, k + shift))
                   for name, M, role, shift in both for k, at in enumerate(places))
    ends = [float(curve.y[1]) for curve in curves]
    tops = tuple(Point(float(k), float(twins.P[at]), "reference", "dot", same(format_number(twins.P[at], ".3g")))
                 for k, at in enumerate(places))
    low, high = (sign * round_up_nicely(1.15 * max(sign * each for each in ends)) if max(sign * each for each in ends) > 0 else 0.0
                 for sign in (-1, 1))
    Q, R, W, V = weights_of(here, outcome.design)
    slow = twins.slowest
    return PlaneFigure(
        "riccati", text("one Riccati equation, read twice"), curves, tops, "", text("entry of the solution"), (-0.6, len(places) - 0.4),
        (low, high if high > low else low + 1.0), tab=DUAL_TAB,
        names=tuple((float(k), same(symbol(f"P{i + 1}{j + 1}"))) for k, (i, j) in enumerate(places)),
        caption=text("Largest difference: {gap:.0e}. Q₁₁ = {q:.3g}, R₁₁ = {r:.3g}: slowest LQR pole at Re s = {slow}. W₁₁ = {w:.3g}, "
                     "V₁₁ = {v:.3g}: slowest LQE pole at Re s = {slow2}.", gap=float(np.abs(twins.P - twins.S_dual).max()),
                     q=Q[0, 0], r=R[0, 0], slow=_entry(slow[0]), w=W[0, 0], v=V[0, 0], slow2=_entry(slow[1])))


def _pairing(twins: Twins, relative: float) -> LineFigure:
    value = format_number(twins.pairing[0], ".4g")
    return LineFigure(
        "pairing", text("observer forward, dual backward"), twins.pair.t,
        (Curve(same("‖e(t)‖"), np.linalg.norm(twins.pair.e, axis=1), "error"),
         Curve(same("‖x_d(T − t)‖"), np.linalg.norm(twins.pair.z, axis=1), "second", "dash"),
         Curve(same("x_d(T − t)ᵀ e(t)"), twins.pairing, "muted", "solid", 2.6)),
        "‖e‖, ‖x_d‖, x_dᵀe", window=(-0.5, 1.5), tab=DUAL_TAB,
        caption=text("The product stays at {value} to {relative:.0e} of the size of its factors.",
                     value=value, relative=relative))


def _horizon(here: Setting, design: Design, twins: Twins) -> LineFigure:
    """In weights: the gain of placed poles solves no Riccati equation."""
    R = weights_of(here, design)[1]
    return horizon_figure(twins.horizon, twins.S, twins.P, np.linalg.solve(R, here.plant(design).B.T @ twins.S), design["terminal"])


def _ellipse(W: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
    """x and y of W^{1/2} times the unit circle, and the half axes, long and short."""
    values, axes = np.linalg.eigh(W)
    half = np.sqrt(np.maximum(values, 0.0))
    x, y = (axes * half) @ np.array([np.cos(CIRCLE_ANGLES_RAD), np.sin(CIRCLE_ANGLES_RAD)])
    return x, y, float(half[-1]), float(half[0])


def _plane(name: str, title: Text, caption: Text, own: np.ndarray, twin: np.ndarray, legend: tuple[Text, Text],
           half: float, axes: tuple[Text | str, Text | str]) -> PlaneFigure:
    (x, y, *_), (xt, yt, *_) = _ellipse(own), _ellipse(twin)
    return PlaneFigure(
        name, title, (Curve(legend[0], y, "plant", "solid", 3.4, x), Curve(legend[1], yt, "estimate", "dash", 1.8, xt)),
        (), *axes, (-half, half), (-half, half), equal=True, tab=ELLIPSES_TAB, caption=caption)


def _ellipses(here: Setting, window: float, twins: Twins, mirror: float) -> tuple[PlaneFigure, PlaneFigure]:
    at, energies = np.ix_(here.pair, here.pair), twins.energies
    reach, seen = _ellipse(energies.reach[at]), _ellipse(energies.seen[at])
    half = 1.15 * round_up_nicely(max(reach[2], seen[2]))
    mirrored = (text("It is the mirror image of the upper one.") if mirror < 1e-6 else NO_WORDS)
    return (
        _plane("reach", text("states reached with unit energy"),
               text("Within {window:.3g} s: {reach:.3g} along the easy direction, {reach2:.3g} along the hard one.",
                    window=window, reach=reach[2], reach2=reach[3]),
               energies.reach[at], energies.reach_twin[at],
               (text("reached by (A, B)"), text("seen by (Aᵀ, Bᵀ)")), half, here.axes),
        _plane("seen", text("output energy of an initial state"),
               joined(text("A unit start leaves an output of norm {long:.3g} along the long axis and {short:.3g} along "
                           "the short one, within {window:.3g} s.", long=seen[2], short=seen[3], window=window), mirrored),
               energies.seen[at], energies.seen_twin[at],
               (text("seen by (A, C)"), text("reached by (Aᵀ, Cᵀ)")), half, here.axes),
    )


def _mirrored(here: Setting, twins: Twins) -> PlaneFigure:
    """The states that are reached and the output energy of a start in one plane; of the first the mirror image, where it has one."""
    at = np.ix_(here.pair, here.pair)
    reach, seen = _ellipse(twins.energies.reach[at]), _ellipse(twins.energies.seen[at])
    half = 1.15 * round_up_nicely(max(reach[2], seen[2]))
    curves = [Curve(text("states reached"), reach[1], "plant", "solid", 3.0, reach[0]),
              Curve(text("output energy"), seen[1], "estimate", "solid", 3.0, seen[0])]
    said = text("Half axes, long: {reach:.3g} of the states reached, {seen:.3g} of the output energy.", reach=reach[2], seen=seen[2])
    if here.mirror:
        curves.append(Curve(text("mirror image"), -reach[1], "reference", "dot", 2.0, reach[0]))
        said = text("The two differ from mirror images by {gap:.2g} %.", gap=100 * twins.mirror_gap)
    return PlaneFigure("mirrored", text("states reached and output energy"), tuple(curves), (), *here.axes, (-half, half), (-half, half),
                       equal=True, tab=ELLIPSES_TAB, caption=said)


def ratios(n: int) -> np.ndarray:
    """The ratios at which the locus of n states is drawn."""
    return np.geomspace(LOW, HIGH, max(FEWEST, SAMPLES // n))


def locus(A: np.ndarray, B: np.ndarray, Q: np.ndarray, R: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The 2n roots of det(R/ρ + Bᵀ(−sI − Aᵀ)⁻¹ Q (sI − A)⁻¹B) = 0 for each ratio ρ in `at` (k,).

    The result is (k, 2n), each branch in a column.

    They are the eigenvalues of the Hamiltonian matrix [A, −ρ B R⁻¹Bᵀ; −Q, −Aᵀ]. With each root s, −s is one; those on the left are the
    poles that LQR chooses for ρQ and R. Source: Kailath, Linear Systems (1980), section 3.4: the symmetric root locus.
    """
    push = B @ np.linalg.solve(R, B.T)
    roots = np.array([np.linalg.eigvals(np.block([[A, -ratio * push], [-Q, -A.T]])) for ratio in at], dtype=complex)
    for before, after in pairwise(roots):
        after[:] = after[linear_sum_assignment(np.abs(before[:, None] - after))[1]]
    return roots


@lru_cache(maxsize=16)
def _branches(here: Setting, plant: Plant, filtering: bool) -> np.ndarray:
    given = (plant.A.T, plant.C.T, here.W, here.V) if filtering else (plant.A, plant.B, here.Q, here.R)
    return locus(*given, ratios(plant.n))


def locus_figures(here: Setting, design: Design) -> tuple[PlaneFigure, PlaneFigure]:
    """The locus of the regulator over α_Q/α_R and that of the filter over α_W/α_V."""
    q, r = design["q"], design["r"]
    w, v = (q, r) if design["mirror"] else (design["w"], design["v"])
    return (_figure(here, design, False, q / r, text("symmetric root locus of the LQR"),
                    text("α_Q/α_R from 10⁻⁶ to 10⁶. Crosses: LQR poles at the present ratio {ratio:.3g}. Circles: their mirror images.",
                         ratio=q / r)),
            _figure(here, design, True, w / v, text("symmetric root locus of the LQE"),
                    text("α_W/α_V from 10⁻⁶ to 10⁶. Crosses: LQE poles at the present ratio {ratio:.3g}. Circles: their mirror images.",
                         ratio=w / v)))


def _figure(here: Setting, design: Design, filtering: bool, ratio: float, title: Text, caption: Text) -> PlaneFigure:
    plant, role = here.plant(design), "estimate" if filtering else "plant"
    given = (plant.A.T, plant.C.T, here.W, here.V) if filtering else (plant.A, plant.B, here.Q, here.R)
    wide, high = -here.window.re_low, here.window.im_high
    curves = []
    for branch in _branches(here, plant, filtering).T:
        seen = branch[(np.abs(branch.real) <= wide) & (np.abs(branch.imag) <= high)]
        if len(seen) > 1:
            stable = float(np.median(seen.real)) < 0
            curves.append(Curve(text("chosen") if stable else text("mirror image"), seen.imag, role if stable else "muted",
                                "solid" if stable else "dash", 2.0, seen.real))
    now = locus(*given, np.array([ratio]))[0]
    points = [Point(float(s.real), float(s.imag), role if s.real < 0 else "muted", "cross" if s.real < 0 else "circle") for s in now
              if abs(s.real) <= wide and abs(s.imag) <= high]
    return PlaneFigure("filter-locus" if filtering else "regulator-locus", title, tuple(curves), tuple(points), "Re s", "Im s",
                       (-wide, wide), (-high, high), tab=LOCUS_TAB, caption=caption)
