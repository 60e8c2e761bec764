"""Figures of the lesson, from an outcome and nothing else."""

from __future__ import annotations

import numpy as np

from app.engine.network import mean_lower_limit
from app.lesson.figures import Curve, Figure, MatrixFigure, PlaneFigure, Point, TableFigure, TimeFigure
from app.lesson.lesson import Outcome
from app.text.words import Text, same

from ..toolkit.figures import TIME_TAB
from .cases import KINDS, SAMPLES
from .job import RUNS
from .study import INPUT_LOSSES, LOSSES, MOST, OVER, ZERO, Study, bounds_over_loss, growth_now, input_growth, key

MEAN_TAB, WALL_TAB, INPUT_TAB = Text("Covariance", "协方差"), Text("Separation", "分离"), Text("Lost inputs", "输入丢包")
JUST = 1e-3  # of a period: how long before a sample its upper corner is drawn
TURN = np.linspace(0, 2 * np.pi, 73)
NEVER = Text("none", "不存在")
DIGITS, RAISED = "-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Time, covariance, separation, lost inputs: at most three in a tab."""
    return (_state(outcome), _input(outcome), _ages(outcome), _teeth(outcome), _means(outcome), _limits(outcome),
            _error(outcome), _spectrum(outcome), _blocks(outcome), _growth(outcome))


def times(outcome: Outcome[Study]) -> np.ndarray:
    """Two moments a sample: at it, and just before the next."""
    h = outcome.study.watched.sampled.plant.dt
    return np.column_stack([np.arange(SAMPLES), np.arange(1, SAMPLES + 1) - JUST]).ravel() * h


def _steps(values: np.ndarray) -> np.ndarray:
    """Held from sample to sample."""
    return np.repeat(values, 2)


def _lines(values: np.ndarray) -> np.ndarray:
    """Straight from sample to sample."""
    return np.column_stack([values, np.append(values[1:], values[-1])]).ravel()


# --- time ------------------------------------------------------------------------------------------------------------
def _state(outcome: Outcome[Study]) -> TimeFigure:
    s, signal = outcome.study, KINDS[outcome.design["case"]].watched
    true, guess = signal.of(s.x), signal.of(s.xhat)
    low, high = float(min(true.min(), guess.min(), 0.0)), float(max(true.max(), guess.max(), 0.0))
    comb = _steps(np.where(s.heard, low, low - 0.12 * (high - low)))
    lost = int(np.sum(~s.heard))
    return TimeFigure("state", signal.name, times(outcome),
                      (Curve(Text("true", "真实"), _lines(true)), Curve(Text("estimate", "估计"), _lines(guess), "estimate", "dash"),
                       Curve(Text("steps down: nothing heard", "下凹：没有收到"), comb, "disturbance", width=1.2)),
                      f"[{signal.unit}]" if signal.unit else "x₁", tab=TIME_TAB,
                      caption=Text(f"{lost} of {SAMPLES} samples brought no measurement; the longest gap lasted {longest(s.heard)}.",
                                   f"{SAMPLES} 个采样时刻中有 {lost} 个没有收到测量；最长的间断为 {longest(s.heard)} 个采样周期。"))


def longest(heard: np.ndarray) -> int:
    """The longest run of samples without a packet."""
    gap = most = 0
    for there in heard.tolist():
        gap = 0 if there else gap + 1
        most = max(most, gap)
    return most


def _input(outcome: Outcome[Study]) -> TimeFigure:
    s, d, unit = outcome.study, outcome.design, KINDS[outcome.design["case"]].input_unit
    lost = int(np.sum(s.run.draw.acted < 0))
    how = Text("zero stands in for them", "以零代替") if d["lost"] == ZERO else Text("the last one is held", "保持上一个值")
    return TimeFigure("input", Text("input asked for and applied", "指令输入与实际输入"), times(outcome),
                      (Curve(Text("asked", "指令"), _steps(s.asked[:, 0]), "second", "dash", 1.6),
                       Curve(Text("applied", "实际"), _steps(s.applied[:, 0]), "force")), f"u [{unit}]" if unit else "u",
                      tab=TIME_TAB, caption=_fate(lost, how, int(d["delay"])))


def _fate(lost: int, how: Text, late: int) -> Text:
    """What became of the inputs."""
    gone = Text(f"{lost} inputs lost, {how.en}; the others" if lost else "No input is lost; all",
                f"丢失 {lost} 个输入，{how.zh}；其余的" if lost else "没有丢失输入，全部")
    when = Text(f"arrive {late} samples late" if late else "arrive at once", f"晚 {late} 个采样周期到达" if late else "立即到达")
    return Text(f"{gone.en} {when.en}.", f"{gone.zh}{when.zh}。")


def _ages(outcome: Outcome[Study]) -> TimeFigure:
    sensor, actuator = outcome.study.ages
    return TimeFigure("age", Text("age of the newest packet", "最新数据包的年龄"), times(outcome),
                      (Curve(Text("measurement", "测量"), _steps(sensor).astype(float), "estimate"),
                       Curve(Text("input", "输入"), _steps(actuator).astype(float), "force", "dash", 1.6)),
                      "k − k₀", tab=TIME_TAB, window=(0.0, 4.0),
                      caption=Text(f"In samples. Oldest measurement in use: {int(sensor.max())}; oldest input: {int(actuator.max())}.",
                                   f"以采样数计。用过的最旧测量：{int(sensor.max())}；最旧输入：{int(actuator.max())}。"))


# --- covariance --------------------------------------------------------------------------------------------------------
def _teeth(outcome: Outcome[Study]) -> TimeFigure:
    s = outcome.study
    curves = [Curve(Text("this run", "本次运行"), s.teeth.ravel(), "plant")]
    if s.trials is not None and len(s.trials.mean):
        curves.append(Curve(Text(f"mean of {RUNS}", f"{RUNS} 次平均"), _bound(s.trials.mean), "estimate"))
    curves += [Curve(Text("mean, at least", "均值下界"), _bound(s.lower), "reference", "dot", 1.6),
               Curve(Text("mean, at most", "均值上界"), _bound(s.upper), "reference", "dash", 1.6)]
    peak = float(s.teeth.max())
    low, high = _big(s.lower[-1]), _big(s.upper[-1])
    mean = (Text(f"lies between {low} and {high}", f"在 {low} 与 {high} 之间") if s.upper[-1] < MOST else
            Text(f"is at least {low}", f"不小于 {low}"))
    words = Text(f"Variance of the error over that without loss. This run rises to {_big(peak)}; after {SAMPLES} samples the mean "
                 f"{mean.en}.",
                 f"误差方差与无丢包时之比。本次运行最高 {_big(peak)}；{SAMPLES} 个采样周期后均值{mean.zh}。")
    return TimeFigure("teeth", Text("how unsure the filter is", "滤波器有多不确定"), times(outcome), tuple(curves), "σ²/σ₀²",
                      log=True, window=(0.5, 10.0), tab=MEAN_TAB, caption=words)


def _bound(values: np.ndarray) -> np.ndarray:
    """A sequence before the packets of samples 0 … N, drawn straight."""
    return np.column_stack([values[:-1], values[1:]]).ravel()


def _big(value: float) -> str:
    """A ratio in few letters."""
    if value >= MOST:
        return "10⁹"
    if value < 1e4:
        return f"{value:.3g}"
    mantissa, power = f"{value:.1e}".split("e")
    return f"{mantissa}·10{str(int(power)).translate(str.maketrans(DIGITS, RAISED))}"


def _log(values: np.ndarray) -> np.ndarray:
    return np.log10(np.maximum(values, 1e-3))


def _means(outcome: Outcome[Study]) -> PlaneFigure:
    s, d = outcome.study, outcome.design
    edge = s.watched.sampled.edge
    lower, upper = bounds_over_loss(key(d))
    top = float(np.clip(np.ceil(np.log10(upper[-2])), 1.0, 6.0))
    curves = [Curve(Text("mean, at least", "均值下界"), _log(lower), "reference", "dot", 1.6, LOSSES),
              Curve(Text("mean, at most", "均值上界"), _log(upper), "reference", "dash", 1.6, LOSSES)]
    if edge.lost < 1:
        curves.append(Curve(Text("1/max|λ|²", "1/max|λ|²"), np.array([-1.0, top + 1]), "error", "solid", 2.0, np.full(2, edge.lost)))
    if not edge.exact:
        curves.append(Curve(Text("1/∏|λ|²", "1/∏|λ|²"), np.array([-1.0, top + 1]), "disturbance", "solid", 2.0, np.full(2, edge.safe)))
    points = [Point(d["loss"], float(np.clip(_log(s.teeth[:, 1]).mean(), -0.3, top)), "plant", "circle")]
    if s.trials is not None:
        points += [Point(float(p), float(min(_log(np.array(v)), top)), role, mark)  # type: ignore[arg-type]
                   for values, role, mark in ((s.trials.means, "estimate", "cross"), (s.trials.medians, "plant", "dot"))
                   for p, v in zip(OVER, values, strict=False)]
    words = (Text(f"After {SAMPLES} samples, log₁₀. Crosses: mean of {RUNS} runs; dots: their median. At high loss the crosses "
                  "can miss the rare runs that carry the mean. Circle: this run.",
                  f"{SAMPLES} 个采样周期之后，取 log₁₀。叉号为 {RUNS} 次运行的均值，圆点为中位数，圆圈为本次运行。"
                  "丢包率高时，叉号可能漏掉支配均值的少数运行。")
             if s.trials is not None else
             Text(f"After {SAMPLES} samples, log₁₀. Circle: this run. Press “Average {RUNS} runs” for means and medians.",
                  f"{SAMPLES} 个采样周期之后，取 log₁₀。圆圈为本次运行。按“平均 {RUNS} 次运行”，得到均值与中位数。"))
    return PlaneFigure("means", Text("mean variance over the share lost", "平均方差随丢包率的变化"), tuple(curves), tuple(points),
                       "p", "log₁₀ σ²/σ₀²", (0.0, 1.0), (-0.3, top), caption=words, tab=MEAN_TAB)


def _limits(outcome: Outcome[Study]) -> TableFigure:
    s, d, m = outcome.study, outcome.design, outcome.metrics
    plant = s.watched.sampled
    edge, p = plant.edge, d["loss"]
    least = (f"{s.watched.ratio(mean_lower_limit(plant.plant.A, plant.Q, p)):.4g}" if p * plant.radius**2 < 1 else NEVER)
    rows: tuple[tuple[Text | str, ...], ...] = (
        (same("max|λ|"), f"{plant.radius:.4f}"),
        (Text("diverges above 1/max|λ|²", "高于 1/max|λ|² 则发散"), f"{100 * edge.lost:.2f} %" if edge.lost < 1 else NEVER),
        (Text("bounded below", "低于此值则有界"), f"{100 * edge.safe:.2f} %"),
        (Text("lost now", "当前丢包率"), f"{100 * p:.1f} %"),
        (Text("loss · max|λ|², growth per sample", "丢包率 · max|λ|²，每个采样周期的增长倍数"), f"{m['growth']:.4f}"),
        (Text("least limit of the mean, σ²/σ₀²", "均值极限的下界，σ²/σ₀²"), least),
    )
    said = (Text("The mean stays bounded.", "均值有界。") if p < edge.safe else
            Text("The mean grows without end.", "均值无限增长。") if p > edge.lost else
            Text("Between the two: these bounds do not decide.", "介于两者之间：这两个界不能判定。"))
    return TableFigure("limits", Text("how many may be lost", "最多能丢多少"), (Text("quantity", "量"), Text("value", "值")), rows,
                       caption=said, tab=MEAN_TAB)


# --- separation --------------------------------------------------------------------------------------------------------
def _error(outcome: Outcome[Study]) -> TimeFigure:
    s, meter = outcome.study, outcome.metrics["separation_meter"]
    held = meter < 1e-6
    words = (Text("Separation meter: 0. The error is what noise and packets make of it, whatever the controller does.",
                  "分离度量：0。误差只取决于噪声与数据包，与控制器无关。") if held else
             Text(f"Separation meter: {_big(meter)}. The controller now drives the error of the estimate.",
                  f"分离度量：{_big(meter)}。控制器开始影响估计误差。"))
    return TimeFigure("error", Text("estimation error, in σ₀", "估计误差（以 σ₀ 计）"), times(outcome),
                      (Curve(Text("error", "误差"), _lines(s.size), "error"),
                       Curve(Text("of an observer told everything", "完全知情的观测器"), _lines(s.promised), "reference", "dash", 1.6)),
                      "‖e‖/σ₀", log=True, window=(0.1, 10.0), caption=words, tab=WALL_TAB)


def _spectrum(outcome: Outcome[Study]) -> PlaneFigure:
    groups = (("controller", "plant", "cross"), ("observer", "estimate", "cross"), ("loop", "reference", "circle"))
    radius = outcome.metrics["loop_radius"]
    reach = float(np.clip(1.15 * radius, 1.25, 4.5))
    points = tuple(Point(float(p.real), float(p.imag), role, mark)  # type: ignore[arg-type]
                   for name, role, mark in groups for p in outcome.poles[name])
    words = Text(f"Delay alone, no loss. Crosses: controller and observer as designed. Circles: the loop; the largest has modulus "
                 f"{radius:.3f}.",
                 f"只计时延、不计丢包。叉号：设计的控制器与观测器极点。圆圈：闭环极点，最大模为 {radius:.3f}。")
    return PlaneFigure("spectrum", Text("poles in the z-plane", "z 平面上的极点"),
                       (Curve(same("|z| = 1"), np.sin(TURN), "muted", "dash", 1.4, np.cos(TURN)),), points, "Re z", "Im z",
                       (-reach, reach), (-reach, reach), equal=True, caption=words, tab=WALL_TAB)


def _blocks(outcome: Outcome[Study]) -> MatrixFigure:
    s, d = outcome.study, outcome.design
    plant = s.watched.sampled.plant
    n, m, delay = plant.n, plant.m, int(d["delay"])
    names = (*(f"x{i + 1}" for i in range(n)), *(f"u{'' if m == 1 else j + 1}−{i + 1}" for i in range(delay) for j in range(m)),
             *(f"e{i + 1}" for i in range(n)))
    N = n + delay * m
    scale = np.concatenate([1 / np.sqrt(s.watched.weights), np.ones(delay * m), 1 / np.sqrt(s.watched.weights)])
    shown = s.loop / scale[:, None] * scale[None, :] if n > 1 else s.loop
    corner = float(np.abs(shown[N:, :N]).max())
    words = (Text("The lower left block is zero: state and inputs do not drive the error.", "左下块为零：状态与输入不影响误差。")
             if corner == 0 else
             Text("The lower left block is not zero: what the observer is told is not what acts, and the difference drives the error.",
                  "左下块不为零：观测器得到的输入不是实际起作用的输入，其差驱动误差。"))
    return MatrixFigure("blocks", Text("the loop in (x, inputs under way, e)", "(x, 在途输入, e) 坐标下的闭环"), shown, names, names,
                        (N,), words, WALL_TAB)


# --- lost inputs -------------------------------------------------------------------------------------------------------
def _growth(outcome: Outcome[Study]) -> PlaneFigure:
    d = outcome.design
    name, a, stretch, _ = key(d)
    held, zeroed = input_growth(name, a, stretch)
    hold_now, zero_now = growth_now(name, a, stretch, d["loss_u"])
    now = zero_now if d["lost"] == ZERO else hold_now
    top = float(np.clip(np.ceil(2 * max(held.max(), zeroed.max())) / 2, 1.5, 5.0))
    better = (Text("with nothing lost there is no difference", "没有丢失，二者无差别") if hold_now == zero_now else
              Text("holding is the better stand-in there", "此处保持更好") if hold_now < zero_now else
              Text("zero is the better stand-in there", "此处置零更好"))
    words = Text(f"Growth of E‖x‖² per sample under u = −Kx; below 1 it dies out. At {100 * d['loss_u']:.0f} % lost: {now:.3f}; "
                 f"{better.en}.",
                 f"u = −Kx 时 E‖x‖² 每周期的增长倍数；小于 1 则衰减。丢失 {100 * d['loss_u']:.0f} % 时为 {now:.3f}；{better.zh}。")
    return PlaneFigure("growth", Text("inputs lost: hold or zero", "输入丢包：保持还是置零"),
                       (Curve(Text("hold the last input", "保持上一个输入"), held, "force", x=INPUT_LOSSES),
                        Curve(Text("zero", "置零"), zeroed, "disturbance", "dash", x=INPUT_LOSSES),
                        Curve(Text("limit", "界限"), np.ones(2), "reference", "dot", 1.4, np.array([0.0, 1.0]))),
                       (Point(d["loss_u"], now, "plant", "circle"),), "pᵤ", "E‖x⁺‖² / E‖x‖²", (0.0, 1.0), (0.0, top),
                       caption=words, tab=INPUT_TAB)
