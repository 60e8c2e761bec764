"""Figures of the nonlinear lesson: one run, consistency over the runs, the laws that bend, the report's Algorithm 3."""

from __future__ import annotations

import numpy as np

from app.lesson.figures import Curve, Figure, PlaneFigure, Point, TableFigure, TimeFigure
from app.lesson.lesson import Outcome
from app.plants import cart_pendulum, falling_body, platform
from app.text.words import Text, same

from ..toolkit.figures import TIME_TAB
from .cases import EKF, FALL, KF, LENGTH, PENDULUM, PLATFORM, UKF
from .report import LINES, NONE, finding, linear_spreads
from .runs import FILTERS, Study
from .study import band_of, verdict

CONSISTENCY_TAB = Text("Consistency", "一致性")
LAW_TAB = Text("Laws", "非线性规律")
REPORT_TAB = Text("Algorithm 3", "算法 3")
LOOKS = ((KF, "second", "dot"), (EKF, "estimate", "dash"), (UKF, "force", "solid"))
FLOOR, CEILING = 1e-3, 1e9
SHOWN_ERROR = 980.0  # m, largest error of the altitude that is drawn


def name_of(filter_: str) -> Text:
    """KF, EKF or UKF."""
    return same(filter_.upper())


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Every figure of the lesson."""
    return (_state(outcome), _errors(outcome), _nees(outcome), _nis(outcome), _verdicts(outcome), _law(outcome),
            _second_law(outcome), _algorithm(outcome), _lines(outcome))


# --- one run ---------------------------------------------------------------------------------------------------------
def _state(outcome: Outcome[Study]) -> TimeFigure:
    s, who = outcome.study, outcome.design["filter"]
    signal, falls = s.case.watched[0], s.case.id == FALL
    true, mean, sigma = signal.of(s.x), signal.of(s.means[who]), 3 * s.sigmas[who][:, s.case.state] * signal.scale
    inside = 100 * float(np.mean(np.abs(true - mean) <= sigma))
    if falls:  # metres against tens of kilometres: only the error can be seen
        true, mean = np.zeros_like(true), mean - true
    bound = SHOWN_ERROR if falls else 4 * float(np.max(np.abs(true))) + 1e-9
    title = Text("error of the altitude in this run", "本次运行的高度误差") if falls else signal.name
    return TimeFigure("state", title, s.t, (
        Curve(Text("true", "真实"), true),
        Curve(Text(f"estimate, {who.upper()}", f"估计（{who.upper()}）"), np.clip(mean, -bound, bound), "estimate", "dash"),
        Curve(same("+ 3σ"), np.clip(mean + sigma, -bound, bound), "muted", "dot", 1.2),
        Curve(same("− 3σ"), np.clip(mean - sigma, -bound, bound), "muted", "dot", 1.2)), f"[{signal.unit}]", tab=TIME_TAB,
        caption=Text(f"In this run the truth is inside the {who.upper()}'s own 3σ for {inside:.0f} % of the time.",
                     f"本次运行中，真实值有 {inside:.0f} % 的时间落在 {who.upper()} 自报的 3σ 之内。"))


def _errors(outcome: Outcome[Study]) -> TimeFigure:
    s, who = outcome.study, outcome.design["filter"]
    signal = s.case.watched[1] if s.case.id == FALL else s.case.watched[0]
    at = 1 if s.case.id == FALL else 0
    state = int(np.argmax(np.abs(signal.weights)))
    curves = [Curve(name_of(n), np.clip(signal.scale * s.rms[n][:, at], 1e-9, CEILING), role, dash)  # type: ignore[arg-type]
              for n, role, dash in LOOKS]
    claimed = np.clip(signal.scale * s.sigmas[who][:, state], 1e-9, CEILING)
    curves.append(Curve(Text(f"σ that the {who.upper()} claims", f"{who.upper()} 自报的 σ"), claimed, "muted", "dot", 1.6))
    last = float(signal.scale * s.rms[who][-1, at] / max(claimed[-1], 1e-12))
    return TimeFigure("errors", Text(f"rms error: {signal.name.en}", f"均方根误差：{signal.name.zh}"), s.t, tuple(curves),
                      f"[{signal.unit}]", log=True, tab=TIME_TAB,
                      caption=Text(f"Over {s.runs} runs. At the end the {who.upper()}'s errors are {last:.2g} times the σ "
                                   "that it claims in the run shown.",
                                   f"{s.runs} 次运行的统计。末尾 {who.upper()} 的误差是它在所示运行中自报 σ 的 {last:.2g} 倍。"))


# --- consistency -------------------------------------------------------------------------------------------------------
def shares(values: np.ndarray, band: tuple[float, float]) -> tuple[float, float]:
    """Shares of the samples inside a band and above it."""
    return float(np.mean((values >= band[0]) & (values <= band[1]))), float(np.mean(values > band[1]))


def _squares(outcome: Outcome[Study], id: str, title: Text, dof: int, values: dict[str, np.ndarray]) -> TimeFigure:
    s = outcome.study
    band = band_of(dof, s.runs)
    curves = [Curve(name_of(n), np.clip(values[n], FLOOR, CEILING), role, dash) for n, role, dash in LOOKS]  # type: ignore[arg-type]
    curves += [Curve(Text("95 % band", "95 % 带"), np.full(len(s.t), band[1]), "muted", "dot", 1.4),
               Curve(Text("lower edge", "下沿"), np.full(len(s.t), band[0]), "muted", "dot", 1.4)]
    inside = [f"{n.upper()} {100 * shares(values[n], band)[0]:.0f} %" for n in FILTERS]
    return TimeFigure(id, title, s.t, tuple(curves), id.upper(), log=True, window=(0.1, 1e3), tab=CONSISTENCY_TAB,
                      caption=Text(f"Mean of {s.runs} runs; samples inside [{band[0]:.3g}, {band[1]:.3g}]: {', '.join(inside)}.",
                                   f"{s.runs} 次运行的平均；落在 [{band[0]:.3g}, {band[1]:.3g}] 内的采样：{'，'.join(inside)}。"))


def _nees(outcome: Outcome[Study]) -> TimeFigure:
    n = outcome.study.x.shape[1]
    return _squares(outcome, "nees", Text(f"NEES, {n} states", f"NEES（{n} 个状态）"), n, outcome.study.nees)


def _nis(outcome: Outcome[Study]) -> TimeFigure:
    p = len(outcome.study.case.R)
    return _squares(outcome, "nis", Text(f"NIS, {p} readings" if p > 1 else "NIS, 1 reading", f"NIS（{p} 个读数）"), p,
                    outcome.study.nis)


def _verdicts(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study
    n = s.x.shape[1]
    rows = tuple((name_of(f), _short(float(np.mean(s.nees[f]))), _short(float(np.max(s.nees[f]))), f"{100 * s.honest[f]:.0f} %",
                  verdict(s.nees[f], n, s.runs)) for f in FILTERS)
    fell = (Text(f" The pole fell in {s.fallen} of {s.runs} runs; they count until then.",
                 f"{s.runs} 次中摆杆倒下 {s.fallen} 次；倒下之前仍计入统计。") if s.case.id == PENDULUM else same(""))
    lost = sum(s.lost.values())
    gone = (Text(f" Filters given up because their covariance broke down: {lost}.", f"因协方差失效而中止的滤波共 {lost} 次。")
            if lost else same(""))
    few = (Text("Few runs say little about rare failures; the button tries many.", "次数少，看不出罕见的失败；请按按钮多次试验。")
           if s.runs < 50 else
           Text("In 99 %: runs whose NEES ends below the 99 % point of χ².",
                "“99 % 内”：末尾 NEES 低于 χ² 的 99 % 分位点的运行。"))
    return TableFigure("verdicts", Text(f"NEES over {s.runs} runs, {n} expected", f"{s.runs} 次运行的 NEES，应为 {n}"),
                       (Text("filter", "滤波器"), Text("mean", "均值"), Text("largest", "最大"), Text("in 99 %", "99 % 内"),
                        Text("verdict", "结论")), rows, tab=CONSISTENCY_TAB,
                       caption=Text(few.en + fell.en + gone.en, few.zh + fell.zh + gone.zh))


def _short(value: float) -> str:
    return f"{value:.3g}" if value < 1e4 else f"{value:.1e}"


# --- laws ---------------------------------------------------------------------------------------------------------------
def _law(outcome: Outcome[Study]) -> PlaneFigure:
    s, d = outcome.study, outcome.design
    if s.case.id == PLATFORM:
        k = platform.Parameters()
        e = np.linspace(-12, 12, 97)
        sigma = 1e3 * d["size"] * float(np.hypot(s.case.spread[1], k.a * s.case.spread[2]))
        bend = 1 + d["hardening"] * (1e-3 * e / LENGTH)**2
        at = 1 + d["hardening"] * (1e-3 * sigma / LENGTH)**2
        return _plane("law", Text("pull of a vertical spring", "竖直弹簧的拉力"), "e [mm]", "N", e, 1e-3 * k.kz * e * bend,
                      1e-3 * k.kz * e, sigma,
                      Text(f"Stretched by the start's σ of {sigma:.2g} mm the spring is {at:.2f} times as stiff as the line says.",
                           f"伸长量为初始 σ（{sigma:.2g} mm）时，弹簧的刚度是直线的 {at:.2f} 倍。"), (-25.0, 25.0))
    if s.case.id == PENDULUM:
        angle = np.linspace(-90, 90, 91)
        sigma = float(np.degrees(d["size"] * s.case.spread[1]))
        return _plane("law", Text("pull of gravity on the pole", "重力对摆杆的作用"), "θ [°]", "m/s²", angle,
                      9.81 * np.sin(np.radians(angle)), 9.81 * np.radians(angle), sigma,
                      Text(f"At the start's σ of {sigma:.3g}° the line is off by {100 * _sine_gap(sigma):.2g} %.",
                           f"在初始 σ（{sigma:.3g}°）处，直线偏差 {100 * _sine_gap(sigma):.2g} %。"), (-16.0, 16.0))
    k = falling_body.PARAMETERS
    h = np.linspace(0, 95, 96)
    seen = 1e-3 * np.hypot(k.side, 1e3 * h - k.height)
    start = float(s.case.guess[0])
    line = 1e-3 * (np.hypot(k.side, start - k.height)
                   + (start - k.height) / np.hypot(k.side, start - k.height) * (1e3 * h - start))
    return _plane("law", Text("distance that the radar sees", "雷达测得的距离"), "h [km]", "km", h, seen, line, None,
                  Text("At the radar's own height, 30.5 km, the distance has no slope: it says nothing about the altitude.",
                       "在与雷达等高处（30.5 km），距离曲线斜率为零，测距不含高度信息。"), (0.0, 80.0))


def _sine_gap(degrees: float) -> float:
    angle = np.radians(degrees)
    return float(angle / np.sin(angle) - 1)


def _plane(id: str, title: Text, x_label: str, y_label: str, x: np.ndarray, true: np.ndarray, line: np.ndarray,
           sigma: float | None, caption: Text, y_range: tuple[float, float]) -> PlaneFigure:
    points = () if sigma is None else tuple(
        Point(sign * sigma, float(np.interp(sign * sigma, x, true)), "estimate", "dot", same("σ" if sign < 0 else ""))
        for sign in (1.0, -1.0) if sigma <= float(x[-1]))
    bent, straight = ((y >= y_range[0]) & (y <= y_range[1]) for y in (true, line))
    curves = (Curve(Text("law", "实际规律"), true[bent], "plant", "solid", 2.0, x[bent]),
              Curve(Text("as the KF takes it", "KF 眼中的规律"), line[straight], "reference", "dash", 1.4, x[straight]))
    return PlaneFigure(id, title, curves, points,
                       x_label, y_label, (float(x[0]), float(x[-1])), y_range, caption=caption, tab=LAW_TAB)


def _second_law(outcome: Outcome[Study]) -> PlaneFigure:
    s, d = outcome.study, outcome.design
    if s.case.id == PLATFORM:
        x = np.linspace(-12, 12, 97)
        factor = np.exp(-d["weakening"] * 1e-3 * x / LENGTH)
        low, high = 100 * (np.exp(-d["weakening"] * 0.002 / LENGTH) - 1), 100 * (np.exp(d["weakening"] * 0.002 / LENGTH) - 1)
        return _plane("law2", Text("force constant of a coil", "线圈的力常数"), "d [mm]", "k(d)/k(0)", x, factor, np.ones_like(x), None,
                      Text("The coil is as strong at any gap.", "线圈出力与间隙无关。") if high < 0.5 else
                      Text(f"The gap opening or closing by 2 mm changes the force by −{-low:.0f} % or +{high:.0f} %.",
                           f"间隙张开或合拢 2 mm，出力变化 −{-low:.0f} % 或 +{high:.0f} %。"), (0.0, 3.0))
    if s.case.id == PENDULUM:
        k, angle = cart_pendulum.Parameters(), np.linspace(-90, 90, 91)
        push = np.cos(np.radians(angle)) / (k.cart + k.ball * np.sin(np.radians(angle))**2)
        return _plane("law2", Text("how much a force on the cart turns the pole", "小车受力对摆杆的作用"), "θ [°]", "rad/s²/N", angle, push,
                      np.ones_like(angle), None, Text("Lying flat, the pole can no longer be turned by the cart.",
                                                      "摆杆放平时，小车的力不再能使它转动。"), (0.0, 1.6))
    h = np.linspace(0, 95, 96)
    air = np.exp(-falling_body.PARAMETERS.density * 1e3 * h)
    return _plane("law2", Text("density of the air", "空气密度"), "h [km]", "ρ/ρ₀", h, air, np.full_like(h, air[-1]), None,
                  Text("Above 60 km there is nothing to feel: β stays unknown until the air takes hold, then all at once.",
                       "60 km 以上几乎没有空气：β 无从得知，直到空气开始起作用，才突然显现。"), (0.0, 1.0))


# --- the report ----------------------------------------------------------------------------------------------------------
def _algorithm(outcome: Outcome[Study]) -> TimeFigure:
    s, d = outcome.study, outcome.design
    right, believed, real, _ = linear_spreads(s.case.id, d["wind"], d["sensor"])
    signal = s.case.watched[0]
    scale, t = signal.scale, s.case.step * np.arange(len(right))
    worse = float(real[-1] / right[-1] - 1)
    more = float(believed[-1] / right[-1] - 1)
    said = (Text("The falling body has no process noise, so there is nothing to redraw for. Choose the platform.",
                 "下落体没有过程噪声，无需重抽，三者相同。请改选隔振平台。")
            if s.case.id == FALL else
            Text(f"On the plant made linear: Algorithm 3 believes a σ {100 * more:.1f} % above the Kalman filter's and really "
                 f"errs {100 * worse:.1f} % more.",
                 f"在线性化对象上：算法 3 自报的 σ 比卡尔曼滤波器大 {100 * more:.1f} %，实际误差也大 {100 * worse:.1f} %。"))
    return TimeFigure("algorithm", Text(f"σ of: {signal.name.en}", f"σ：{signal.name.zh}"), t, (
        Curve(Text("Kalman filter", "卡尔曼滤波器"), scale * right, "plant"),
        Curve(Text("Algorithm 3, believed", "算法 3，自报"), scale * believed, "estimate", "dash"),
        Curve(Text("Algorithm 3, real", "算法 3，实际"), scale * real, "error", "dot")), f"[{signal.unit}]", log=True,
        caption=said, tab=REPORT_TAB)


def _lines(outcome: Outcome[Study]) -> TableFigure:
    chosen, s = outcome.design["line"], outcome.study
    gap = s.apart[UKF] if not outcome.design["redraw"] else linear_spreads(PLATFORM, 1.0, 1.0)[3]
    rows = tuple((label, finding(name, gap) if name == chosen else same("?")) for name, label in LINES if name != NONE)
    return TableFigure("lines", Text("lines of the report in doubt", "报告中可疑的几行"),
                       (Text("line", "行"), Text("what the engine finds", "计算结果")), rows, tab=REPORT_TAB,
                       caption=Text("Choose a line with the knob; one of them makes a wrong filter of a linear plant.",
                                    "用旋钮选择一行；其中一行使线性对象的滤波器出错。"))
