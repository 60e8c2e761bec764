"""Figures of duality: the run, the twins in tables and over time, the ellipses."""

from __future__ import annotations

import numpy as np

from app.lesson.figures import Curve, Figure, LineFigure, PlaneFigure, TableFigure, nice
from app.lesson.lesson import Outcome
from app.text.words import Text, same, symbol

from ..toolkit.figures import error_figure, input_figure, state_figures
from ..toolkit.latex import pole_words
from .study import Setting, Twins, weights_of

TWINS_TAB, ELLIPSES_TAB = Text("Twins", "孪生"), Text("Ellipses", "椭圆")
MOST_ROWS = 12  # of a table
CIRCLE = np.linspace(0.0, 2 * np.pi, 121)


def all_figures(here: Setting, outcome: Outcome[Twins]) -> tuple[Figure, ...]:
    """The run; gains, Riccati solutions and the pairing beside their twins; both ellipses."""
    run, twins = outcome.run, outcome.study
    assert run is not None
    return (*state_figures(here.model, run, 2), error_figure(run), input_figure(run, here.model), _gain_table(outcome, twins),
            _riccati_table(here, outcome, twins), _pairing(twins, outcome.metrics["pairing_gap"]),
            *_ellipses(here, outcome.design["window"], twins, outcome.metrics["mirror_gap"]))


def _entry(value: float) -> str:
    return f"{value:.6g}".replace("-", "−")


def _gain_table(outcome: Outcome[Twins], twins: Twins) -> TableFigure:
    wide = twins.L.shape[1] > 1
    names = (symbol(f"L{i + 1}{j + 1}" if wide else f"L{i + 1}") for i, j in np.ndindex(twins.L.shape))
    rows = tuple((name, _entry(float(a)), _entry(float(b)), f"{abs(a - b):.0e}") for name, a, b in zip(
        names, twins.L.ravel(), twins.K_dual.T.ravel(), strict=True))[:MOST_ROWS]
    left, right = (pole_words(outcome.poles[side].tolist()) for side in ("controller", "observer"))
    return TableFigure(
        "gains", Text("one gain, found twice", "同一个增益，两种求法"),
        (same(""), Text("L, own equation", "L：自己的方程"), Text("K_dᵀ of (Aᵀ, Cᵀ)", "(Aᵀ, Cᵀ) 的 K_dᵀ"),
         Text("difference", "差")), rows, tab=TWINS_TAB,
        caption=Text(f"Left board: {left}. Right board: {right}.", f"左板：{left}。右板：{right}。"))


def _riccati_table(here: Setting, outcome: Outcome[Twins], twins: Twins) -> TableFigure:
    rows = [(symbol(f"P{i + 1}{j + 1}"), _entry(float(twins.P[i, j])), _entry(float(twins.S_dual[i, j])),
             f"{abs(twins.P[i, j] - twins.S_dual[i, j]):.0e}") for i, j in np.ndindex(twins.P.shape) if i <= j][:MOST_ROWS]
    Q, R, W, V = weights_of(here, outcome.design)
    slow = twins.slowest
    return TableFigure(
        "riccati", Text("one Riccati equation, read twice", "同一个 Riccati 方程，两种读法"),
        (same(""), Text("P of LQE (W, V)", "LQE (W, V) 的 P"), Text("S of LQR on (Aᵀ, Cᵀ)", "(Aᵀ, Cᵀ) 上 LQR 的 S"),
         Text("difference", "差")), tuple(rows), tab=TWINS_TAB,
        caption=Text(f"Q₁₁ = {Q[0, 0]:.3g}, R₁₁ = {R[0, 0]:.3g}: slowest LQR pole at Re s = {_entry(slow[0])}. "
                     f"W₁₁ = {W[0, 0]:.3g}, V₁₁ = {V[0, 0]:.3g}: slowest LQE pole at Re s = {_entry(slow[1])}.",
                     f"Q₁₁ = {Q[0, 0]:.3g}，R₁₁ = {R[0, 0]:.3g}：LQR 最慢极点的实部 {_entry(slow[0])}。"
                     f"W₁₁ = {W[0, 0]:.3g}，V₁₁ = {V[0, 0]:.3g}：LQE 最慢极点的实部 {_entry(slow[1])}。"))


def _pairing(twins: Twins, relative: float) -> LineFigure:
    value = f"{twins.pairing[0]:.4g}".replace("-", "−")
    return LineFigure(
        "pairing", Text("observer forward, dual backward", "观测器向前，对偶回路向后"), twins.t,
        (Curve(Text("‖e(t)‖", "‖e(t)‖"), np.linalg.norm(twins.e, axis=1), "error"),
         Curve(Text("‖x_d(T − t)‖", "‖x_d(T − t)‖"), np.linalg.norm(twins.z, axis=1), "second", "dash"),
         Curve(Text("x_d(T − t)ᵀ e(t)", "x_d(T − t)ᵀ e(t)"), twins.pairing, "reference", "solid", 2.6)),
        "‖e‖, ‖x_d‖, x_dᵀe", window=(-0.5, 1.5), tab=TWINS_TAB,
        caption=Text(f"The product stays at {value} to {relative:.0e} of the size of its factors.",
                     f"乘积恒为 {value}，相对其因子的变化为 {relative:.0e}。"))


def _ellipse(W: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
    """x and y of W^{1/2} times the unit circle, and the half axes, long and short."""
    values, axes = np.linalg.eigh(W)
    half = np.sqrt(np.maximum(values, 0.0))
    x, y = (axes * half) @ np.array([np.cos(CIRCLE), np.sin(CIRCLE)])
    return x, y, float(half[-1]), float(half[0])


def _plane(name: str, title: Text, caption: Text, own: np.ndarray, twin: np.ndarray, legend: tuple[Text, Text],
           half: float, axes: tuple[Text | str, Text | str]) -> PlaneFigure:
    (x, y, *_), (xt, yt, *_) = _ellipse(own), _ellipse(twin)
    return PlaneFigure(
        name, title, (Curve(legend[0], y, "plant", "solid", 3.4, x), Curve(legend[1], yt, "estimate", "dash", 1.8, xt)),
        (), *axes, (-half, half), (-half, half), equal=True, tab=ELLIPSES_TAB, caption=caption)


def _ellipses(here: Setting, window: float, twins: Twins, mirror: float) -> tuple[PlaneFigure, PlaneFigure]:
    at = np.ix_(here.pair, here.pair)
    reach, seen = _ellipse(twins.reach[at]), _ellipse(twins.seen[at])
    half = 1.15 * nice(max(reach[2], seen[2]))
    mirrored = (Text(" It is the mirror image of the upper one.", " 它正是上图的镜像。") if mirror < 1e-6 else same(""))
    return (
        _plane("reach", Text("states reached with unit energy", "单位能量所能到达的状态"),
               Text(f"Within {window:.3g} s: {reach[2]:.3g} along the easy direction, {reach[3]:.3g} along the hard one.",
                    f"在 {window:.3g} s 之内：容易的方向达 {reach[2]:.3g}，困难的方向只达 {reach[3]:.3g}。"),
               twins.reach[at], twins.reach_twin[at],
               (Text("reached by (A, B)", "(A, B) 可达"), Text("seen by (Aᵀ, Bᵀ)", "(Aᵀ, Bᵀ) 能观")), half, here.axes),
        _plane("seen", Text("how loudly a start is heard", "初始状态在输出中的响度"),
               Text(f"A unit start leaves an output of norm {seen[2]:.3g} along the long axis and {seen[3]:.3g} along the "
                    f"short one, within {window:.3g} s.{mirrored.en}",
                    f"单位初态沿长轴在 {window:.3g} s 之内留下范数 {seen[2]:.3g} 的输出，沿短轴只有 {seen[3]:.3g}。{mirrored.zh}"),
               twins.seen[at], twins.seen_twin[at],
               (Text("seen by (A, C)", "(A, C) 能观"), Text("reached by (Aᵀ, Cᵀ)", "(Aᵀ, Cᵀ) 可达")), half, here.axes),
    )
