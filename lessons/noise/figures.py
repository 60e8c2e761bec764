"""Figures of the lesson: the U-curve and the peak over speed, one run, many runs against Lyapunov."""

from __future__ import annotations

import numpy as np

from app.engine import chi2_band
from app.lesson.figures import Curve, Figure, LineFigure, PlaneFigure, Point, TableFigure
from app.lesson.lesson import Outcome
from app.text.words import Text, same, squared

from ..toolkit.figures import TIME_TAB
from .study import Study

SPEED_TAB, RUNS_TAB = Text("Speed", "速度"), Text("Many runs", "多次运行")
NAMES = (Text("position", "位置"), Text("velocity", "速度"))
UNITS = ("m", "m/s")
LEVEL = 0.95
PLANNED = 400  # runs for which the band is drawn before any has been made


def all_figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Everything on the right of the stage."""
    i = int(outcome.design["watch"] == "velocity")
    return (_valley(outcome, i), _peaks(outcome), _shares(outcome), _measured(outcome), _velocity(outcome), _error(outcome, i),
            _variance(outcome, i))


def _log(values: np.ndarray) -> np.ndarray:
    return np.log10(np.maximum(values, 1e-12))


def _valley(outcome: Outcome[Study], i: int) -> PlaneFigure:
    study, m = outcome.study, outcome.metrics
    ray, x = study.ray, _log(study.ray.speed)
    total = _log(ray.process[:, i] + ray.sensor[:, i]) / 2
    least = float(_log(np.sqrt(study.kalman.solution[i, i])))
    low = np.floor(2 * least) / 2 - 0.5
    now = float(_log(np.sqrt(study.parts.total[i, i])))
    points = [Point(float(_log(np.array(m["kalman_speed"]))), least, "reference", "circle", Text("Kalman", "卡尔曼")),
              Point(float(_log(np.array(m["speed"]))), now, "estimate", "cross", Text("yours", "当前"))]
    if study.trials is not None:
        tried = float(_log(np.sqrt(study.trials.square[-1, i])))
        points.append(Point(float(_log(np.array(m["speed"]))), tried, "error", "dot", Text("runs", "试验")))
    return PlaneFigure(
        "valley", Text(f"{NAMES[i].en} error over observer speed", f"{NAMES[i].zh}误差与观测器速度"),
        (Curve(Text("both noises", "两种噪声合计"), total, "error", x=x),
         Curve(Text("force noise", "力噪声"), _log(ray.process[:, i]) / 2, "disturbance", "dash", 1.8, x),
         Curve(Text("sensor noise", "测量噪声"), _log(ray.sensor[:, i]) / 2, "second", "dot", 1.8, x),
         Curve(Text("least possible", "最小可能值"), np.full(2, least), "reference", "dash", 1.2, np.array([-0.5, 2.5]))),
        tuple(points), "log₁₀ |p| [rad/s]", f"log₁₀ σ [{UNITS[i]}]", (-0.5, 2.5), (float(low), float(low) + 3.0), tab=SPEED_TAB,
        caption=_valley_words(outcome, i))


def _valley_words(outcome: Outcome[Study], i: int) -> Text:
    study, m = outcome.study, outcome.metrics
    now, least = (float(np.sqrt(P[i, i])) for P in (study.parts.total, study.kalman.solution))
    if now < 1.005 * least:
        return Text(f"σ = {now:.3g} {UNITS[i]}: this is the bottom.", f"σ = {now:.3g} {UNITS[i]}：正是谷底。")
    total = study.ray.process[:, i] + study.ray.sensor[:, i]
    best = float(study.ray.speed[np.argmin(total)])
    share = 100 * m["sensor_share"]
    if abs(np.log(m["speed"] / best)) < 0.07:
        advice = Text("No other speed is better; only another pattern is.", "换速度已无益，只有改变极点的形状才行。")
    elif m["speed"] > best:
        advice = Text("Slower would be better.", "慢一些更好。")
    else:
        advice = Text("Faster would be better.", "快一些更好。")
    return Text(f"σ = {now:.3g} {UNITS[i]}, {share:.0f} % of σ² from the sensor; the least is {least:.3g} {UNITS[i]}. {advice.en}",
                f"σ = {now:.3g} {UNITS[i]}，σ² 的 {share:.0f} % 来自传感器；最小值为 {least:.3g} {UNITS[i]}。{advice.zh}")


def _peaks(outcome: Outcome[Study]) -> PlaneFigure:
    ray, m, d = outcome.study.ray, outcome.metrics, outcome.design["error0"]
    said = (Text(f"With {d:.2g} m of starting error and the kick the velocity estimate is wrong by up to {m['peak']:.3g} m/s.",
                 f"初始误差 {d:.2g} m、并受一次冲击时，速度估计最多偏差 {m['peak']:.3g} m/s。") if outcome.design["kick"] >= 0 else
            Text(f"With {d:.2g} m of starting error the velocity estimate is wrong by up to {m['peak']:.3g} m/s.",
                 f"初始误差 {d:.2g} m 时，速度估计最多偏差 {m['peak']:.3g} m/s。"))
    x, y = _log(ray.speed), _log(ray.peak)
    at = float(np.interp(_log(np.array(m["speed"])), x, y))
    return PlaneFigure(
        "peaks", Text("peak of the velocity error, without noise", "无噪声时速度误差的峰值"),
        (Curve(Text("for 1 m of starting error", "初始误差为 1 m 时"), y, "error", x=x),),
        (Point(float(_log(np.array(m["speed"]))), at, "estimate", "cross", Text("yours", "当前")),),
        "log₁₀ |p| [rad/s]", "log₁₀ max|e₂| [m/s]", (-0.5, 2.5), (-0.5, 2.5), tab=SPEED_TAB,
        caption=said)


def _shares(outcome: Outcome[Study]) -> TableFigure:
    study = outcome.study
    rows = []
    for i, name in enumerate(NAMES):
        parts = (study.parts.process, study.parts.sensor, study.parts.total, study.kalman.solution)
        tried = "—" if study.trials is None else f"{np.sqrt(study.trials.square[-1, i]):.3g}"
        rows.append((Text(f"{name.en} [{UNITS[i]}]", f"{name.zh} [{UNITS[i]}]"), *(f"{np.sqrt(P[i, i]):.3g}" for P in parts), tried))
    gap = float(np.linalg.eigvalsh(study.parts.total - study.kalman.solution)[0])
    worst = float(np.abs(study.kalman.solution).max())
    good = gap > -1e-9 * worst
    return TableFigure(
        "shares", Text("σ of the settled error", "稳态误差的标准差 σ"),
        (Text("error in", "误差"), Text("force noise", "力噪声"), Text("sensor noise", "测量噪声"), Text("both", "合计"),
         Text("least", "最小"), Text("runs", "试验")), tuple(rows), tab=SPEED_TAB,
        caption=Text("P − P_min has no negative eigenvalue: no combination of errors is smaller than the Kalman filter's.",
                     "P − P_min 没有负特征值：误差的任何组合都不会小于卡尔曼滤波器的。") if good else
        Text("P − P_min has a negative eigenvalue by rounding.", "P − P_min 因舍入出现负特征值。"))


def _measured(outcome: Outcome[Study]) -> LineFigure:
    run = outcome.run
    assert run is not None
    noise = float(np.sqrt(outcome.design["v"] / run.scenario.dt))
    return LineFigure(
        "measured", Text("position", "位置"), run.t,
        (Curve(Text("measured", "测量"), run.y[:, 0], "muted", width=1.0), Curve(Text("true", "真实"), run.x[:, 0]),
         Curve(Text("estimate", "估计"), run.xhat[:, 0], "estimate", "dash")), "q [m]", window=(-0.5, 0.5), tab=TIME_TAB,
        caption=Text(f"A single reading is off by σ = {noise:.2g} m; the settled estimate by {outcome.metrics['position_rms']:.2g} m.",
                     f"单次读数的标准差为 {noise:.2g} m，稳态估计为 {outcome.metrics['position_rms']:.2g} m。"))


def _velocity(outcome: Outcome[Study]) -> LineFigure:
    run = outcome.run
    assert run is not None
    return LineFigure(
        "velocity", Text("velocity", "速度"), run.t,
        (Curve(Text("true", "真实"), run.x[:, 1]), Curve(Text("estimate", "估计"), run.xhat[:, 1], "estimate", "dash")),
        "v [m/s]", window=(-0.5, 0.5), tab=TIME_TAB,
        caption=Text(f"Nobody measures the velocity; its settled estimate is off by σ = {outcome.metrics['velocity_rms']:.2g} m/s.",
                     f"速度没有测量；其稳态估计的标准差为 {outcome.metrics['velocity_rms']:.2g} m/s。"))


def error_curves(e: np.ndarray, quiet: np.ndarray, spread: np.ndarray) -> tuple[Curve, ...]:
    """The error of a run, its course without noise, and `spread` about that."""
    return (Curve(Text("error", "误差"), e, "error"), Curve(Text("without noise", "无噪声"), quiet, "reference", "dash", 1.4),
            Curve(same("+ 2σ"), quiet + spread, "muted", "dot", 1.4), Curve(same("− 2σ"), quiet - spread, "muted", "dot", 1.4))


def variance_curves(promised: np.ndarray, tried: np.ndarray | None, count: int) -> tuple[tuple[Curve, ...], float]:
    """The promised variance and its band over `count` runs, beside what the runs gave; percent of the instants inside, NaN before any."""
    low, high = chi2_band(1, count=count, level=LEVEL)
    curves = (Curve(Text("Lyapunov", "Lyapunov 方程"), promised, "reference", "dash"),
              Curve(Text(f"95 % band, {count} runs", f"95 % 带，{count} 次"), high * promised, "muted", "dot", 1.4),
              Curve(Text("lower edge", "下沿"), low * promised, "muted", "dot", 1.4))
    if tried is None:
        return curves, np.nan
    inside = (tried[1:] >= low * promised[1:]) & (tried[1:] <= high * promised[1:])
    return (*curves, Curve(Text("runs", "试验"), tried, "error")), 100 * float(np.mean(inside))


def _error(outcome: Outcome[Study], i: int) -> LineFigure:
    run, study = outcome.run, outcome.study
    assert run is not None
    spread = 2 * np.sqrt(np.maximum(study.grown[:, i, i], 0.0))
    inside = 100 * float(np.mean(np.abs(run.e[:, i] - study.quiet[:, i]) <= spread + 1e-12))
    return LineFigure(
        "error", Text(f"error of the {NAMES[i].en}", f"{NAMES[i].zh}误差"), run.t,
        error_curves(run.e[:, i], study.quiet[:, i], spread), f"e [{UNITS[i]}]", window=(-0.2, 0.2), tab=TIME_TAB,
        caption=Text(f"{inside:.0f} % of this run lies within 2σ of the noise-free error; 95 % are expected on average.",
                     f"本次运行有 {inside:.0f} % 落在无噪声误差的 2σ 之内；平均应为 95 %。"))


def _variance(outcome: Outcome[Study], i: int) -> LineFigure:
    run, study = outcome.run, outcome.study
    assert run is not None
    promised = study.grown[:, i, i]
    tried, count = (None, PLANNED) if study.trials is None else (study.trials.square[:, i], study.trials.count)
    curves, inside = variance_curves(promised, tried, count)
    if tried is None:
        said = Text("No runs yet: press the button under the knobs.", "尚未试验：请按旋钮下方的按钮。")
    else:
        said = Text(f"{count} runs: the variance lies within its 95 % band at {inside:.0f} % of the instants; at the end it is "
                    f"{tried[-1] / promised[-1]:.3f} of the promise.",
                    f"{count} 次试验：{inside:.0f} % 的时刻方差落在 95 % 带内；末时刻为理论值的 {tried[-1] / promised[-1]:.3f} 倍。")
    return LineFigure("variance", Text(f"variance of the {NAMES[i].en} error", f"{NAMES[i].zh}误差的方差"), run.t, curves,
                      f"[{squared(UNITS[i])}]", window=(0.0, float(1.3 * promised[-1])), caption=said, tab=RUNS_TAB)
