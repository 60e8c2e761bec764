"""Figures of the lesson: g and its error, the eight steps, the three cases with singular values, the two forms."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from app.engine.observers import BilinearObserver
from app.lesson.figures import Curve, Dash, Figure, TableFigure, TimeFigure
from app.lesson.lesson import Check, Outcome
from app.plants.bilinear import POLE
from app.text.words import Text, same

from ..toolkit.figures import TIME_TAB
from .page import DOUBTED, LINES, words
from .problems import PAPER, PROBLEMS
from .study import FORM_NAMES, HORIZON, Study, Watch, form_index

STEPS_TAB = Text("Eight steps", "八个步骤")
CASES_TAB, FORMS_TAB = Text("Three cases", "三种情形"), Text("With and without ẏ", "用不用 ẏ")
YES, NO = Text("● yes", "● 是"), Text("○ no", "○ 否")
HEADINGS = (
    Text("1: canonise C, then K₁; the coordinates T and V", "1：对 C 和 K₁ 作典范化，得坐标变换 T、V"),
    Text("2: form Q and canonise it", "2：构造 Q 并作典范化"),
    Text("3: is condition (21) met", "3：条件 (21) 是否成立"),
    Text("4: has Q a left divisor of zero", "4：Q 是否有左零因子"),
    Text("5: A* and B*, controllable or not", "5：A*、B* 及其能控性"),
    Text("6: π by placing the pole", "6：由极点配置求 π"),
    Text("7: the gain L", "7：增益 L"),
    Text("8: the observer", "8：写出观测器"),
)


def steps_figures(problem: str, o: BilinearObserver, step: int, line: str) -> tuple[TableFigure, TableFigure]:
    """This step with the paper's digits beside ours, and all lines that can be doubted."""
    return _step(problem, o, step), _page(line)


def _step(problem: str, o: BilinearObserver, step: int) -> TableFigure:
    printed = problem == PAPER
    rows = tuple((line.name, line.printed if printed else "—", words(line.ours(o))) for line in LINES if line.step == step)
    heading = HEADINGS[step - 1]
    moved = printed and step >= 6 and o.asked[0].real != POLE
    caption = (Text("The paper works this problem for the pole −30 only; the last column follows your pole.",
                    "论文只对极点 −30 作了计算；最后一列随你选的极点而变。") if moved
               else Text("The paper's digits stand beside ours.", "论文所印的数字与我们的结果并列。") if printed
               else Text("The paper does not treat this problem, so its column stays empty.", "论文没有讨论这个问题，因此该列为空。"))
    return TableFigure("step", heading, (Text("item", "项目"), Text("printed", "论文所印"), Text("ours", "我们的结果")),
                       rows, tab=STEPS_TAB, caption=caption)


def _page(line: str) -> TableFigure:
    o = PROBLEMS[PAPER].solved
    rows = []
    for each in DOUBTED:
        assert each.alone is not None
        here = each.id == line
        name = Text(f"▸ {each.name.en}", f"▸ {each.name.zh}") if here else each.name
        rows.append((name, each.printed, words(np.array([each.alone(o)]), 2) if here else "·"))
    chosen = next((each for each in DOUBTED if each.id == line), None)
    if chosen is None:
        caption = Text("Choose a line in doubt: the last column then says which pole it leads to by itself.",
                       "选一行可疑的数字，最后一列便给出照它计算得到的极点。")
    else:
        assert chosen.alone is not None
        pole = words(np.array([chosen.alone(o)]), 2)
        caption = Text(f"With only {chosen.name.en} as printed and all else exact, the observer's pole is {pole}.",
                       f"只有“{chosen.name.zh}”照论文所印、其余全部精确时，观测器的极点为 {pole}。")
    return TableFigure("page", Text("the paper's lines, for the pole −30", "论文各行（极点 −30）"),
                       (Text("line", "行"), Text("printed", "论文所印"), Text("pole by itself", "由它得到的极点")),
                       tuple(rows), tab=STEPS_TAB, caption=caption)


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Everything on the right of the stage."""
    design, observer, run = outcome.design, outcome.study.observer, outcome.study.run
    return (_functional(outcome, run), _error(outcome, run), _input(run),
            *steps_figures(design["problem"], observer, int(design["step"]), design["line"]),
            _lights(outcome.checks), _singular(observer), _problems(design["problem"]),
            _forms(run), _fed(run, design["tau"]))


def _functional(outcome: Outcome[Study], run: Watch) -> TimeFigure:
    guess = run.estimates[:, form_index(outcome.design)]
    met = outcome.metrics["settled_after"]
    caption = (Text(f"After {met:.3f} s the error of ĝ stays below 2 % of what it was at first.",
                    f"{met:.3f} s 之后，ĝ 与 g 之差一直小于初始误差的 2 %。") if met <= HORIZON
               else Text("Within this run ĝ does not settle on g.", "在本次运行中，ĝ 没有收敛到 g。"))
    return TimeFigure("functional", Text("the number wanted, g = K x", "要监视的量 g = K x"), run.t,
                      (Curve(same("g"), run.g), Curve(same("ĝ"), guess, "estimate", "dash")), "g", window=(-10.0, 30.0),
                      tab=TIME_TAB, caption=caption)


def _error(outcome: Outcome[Study], run: Watch) -> TimeFigure:
    m = outcome.metrics
    pole = words(np.array([m["pole"]]), 2)
    if m["law_gap"] <= 1e-6:
        caption = Text(f"|ε| follows e^({pole}t) to within {m['law_gap']:.0e} of its peak, whatever u does.",
                       f"无论 u 怎样变化，|ε| 都按 e^({pole}t) 变化，相对峰值的偏差仅 {m['law_gap']:.0e}。")
    else:
        caption = Text(f"|ε| leaves the line e^({pole}t): in the last tenth of the run it is up to {m['late_error']:.2g}.",
                       f"|ε| 偏离了 e^({pole}t)：在运行的最后十分之一，它仍达 {m['late_error']:.2g}。")
    return TimeFigure("error", Text("error ε = ĝ − g", "误差 ε = ĝ − g"), run.t,
                      (Curve(same("|ε|"), np.abs(run.errors[:, form_index(outcome.design)]), "error"),
                       Curve(Text(f"e^({pole}t)", f"e^({pole}t)"), np.abs(run.law), "reference", "dash", 1.6)), "|ε|",
                      log=True, window=(1e-6, 10.0), tab=TIME_TAB, caption=caption)


def _input(run: Watch) -> TimeFigure:
    peak = float(np.max(np.abs(run.u)))
    return TimeFigure("input", Text("input u, which also multiplies the state", "输入 u，它还乘在状态上"), run.t,
                      (Curve(same("u"), run.u, "force"),), "u", window=(-1.0, 1.0), tab=TIME_TAB,
                      caption=Text(f"Largest |u|: {peak:.3g}.", f"|u| 的最大值：{peak:.3g}。"))


def _lights(checks: tuple[Check, ...]) -> TableFigure:
    lit = sum(c.holds for c in checks)
    return TableFigure("lights", Text("lights", "指示灯"), (Text("statement", "性质"), Text("holds", "成立")),
                       tuple((c.text, YES if c.holds else NO) for c in checks), tab=CASES_TAB,
                       caption=Text(f"{lit} of {len(checks)} are lit.", f"{len(checks)} 盏灯中亮了 {lit} 盏。"))


def _singular(o: BilinearObserver) -> TableFigure:
    tall = np.linalg.svd(np.vstack([o.Q, o.right]), compute_uv=False)
    wide, rows = o.canonical_Q.singular_values, len(o.Q)
    rank = int(np.sum(tall > 1e-9 * tall[0]))
    more = rank > o.canonical_Q.rank
    table = ((same("Q"), words(wide, 3), f"{o.canonical_Q.rank} / {rows}"),
             (Text("Q with the row V₂(FT₂ AT₃ FT₃)", "Q 加上一行 V₂(FT₂ AT₃ FT₃)"), words(tall, 3), f"{rank} / {rows + 1}"))
    caption = (Text(f"The row adds to the rank: no combination of the rows of Q is equal to it. What is left of (21) is "
                    f"{o.defect_size:.1e}, relative.",
                    f"加上这一行后秩增大：它不是 Q 各行的线性组合。(21) 的相对残差为 {o.defect_size:.1e}。") if more else
               Text(f"The row adds nothing to the rank, so (21) holds. Rows of Q to spare: {rows - o.canonical_Q.rank}.",
                    f"加上这一行后秩不变，(21) 成立；Q 富余的行数为 {rows - o.canonical_Q.rank}。"))
    return TableFigure("singular", Text("singular values", "奇异值"),
                       (Text("matrix", "矩阵"), Text("singular values", "奇异值"), Text("rank / rows", "秩 / 行数")), table,
                       tab=CASES_TAB, caption=caption)


@lru_cache(maxsize=8)
def _problems(chosen: str) -> TableFigure:
    rows = []
    for p in PROBLEMS.values():
        name = Text(f"▸ {p.label.en}", f"▸ {p.label.zh}") if p.id == chosen else p.label
        o = p.solved
        fate = (Text("no L", "没有 L") if o.case == 1 else Text("one L", "只有一个 L") if o.case == 2
                else Text("a family of L", "一族 L"))
        pole = (same("—") if o.case == 1 else Text("any", "任意") if o.case == 3 and o.controllable
                else same(words(o.reached.real, 2)))
        rows.append((name, str(o.case), fate, pole))
    return TableFigure("problems", Text("four problems on one plant", "同一对象的四个问题"),
                       (Text("problem", "问题"), Text("case", "情形"), Text("solutions", "解"), Text("pole", "极点")),
                       tuple(rows), tab=CASES_TAB, caption=Text(
                           "Fewer sensors, or others, and the same number may no longer be watched.",
                           "传感器少了，或换了位置，同一个量就未必还能监视。"))


def _forms(run: Watch) -> TimeFigure:
    late = np.max(np.abs(run.errors[len(run.t) // 2:]), axis=0)
    styles: tuple[tuple[str, Dash], ...] = (("error", "solid"), ("second", "dot"), ("disturbance", "dash"))
    curves = tuple(Curve(name, np.abs(size), *style)
                   for name, size, style in zip(FORM_NAMES, run.errors.T, styles, strict=True))
    return TimeFigure("forms", Text("|ε| of the three ways to run it", "三种实现的 |ε|"), run.t, curves, "|ε|", log=True,
                      window=(1e-6, 10.0), tab=FORMS_TAB, caption=Text(
                          f"In the second half of the run the error is up to {late[0]:.2g} without ẏ, {late[1]:.2g} with the "
                          f"true ẏ and {late[2]:.2g} with a differentiator.",
                          f"在运行的后一半，误差最多为：不用 ẏ {late[0]:.2g}，用真实的 ẏ {late[1]:.2g}，用微分器 {late[2]:.2g}。"))


def _fed(run: Watch, tau: float) -> TimeFigure:
    gap = float(np.max(np.abs(run.fed[:, 0] - run.fed[:, 1])))
    return TimeFigure("fed", Text("L ẏ, true and from the differentiator", "L ẏ：真实值与微分器的输出"), run.t,
                      (Curve(Text("true", "真实"), run.fed[:, 0], "second"),
                       Curve(Text("differentiator", "微分器"), run.fed[:, 1], "disturbance", "dash")), "L ẏ",
                      window=(-200.0, 200.0), tab=FORMS_TAB, caption=Text(
                          f"The differentiator lags by about {1000 * tau:.3g} ms and misses L ẏ by up to {gap:.3g}.",
                          f"微分器大约滞后 {1000 * tau:.3g} ms，L ẏ 的偏差最多达 {gap:.3g}。"))
