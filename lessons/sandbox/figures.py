"""Figures of the sandbox; where an analysis does not apply, its figure stays, empty, with the sentence why."""

from __future__ import annotations

from itertools import accumulate
from typing import TypeVar

import numpy as np

from app.engine import autonomous_error
from app.engine.design import typical_rate
from app.engine.simulation import Run
from app.engine.structure import Controllability, Mode, Observability
from app.lesson.figures import Curve, Figure, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure
from app.lesson.lesson import Outcome
from app.plants import Model
from app.text.words import Text, same

from ..toolkit.figures import error_figure, input_figure, state_figures
from ..toolkit.latex import pole_words
from .analyses import Refusal, Structure
from .loop_figures import (
    LOWEST,
    STRUCTURE_TAB,
    VERDICT_TAB,
    blocks,
    certificate_table,
    decades,
    empty_plane,
    gain_figure,
    margin_table,
    nis_figure,
    recovery_plane,
    sensitivity_figure,
    spectrum,
    valley,
    why,
)
from .study import STEPS, Study, frequencies, verdicts


def figures(model: Model, outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Verdicts; structure; the run; loop; noise; robustness."""
    study, run, design, plant = outcome.study, outcome.run, outcome.design, model.plant
    assert run is not None
    limit = design["u_max"] if design["limited"] else None
    rows = verdicts(study.structure, study.loop, study.meter, limit is not None, study.noise, study.trial, study.margins)
    return (
        lights(rows), modes_table(study.structure),
        *time_figures(model, run, limit),
        sizes_plane(study.structure, design["tolerance"]), decomposition_map(study.structure, plant.n),
        hankel_plane(study.structure),
        spectrum(study.loop, plant.dt), blocks(study.loop, plant),
        certificate_table(study.certificates),
        valley(study.noise, design["belief"]), nis_figure(study.trial, plant.p), gain_figure(study.trial),
        sensitivity_figure(study.margins, study.recovered, frequencies(plant_rate=typical_rate(plant), dt=plant.dt)),
        margin_table(study.margins, plant), recovery_plane(study.steps, len(STEPS), study.refused))


MOST_MODES = 10  # rows of the table of modes
YES, NO, MUTE = Text("● yes", "● 是"), Text("○ no", "○ 否"), Text("— not here", "— 不适用")
T = TypeVar("T")


# --- verdicts ----------------------------------------------------------------------------------------------------------
def lights(rows: tuple[tuple[Text, bool | None, Text], ...]) -> TableFigure:
    """Every analysis with its light and what it rests on."""
    lit, dark = (sum(row[1] is value for row in rows) for value in (True, False))
    return TableFigure(
        "lights", Text("what can be said of this plant and loop", "关于该对象与闭环的结论"),
        (Text("question", "问题"), Text("verdict", "结论"), Text("rests on", "依据")),
        tuple((name, MUTE if holds is None else YES if holds else NO, said) for name, holds, said in rows), tab=VERDICT_TAB,
        caption=Text(f"{lit} yes, {dark} no, {len(rows) - lit - dark} without an answer here.",
                     f"{lit} 项为是，{dark} 项为否，{len(rows) - lit - dark} 项不适用。"))


def modes_table(found: Structure) -> TableFigure:
    """Each mode with its distances to being hidden from y and out of reach of u, the weakest first."""
    title = Text("modes, and how far from hidden (PBH, units divided out)", "各模态及其离“隐藏”的距离（PBH，已除去单位）")
    heads = (Text("mode", "模态"), Text("by itself", "自由运动"), Text("seen by y", "输出可见"), Text("reached by u", "输入可达"))
    for report in (found.seen, found.reached):
        if isinstance(report, Refusal):
            return TableFigure("modes", title, heads, ((same("—"), same("—"), same("—"), same("—")),), why(report), VERDICT_TAB)
    assert isinstance(found.seen, Observability) and isinstance(found.reached, Controllability)
    pairs = [(a, b) for a, b in _paired(found.seen.modes, found.reached.modes) if a.pole.imag >= -1e-12 * abs(a.pole)]
    pairs.sort(key=lambda pair: min(p.margin if p.visible else -1.0 for p in pair))
    rows = tuple((pole_words([complex(a.pole.real, abs(a.pole.imag))]), Text("settles", "衰减") if a.stable else
                  Text("does not settle", "不衰减"), _bar(a), _bar(b)) for a, b in pairs[:MOST_MODES])
    left = len(pairs) - len(rows)
    more = Text(f" The {left} others are farther from hidden.", f" 其余 {left} 个离隐藏更远。") if left > 0 else Text("", "")
    hidden, fixed = len(found.seen.unobservable), len(found.reached.uncontrollable)
    return TableFigure("modes", title, heads, rows, tab=VERDICT_TAB, caption=Text(
        f"Hidden from y: {hidden}. Out of reach of u: {fixed}.{more.en}", f"对 y 隐藏：{hidden} 个；对 u 不能控：{fixed} 个。{more.zh}"))


def _paired(seen: tuple[Mode, ...], reached: tuple[Mode, ...]) -> list[tuple[Mode, Mode]]:
    left, out = list(reached), []
    for mode in seen:
        twin = min(left, key=lambda other: abs(other.pole - mode.pole))
        left.remove(twin)
        out.append((mode, twin))
    return out


def _bar(mode: Mode) -> str:
    if not mode.visible:
        return "0"
    return f"{mode.distance:.2g} " + "▮" * max(1, round(6 + np.log10(max(mode.margin, 1e-6))))


# --- structure ---------------------------------------------------------------------------------------------------------
def sizes_plane(found: Structure, rtol: float) -> PlaneFigure:
    """Singular values of O and of the controllability matrix against the tolerance."""
    title = Text("singular values of O and [B, AB, …], log₁₀(σ/σ₁)", "O 与 [B, AB, …] 的奇异值 log₁₀(σ/σ₁)")
    points, said = [], []
    for report, role, mark in ((found.seen, "estimate", "dot"), (found.reached, "plant", "cross")):
        if isinstance(report, Refusal):
            return empty_plane("sizes", title, STRUCTURE_TAB, why(report))
        values = report.singular_values
        levels = decades(values / values[0]) if values[0] > 0 else np.full(len(values), LOWEST)
        points += [Point(k + 1.0, float(v), role, mark) for k, v in enumerate(levels)]  # type: ignore[arg-type]
        rank = report.matrix_rank(rtol) if values[0] > 0 else 0
        said.append((rank, report.rank))
    n = len(said) and found.seen.matrix.shape[1]  # type: ignore[union-attr]
    line = Curve(Text("tolerance τ", "容差 τ"), np.full(2, np.log10(rtol)), "reference", "dash", 1.6, np.array([0.5, n + 0.5]))
    (o, o_true), (c, c_true) = said
    return PlaneFigure("sizes", title, (line,), tuple(points), "k", "log₁₀(σ/σ₁)", (0.5, n + 0.5), (LOWEST - 0.5, 0.5), tab=STRUCTURE_TAB,
                       caption=Text(f"At this tolerance rank(O) = {o} (dots) and rank[B, AB, …] = {c} (crosses) of {n}; the staircase "
                                    f"finds {o_true} and {c_true}.",
                                    f"在此容差下 O 的秩为 {o}（圆点），[B, AB, …] 的秩为 {c}（叉号），n = {n}；"
                                    f"阶梯算法得 {o_true} 与 {c_true}。"))


def decomposition_map(found: Structure, plant_states: int) -> MatrixFigure:
    """Kalman decomposition as a heat map with its blocks."""
    d, title = found.decomposition, Text("Kalman decomposition", "卡尔曼分解")
    if isinstance(d, Refusal):
        return MatrixFigure("decomposed", title, np.zeros((1, 1)), caption=why(d), tab=STRUCTURE_TAB)
    whole = np.block([[d.A, d.B], [d.C, np.zeros((len(d.C), d.B.shape[1]))]])
    edges = tuple(k for k in accumulate(d.sizes) if 0 < k < plant_states)
    both, reached, seen, neither = d.sizes
    rows = (*(f"z{i + 1}" for i in range(plant_states)), *(f"y{i + 1}" for i in range(len(d.C))))
    columns = (*(f"z{i + 1}" for i in range(plant_states)), *(f"u{i + 1}" for i in range(d.B.shape[1])))
    return MatrixFigure("decomposed", title, whole, rows, columns, (*edges, plant_states), tab=STRUCTURE_TAB, caption=Text(
        f"Reached and seen: {both}; reached only: {reached}; seen only: {seen}; neither: {neither}. From u to y only the first "
        "block acts.",
        f"既可达又可见：{both}；只可达：{reached}；只可见：{seen}；两者皆否：{neither}。从 u 到 y 只有第一块起作用。"))


def hankel_plane(found: Structure) -> PlaneFigure:
    """Hankel singular values of the stable part."""
    values, title = found.hankel, Text("Hankel singular values, log₁₀(σ/σ₁)", "Hankel 奇异值 log₁₀(σ/σ₁)")
    if isinstance(values, Refusal):
        return empty_plane("hankel", title, STRUCTURE_TAB, why(values))
    levels = decades(values / values[0]) if values[0] > 0 else np.full(len(values), LOWEST)
    strong = int(np.count_nonzero(levels > -2))
    aside = (Text(f" Unstable states, set aside first: {found.kept}.", f" 先分出了 {found.kept} 个不稳定状态。")
             if found.kept else Text("", ""))
    return PlaneFigure("hankel", title, (), tuple(Point(k + 1.0, float(v), "plant", "dot") for k, v in enumerate(levels)), "k",
                       "log₁₀(σ/σ₁)", (0.5, len(values) + 0.5), (min(float(levels.min()), -3.0) - 0.5, 0.5), tab=STRUCTURE_TAB,
                       caption=Text(f"{strong} of {len(values)} are above a hundredth of the largest: about so many states matter "
                                    f"between u and y.{aside.en}",
                                    f"{len(values)} 个中有 {strong} 个大于最大值的百分之一：从 u 到 y 大约只有这么多"
                                    f"状态起作用。{aside.zh}"))


# --- loop --------------------------------------------------------------------------------------------------------------
def time_figures(model: Model, run: Run, limit: float | None) -> tuple[LineFigure, ...]:
    """Watched signals; error beside its promise; inputs."""
    return (*state_figures(model, run), error_figure(run, autonomous_error(run)), input_figure(run, model, limit))
