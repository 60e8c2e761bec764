"""Figures of the lesson, from an outcome and nothing else."""

from __future__ import annotations

import numpy as np

from app.lesson.figures import (
    Curve,
    Figure,
    LineFigure,
    MapFigure,
    PlaneFigure,
    Point,
    TableFigure,
    nice,
    over_frequency,
)
from app.lesson.lesson import Design, Outcome
from app.text.words import Text, same

from .knobs import COLUMNS, LINES, NORMS, ONE, REMARKS
from .paper import PRINTED_SIZES, claimed_columns, free_columns, remark_3, true_size
from .study import CASES, FREQUENCIES, MOST, Search, Story, criterion_1, criterion_2, steering

TIME_TAB, J_TAB = Text("Time", "时间"), Text("Criterion J", "指标 J")
WORST_TAB, PAPER_TAB = Text("Worst case", "最坏情况"), Text("Paper", "论文")
AXIS = np.linspace(-12.0, -0.05, 160)
GRID = np.linspace(-12.0, -0.2, 48)
WEIGHTS = np.linspace(0.0, 3.0, 31)
LARGE_N = 20.0
EDGE = 200.0  # signals beyond are drawn at the edge
NONE = same("–")


def all_figures(outcome: Outcome[Story]) -> tuple[Figure, ...]:
    """Time, criterion, worst case, paper: at most three in a tab."""
    return (_error(outcome), _input(outcome), _output(outcome), _criterion(outcome), _map(outcome),
            _found(outcome), _frequency(outcome), _sweep(outcome), _numbers(outcome), _slips(outcome))


def _edge(values: np.ndarray) -> np.ndarray:
    return np.clip(values, -EDGE, EDGE)


def _error(outcome: Outcome[Story]) -> LineFigure:
    story, late = outcome.study, outcome.metrics["late_error"]
    steady = story.steady
    t, window = story.true.t, (-5.0, 5.0)
    same_plant = np.array_equal(story.true.e_u, story.model.e_u)
    caption = (Text("Plant and model agree: e_u dies out like the observer's poles, whatever v does.",
                    "对象与模型一致：不论 v 如何，e_u 都按观测器极点衰减。") if same_plant else
               Text("With the true plant the loop is unstable, and e_u grows with it; on the model it dies out.",
                    "对真实对象，闭环不稳定，e_u 随之增大；在模型上则衰减到零。") if outcome.metrics["slowest_loop"] >= 0 else
               Text(f"With the true plant e_u settles to an amplitude of {steady:.2g}; on the model it dies out.",
                    f"对真实对象，e_u 最终保持 {steady:.2g} 的幅度；在模型上则衰减到零。") if late < 1.2 * steady + 1e-9 else
               Text(f"With the true plant e_u will settle to an amplitude of {steady:.2g}, but at the end of this run the start still "
                    f"shows: up to {late:.2g}.",
                    f"对真实对象，e_u 最终的幅度为 {steady:.2g}；但在本次运行末段，初始误差仍未消失，最大为 {late:.2g}。"))
    return LineFigure("e_u", Text("error of the input, û − Kx in the paper's sign", "输入的误差（论文记号 û − Kx）"), t,
                      (Curve(Text("true plant", "真实对象"), _edge(story.true.e_u[:, 0]), "error"),
                       Curve(Text("model", "模型"), _edge(story.model.e_u[:, 0]), "reference", "dash", 1.6)),
                      "e_u", window=window, caption=caption, tab=TIME_TAB)


def _input(outcome: Outcome[Story]) -> LineFigure:
    run = outcome.study.true
    given = run.u[:, 0]
    peak = min(float(np.max(np.abs(given))), MOST)
    return LineFigure("input", Text("input wanted and given", "期望输入与实际给出的输入"), run.t,
                      (Curve(Text("wanted, −Kx + v", "期望的 −Kx + v"), _edge(given - run.e_u[:, 0]), "plant"),
                       Curve(Text("given", "实际给出的"), _edge(given), "estimate", "dash"),
                       Curve(Text("v", "v"), run.v[:, 0], "muted", "dot", 1.4)), "u", window=(-10.0, 10.0),
                      caption=Text(f"v = −4 sin(5t + π/2). Largest input given: {peak:.3g}.",
                                   f"v = −4 sin(5t + π/2)。给出的输入最大为 {peak:.3g}。"), tab=TIME_TAB)


def _output(outcome: Outcome[Story]) -> LineFigure:
    story = outcome.study
    gap = min(float(np.max(np.abs(story.true.y - story.model.y))), MOST)
    return LineFigure("output", Text("measured output y", "测量输出 y"), story.true.t,
                      (Curve(Text("true plant", "真实对象"), _edge(story.true.y[:, 0]), "plant"),
                       Curve(Text("model", "模型"), _edge(story.model.y[:, 0]), "reference", "dash", 1.6)), "y",
                      window=(-0.5, 0.5), caption=Text(f"The two differ by up to {gap:.2g}.", f"二者最多相差 {gap:.2g}。"),
                      tab=TIME_TAB)


# --- the criterion ---------------------------------------------------------------------------------------------------
def _poles(design: Design) -> tuple[complex, ...]:
    return design[CASES[design["example"]].poles]


def _criterion(outcome: Outcome[Story]) -> PlaneFigure:
    design, J = outcome.design, outcome.metrics["J"]
    poles, search = _poles(design), outcome.study.search
    if design["example"] == ONE:
        known, seen, output = criterion_1(AXIS, design)
        curves = [Curve(same("J"), known + seen + output, "plant", width=2.4, x=AXIS),
                  Curve(same("2α|s|"), known, "muted", "dot", 1.4, AXIS),
                  Curve(same("β|s² + 4s + 3|"), seen, "estimate", "dash", 1.4, AXIS),
                  Curve(same("γ|50 + 30s|"), output, "force", "dash", 1.4, AXIS)]
        title = Text("J over the observer pole s", "J 随观测器极点 s 的变化")
        words = Text(f"J = {J:.4g} at s = {poles[0].real:.3g}. The kink of the green part is where M = 0: s = −5/3.",
                     f"s = {poles[0].real:.3g} 处 J = {J:.4g}。绿色部分的尖点即 M = 0 处：s = −5/3。")
    elif poles[0].imag:
        curves = [Curve(same("J"), criterion_2(AXIS + 1j * abs(poles[0].imag), AXIS - 1j * abs(poles[0].imag),
                                               design).sum(axis=0), "plant", x=AXIS)]
        title = Text("J over Re s, Im s kept", "J 随 Re s 的变化（Im s 不变）")
        words = Text(f"J = {J:.4g} in the norm {_norm(design)}.", f"范数 {_norm(design)} 下 J = {J:.4g}。")
    else:
        curves = [Curve(Text("s₂ kept", "s₂ 不变"), criterion_2(AXIS, np.full_like(AXIS, poles[1].real), design).sum(axis=0),
                        "plant", x=AXIS),
                  Curve(Text("s₁ kept", "s₁ 不变"), criterion_2(np.full_like(AXIS, poles[0].real), AXIS, design).sum(axis=0),
                        "second", "dash", x=AXIS)]
        title = Text("J while one pole moves", "只移动一个极点时的 J")
        words = Text(f"J = {J:.4g} in the norm {_norm(design)}; J does not see that N grows where the poles meet.",
                     f"范数 {_norm(design)} 下 J = {J:.4g}；两极点靠拢时 N 增大，而 J 看不到。")
    top = nice(2.2 * max(J, 4.0))
    curves = [Curve(c.name, np.minimum(c.y, 1.5 * top), c.role, c.dash, c.width, c.x) for c in curves]
    for end in ("region_low", "region_high"):
        curves.append(Curve(Text("region", "区域"), np.array([0.0, 1.5 * top]), "reference", "dot", 1.2,
                            np.full(2, design[end])))
    points = tuple(Point(max(p.real, AXIS[0]), min(J, top), "error", "circle") for p in poles)
    return PlaneFigure("criterion", title, tuple(curves), (*points, *_optimum(search, design, top)), "s [rad/s]", "J",
                       (-12.0, 0.0), (0.0, top), caption=words, tab=J_TAB)


def _norm(design: Design) -> str:
    return "∞" if design["norm"] == "inf" else design["norm"]


def _optimum(search: Search | None, design: Design, top: float) -> tuple[Point, ...]:
    """Where RLO found the least J in the chosen norm."""
    for name, found in search.found if search is not None else ():
        if name == design["norm"]:
            return tuple(Point(float(p.real), min(found.value, top), "force", "cross", Text("RLO", "RLO"))
                         for p in found.observer.poles)
    return ()


def _map(outcome: Outcome[Story]) -> MapFigure:
    """Where J would be less than now: over (s, γ) in example 1, over (s₁, s₂) in example 2."""
    design, now = outcome.design, outcome.metrics["J"]
    poles = _poles(design)
    if design["example"] == ONE:
        unit = criterion_1(GRID, design.with_values(gamma=1.0))
        J = (unit[0] + unit[1])[None] + WEIGHTS[:, None] * unit[2][None]
        N = np.zeros(J.shape)  # N = −30 for every s
        x, y, labels, mark = GRID, WEIGHTS, ("s [rad/s]", "γ"), (poles[0].real, design["gamma"])
        title = Text("J over s and γ, against J now", "J 随 s 与 γ 的变化，与当前 J 比较")
    else:
        s1, s2 = np.meshgrid(GRID, GRID)
        J, N = criterion_2(s1, s2, design).sum(axis=0), steering(s1, s2)
        x = y = GRID
        labels, mark = ("s₁ [rad/s]", "s₂ [rad/s]"), None if poles[0].imag else (poles[0].real, poles[1].real)
        title = Text("J over s₁ and s₂, against J now", "J 随 s₁、s₂ 的变化，与当前 J 比较")
    values = np.where(now * 2 < J, 2, np.where(now * (1 + 1e-9) < J, 1, 0))
    values = np.where(N > LARGE_N, 3, values)
    share = float(np.mean(values == 0))
    return MapFigure("map", title, x, y, values,
                     ((Text("less than now", "比现在小"), "force"), (Text("up to twice", "不到两倍"), "second"),
                      (Text("more than twice", "超过两倍"), "muted"), (Text("|N| > 20", "|N| > 20"), "error")),
                     *labels, marked=mark, tab=J_TAB,
                     caption=Text(f"On {100 * share:.0f} % of the map J would be no larger than {now:.3g}.",
                                  f"图中 {100 * share:.0f} % 的区域 J 不大于 {now:.3g}。"))


def _found(outcome: Outcome[Story]) -> TableFigure:
    """What algorithm RLO found in each norm, or that it has not run."""
    columns = (Text("norm", "范数"), Text("order", "阶数"), Text("poles", "极点"), Text("least J", "最小 J"),
               Text("orders tried", "试过的阶数"))
    search: Search | None = outcome.study.search
    rows: list[tuple[Text | str, ...]] = []
    for name in NORMS:
        found = next((f for key, f in search.found if key == name), None) if search is not None else None
        shown = "∞" if name == "inf" else name
        if found is None:
            rows.append((shown, NONE, NONE, NONE, NONE))
            continue
        tried = ", ".join(f"{a.order}: {'✓' if a.feasible else f'✗ {a.gap:.2g}'}" for a in found.attempts)
        poles = ", ".join(f"{p.real:.5g}".replace("-", "−") for p in found.observer.poles)
        rows.append((shown, str(found.observer.order), poles, f"{found.value:.6g}", tried))
    caption = (Text("Not run yet: press the button “Run algorithm RLO”.", "尚未运行：请按“运行算法 RLO”。")
               if search is None or not search.found else
               Text("✗ with the share of K that an observer of that order misses; then the order is raised.",
                    "✗ 后为该阶观测器达不到的 K 的相对误差；此时阶数加一。"))
    return TableFigure("found", Text("algorithm RLO inside the region", "区域内的算法 RLO"), columns, tuple(rows),
                       caption=caption, tab=J_TAB)


# --- worst case ------------------------------------------------------------------------------------------------------
def _frequency(outcome: Outcome[Story]) -> LineFigure:
    story, peak = outcome.study, outcome.metrics["worst_gain"]
    floor = 1e-6
    caption = (Text("At some sign pattern of the δ the loop is unstable.", "在某组 δ 符号下闭环不稳定。") if peak >= MOST else
               Text(f"Worst of the eight sign patterns: {peak:.3g} times v.", f"八种符号组合中最坏的：v 的 {peak:.3g} 倍。"))
    return over_frequency("gain", Text("from v to the error of the input", "由 v 到输入误差的增益"), FREQUENCIES,
                          (Curve(Text("these δ", "当前 δ"), np.maximum(story.now, floor), "error"),
                           Curve(Text("worst signs", "最坏符号"), np.maximum(story.worst, floor), "reference", "dash")),
                          "|e_u/v|", caption=caption, tab=WORST_TAB, window=(1e-2, 1.0))


def _sweep(outcome: Outcome[Story]) -> PlaneFigure:
    """The worst case along the axis, as far as the job has come; now is the dotted line."""
    design, search, now = outcome.design, outcome.study.search, outcome.metrics["worst_gain"]
    top = nice(1.6 * min(max(now, 1.0), 50.0))
    curves = [Curve(Text("now", "当前"), np.full(2, min(now, top)), "error", "dot", 1.6, np.array([-12.0, 0.0]))]
    points: tuple[Point, ...] = ()
    caption = Text("Run algorithm RLO to draw the worst case along the axis.", "运行算法 RLO 后给出沿实轴的最坏情况。")
    if search is not None and len(search.s):
        curves.append(Curve(Text("worst of eight", "八种中最坏的"), np.minimum(search.worst, 1.5 * top), "plant", x=search.s))
        k = int(np.argmin(search.worst))
        points = (Point(float(search.s[k]), min(float(search.worst[k]), top), "force", "circle"),)
        least = Text(f"Least worst case so far: {search.worst[k]:.3g} at s = {search.s[k]:.3g}",
                     f"目前最小的最坏情况：{search.worst[k]:.3g}，在 s = {search.s[k]:.3g}")
        tail = (Text("; J is least elsewhere.", "；J 的最小点不在这里。") if design["example"] == ONE else
                Text(" (poles s and s − 1).", "（极点为 s 与 s − 1）。"))
        caption = Text(least.en + tail.en, least.zh + tail.zh)
    return PlaneFigure("sweep", Text("largest |e_u/v| over the eight sign patterns", "八种符号组合下 |e_u/v| 的最大值"),
                       tuple(curves), points, "s [rad/s]", "max |e_u/v|", (-12.0, 0.0), (0.0, top), caption=caption,
                       tab=WORST_TAB)


# --- the paper -------------------------------------------------------------------------------------------------------
def _row(M: np.ndarray) -> str:
    return "; ".join(" ".join(f"{v:.4g}" if abs(v) > 1e-12 else "0" for v in row) for row in M).replace("-", "−")


def _numbers(outcome: Outcome[Story]) -> TableFigure:
    """Ours in both signs."""
    rows = [(name, _row(outcome.gains[name]), _row(outcome.gains[name] * (-1 if name in "KNM" else 1)))
            for name in ("F", "T", "L", "N", "M", "K")]
    rows += [("J", f"{outcome.metrics['J']:.6g}", f"{outcome.metrics['J']:.6g}"),
             ("Σ‖·‖∞", f"{outcome.metrics['error_index']:.6g}", f"{outcome.metrics['error_index']:.6g}")]
    return TableFigure("numbers", Text("the observer in both signs", "两种符号约定下的观测器"),
                       (Text("matrix", "矩阵"), Text("here, u = −K x̂", "本课 u = −K x̂"),
                        Text("paper, u = +K x̂", "论文 u = +K x̂")), tuple(rows), tab=PAPER_TAB,
                       caption=Text("F, T and L do not change; K, N and M do. The last row is an index that sees N and not W.",
                                    "F、T、L 不变，K、N、M 变号。末行的指标看得到 N，而与 W 无关。"))


def _share(value: float | None) -> Text | str:
    if value is None:
        return Text("does not fit", "尺寸不合")
    return "0" if value < 1e-12 else f"{value:.2g}"


def _slips(outcome: Outcome[Story]) -> TableFigure:
    """The chosen readings beside what the engine finds."""
    d = outcome.design
    gaps, printed, true = remark_3(d["remark"]), PRINTED_SIZES[d["line"]], true_size(d["line"])
    claimed = claimed_columns(d["columns"])
    rows: tuple[tuple[Text | str, ...], ...] = (
        (Text("remark 3: (2b) missed by", "注 3：(2b) 的误差"), REMARKS[d["remark"]], _share(gaps.dynamics)),
        (Text("remark 3: (2c) missed by", "注 3：(2c) 的误差"), REMARKS[d["remark"]], _share(gaps.output)),
        (Text(f"{LINES[d['line']]}: size", f"{LINES[d['line']]} 的尺寸"), f"{printed[0]}×{printed[1]}", f"{true[0]}×{true[1]}"),
        (Text("M′: columns", "M′ 的列数"), f"{COLUMNS[d['columns']]} = {claimed}", str(free_columns())),
    )
    wrong = (not gaps.met) + (printed != true) + (claimed != free_columns())
    return TableFigure("slips", Text("lines of the paper against the engine", "论文中的几行与引擎对照"),
                       (Text("line", "内容"), Text("as read", "读作"), Text("engine", "引擎")), rows, tab=PAPER_TAB,
                       caption=Text(f"Example 2, s = −4, −3. Readings that disagree: {wrong} of 3.",
                                    f"例 2，s = −4、−3。三处读法中有 {wrong} 处不符。"))
