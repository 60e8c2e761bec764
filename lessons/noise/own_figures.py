"""Figures of the valley on a person's own plant."""

from __future__ import annotations

import numpy as np

from app.engine.simulation import Run
from app.lesson.figures import Curve, Figure, LineFigure, PlaneFigure, Point, TableFigure
from app.lesson.lesson import Outcome
from app.plants import Model, Signal
from app.text.words import Text, squared

from ..toolkit.figures import TIME_TAB
from .figures import RUNS_TAB, SPEED_TAB, error_curves, variance_curves
from .job import RUNS
from .own_study import BELIEF, RUNGS, Study, watched_signal


# --- figures -----------------------------------------------------------------------------------------------------------
def figures(model: Model, outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """The valley and the peak over belief, shares; one run; many runs."""
    run, signal = outcome.run, watched_signal(model, outcome.design)
    assert run is not None
    return (_valley(outcome, signal), _peaks(outcome), _shares(model, outcome), _seen(model, run), _hidden(signal, run),
            _error(outcome, signal, run), _variance(outcome, signal, run))


def _rms(P: np.ndarray, signal: Signal) -> float:
    row = np.array(signal.weights)
    return float(np.sqrt(max(row @ P @ row, 1e-300)))


def _now(outcome: Outcome[Study]) -> float | None:
    return float(np.log10(outcome.design["belief"])) if outcome.design["method"] == BELIEF else None


def _valley(outcome: Outcome[Study], signal: Signal) -> PlaneFigure:
    study, x, m = outcome.study, np.log10(RUNGS), outcome.metrics
    total, process, sensor = (np.log10([_rms(getattr(p, k), signal) for p in study.ladder.parts]) for k in ("total", "process", "sensor"))
    at = _now(outcome)
    here = (Point(2.2 if at is None else at, float(np.log10(max(m["rms"], 1e-150))), "estimate", "cross", Text("yours", "当前")),)
    low = float(np.floor(2 * total.min()) / 2 - 0.5)
    sensor_share = 100 * (_rms(study.parts.sensor, signal) / _rms(study.parts.total, signal)) ** 2
    return PlaneFigure("valley", Text(f"error of {signal.name.en} over belief", f"{signal.name.zh}的误差与信念"), (
        Curve(Text("both noises", "两种噪声合计"), total, "error", x=x),
        Curve(Text("process noise", "过程噪声"), process, "disturbance", "dash", 1.8, x),
        Curve(Text("sensor noise", "测量噪声"), sensor, "second", "dot", 1.8, x)),
        (Point(0.0, float(total[len(x) // 2]), "reference", "circle", Text("Kalman", "卡尔曼")), *here), "log₁₀ b",
        f"log₁₀ σ [{signal.unit}]",
        (-3.0, 3.0), (low, max(low + 2.0, float(total.max()) + 0.2)), tab=SPEED_TAB, caption=Text(
            f"σ = {m['rms']:.3g} {signal.unit}, {sensor_share:.0f} % of σ² from the sensor; the least is {m['least_rms']:.3g}.",
            f"σ = {m['rms']:.3g} {signal.unit}，σ² 的 {sensor_share:.0f} % 来自传感器；最小值为 {m['least_rms']:.3g}。"))


def _peaks(outcome: Outcome[Study]) -> PlaneFigure:
    y, at = np.log10(np.maximum(outcome.study.peaks, 1e-150)), _now(outcome)
    points = () if at is None else (Point(at, float(np.interp(at, np.log10(RUNGS), y)), "estimate", "cross", Text("yours", "当前")),)
    return PlaneFigure("peaks", Text("peak of the error from x(0), without noise", "无噪声时误差的峰值（初始误差为 x(0)）"),
                       (Curve(Text("start as wrong as x(0)", "初始误差等于 x(0)"), y, "error", x=np.log10(RUNGS)),), points,
                       "log₁₀ b", "log₁₀ max|e|",
                       (-3.0, 3.0), (float(np.floor(y.min())) - 0.2, float(np.ceil(y.max())) + 0.2), tab=SPEED_TAB,
                       caption=Text(f"In this run the estimate is wrong by up to {outcome.metrics['peak']:.3g}, noise aside.",
                                    f"本次运行中，除去噪声，估计最多偏差 {outcome.metrics['peak']:.3g}。"))


def _shares(model: Model, outcome: Outcome[Study]) -> TableFigure:
    study = outcome.study
    rows = tuple((Text(f"{s.name.en} [{s.unit}]", f"{s.name.zh} [{s.unit}]"), *(
        f"{_rms(P, s):.3g}" for P in (study.parts.process, study.parts.sensor, study.parts.total, study.least.total)))
        for s in model.watched[:6])
    return TableFigure("shares", Text("σ of the settled error", "稳态误差的标准差 σ"),
                       (Text("error in", "误差"), Text("process", "过程噪声"), Text("sensor", "测量噪声"), Text("both", "合计"),
                        Text("least", "最小")), rows,
                       tab=SPEED_TAB, caption=Text("No entry of the column both is below that of the column least.",
                                                   "“合计”一列没有一项小于“最小”一列。"))


def _seen(model: Model, run: Run) -> LineFigure:
    signal = model.watched[0]
    return LineFigure("measured", signal.name, run.t, (
        Curve(Text("measured", "测量"), run.y[:, 0], "muted", width=1.0), Curve(Text("true", "真实"), signal.of(run.x)),
        Curve(Text("estimate", "估计"), signal.of(run.xhat), "estimate", "dash")), f"[{signal.unit}]", tab=TIME_TAB,
        caption=Text(f"Readings differ from the truth by up to {np.abs(run.y[:, 0] - signal.of(run.x)).max():.2g}.",
                     f"读数与真实值最多相差 {np.abs(run.y[:, 0] - signal.of(run.x)).max():.2g}。"))


def _hidden(signal: Signal, run: Run) -> LineFigure:
    true, guess = signal.of(run.x), signal.of(run.xhat)
    return LineFigure("velocity", signal.name, run.t, (Curve(Text("true", "真实"), true),
                                                       Curve(Text("estimate", "估计"), guess, "estimate", "dash")),
                      f"[{signal.unit}]", tab=TIME_TAB, caption=Text(f"Largest difference: {np.abs(true - guess).max():.2g} {signal.unit}.",
                                                                     f"最大相差 {np.abs(true - guess).max():.2g} {signal.unit}。"))


def _error(outcome: Outcome[Study], signal: Signal, run: Run) -> LineFigure:
    study = outcome.study
    count = len(study.grown)
    e, quiet, spread = signal.of(run.e)[:count], signal.of(study.quiet), 2 * np.sqrt(study.grown)
    inside = 100 * float(np.mean(np.abs(e - quiet) <= spread + 1e-300))
    return LineFigure("error", Text(f"error of {signal.name.en}", f"{signal.name.zh}的误差"), run.t[:count],
                      error_curves(e, quiet, spread), f"[{signal.unit}]", tab=TIME_TAB,
                      caption=Text(f"{inside:.0f} % of this run lies within 2σ of the noise-free error.",
                                   f"本次运行有 {inside:.0f} % 落在无噪声误差的 2σ 之内。"))


def _variance(outcome: Outcome[Study], signal: Signal, run: Run) -> LineFigure:
    study = outcome.study
    grown, count = study.grown, RUNS if study.trials is None else study.trials.count
    curves, inside = variance_curves(grown, None if study.trials is None else study.trials.square[:, 0], count)
    if study.trials is None:
        said = Text("No runs yet: press the button under the knobs.", "尚未试验：请按旋钮下方的按钮。")
    else:
        said = Text(f"{count} runs: the variance lies within its 95 % band at {inside:.0f} % of the instants.",
                    f"{count} 次试验：{inside:.0f} % 的时刻方差落在 95 % 带内。")
    return LineFigure("variance", Text(f"variance of the error of {signal.name.en}", f"{signal.name.zh}误差的方差"),
                      run.t[:len(grown)], curves, f"[{squared(signal.unit)}]", caption=said, tab=RUNS_TAB)
