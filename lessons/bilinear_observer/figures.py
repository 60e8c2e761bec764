"""Draw the figures of lesson 16: g and its error, eight steps, three cases, two forms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from observer_lab.course.figures.curves import UNDER
from observer_lab.course.figures.records import Curve, Dash, LineFigure, PlaneFigure, Point, TableFigure
from observer_lab.course.lazy import FigureSet, TabFigures, tab_figures
from observer_lab.course.lesson import Check, Outcome
from observer_lab.engine.observers import BilinearObserver
from observer_lab.plants.bilinear import POLE
from observer_lab.text import Text, joined, listed, same, text, text_in

from ..toolkit.figures import TIME_TAB
from .input_signals import columns, form_index
from .paper_example import DOUBTED, PRINTED_LINES, words
from .problems import PAPER_PROBLEM, PROBLEMS
from .run_record import Setting
from .study import FORM_NAMES, Study, bound, counts
from .terms_figure import TERMS_TAB, terms_figure

STEPS_TAB = text("Eight steps")
CASES_TAB, FORMS_TAB, POLES_TAB = text("Three cases"), text("With and without ẏ"), text("Four problems")
SENSOR_NAMES = (same("x₁ … x₄"), same("x₁ x₂ x₃"), text("another K"), same("x₁ x₃ x₅ x₆"))  # of the four problems
BAR_WIDTH_PX = 34.0
MAX_DRAWN_ROWS = 3  # rows of g in a figure
ROLES = (("plant", "estimate"), ("second", "disturbance"), ("force", "error"))  # of these rows and their estimates
YES, NO = text("● yes"), text("○ no")
Tables = Callable[[Outcome[Study]], tuple[TableFigure, ...]]
HEADINGS = (
    text("1: canonise C, then K₁; the coordinates T and V"),
    text("2: form Q and canonise it"),
    text("3: is condition (21) met"),
    text("4: has Q a left divisor of zero"),
    text("5: A* and B*, controllable or not"),
    text("6: π by placing the pole"),
    text("7: the gain L"),
    text("8: the observer"),
)


def _step(problem: str, o: BilinearObserver, step: int) -> TableFigure:
    printed = problem == PAPER_PROBLEM
    rows = tuple((line.name, line.printed if printed else "—", words(line.ours(o))) for line in PRINTED_LINES if line.step == step)
    heading = HEADINGS[step - 1]
    moved = printed and step >= 6 and o.asked[0].real != POLE
    caption = (text("The paper works this problem for the pole −30 only; the last column follows your pole.") if moved
               else text("The paper's digits stand beside ours.") if printed
               else text("The paper does not treat this problem, so its column stays empty."))
    return TableFigure("step", heading, (text("item"), text_in("bilinear-observer", "printed"), text("ours")),
                       rows, tab=STEPS_TAB, caption=caption)


def _page(line: str) -> TableFigure:
    o = PROBLEMS[PAPER_PROBLEM].solved
    rows = []
    for each in DOUBTED:
        assert each.alone is not None
        here = each.id == line
        name = text("▸ {name}", name=each.name) if here else each.name
        rows.append((name, each.printed, words(np.array([each.alone(o)]), 2) if here else "·"))
    chosen = next((each for each in DOUBTED if each.id == line), None)
    if chosen is None:
        caption = text("Choose a line in doubt: the last column then says which pole it leads to by itself.")
    else:
        assert chosen.alone is not None
        pole = words(np.array([chosen.alone(o)]), 2)
        caption = text("With only {name} as printed and all else exact, the observer's pole is {pole}.",
                       name=chosen.name, pole=pole)
    return TableFigure("page", text("the paper's lines, for the pole −30"),
                       (text("line"), text_in("bilinear-observer", "printed"), text("pole by itself")),
                       tuple(rows), tab=STEPS_TAB, caption=caption)


def figures(steps: Tables, cases: Tables, more: Callable[[Outcome[Study]], tuple[TabFigures, ...]], outcome: Outcome[Study]) -> FigureSet:
    """Everything on the right of the stage; `steps`, `cases` and `more` are what a plant has in these tabs, and its further tabs."""
    return FigureSet(
        tab_figures(TIME_TAB, lambda: (_functional(outcome), _error(outcome), _input(outcome.study))),
        tab_figures(STEPS_TAB, lambda: steps(outcome)), tab_figures(CASES_TAB, lambda: (_lights(outcome.checks), *cases(outcome))),
        *more(outcome), tab_figures(FORMS_TAB, lambda: (_forms(outcome.study), _fed(outcome))))


def paper_steps(outcome: Outcome[Study]) -> tuple[TableFigure, ...]:
    """This step with the paper's digits beside ours, and all lines that can be doubted."""
    design = outcome.design
    return _step(design["problem"], outcome.study.observer, int(design["step"])), _page(design["line"])


def paper_cases(outcome: Outcome[Study]) -> tuple[TableFigure, ...]:
    """Ranks, and the four problems."""
    return _singular(outcome.study.observer), _problems(outcome.design["problem"])


def paper_tabs(outcome: Outcome[Study]) -> tuple[TabFigures, ...]:
    """The unknown terms, and the pole in each of the four problems."""
    problem = outcome.design["problem"]
    return tab_figures(TERMS_TAB, lambda: (terms_figure(problem),)), tab_figures(POLES_TAB, lambda: (_poles(problem),))


def _functional(outcome: Outcome[Study]) -> LineFigure:
    s, run, met, index = outcome.study.setting, outcome.study.run, outcome.metrics["settled_after"], form_index(outcome.design)
    several = len(s.rows) > 1
    size, unit = s.size(run) if several else np.ones(1), s.rows[0].unit
    curves = []
    for i, (row, (true, guess)) in enumerate(zip(s.rows, ROLES, strict=False)):
        curves += [Curve(row.name, run.g[:, i] / size[i], true), Curve(row.guess, run.estimates[:, index, i] / size[i], guess, "dash")]
    caption = (text("After {met:.3g} s the error of ĝ stays below 2 % of its peak.", met=met) if met <= s.horizon
               else text("With the sensors' noise the error of ĝ does not stay below 2 % of its peak in this run.")
               if outcome.design["noise"] and not s.own else text("Within this run ĝ does not settle on g."))
    label = text("g over its largest value") if several else same(f"[{unit}]" if unit else "g")
    return LineFigure("functional", text("the numbers wanted, g = K x") if several else text("the number wanted, g = K x"), run.t,
                      tuple(curves), label, window=s.windows.get("functional"), tab=TIME_TAB, caption=caption)


def _error(outcome: Outcome[Study]) -> LineFigure:
    s, run, index = outcome.study.setting, outcome.study.run, form_index(outcome.design)
    size, rows = s.size(run), s.rows[:MAX_DRAWN_ROWS]
    curves = [Curve(row.error, np.abs(run.errors[:, index, i]) / size[i], ROLES[i][1] if s.own else "error") for i, row in enumerate(rows)]
    if len(rows) < MAX_DRAWN_ROWS:
        curves += [Curve(row.law, np.abs(run.law[:, i]) / size[i], "reference", "dash", 1.6) for i, row in enumerate(rows)]
    return LineFigure("error", text("error ε = ĝ − g over the largest g") if s.own else text("error ε = ĝ − g"), run.t, tuple(curves),
                      _axis(s), log_y=True, window=s.windows["error"], tab=TIME_TAB, caption=s.told_of_error(outcome.metrics))


def _axis(s: Setting) -> str:
    return "|ε| / |g|" if s.own else "|ε|"


def _input(study: Study) -> LineFigure:
    s, t, drive = study.setting, study.run.t, columns(study.run.u)
    peaks = np.max(np.abs(drive), axis=0)
    if len(peaks) == 1:
        unit = s.inputs[0][1]
        return LineFigure("input", text("input u, which also multiplies the state"), t, (Curve(same("u"), drive[:, 0], "force"),),
                          f"u [{unit}]" if unit else "u", window=s.windows.get("input"), tab=TIME_TAB,
                          caption=text("Largest |u|: {peak:.3g}.", peak=float(peaks[0])))
    looks: tuple[tuple[str, Dash], ...] = (("force", "solid"), ("second", "dash"), ("disturbance", "dot"), ("error", "solid"))
    curves = tuple(Curve(name, u / (size or 1.0), *looks[j % len(looks)])
                   for j, ((name, _), u, size) in enumerate(zip(s.inputs, drive.T, peaks.tolist(), strict=True)))
    told = listed(same(f"{peak:.3g} {unit}".rstrip()) for peak, (_, unit) in zip(peaks.tolist(), s.inputs, strict=True))
    return LineFigure("input", text("inputs, which also multiply the state, over their largest values"), t, curves, "u / max |u|",
                      tab=TIME_TAB, caption=text("Largest values: {peaks}.", peaks=told))


def _lights(checks: Sequence[Check]) -> TableFigure:
    """Which statements hold."""
    lit = sum(c.holds for c in checks)
    return TableFigure("lights", text("lights"), (text("statement"), text("holds")),
                       tuple((c.text, YES if c.holds else NO) for c in checks), tab=CASES_TAB,
                       caption=text("{lit} of {count} are lit.", lit=lit, count=len(checks)))


def _singular(o: BilinearObserver) -> TableFigure:
    tall = np.linalg.svd(np.vstack([o.Q, o.right]), compute_uv=False)
    wide, rows = o.canonical_Q.singular_values, len(o.Q)
    rank = int(np.sum(tall > 1e-9 * tall[0]))
    more = rank > o.canonical_Q.rank
    table = ((same("Q"), words(wide, 3), f"{o.canonical_Q.rank} / {rows}"),
             (text("Q with the row V₂(FT₂ AT₃ FT₃)"), words(tall, 3), f"{rank} / {rows + 1}"))
    caption = (text("The row adds to the rank: no combination of the rows of Q is equal to it. In these "
                    "coordinates (21) fails by {defect_size:.1e} of its size; another basis gives another share.",
                    defect_size=o.defect_size) if more else
               text("The row adds nothing to the rank, so (21) holds. Rows of Q to spare: {rows}.",
                    rows=rows - o.canonical_Q.rank))
    return TableFigure("singular", text("singular values"),
                       (text("matrix"), text("singular values"), text("rank / rows")), table,
                       tab=CASES_TAB, caption=caption)


def problems_table(title: Text, first: Text, problems: Sequence[tuple[Text, BilinearObserver, Text]], chosen: int, caption: Text,
                   orders: bool = False) -> TableFigure:
    """What may be wanted: its label, the eight steps, the pole in words; how many L there are, and whether the sizes let one expect it."""
    rows = []
    for k, (label, o, pole) in enumerate(problems):
        known, needed = counts(o)
        solutions = text("no L") if o.case == 1 else text("one L") if o.case == 2 else text("a family of L")
        rows.append((text("▸ {label}", label=label) if k == chosen else label, str(o.case), solutions, pole,
                     *((str(o.order),) if orders else ()), f"{known} {'≥' if o.advised else '<'} {needed}"))
    heads = (first, text_in("bilinear-observer", "case"), text("solutions"), text("pole"), *((text("order"),) if orders else ()),
             same(bound(problems[0][1].plant)))
    return TableFigure("problems", title, heads, tuple(rows), tab=CASES_TAB, caption=caption)


@lru_cache(maxsize=8)
def _problems(chosen: str) -> TableFigure:
    def pole(o: BilinearObserver) -> Text:
        return same("—") if o.case == 1 else text("any") if o.case == 3 and o.controllable else same(words(o.reached.real, 2))
    return problems_table(
        text("four problems on one plant"), text("problem"), [(p.label, p.solved, pole(p.solved)) for p in PROBLEMS.values()],
        list(PROBLEMS).index(chosen), text(
            "Fewer sensors, or others, and the same number may no longer be watched. Where 3m + r ≥ 2n, an L exists in "
            "general; the third problem has one although the condition fails."))


@lru_cache(maxsize=8)
def _poles(chosen: str) -> PlaneFigure:
    """The observer's pole in each of the four problems: placed, fixed, or none."""
    kinds = {"force": text("pole that can be placed"), "error": text("fixed pole")}
    bars, marks = list[Curve](), list[Point]()
    for k, p in enumerate(PROBLEMS.values()):
        if p.solved.case == 1:
            marks.append(Point(float(k), 0.0, "reference", "cross", text("no L")))
            continue
        role = "force" if p.solved.case == 3 and p.solved.controllable else "error"
        bars.append(Curve(kinds[role], np.array([0.0, float(np.real(p.solved.reached.item()))]), role, "solid", BAR_WIDTH_PX,
                          np.full(2, float(k))))
    edge = Curve(text("stable below"), np.zeros(2), "muted", "dash", 1.6, np.array([-0.6, len(PROBLEMS) - 0.4]))
    return PlaneFigure("case_poles", text("the observer's pole in four problems"), (*bars, edge), tuple(marks), "", text("pole [rad/s]"),
        (-0.6, len(PROBLEMS) - 0.4), (-40.0, 20.0), caption=text(
            "The pole can be placed with x₁ … x₄ alone; here it is asked to be at {pole:g}.", pole=POLE), tab=POLES_TAB,
        names=tuple((float(k), text("▸ {name}", name=name) if p.id == chosen else name)
                    for k, (p, name) in enumerate(zip(PROBLEMS.values(), SENSOR_NAMES, strict=True))))


def _forms(study: Study) -> LineFigure:
    s, run = study.setting, study.run
    worst = np.max(np.abs(run.errors) / s.size(run), axis=2)
    late = np.max(worst[len(run.t) // 2:], axis=0)
    told = {"late": late[0], "late2": late[1], "late3": late[2]}
    styles: tuple[tuple[str, Dash, float], ...] = (("error", "solid", UNDER), ("second", "dash", 2.0), ("disturbance", "dash", 2.4))
    curves = tuple(Curve(name, part, *style) for name, part, style in zip(FORM_NAMES, worst.T, styles, strict=True))
    title, caption = ((text("|ε| of the three ways to run it, over the largest g"),
                       text("Largest error in the second half, relative to g: {late:.2g} without ẏ, {late2:.2g} with the true ẏ, "
                            "{late3:.2g} with a differentiator.", **told)) if s.own else
                      (text("|ε| of the three ways to run it"),
                       text("Largest error in the second half of the run: {late:.2g} without ẏ, {late2:.2g} with the true ẏ, "
                            "{late3:.2g} with a differentiator.", **told)))
    return LineFigure("forms", title, run.t, curves, _axis(s), log_y=True, window=s.windows["error"], tab=FORMS_TAB, caption=caption)


def _fed(outcome: Outcome[Study]) -> LineFigure:
    s, run, tau = outcome.study.setting, outcome.study.run, outcome.design["tau"]
    gap = float(np.max(np.abs(run.fed[:, 0] - run.fed[:, 1])))
    caption = text("The differentiator lags by about {tau:.3g} ms and misses L ẏ by up to {gap:.3g}.", tau=1000 * tau, gap=gap)
    if s.own:
        caption = joined(text("The differentiator lags by about {tau:.3g} s and misses L ẏ by up to {gap:.3g}.", tau=tau, gap=gap),
                         text("Shown is its first row.") if len(s.L) > 1 else text("It is one number."))
    return LineFigure("fed", text("L ẏ, true and from the differentiator"), run.t,
                      (Curve(text("true"), run.fed[:, 0], "second"), Curve(text("differentiator"), run.fed[:, 1], "disturbance", "dash")),
                      "L ẏ", window=s.windows.get("fed"), tab=FORMS_TAB, caption=caption)
