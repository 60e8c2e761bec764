"""Figures of the lesson: ranks, the staircase and its error, the motions, the two regulators."""

from __future__ import annotations

import re

import numpy as np

from app.lesson.figures import Curve, Figure, FrequencyFigure, MatrixFigure, PlaneFigure, Point, TableFigure
from app.lesson.lesson import Outcome
from app.text.words import Text, same

from .body import share
from .regulator import PAIRS
from .study import RELATIVE, REPORT, Study
from .system import STATES, SUBSCRIPTS, closed_forms, relative, sigmas

RANK_TAB, HANKEL_TAB = Text("Rank", "秩"), Text("Hankel values", "Hankel 奇异值")
MOTION_TAB, LQG_TAB = Text("Motions", "运动"), Text("LQG", "LQG")
NOTHING_CUT = Text("All ten states are kept: there is only one design. Keep fewer and compare.",
                   "十个状态全部保留，只有一种设计；减少保留的状态再比较。")
LEAST = 1e-11  # drawn in place of zero on a logarithmic axis
TOLERANCES = np.linspace(-18.0, 0.0, 145)  # log₁₀


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Everything on the right of the stage."""
    return (_sizes(outcome), _ranks(outcome), _staircase(outcome), _error(outcome), _forms(outcome), _motions(outcome),
            _shapes(outcome), _spectrum(outcome), _gains(outcome), _costs(outcome))


def show(value: float, digits: int = 3) -> str:
    """A number for a table, with a true minus sign and a short exponent."""
    return re.sub(r"e([+-])0", r"e\1", f"{value:.{digits}g}").replace("e+", "e").replace("-", "−")


# --- rank --------------------------------------------------------------------------------------------------------------
def _sizes(outcome: Outcome[Study]) -> PlaneFigure:
    r, d = outcome.study.ranks, outcome.design
    against = d["measure"] == RELATIVE
    reached, seen = (np.log10(np.maximum(v / v[0] if against else v, 1e-40)) for v in (r.reached, r.seen))
    index, level = np.arange(1.0, STATES + 1), np.log10(d["tolerance"])
    line = Curve(Text("tolerance", "容差"), np.full(2, level), "reference", "dash", 1.6, np.array([0.5, STATES + 0.5]))
    curves = (Curve(Text("controllability", "能控性矩阵"), reached, "force", x=index),
              Curve(Text("observability", "能观性矩阵"), seen, "estimate", "dash", x=index), line)
    points = [Point(float(k), float(v), role, "dot" if v > level else "circle")
              for values, role in ((reached, "force"), (seen, "estimate")) for k, v in zip(index, values, strict=True)]
    low, high = min(reached[-1], seen[-1], level), max(reached[0], seen[0], level)
    return PlaneFigure(
        "sizes", Text("singular values of both matrices", "两个矩阵的奇异值"), curves, tuple(points), "k",
        "log₁₀(σ/σ₁)" if against else "log₁₀ σ", (0.5, STATES + 0.5), (float(low - 1), float(high + 1)),
        tab=RANK_TAB,
        caption=Text(f"Time in units of {show(r.clock)} s: smallest over largest {show(r.reached[-1] / r.reached[0], 2)} and "
                     f"{show(r.seen[-1] / r.seen[0], 2)}.",
                     f"时间以 {show(r.clock)} s 为单位：最小与最大奇异值之比为 {show(r.reached[-1] / r.reached[0], 2)} 与 "
                     f"{show(r.seen[-1] / r.seen[0], 2)}。"))


def _ranks(outcome: Outcome[Study]) -> PlaneFigure:
    r, d = outcome.study.ranks, outcome.design
    steps = np.array([r.at(10.0**level, d["measure"]) for level in TOLERANCES], dtype=float)
    first, last = np.log10(REPORT)
    now = r.at(d["tolerance"], d["measure"])
    curves = [Curve(Text("controllability", "能控性矩阵"), steps[:, 0], "force", x=TOLERANCES),
              Curve(Text("observability", "能观性矩阵"), steps[:, 1], "estimate", "dash", x=TOLERANCES)]
    curves.append(Curve(Text("the report's range", "报告的范围"), np.array([0.0, 10.5, 10.5, 0.0]), "muted", "dot", 1.6,
                        np.array([first, first, last, last])))
    points = [Point(float(np.log10(d["tolerance"])), float(rank), role, "circle")
              for rank, role in zip(now, ("force", "estimate"), strict=True)]
    return PlaneFigure(
        "ranks", Text("rank against tolerance", "秩随容差的变化"), tuple(curves), tuple(points),
        "log₁₀ τ", "rank", (-18.0, 0.0), (0.0, 11.5), tab=RANK_TAB,
        caption=Text(f"At this tolerance: rank {now[0]} of controllability, {now[1]} of observability, of {STATES}.",
                     f"在此容差下：能控性矩阵的秩为 {now[0]}，能观性矩阵的秩为 {now[1]}（共 {STATES}）。"))


# --- Hankel ------------------------------------------------------------------------------------------------------------
def _bars(positions: np.ndarray, levels: np.ndarray, floor: float, half: float) -> tuple[np.ndarray, np.ndarray]:
    """One line that goes up and down around every bar."""
    x = (positions[:, None] + half * np.array([-1.0, -1.0, 1.0, 1.0])).ravel()
    y = np.stack([np.full(len(levels), floor), levels, levels, np.full(len(levels), floor)], axis=1).ravel()
    return x, y


def _staircase(outcome: Outcome[Study]) -> PlaneFigure:
    s, order = outcome.study.system, int(outcome.design["order"])
    values, floor = np.log10(np.maximum(s.hankel, 1e-12)), -10.0
    index = np.arange(1.0, STATES + 1)
    curves = []
    for name, role, part in ((Text("kept", "保留"), "plant", slice(0, order)), (Text("cut", "截去"), "muted", slice(order, None))):
        if len(values[part]):
            x, y = _bars(index[part], values[part], floor, 0.33)
            curves.append(Curve(name, y, role, x=x, width=2.6))
    pair = int(outcome.design["pair"]) - 1
    points = [Point(float(index[k]), float(values[k]), "error", "dot") for k in (2 * pair, 2 * pair + 1)]
    ratio = s.hankel[:-1] / s.hankel[1:]
    widest = int(np.argmax(ratio))
    after = same("") if widest == 7 else Text(f"; after 8 it is {ratio[7]:.0f}", f"；第 8 个之后为 {ratio[7]:.0f} 倍")
    return PlaneFigure(
        "staircase", Text("Hankel singular values", "Hankel 奇异值"), tuple(curves), tuple(points), "i", "log₁₀ σ",
        (0.3, STATES + 0.7), (floor, 4.0), tab=HANKEL_TAB,
        caption=Text(f"The widest gap, a factor of {ratio[widest]:.0f}, lies after {widest + 1}{after.en}. Dots: the pair on the stage.",
                     f"最大的落差在第 {widest + 1} 个之后，为 {ratio[widest]:.0f} 倍{after.zh}。圆点：场景中的那一对。"))


def _error(outcome: Outcome[Study]) -> FrequencyFigure:
    c, s = outcome.study.cut, outcome.study.system
    bound = max(c.bound, LEAST)
    said = (Text("Nothing is cut: no error.", "没有截去任何状态：误差为零。") if c.order == STATES else
            Text(f"Largest error {show(c.peak, 4)} at {show(c.where, 3)} Hz; the bound 2Σσ promises {show(c.bound, 4)}.",
                 f"最大误差 {show(c.peak, 4)}，出现在 {show(c.where, 3)} Hz；误差界 2Σσ 为 {show(c.bound, 4)}。"))
    size = np.sqrt(np.linalg.eigvalsh(s.response @ np.swapaxes(s.response.conj(), 1, 2))[:, -1])
    return FrequencyFigure(
        "error", Text("what the model leaves out: σ_max(G − G_r)", "模型漏掉的部分：σ_max(G − G_r)"),
        s.frequencies,
        (Curve(Text("whole plant", "整个对象"), size, "muted", width=1.4),
         Curve(Text("error", "误差"), np.maximum(c.error, LEAST), "error"),
         Curve(Text("bound 2Σσ", "误差界 2Σσ"), np.full(len(s.frequencies), bound), "reference", "dash", 1.6)),
        "σ_max", tab=HANKEL_TAB, window=(1e-8, 1e4), caption=said)


def _forms(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study.system
    rows = tuple((f"σ{k + 1}".translate(SUBSCRIPTS), words, show(s.hankel[k], 4), show(value, 4))
                 for (k, value), words in zip(closed_forms(s.parameters), (
                     "kz/(√2 cz)", "2√2 kz μ²/(m² cp)", "√2 kx h μ² s² √(s²+h²)/(J² cp)"), strict=True))
    return TableFigure(
        "forms", Text("three values from the geometry", "由几何参数直接得到的三个值"),
        (same("σ"), Text("closed form", "闭式"), Text("exact", "精确值"), Text("form", "闭式值")), rows, tab=HANKEL_TAB,
        caption=Text("The stiffness kp of the servo is in none of them.", "伺服刚度 kp 不出现在任何一式中。"))


# --- motions -----------------------------------------------------------------------------------------------------------
def _motions(outcome: Outcome[Study]) -> TableFigure:
    s, order, pair = outcome.study.system, int(outcome.design["order"]), int(outcome.design["pair"]) - 1
    rows = []
    for k, motion in enumerate(s.motions):
        held = share(s, motion, order)
        word = Text("yes", "是") if held > 0.9 else Text("no", "否") if held < 0.1 else Text("in part", "部分")
        mark = "▶\N{NO-BREAK SPACE}" if k == pair else ""
        rows.append((mark + sigmas(k), motion.name, f"{motion.frequency:.3g}", f"{100 * motion.damping:.2f}",
                     show(motion.strength), show(s.hankel[2 * k]), word))
    return TableFigure(
        "motions", Text("five motions, ten states", "五种运动，十个状态"),
        (Text("pair", "对"), Text("motion", "运动"), same("Hz"), same("ζ %"), same("≈ σ"), same("σ"), Text("held", "保留")),
        tuple(rows), tab=MOTION_TAB,
        caption=Text("≈ σ: strength of the mode, ‖Cv‖ ‖wᴴB‖ / 2|Re λ|, from its eigenvectors alone.",
                     "≈ σ：只由特征向量算出的模态强度 ‖Cv‖ ‖wᴴB‖ / 2|Re λ|。"))


def _shapes(outcome: Outcome[Study]) -> MatrixFigure:
    s = outcome.study.system
    shapes = np.stack([np.abs(relative(s.parameters, m.shape)) for m in s.motions], axis=1)
    shapes[2] *= s.parameters.s
    shapes = shapes / shapes.max(axis=0)
    pair = int(outcome.design["pair"]) - 1
    return MatrixFigure(
        "shapes", Text("what moves in each pair", "每一对中什么在动"), shapes, ("x", "z", "s θ", "p_L", "p_R"),
        tuple(("▶ " if k == pair else "") + sigmas(k) for k in range(PAIRS)), (3,), tab=MOTION_TAB,
        caption=Text(f"A column a pair, {sigmas(0)} first: amplitudes, the largest 1; p_L and p_R as seen from their sensors.",
                     f"每列一对，{sigmas(0)} 在最左：振幅，最大者为 1；p_L、p_R 为相对各自传感器的位移。"))


# --- LQG ---------------------------------------------------------------------------------------------------------------
def _spectrum(outcome: Outcome[Study]) -> FrequencyFigure:
    c, f = outcome.study.compared, outcome.study.system.frequencies
    order = outcome.study.cut.order
    curves = [Curve(Text("without control", "无控制"), 1e12 * c.free[:, 0], "muted", width=1.4)]
    if c.full.densities is not None:
        curves.append(Curve(Text("LQG on 10 states", "基于 10 个状态的 LQG"), 1e12 * c.full.densities[:, 0], "plant"))
    if c.small.densities is not None and order < STATES:
        curves.append(Curve(Text(f"LQG on {order}", f"基于 {order} 个状态的 LQG"), 1e12 * c.small.densities[:, 0], "estimate", "dash"))
    said = (NOTHING_CUT if order == STATES else
            Text(f"The two loops differ by {show(100 * c.gap, 2)} % at most, in any output and at any frequency.",
                 f"两个闭环在任何输出、任何频率上最多相差 {show(100 * c.gap, 2)} %。") if c.gap is not None else
            Text(f"The loop with {order} states is unstable on the platform: rightmost pole {show(c.small.rightmost, 2)}.",
                 f"基于 {order} 个状态的控制器使平台失稳：最右极点的实部为 {show(c.small.rightmost, 2)}。"))
    return FrequencyFigure("spectrum", Text("velocity VL under ground noise", "地面噪声下的速度 VL"), f,
                           tuple(Curve(k.name, np.maximum(k.y, LEAST), k.role, k.dash, k.width) for k in curves),
                           "[(µm/s)²/Hz]", tab=LQG_TAB, window=(1e-6, 1e6), caption=said)


def _gains(outcome: Outcome[Study]) -> PlaneFigure:
    c, order = outcome.study.compared, outcome.study.cut.order
    index = np.arange(1.0, PAIRS + 1)
    curves, lowest = [], -10.0
    bars = ((c.full.K, Text("K on 10 states", "10 个状态的 K"), "plant", -0.3),
            (c.small.K, Text(f"K on {order}", f"{order} 个状态的 K"), "estimate", -0.1),
            (c.full.L, Text("L on 10 states", "10 个状态的 L"), "second", 0.1),
            (c.small.L, Text(f"L on {order}", f"{order} 个状态的 L"), "disturbance", 0.3))
    for K, name, role, offset in bars if order < STATES else bars[::2]:
        some = K > 0
        x, y = _bars(index[some] + offset, np.log10(np.maximum(K[some], 1e-10)), lowest, 0.09)
        curves.append(Curve(name, y, role, x=x, width=2.2))
    return PlaneFigure(
        "gains", Text("gains on the k-th pair of balanced states", "第 k 对平衡状态上的增益"), tuple(curves), (), "k",
        "log₁₀ ‖·‖", (0.4, PAIRS + 0.6), (lowest, 10.0), tab=LQG_TAB,
        caption=NOTHING_CUT if order == STATES else
        Text(f"On 10 states ‖K‖ is {show(100 * c.growth, 2)} % larger than on {order}; the last pair's share of it is "
             f"{show(float(c.full.K[-1] / np.linalg.norm(c.full.K)), 2)}.",
             f"10 个状态时 K 的范数比 {order} 个状态时大 {show(100 * c.growth, 2)} %；最后一对在其中占 "
             f"{show(float(c.full.K[-1] / np.linalg.norm(c.full.K)), 2)}。"))


def _costs(outcome: Outcome[Study]) -> TableFigure:
    c, order = outcome.study.compared, outcome.study.cut.order

    def cell(value: float | None, digits: int = 5) -> str:
        return "—" if value is None else show(value, digits)

    rows = ((Text("cost on the platform", "在平台上的代价"), cell(c.full.cost), cell(c.small.cost)),
            (Text("force, rms [N]", "力的均方根 [N]"), cell(c.full.force), cell(c.small.force)),
            (Text("rightmost pole [rad/s]", "最右极点 [rad/s]"), cell(c.full.rightmost, 3), cell(c.small.rightmost, 3)))
    said = (NOTHING_CUT if order == STATES else
            Text("An unstable loop has no average cost.", "不稳定的闭环没有平均代价。") if c.extra is None else
            Text("Leaving the states out costs nothing that one could measure.", "舍去这些状态，代价没有可察觉的增加。")
            if c.extra < 1e-7 else
            Text(f"Leaving states out costs {show(100 * c.extra, 2)} % more.", f"舍去状态使代价增加 {show(100 * c.extra, 2)} %。"))
    return TableFigure("costs", Text("two designs on ten states", "两种设计用于十状态平台"),
                       (Text("design on", "设计模型"), Text("10 states", "10 个状态"), Text(f"{order} states", f"{order} 个状态")),
                       rows, tab=LQG_TAB, caption=said)
