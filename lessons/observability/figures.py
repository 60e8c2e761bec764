"""The figures of lesson 3: O and its rank, the rebuilt start, the shrinking ellipse, distances and criteria."""

from __future__ import annotations

import numpy as np

from app.engine.structure import Mode
from app.lesson.figures import Curve, Figure, MatrixFigure, PlaneFigure, Point, TableFigure, TimeFigure
from app.lesson.lesson import Outcome
from app.text.words import Text, same

from ..toolkit.latex import pole_words
from .cases import label, shown, unit
from .criteria import DET
from .knowledge import REACH
from .study import NEAR, Study
from .sweep import LOWEST, Sweep, decades

MATRIX_TAB, CLOUD_TAB, MODES_TAB = Text("Matrix", "矩阵"), Text("Ellipsoid", "椭球"), Text("Modes", "模态")
CIRCLE = np.linspace(0.0, 2 * np.pi, 73)
HIDDEN = -10.0  # decades: distances at or below are rounding
SHARES = (0.0, 0.04, 0.15, 0.4, 1.0)  # of the run: when the ellipse is drawn
MOST_STATES = 8  # rows of the table of states
YES, NO, MUTE = Text("yes", "是"), Text("no", "否"), Text("says nothing", "无从谈起")


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Everything on the right of the stage."""
    found, design = outcome.study, outcome.design
    return (_matrix(found), _sizes(found, design["tolerance"]), _start(found),
            _ellipses(found), _halves(found), _energy(found),
            _modes(found), *(() if found.sweep is None else (_sweep(found.sweep, found),)), _criteria(found, design["criterion"]))


def _matrix(found: Study) -> MatrixFigure:
    built, plant = found.rebuilt, found.sensed.plant
    names = tuple(("C" if k == 0 else "CA" if k == 1 else f"CA^{k}") for k in range(built.rows) for _ in range(plant.p))
    return MatrixFigure(
        "matrix", Text("observability matrix, row by row", "能观性矩阵，逐行构造"), built.matrix, names,
        tuple(label(found.case, i) for i in range(plant.n)), tab=MATRIX_TAB,
        caption=Text(f"{built.rows} of {plant.n} block rows built: rank {built.rank} of {plant.n} at this tolerance.",
                     f"已构造 {built.rows}/{plant.n} 个块行：在此容差下秩为 {built.rank}/{plant.n}。"))


def _sizes(found: Study, rtol: float) -> PlaneFigure:
    built, n = found.rebuilt, found.sensed.plant.n
    top = built.sizes[0] if built.sizes[0] > 0 else 1.0
    levels = decades(built.sizes / top)
    points = tuple(Point(k + 1.0, float(d), "plant" if k < built.rank else "muted", "dot" if k < built.rank else "cross")
                   for k, d in enumerate(levels))
    line = Curve(Text("tolerance τ", "容差 τ"), np.full(2, np.log10(rtol)), "reference", "dash", 1.6, np.array([0.5, n + 0.5]))
    lost = len(levels) - built.rank
    caption = (Text(f"{lost} of {len(levels)} count as zero; the smallest is {10 ** levels[-1]:.1g} times the largest.",
                    f"{len(levels)} 个中有 {lost} 个按零计；最小的是最大的 {10 ** levels[-1]:.1g} 倍。")
               if built.sizes[0] > 0 else Text("No sensor is on: O is zero.", "没有开启任何传感器：O 为零。"))
    return PlaneFigure(
        "sizes", Text("singular values of O, log₁₀(σ/σ₁)", "O 的奇异值 log₁₀(σ/σ₁)"), (line,), points, "k", "log₁₀(σ/σ₁)",
        (0.5, n + 0.5), (LOWEST - 0.5, 0.5), tab=MATRIX_TAB, caption=caption)


def _value(value: float) -> str:
    return f"{value:.4g}".replace("-", "−")


def _start(found: Study) -> TableFigure:
    case, built, n = found.case, found.rebuilt, found.sensed.plant.n
    every = tuple(range(n))
    true, guess = shown(case, found.start, every), shown(case, built.guess, every)
    table = tuple((unit(case, i), _value(true[i]), _value(guess[i]),
                   Text("fixed", "已定") if built.share[i] > 1 - 1e-6 else
                   Text("not yet", "未定") if built.share[i] < 1e-6 else Text("partly", "部分"))
                  for i in every[:MOST_STATES])
    gap = float(np.linalg.norm(built.guess - found.start) / np.linalg.norm(found.start))
    left = n - built.rank
    return TableFigure(
        "start", Text("x(0) from y and its derivatives", "由 y 及其导数重构 x(0)"),
        (Text("state", "状态"), Text("true", "真实"), Text("rebuilt", "重构"), Text("by these rows", "由这些行")), table,
        tab=MATRIX_TAB,
        caption=Text(f"Directions of x(0) still open: {left}. The rebuilt start is off by {gap:.2g} of its size.",
                     f"x(0) 还有 {left} 个方向未定；重构的初态偏差为其大小的 {gap:.2g} 倍。"))


def _ellipses(found: Study) -> PlaneFigure:
    case, s, belief = found.case, found.sensed, found.belief
    pair = case.pair
    curves, last = [], len(s.t) - 1
    for share in SHARES:
        k = round(share * last)
        values, axes = np.linalg.eigh(belief.P[k][np.ix_(pair, pair)])
        ring = REACH[1] * (axes * np.sqrt(np.maximum(values, 0.0))) @ np.array([np.cos(CIRCLE), np.sin(CIRCLE)])
        drawn = shown(case, ring.T + belief.mean[k, list(pair)], pair)
        final = share == SHARES[-1]
        curves.append(Curve(same(f"t = {s.t[k]:.2g} s"), drawn[:, 1], "estimate" if final else "second",
                            "solid" if final else "dash" if share else "dot", 2.6 if final else 1.6, drawn[:, 0]))
    half = shown(case, np.full(2, 3.4), pair)
    true = shown(case, found.start[list(pair)], pair)
    drop = belief.halves[-1]
    return PlaneFigure(
        "ellipses", Text("states that the data allow (95 %)", "数据所允许的状态（95 %）"), tuple(curves),
        (Point(float(true[0]), float(true[1]), "plant", "cross", Text("true x(0)", "真实 x(0)")),),
        unit(case, pair[0]), unit(case, pair[1]), (-float(half[0]), float(half[0])), (-float(half[1]), float(half[1])),
        tab=CLOUD_TAB,
        caption=Text(f"After {s.t[-1]:.2g} s the longest half axis of the whole ellipsoid is {drop[0]:.2g} of its start, "
                     f"the shortest {drop[-1]:.2g}.",
                     f"{s.t[-1]:.2g} s 之后，整个椭球最长的半轴为起初的 {drop[0]:.2g}，最短的为 {drop[-1]:.2g}。"))


def _halves(found: Study) -> TimeFigure:
    s, halves = found.sensed, found.belief.halves
    n = s.plant.n
    kept = np.unique(np.linspace(0, n - 1, min(n, 6)).round().astype(int))
    roles = ("estimate", "error", "disturbance", "force", "second", "plant")
    curves = tuple(Curve(Text(f"axis {i + 1}", f"第 {i + 1} 轴"), halves[:, i], role)
                   for i, role in zip(kept, roles, strict=False))
    return TimeFigure(
        "halves", Text("half axes of the ellipsoid, start = 1", "椭球的半轴（起初为 1）"), s.t, curves,
        "σ(t) / σ(0)", log=True, window=(1e-3, 1.0),
        tab=CLOUD_TAB,
        caption=Text(f"{found.belief.known} of {n} axes have shrunk to a tenth. An axis that stays at 1 was not heard at all.",
                     f"{n} 根半轴中有 {found.belief.known} 根缩到十分之一；停在 1 的半轴完全没有被听到。"))


def _energy(found: Study) -> TimeFigure:
    s = found.sensed
    least, most = s.heard[:, 0], s.heard[:, -1]
    return TimeFigure(
        "energy", Text("eigenvalues of the Gramian W(t)", "Gram 矩阵 W(t) 的特征值"), s.t,
        (Curve(Text("largest", "最大"), most, "plant"), Curve(Text("smallest", "最小"), least, "error", "dash")), "λ(W)",
        log=True, window=(1e-6, 1.0), tab=CLOUD_TAB,
        caption=Text(f"At the end: largest {most[-1]:.2g}, smallest {least[-1]:.1g}. "
                     "W(t) > 0 is what “y determines x(0)” means.",
                     f"末时刻：最大 {most[-1]:.2g}，最小 {least[-1]:.1g}。W(t) > 0 正是“y 确定 x(0)”的含义。"))


def _bar(mode: Mode) -> str:
    return f"{mode.distance:.2g} " + "▮" * max(1, round(6 + 1.5 * np.log10(max(mode.distance, 1e-9))))


def _modes(found: Study) -> TableFigure:
    table, counts = [], {"hidden": 0, "near": 0}
    for mode in found.sensed.seen.modes:
        if mode.pole.imag < -1e-9:
            continue
        word = (Text("hidden", "隐藏") if not mode.visible else Text("nearly hidden", "几乎隐藏") if mode.distance < NEAR
                else Text("seen", "可见"))
        counts["hidden"] += not mode.visible
        counts["near"] += mode.visible and mode.distance < NEAR
        table.append((pole_words([complex(mode.pole.real, abs(mode.pole.imag))]),
                      _bar(mode) if mode.visible else "0", word))
    n = found.sensed.plant.n
    return TableFigure(
        "modes", Text("distance of each mode from being hidden (PBH, typical sizes)", "各模态离“隐藏”的距离（PBH，以典型大小计）"),
        (Text("mode", "模态"), Text("distance", "距离"), Text("verdict", "结论")), tuple(table), tab=MODES_TAB,
        caption=Text(f"Modes hidden: {counts['hidden']}, nearly hidden: {counts['near']}; meanwhile rank(O) = {found.rank} of {n}.",
                     f"隐藏 {counts['hidden']} 个，几乎隐藏 {counts['near']} 个；而 rank(O) = {found.rank}/{n}。"))


def _sweep(sweep: Sweep, found: Study) -> PlaneFigure:
    now = float(decades(np.array([found.weakest.distance]))[0])
    best = float(sweep.along[np.argmax(sweep.distance)])
    words = (f"{10**best:.2g}" if sweep.log else f"{best:.3g}").replace("-", "−")
    return PlaneFigure(
        "sweep", Text("one knob moved, all else kept", "只动一个旋钮"),
        (Curve(Text("weakest mode, log₁₀", "最弱模态 log₁₀"), sweep.distance, "plant", "solid", 2.4, sweep.along),
         Curve(Text("σ_min/σ_max(O), log₁₀", "O 的 σ_min/σ_max，log₁₀"), sweep.ratio, "second", "dash", 1.8, sweep.along)),
        (Point(sweep.at, now, "reference", "circle", Text("now", "现在")),), sweep.label, "log₁₀",
        (float(sweep.along.min()), float(sweep.along.max())), (LOWEST - 0.5, 1.0), tab=MODES_TAB,
        caption=Text(f"The weakest mode is farthest from hidden at {words}. "
                     "The curve of O is another matter: it depends on the unit of time.",
                     f"最弱模态在 {words} 处离隐藏最远。O 的曲线是另一回事：它随时间单位而变。")
        if np.max(sweep.distance) > HIDDEN else
        Text("Some mode stays hidden wherever this knob stands.", "不论这个旋钮在哪里，总有模态是隐藏的。"))


def _criteria(found: Study, chosen: str) -> TableFigure:
    table = tuple((Text(f"{'▶ ' if c.id == chosen else ''}{c.text.en}", f"{'▶ ' if c.id == chosen else ''}{c.text.zh}"),
                   c.number, MUTE if c.says is None else YES if c.says else NO) for c in found.criteria)
    pick = next(c for c in found.criteria if c.id == chosen)
    caption = (Text(f"C e^(At) is {pick.number}: it has no determinant, whatever the plant.",
                    f"C e^(At) 是 {pick.number} 矩阵：不论对象如何，它都没有行列式。") if pick.id == DET else
               Text(f"{pick.number} is below rounding: in double precision this sentence cannot tell.",
                    f"{pick.number}，已低于舍入误差：在双精度下这句话无法判断。") if pick.says is None else
               Text(f"The chosen sentence rests on {pick.number} and says {'yes' if pick.says else 'no'}.",
                    f"所选判据依据 {pick.number}，结论为“{'是' if pick.says else '否'}”。"))
    return TableFigure("criteria", Text("four sentences on trial", "四句话的检验"),
                       (Text("observable if", "能观的条件"), Text("number", "数值"), Text("says", "结论")), table,
                       tab=MODES_TAB, caption=caption)
