"""Draw the figures for an own bilinear plant: g, error, conditions, the three forms."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.figures.records import Curve, Dash, LineFigure, TableFigure
from observer_lab.course.lazy import FigureSet, tab_figures
from observer_lab.course.lesson import Outcome
from observer_lab.text import format_number, joined, listed, same, text, text_in

from ..toolkit.boards import listed as in_pairs
from ..toolkit.figures import TIME_TAB
from ..toolkit.latex import pole_words
from .figures import CASES_TAB, FORMS_TAB, HEADINGS, STEPS_TAB, lights
from .input_signals import columns, form_index
from .own_summary import LAW, Story
from .study import FORM_NAMES, bound, counts

MAX_DRAWN_ROWS = 3  # rows of g in a figure
MOST_CELLS = 12  # entries of a matrix that a table writes out
ROLES = (("plant", "estimate"), ("second", "disturbance"), ("force", "error"))
ERROR_RANGE = (1e-6, 1.0)
LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def figures(outcome: Outcome[Story]) -> FigureSet:
    """Everything on the right of the stage."""
    s = outcome.study
    return FigureSet(tab_figures(TIME_TAB, lambda: (_functional(outcome), _error(outcome), _input(outcome))),
                 tab_figures(STEPS_TAB, lambda: (_step(outcome),)),
                 tab_figures(CASES_TAB, lambda: (lights(outcome.checks), _conditions(s), _wanted(s))),
                 tab_figures(FORMS_TAB, lambda: (_forms(s), _fed(outcome))))


def _sizes(s: Story) -> np.ndarray:
    size = np.max(np.abs(s.run.g), axis=0)
    return np.where(size > 0, size, 1.0)


def _functional(outcome: Outcome[Story]) -> LineFigure:
    s, m = outcome.study, outcome.metrics
    run, w, index = s.run, s.wanted, form_index(outcome.design)
    several = len(w.rows) > 1
    size = _sizes(s) if several else np.ones(1)
    curves = []
    for i, name in enumerate(w.rows[:MAX_DRAWN_ROWS]):
        true, guess = ROLES[i]
        estimated = text("{name}, estimated {form}", name=name, form=FORM_NAMES[index])
        curves += [Curve(name, run.g[:, i] / size[i], true), Curve(estimated, run.estimates[:, index, i] / size[i], guess, "dash")]
    met = m["settled_after"]
    said = (text("After {met:.3g} s the error of ĝ stays below 2 % of its peak.", met=met) if met <= s.here.horizon
            else text("Within this run ĝ does not settle on g."))
    label = text("g over its largest value") if several else same(f"[{w.units[0]}]") if w.units[0] else same("g")
    return LineFigure("functional", text("the number wanted, g = K x") if not several else text("the numbers wanted, g = K x"), run.t,
                      tuple(curves), label, tab=TIME_TAB, caption=said)


def _error(outcome: Outcome[Story]) -> LineFigure:
    s, m, index = outcome.study, outcome.metrics, form_index(outcome.design)
    size, rows = _sizes(s), s.wanted.rows[:MAX_DRAWN_ROWS]
    curves = [Curve(text("|ε| of {name}", name=name), np.abs(s.run.errors[:, index, i]) / size[i], ROLES[i][1])
              for i, name in enumerate(rows)]
    if len(rows) < MAX_DRAWN_ROWS:
        curves += [Curve(text("law of {name}", name=name), np.abs(s.run.law[:, i]) / size[i], "reference", "dash", 1.6)
                   for i, name in enumerate(rows)]
    said = claim(text("|ε| follows ẇ = A_L w to within {law_gap:.0e} of its peak, whatever u does.", law_gap=m["law_gap"]), m["law_gap"],
                 below=LAW, otherwise=text("|ε| leaves its law: in the last tenth of the run it is up to {late:.2g} of g.",
                                           late=m["late_error"]))
    if s.wanted.solved.case == 1:  # at some u it may follow a law all the same
        said = text("No L frees |ε| from u and x: in the last tenth of the run it is up to {late:.2g} of g.", late=m["late_error"])
    return LineFigure(
        "error",
        text("error ε = ĝ − g over the largest g"),
        s.run.t,
        tuple(curves),
        "|ε| / |g|",
        log_y=True,
        window=ERROR_RANGE,
        tab=TIME_TAB,
        caption=said,
    )


def _input(outcome: Outcome[Story]) -> LineFigure:
    s = outcome.study
    here, drive = s.here, columns(s.run.u)
    peaks = np.max(np.abs(drive), axis=0)
    if len(peaks) == 1:
        unit = here.units[0]
        return LineFigure("input", text("input u, which also multiplies the state"), s.run.t, (Curve(same("u"), drive[:, 0], "force"),),
                          f"u [{unit}]" if unit else "u", tab=TIME_TAB, caption=text("Largest |u|: {peak:.3g}.", peak=float(peaks[0])))
    looks: tuple[tuple[str, Dash], ...] = (("force", "solid"), ("second", "dash"), ("disturbance", "dot"), ("error", "solid"))
    curves = tuple(Curve(name, u / (size or 1.0), *looks[j % len(looks)])
                   for j, (name, u, size) in enumerate(zip(here.names, drive.T, peaks.tolist(), strict=True)))
    told = listed(same(f"{peak:.3g} {unit}".rstrip()) for peak, unit in zip(peaks.tolist(), here.units, strict=True))
    return LineFigure("input", text("inputs, which also multiply the state, over their largest values"), s.run.t, curves, "u / max |u|",
                      tab=TIME_TAB, caption=text("Largest values: {peaks}.", peaks=told))


def _step(outcome: Outcome[Story]) -> TableFigure:
    """The matrices of the step shown: their sizes, and their entries where they are few."""
    s, step = outcome.study, int(outcome.design["step"])
    o = s.wanted.solved
    c = o.canonical_Q
    shown = {1: (("V₂", o.V[1]), ("T₂ᵀ", o.T[1].T), ("T₃ᵀ", o.T[2].T)), 2: (("Q", o.Q), ("Q̄ᴸ", c.zero_left)),
             3: (("Q̄ᴿ", c.zero_right), ("W Q̄ᴿ", o.defect)), 4: (("Q̄ᴸ", c.zero_left),), 5: (("A*", o.A_star), ("B*", o.B_star)),
             6: (("A*", o.A_star), ("B*", o.B_star)), 7: (("L", s.L),),
             8: (("A_L", s.plain.A), ("Y", s.plain.Y), ("b", s.plain.B), ("U", s.plain.U), ("G", s.plain.G_y), ("H", s.plain.G_z))}[step]
    rows = tuple((same(name), f"{M.shape[0]} × {M.shape[1]}", _cells(M)) for name, M in shown)
    return TableFigure("step", HEADINGS[step - 1], (text("item"), text("size"), text("entries, row by row")), rows, tab=STEPS_TAB,
                       caption=text("The entries, in the units of the file; the formulas show larger matrices, of the largest the norm."))


def _cells(M: np.ndarray) -> str:
    return "—" if not M.size or M.size > MOST_CELLS else ", ".join(format_number(v, ".4g") for v in M.ravel()).replace("-", "−")


def _conditions(s: Story) -> TableFigure:
    o = s.wanted.solved
    n, m, q = o.plant.n, o.plant.m, o.order
    left = len(o.canonical_Q.zero_left)
    rows = (
        (text("input u"), listed(s.here.names)),
        (text("what u multiplies"), text("nothing: F is zero") if s.here.linear else same(_terms(o.plant.inputs))),
        (text("states n, sensors m, numbers wanted r"), f"{n}, {m}, {len(o.K)}"),
        (text("order q of the observer"), str(q)),
        (text("order n − m of Luenberger's reduced observer"), str(n - m)),
        (text("rows and columns of Q"), f"{o.Q.shape[0]}, {o.Q.shape[1]}"),
        (text("rank of Q"), str(o.canonical_Q.rank)),
        (text("what is left of (21), relative"), text("{left:.1e}", left=o.defect_size) if o.defect_size else "0"),
        (text("rows of Q to spare"), str(left)),
    )
    lower = (text("Order {q} instead of n − m = {most}: the functional observer is the smaller one.", q=q, most=n - m) if q < n - m else
             text("Order {q} is that of Luenberger's reduced observer: all that is not measured is estimated.", q=q))
    if q < len(o.K):
        lower = joined(lower, text("Beyond what y says, the {rows} numbers wanted have rank {q}: r is {q} in "
                                   "the lights.", rows=len(o.K), q=q))
    return TableFigure("conditions", text("sizes and conditions"), (text("quantity"), text("value")), rows, tab=CASES_TAB, caption=lower)


def _terms(inputs: int) -> str:
    return "F x" if inputs == 1 else ", ".join(f"F{str(j + 1).translate(LOWERED)} x" for j in range(inputs))


def _wanted(s: Story) -> TableFigure:
    rows = []
    for w in s.here.wanted:
        o = w.solved
        name = text("▸ {label}", label=w.label) if w.id == s.wanted.id else w.label
        fate = text("no L") if o.case == 1 else text("one L") if o.case == 2 else text("a family of L")
        if o.case == 3 and not w.bolted:
            poles = text("any")
        else:
            fixed = w.bolted if o.case == 3 else tuple(in_pairs(o.reached))
            poles = same("—" if o.case == 1 else pole_words(fixed[:4]))
        known, needed = counts(o)
        rows.append((name, str(o.case), fate, poles, str(o.order), f"{known} {'≥' if o.advised else '<'} {needed}"))
    met = sum(w.solved.case != 1 for w in s.here.wanted)
    return TableFigure("problems", text("what may be wanted of this plant"),
                       (text("wanted"), text_in("bilinear-observer", "case"), text("solutions"), text("pole"), text("order"),
                        same(bound(s.here.plant))), tuple(rows), tab=CASES_TAB,
                       caption=text("{met} of {count} have an L that frees ε from u and x.", met=met, count=len(rows)))


def _forms(s: Story) -> LineFigure:
    run, size = s.run, _sizes(s)
    worst = np.max(np.abs(run.errors) / size, axis=2)
    late = np.max(worst[len(run.t) // 2:], axis=0)
    styles: tuple[tuple[str, Dash], ...] = (("error", "solid"), ("second", "dot"), ("disturbance", "dash"))
    curves = tuple(Curve(name, part, *style) for name, part, style in zip(FORM_NAMES, worst.T, styles, strict=True))
    return LineFigure("forms", text("|ε| of the three ways to run it, over the largest g"), run.t, curves, "|ε| / |g|", log_y=True,
                      window=ERROR_RANGE, tab=FORMS_TAB, caption=text(
                          "Largest error in the second half, relative to g: {late:.2g} without ẏ, {late2:.2g} with the true ẏ, "
                          "{late3:.2g} with a differentiator.", late=late[0], late2=late[1], late3=late[2]))


def _fed(outcome: Outcome[Story]) -> LineFigure:
    run = outcome.study.run
    gap = float(np.max(np.abs(run.fed[:, 0] - run.fed[:, 1])))
    first = text("Shown is its first row.") if len(outcome.study.L) > 1 else text("It is one number.")
    return LineFigure("fed", text("L ẏ, true and from the differentiator"), run.t,
                      (Curve(text("true"), run.fed[:, 0], "second"), Curve(text("differentiator"), run.fed[:, 1], "disturbance", "dash")),
                      "L ẏ", tab=FORMS_TAB, caption=joined(
                          text("The differentiator lags by about {tau:.3g} s and misses L ẏ by up to {gap:.3g}.",
                               tau=outcome.design["tau"], gap=gap), first))
