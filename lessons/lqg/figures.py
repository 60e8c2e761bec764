"""Figures of the lesson: spectra, input and cost, robustness, recovery, one run, the report's rules."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from app.engine.feedback import ChannelMargins
from app.lesson.figures import Curve, Figure, LineFigure, PlaneFigure, Point, TableFigure, finite, over_frequency
from app.lesson.lesson import Outcome
from app.plants.names import called
from app.text.words import Text, same, squared

from ..toolkit.figures import TIME_TAB, axis_name, within
from ..toolkit.latex import tiny
from .knobs import CAUTION, NONE, PROCESS, RULES, SENSOR, SLIPS, SPLIT, UNITS
from .loops import Robustness
from .study import Study

SPECTRUM_TAB, COST_TAB = Text("Spectrum", "频谱"), Text("Input and cost", "输入与代价")
ROBUST_TAB, RECOVERY_TAB = Text("Robustness", "鲁棒性"), Text("Recovery", "回路传递恢复")
TURN = np.linspace(0, 2 * np.pi, 73)
TOO_MUCH = 1e30  # a density beyond this is drawn at it
OPEN, CLOSED = Text("no control", "无控制"), Text("closed, predicted", "闭环（理论）")
ANY = Text("any", "任意")
ROLES = ("force", "disturbance", "second")


def all_figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Everything on the right of the stage."""
    return (*_spectra(outcome), _input(outcome), _cost(outcome), _nyquist(outcome), _return(outcome), _margins(outcome),
            _loop_gain(outcome), _price(outcome), *_run(outcome), rules_figure(outcome))


def words(value: float, digits: int = 3) -> str:
    """A number for a table: ∞, a true minus sign, powers of ten where they help."""
    if not np.isfinite(value):
        return "∞"
    return f"{value:.{digits}g}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e").replace("-", "−")


def level(power: float) -> str:
    """Decibels of a power ratio with a true minus sign."""
    return f"{power:.1f}".replace("-", "−")


def density(unit: str) -> str:
    """The axis of a density of a signal in this unit."""
    return f"[{squared(unit)}/Hz]"


def _phase(m: ChannelMargins) -> Text | str:
    """The phase margin in degrees; any phase will do where |ℓ| = 1 nowhere."""
    return ANY if np.isnan(m.phase_frequency) and m.phase > 3 else f"{np.degrees(m.phase):.3g}°"


# --- spectra ---------------------------------------------------------------------------------------------------------
def _spectra(outcome: Outcome[Study]) -> tuple[LineFigure, ...]:
    s = outcome.study
    case, square = s.case, s.case.scale**2
    figures = []
    for i, name in enumerate(case.names):
        curves = []
        if case.open_psd is not None:
            curves.append(Curve(OPEN, square * s.disturbance * case.open_psd[:, i], "muted", "dash", 1.8))
        if s.trials is not None:
            curves.append(Curve(Text(f"{s.trials.count} runs", f"{s.trials.count} 次运行"),
                                finite(square * s.trials.density[:, i], TOO_MUCH), "disturbance", "solid", 4.0))
            curves.append(Curve(Text("predicted for this computer", "理论值（该计算机）"),
                                finite(square * s.trials.predicted[:, i], TOO_MUCH), "reference", "dot", 1.6))
        if s.density is not None:
            curves.append(Curve(CLOSED, finite(square * s.density[:, i], TOO_MUCH), "plant"))
        figures.append(over_frequency(
            f"spectrum{i}", name, case.frequency, tuple(curves) or (Curve(Text("none", "无"), np.ones(len(case.frequency)), "muted"),),
            density(case.unit), _spectrum_words(outcome, i), SPECTRUM_TAB, _deep(curves)))
    return tuple(figures)


def _deep(curves: list[Curve]) -> tuple[float, float] | None:
    """The range of all curves, at most twelve decades: a quiet channel is worth seeing too."""
    if not curves:
        return None
    top = max(float(c.y.max()) for c in curves)
    return max(min(float(c.y.min()) for c in curves), 1e-12 * top), top


def _spectrum_words(outcome: Outcome[Study], i: int) -> Text:
    s = outcome.study
    if s.density is None or s.variance is None:
        return Text("The loop is unstable: it has no stationary spectrum.", "回路不稳定，没有平稳频谱。")
    if s.trials is not None:
        t = s.trials
        within = f"{100 * t.inside[i]:.0f} %"
        return Text(f"Runs over prediction: {t.ratio[i]:.2f} on average; {within} of the points lie within their 95 % band.",
                    f"运行结果与理论值之比平均为 {t.ratio[i]:.2f}；{within} 的点落在 95 % 带内。")
    if s.suppression is None:
        rms = float(np.sqrt(s.variance[i])) * s.case.scale
        return Text(f"Without control nothing is stationary; with it the rms is {rms:.3g}.", f"无控制时不平稳；闭环均方根值为 {rms:.3g}。")
    drop, low = s.suppression[i], s.low[i]
    under = (Text(f"amplified {level(-low)} dB", f"放大 {level(-low)} dB") if low < -0.1 else
             Text(f"lowered {level(low)} dB", f"降低 {level(low)} dB") if low > 0.1 else Text("nothing gained", "没有收益"))
    return Text(f"Peak lowered by {level(drop)} dB; at {s.case.low:.2g} Hz {under.en}.",
                f"峰值降低 {level(drop)} dB；{s.case.low:.2g} Hz 处{under.zh}。")


# --- input and cost --------------------------------------------------------------------------------------------------
def _input(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    case, square = s.case, s.case.input_scale**2
    names = [called(case.plant, name) for name in case.plant.input_names]
    curves: list[Curve] = []
    if s.asked is not None:
        ground, sensors = s.asked
        for j in range(min(len(names), 3)):
            curves.append(Curve(names[j], finite(square * (ground + sensors)[:, j], TOO_MUCH), ROLES[j],
                                "dash" if j == 1 else "solid"))
        curves.append(Curve(Text("{}, sensors' part", "{} 中测量噪声的部分").format(names[-1]),
                            finite(square * sensors[:, -1], TOO_MUCH), "estimate", "dot", 1.6))
        share = 100 * outcome.metrics.get("sensor_share", 0.0)
        said = Text(f"The sensors' noise causes {share:.3g} % of the input's power.", f"输入功率的 {share:.3g} % 由测量噪声引起。")
    else:
        curves.append(Curve(Text("none", "无"), np.ones(len(case.frequency)), "muted"))
        said = Text("The loop is unstable: the input has no spectrum.", "回路不稳定，输入没有频谱。")
    return over_frequency("input", Text("inputs", "输入"), case.frequency, tuple(curves), density(case.input_unit), said, COST_TAB,
                          _deep(curves))


def _cost(outcome: Outcome[Study]) -> TableFigure:
    c = outcome.study.cost
    unknown = c.total - c.known
    rows = (
        (Text("x known: tr(S G W Gᵀ)", "状态已知：tr(S G W Gᵀ)"), words(c.known)),
        (Text("+ x only estimated", "＋ 状态只能估计"), words(unknown)),
        (Text("= this loop", "＝ 本回路"), words(c.total, 4)),
        (Text("  of it E xᵀQx, E uᵀRu", "  其中 E xᵀQx、E uᵀRu"), f"{words(c.state)}, {words(c.input)}"),
        (Text("least for this noise", "此噪声下的最小值"), words(c.least, 4)),
        (Text("without control", "无控制"), words(c.idle)),
    )
    if not np.isfinite(c.total):
        said = Text("An unstable loop costs without bound.", "不稳定的回路代价无界。")
    elif c.total <= c.least * (1 + 1e-6):
        said = Text("No other controller is cheaper on average under this noise.", "在这一噪声下，没有任何控制器的平均代价更低。")
    else:
        said = Text(f"{words(c.total / c.least)} times the least: the filter believes in another noise.",
                    f"是最小值的 {words(c.total / c.least)} 倍：滤波器设定的噪声与实际不符。")
    return TableFigure("cost", Text("average of xᵀQx + uᵀRu", "xᵀQx + uᵀRu 的平均值"), (Text("part", "组成"), same("J")), rows,
                       said, COST_TAB)


# --- robustness ------------------------------------------------------------------------------------------------------
def _nyquist(outcome: Outcome[Study]) -> PlaneFigure:
    s = outcome.study

    def both(ell: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        half = finite(np.real(ell), 1e6), finite(np.imag(ell), 1e6)
        return np.concatenate([half[0], half[0][::-1]]), np.concatenate([half[1], -half[1][::-1]])

    ideal, real = both(s.ideal.curve), both(s.real.curve)
    low, high = s.real.margins.gain
    return PlaneFigure(
        "nyquist", Text("Nyquist, cut at one input", "Nyquist 曲线，在一个输入处断开"),
        (Curve(Text("unit circle around −1", "以 −1 为圆心的单位圆"), np.sin(TURN), "muted", "dot", 1.4, np.cos(TURN) - 1),
         Curve(same("LQR"), ideal[1], "plant", "dash", 2.0, ideal[0]), Curve(same("LQG"), real[1], "estimate", "solid", 2.0, real[0])),
        (Point(-1.0, 0.0, "reference", "cross"),), "Re ℓ", "Im ℓ", (-2.6, 1.0), (-1.8, 1.8), equal=True, tab=ROBUST_TAB,
        caption=Text(f"LQG stays stable while the input's gain is between {words(low, 4)} and {words(high, 6)} times the model's.",
                     f"输入增益在模型值的 {words(low, 4)} 倍与 {words(high, 6)} 倍之间时，LQG 回路保持稳定。"))


def _return(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    f, least = s.case.wide, words(s.real.margins.nearest)
    curves = [Curve(same("LQR |1 + ℓ|"), np.clip(np.abs(1 + s.ideal.gain), 1e-6, 1e6), "plant", "dash"),
              Curve(same("LQG |1 + ℓ|"), np.clip(np.abs(1 + s.real.gain), 1e-6, 1e6), "estimate")]
    said = Text(f"LQR never falls below 1; LQG comes down to {least}.", f"LQR 从不低于 1；LQG 最低为 {least}。")
    if s.case.plant.m > 1:
        curves.append(Curve(Text("LQG, all inputs: σ_min(I + L)", "LQG，全部输入：σ_min(I + L)"),
                            np.clip(s.real.together, 1e-6, 1e6), "error", "dot", 1.6))
        together = words(s.real.nearest)
        said = Text(f"LQR never falls below 1; LQG comes down to {least}, with all inputs at once to {together}.",
                    f"LQR 从不低于 1；LQG 最低为 {least}，全部输入同时考虑时为 {together}。")
    curves.append(Curve(same("1"), np.ones(len(f)), "reference", "dot", 1.2))
    return over_frequency("return", Text("return difference", "回差"), f, tuple(curves), "|1 + ℓ|", said, ROBUST_TAB,
                          window=(0.1, 100.0))


def _margins(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study

    def column(r: Robustness) -> tuple[Text | str, ...]:
        m = r.margins
        low, high = m.gain
        return (f"{words(low, 4)} … {words(high, 6)}", _phase(m), ANY if np.isinf(m.delay) else f"{words(m.delay)} s",
                words(m.disk.alpha), words(m.nearest), f"{words(r.alpha)}, {words(r.nearest)}")

    names = (Text("gain", "增益"), Text("phase", "相位"), Text("delay", "时延"), Text("disk α", "圆盘 α"), same("min |1 + ℓ|"),
             Text("all inputs: α, σ_min", "全部输入：α、σ_min"))
    rows = tuple((name, a, b) for name, a, b in zip(names, column(s.ideal), column(s.real), strict=True))
    thin = s.real.margins.gain[1] < 1.1 or s.real.margins.gain[0] > 0.9 or s.real.margins.delay < 1e-3
    best = s.cost.total <= s.cost.least * (1 + 1e-6)
    said = (Text("A little error of gain, phase or timing breaks this loop, which is not even optimal for this noise.",
                 "增益、相位或时间上的一点误差就会使这个回路失稳，而它对此噪声甚至并非最优。") if thin and not best else
            Text("Optimal, yet a little error of gain, phase or timing breaks it.",
                 "最优，却经不起增益、相位或时间上的一点误差。") if thin else
            Text("This loop has margins; being optimal promised none of them.",
                 "这个回路有裕度，但并非由最优性所保证。") if best else
            Text("This loop has margins; for this noise it is not the optimal one.", "这个回路有裕度；对此噪声它并非最优。"))
    return TableFigure("margins", Text("margins", "稳定裕度"), (Text("margin", "裕度"), same("LQR"), same("LQG")), rows, said,
                       ROBUST_TAB)


# --- recovery --------------------------------------------------------------------------------------------------------
def _loop_gain(outcome: Outcome[Study]) -> LineFigure:
    s = outcome.study
    curves = [Curve(same("LQR |ℓ|"), np.clip(np.abs(s.ideal.gain), 1e-12, 1e12), "plant", "dash"),
              Curve(Text("plain LQG |ℓ|", "普通 LQG |ℓ|"), np.clip(np.abs(s.plain.gain), 1e-12, 1e12), "muted", "dot", 1.6),
              Curve(Text("this LQG |ℓ|", "当前 LQG |ℓ|"), np.clip(np.abs(s.real.gain), 1e-12, 1e12), "estimate")]
    gap = float(np.max(np.abs(1 / (1 + s.real.gain) - 1 / (1 + s.ideal.gain))))
    return over_frequency("loop-gain", Text("loop gain, cut at one input", "回路增益，在一个输入处断开"), s.case.wide,
                          tuple(curves), "|ℓ|",
                          Text(f"Largest difference of the sensitivities of LQG and LQR: {words(gap)}.",
                               f"LQG 与 LQR 灵敏度之差最大为 {words(gap)}。"), RECOVERY_TAB, window=(1e-3, 1e2))


def _price(outcome: Outcome[Study]) -> TableFigure:
    s = outcome.study
    unit = f" [{s.case.input_unit}]" if s.case.input_unit else ""
    noise = [s.case.input_scale * float(np.linalg.norm(c.sensors)) for c in (s.plain_cost, s.cost)]
    rows = (
        (Text("gain may grow to", "增益可增大到"), words(s.plain.margins.gain[1], 6), words(s.real.margins.gain[1], 6)),
        (Text("gain may fall to", "增益可减小到"), words(s.plain.margins.gain[0], 4), words(s.real.margins.gain[0], 4)),
        (Text("phase margin", "相位裕度"), _phase(s.plain.margins), _phase(s.real.margins)),
        (same("min |1 + ℓ|"), words(s.plain.margins.nearest), words(s.real.margins.nearest)),
        (Text(f"input from sensor noise{unit}", f"测量噪声引起的输入{unit}"),
         words(noise[0]), words(noise[1])),
        (same("J"), words(s.plain_cost.total, 4), words(s.cost.total, 4)),
    )
    said = (Text("Recovery is off: move ρ.", "恢复未启用：请移动 ρ。") if outcome.design["recovery"] == 0 else
            Text("Margins are bought with noise in the input and a higher cost.", "裕度是用输入中的噪声和更高的代价换来的。")
            if s.plain_cost.total < s.cost.total else
            Text("Here the loop with recovery is not dearer than the plain one.", "此处带恢复的回路并不比普通回路代价更高。"))
    return TableFigure("price", Text("what recovery gives and takes", "恢复的得与失"),
                       (same(""), Text("plain LQG", "普通 LQG"), Text("now", "现在")), rows, said, RECOVERY_TAB)


# --- one run ---------------------------------------------------------------------------------------------------------
def _run(outcome: Outcome[Study]) -> tuple[LineFigure, ...]:
    s = outcome.study
    run, model = s.trace, s.case.model
    figures = []
    for i, signal in enumerate(model.watched[:2]):
        edge = 40 * max(float(np.max(np.abs(signal.of(np.array([model.x0, model.guess]))))), 1e-9)
        true, guess = signal.of(run.x), signal.of(run.xhat)
        late = float(np.abs(true[-max(len(true) // 10, 1):]).max())
        figures.append(within(LineFigure(
            f"state{i}", signal.name, run.t,
            (Curve(Text("true", "真实"), true), Curve(Text("estimate", "估计"), guess, "estimate", "dash")),
            axis_name(signal), tab=TIME_TAB,
            caption=Text(f"In the last tenth of the run at most {f'{late:.2g} {signal.unit}'.strip()}.",
                         f"最后十分之一时间内不超过 {f'{late:.2g} {signal.unit}'.strip()}。")), edge))
    size = run.error(s.case)
    start = max(float(size[0]), 1e-12)
    half = np.flatnonzero(size > 0.1 * start)
    said = (Text("Still above a tenth of its first size at the end.", "末时刻仍高于初始值的十分之一。")
            if len(half) and half[-1] == len(run.t) - 1 else
            Text(f"Last above a tenth of its first size at {run.t[half[-1]] if len(half) else 0.0:.2f} s.",
                 f"最后一次高于初始值的十分之一是在 {run.t[half[-1]] if len(half) else 0.0:.2f} s。"))
    figures.append(LineFigure(
        "error", Text("estimation error over its first size", "估计误差与初始误差之比"), run.t,
        (Curve(same("‖e‖ / ‖e(0)‖"), np.clip(size / start, 1e-9, 1e6), "error"),), "‖e‖ / ‖e(0)‖", log_y=True,
        tab=TIME_TAB, window=(1e-3, 1.0),
        caption=said))
    return tuple(figures)


def rules_figure(outcome: Outcome[Study]) -> TableFigure:
    """The rules one by one; the chosen one with its evidence."""
    m, chosen = defaultdict(lambda: float("inf"), outcome.metrics), outcome.design["rule"]
    evidence = {
        SPLIT: lambda: Text(f"holds: the loop's poles are both sets, off by {tiny(m['union_error'])}",
                            f"成立：回路极点即两组极点之并，偏差 {tiny(m['union_error'])}"),
        SENSOR: lambda: Text(f"slip: input from sensor noise ×{m['sensor_less']:.3g} at β_R/10, ×{m['sensor_more']:.3g} at 10 β_R",
                             f"有误：测量噪声引起的输入在 β_R/10 时为 {m['sensor_less']:.3g} 倍，10 β_R 时为 {m['sensor_more']:.3g} 倍"),
        PROCESS: lambda: Text(f"holds: at 10 β_Q the sum of the filter's poles ×{m['process_more']:.3g}, input from sensor noise "
                              f"×{m['process_input']:.3g}",
                              f"成立：10 β_Q 时滤波器极点之和为 {m['process_more']:.3g} 倍，"
                              f"测量噪声引起的输入为 {m['process_input']:.3g} 倍"),
        CAUTION: lambda: Text(f"holds: nothing is promised; here min |1 + ℓ| = {m['nearest']:.3g}",
                              f"成立：没有任何保证；此处 min |1 + ℓ| = {m['nearest']:.3g}"),
        UNITS: lambda: Text("slip: R_v = σ_v² I gives 1e-18; the figures use 1e-9 and 1e-6",
                            "有误：由 R_v = σ_v² I 应为 1e-18；图中用的是 1e-9 与 1e-6"),
    }
    rows = tuple((label, evidence[key]() if key == chosen else same("—")) for key, label in RULES if key != NONE)
    said = (Text("Choose a line with the last knob.", "用最后一个旋钮选择一行。") if chosen == NONE else
            Text("This line is wrong.", "这一行有误。") if chosen in SLIPS else Text("This line holds.", "这一行成立。"))
    return TableFigure("rules", Text("lines of the report, section 5.2", "报告第 5.2 节的若干行"),
                       (Text("line", "行"), Text("this loop says", "本回路的检验")), rows, said, Text("Report", "报告"))
