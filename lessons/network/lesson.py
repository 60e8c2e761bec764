"""Network: measurements and inputs that travel in packets, how many may be lost, and what a delay does to separation."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.lesson.knobs import Choice, Number
from app.lesson.lesson import Check, Design, Formula, Job, Lesson, Outcome, Stage
from app.lesson.prose import read_prose
from app.text.words import Text

from ..toolkit.knobs import run_knobs
from ..toolkit.latex import matrix, number
from .cases import CART, CHIP, DECK, HORIZON, KINDS, SAMPLES, SCALAR, SLOWEST
from .pictures import all_figures
from .runs import AHEAD, APPLIED, ASKED, HOLD, ZERO, Story, loop_radius, tell
from .tasks import HELD, TASKS, exam
from .trials import RUNS, Trials, average, carry

FINE = 0.04  # s, how finely the stage plays
MOST_FINE = 12
SENSOR, ACTUATOR = Text("From the sensor", "传感器一侧"), Text("To the actuator", "执行器一侧")

KNOBS = (
    Choice("case", "", Text("case", "算例"), default=SCALAR, options=tuple((name, kind.label) for name, kind in KINDS.items()),
           hint=Text("Four that run away by themselves, and the deck, which does not.", "四个会自行发散的对象，以及不会发散的平台。")),
    Number("a", "a", Text("growth per sample a", "每周期增长倍数 a"), low=1.01, high=2.0, default=1.2, step=0.01, when=("case", (SCALAR,)),
           hint=Text("x⁺ = a x + u + w: left alone, x is multiplied by a every sample.",
                     "x⁺ = a x + u + w：不加控制时，x 每个采样周期乘以 a。")),
    Number("stretch", r"h/h_0", Text("sampling period", "采样周期"), "h₀", low=0.5, high=SLOWEST, default=1.0, step=0.05,
           when=("case", (CHIP, CART, DECK)),
           hint=Text("In units of the normal one: chip 0.5 s, cart 50 ms, deck 40 ms.",
                     "以常规周期为单位：芯片 0.5 s，小车 50 ms，平台 40 ms。")),
    Number("noise", r"\sigma_v", Text("sensor noise", "测量噪声"), "σ₀", low=0.1, high=10.0, default=1.0, scale="log",
           hint=Text("Standard deviation, in units of the normal one.", "标准差，以常规值为单位。")),
    Number("loss", "p", Text("measurements lost", "测量丢包率"), low=0.0, high=0.99, default=0.3, step=0.01, group=SENSOR,
           hint=Text("Each packet is lost with this probability, whatever happened to the others.", "每个数据包以此概率独立丢失。")),
    Number("jitter", "J", Text("late by up to (samples)", "最多迟到（周期数）"), low=0, high=4, default=0, scale="integer", group=SENSOR,
           hint=Text("Each measurement comes 0 to J samples late, so they may overtake each other.",
                     "每个测量随机晚到 0 到 J 个采样周期，可能后发先至。")),
    Choice("order", "", Text("late measurements", "迟到的测量"), default="stamped", group=SENSOR, when=("jitter", (1.0, 2.0, 3.0, 4.0)),
           options=(("stamped", Text("put in place by time stamp", "按时间戳归位")), ("arrival", Text("taken for fresh", "当作刚测的"))),
           hint=Text("With time stamps the filter goes back and takes each in where it belongs.",
                     "有时间戳时，滤波器回到相应时刻再纳入该测量。")),
    Number("loss_u", "p_u", Text("inputs lost", "输入丢包率"), low=0.0, high=0.95, default=0.1, step=0.01, group=ACTUATOR,
           hint=Text("Each input packet is lost with this probability.", "每个输入数据包以此概率丢失。")),
    Choice("lost", "", Text("in place of a lost input", "输入丢失时"), default=HOLD, group=ACTUATOR,
           options=((HOLD, Text("hold the last one", "保持上一个")), (ZERO, Text("apply zero", "置零"))),
           hint=Text("What the actuator does when no packet comes.", "没有收到数据包时执行器怎么做。")),
    Number("delay", "d", Text("delay of inputs (samples)", "输入时延（周期数）"), low=0, high=4, default=0, scale="integer", group=ACTUATOR,
           hint=Text("Every input acts this many samples after it was asked for.", "每个输入在发出若干采样周期之后才起作用。")),
    Choice("told", "", Text("the observer counts with", "观测器使用的输入"), default=APPLIED, group=ACTUATOR,
           options=((ASKED, Text("the input asked for", "指令输入")), (APPLIED, Text("the input applied", "实际输入")),
                    (AHEAD, Text("the input applied, u looks ahead", "实际输入，控制器预测"))),
           hint=Text("Looking ahead: u = −K times the state predicted over the delay.", "预测：u = −K 乘以时延之后的预测状态。")),
    *run_knobs(HORIZON),
)


@dataclass(frozen=True, eq=False)
class Study(Story):
    """A run and what many runs have shown so far."""

    trials: Trials | None = None


def compute(design: Design) -> Outcome:
    """One run over the two links, bounds of the mean covariance, the loop with its delay."""
    study = Study(**vars(tell(design)))
    s = study.watched.sampled
    metrics = {
        "critical": s.edge.lost, "safe": s.edge.safe, "growth": design["loss"] * s.radius**2, "radius": s.radius,
        "period": s.plant.dt, "separation_meter": study.meter, "loop_radius": loop_radius(study),
        "lower": float(study.lower[-1]), "upper": float(study.upper[-1]), "peak": float(study.teeth.max()),
        "lost_measurements": float(np.sum(~study.heard)), "lost_inputs": float(np.sum(study.run.draw.acted < 0)),
    }
    checks = (
        Check("bounded", Text("the mean covariance stays bounded", "平均协方差有界"), design["loss"] < s.edge.safe, metrics["growth"]),
        Check("separation", Text("the error lives by itself", "误差独自演化"), study.meter < HELD, study.meter),
        Check("loop", Text("the loop with its delay is stable", "含时延的闭环稳定"), metrics["loop_radius"] < 1, metrics["loop_radius"]),
    )
    poles = {"controller": np.linalg.eigvals(s.plant.A - s.plant.B @ s.K), "observer": study.watched.steady.poles,
             "loop": np.linalg.eigvals(study.loop)}
    return Outcome(design, {"K": s.K, "L": study.watched.steady.gain, "M": study.watched.steady.filter_gain}, poles, metrics,
                   checks, None, (), _stage(design, study), _formulas(design, study), _live(design, metrics), study)


def _stage(design: Design, study: Study) -> Stage:
    """The run played finely, straight between samples, with the packets as lamps and 3σ of the filter as a cloud."""
    kind, s = KINDS[design["case"]], study.watched.sampled
    fine = int(np.clip(np.ceil(s.plant.dt / FINE), 1, MOST_FINE))
    index, share = np.divmod(np.arange((SAMPLES - 1) * fine + 1), fine)
    share = (share / fine)[:, None]
    after = np.minimum(index + 1, SAMPLES - 1)
    lamps = np.column_stack([study.heard, study.fresh])[index]

    def played(x: np.ndarray) -> np.ndarray:
        return np.hstack([x[index] * (1 - share) + x[after] * share, lamps])
    row = np.array(kind.shown)
    sigma = np.sqrt(np.einsum("i,kij,j->k", row, study.run.plan.P, row))
    t = np.arange(len(index)) * s.plant.dt / fine
    return Stage(kind.body, t, played(study.x), played(study.xhat), study.applied[index], 3 * np.minimum(sigma, 1e3)[index])


def _formulas(design: Design, study: Study) -> tuple[Formula, ...]:
    s, p = study.watched.sampled, design["loss"]
    sign = "<" if p * s.radius**2 < 1 else r"\ge"
    out = [
        Formula("mean", r"P^+ = A (P - \gamma\, M C P) A^{\mathsf T} + Q",
                Text("γ is 1 when the packet comes and 0 when it is lost", "收到数据包时 γ 为 1，丢失时为 0")),
        Formula("edge", rf"p_c = \frac{{1}}{{\max|\lambda|^2}} = \frac{{1}}{{{number(s.radius, 4)}^2}} = {number(1 / s.radius**2, 4)}"
                if s.radius > 1 else rf"\max|\lambda| = {number(s.radius, 4)} \le 1"),
        Formula("growth", rf"p \max|\lambda|^2 = {number(p * s.radius**2, 4)} {sign} 1"),
    ]
    if not s.edge.exact:
        out.append(Formula("safe", rf"p < \prod|\lambda|^{{-2}} = {number(s.edge.safe, 4)}",
                           Text("enough for a bounded mean with one sensor", "单传感器时均值有界的充分条件")))
    if s.plant.n <= 4:
        out += [Formula("A", rf"A = {matrix(s.plant.A)}"), Formula("K", rf"K = {matrix(s.K)}"),
                Formula("M", rf"M = {matrix(study.watched.steady.filter_gain)}", Text("filter gain without loss", "无丢包时的滤波增益"))]
    return tuple(out)


def _live(design: Design, m: dict[str, float]) -> Text:
    lost = f"{100 * design['loss']:.0f} %"
    if m["critical"] >= 1:
        first = Text(f"{lost} of the measurements are lost; this plant does not run away, so the mean stays bounded.",
                     f"测量丢包率 {lost}；该对象不会自行发散，均值有界。")
    elif design["loss"] < m["safe"]:
        first = Text(f"{lost} of the measurements are lost, {100 * m['safe']:.1f} % may be: the mean stays bounded.",
                     f"测量丢包率 {lost}，允许 {100 * m['safe']:.1f} %：均值有界。")
    elif design["loss"] > m["critical"]:
        first = Text(f"{lost} of the measurements are lost, {100 * m['critical']:.1f} % is the limit: the mean diverges.",
                     f"测量丢包率 {lost}，极限为 {100 * m['critical']:.1f} %：均值发散。")
    else:
        first = Text(f"{lost} of the measurements are lost, between the two bounds.", f"测量丢包率 {lost}，介于两个界之间。")
    second = (Text(" Separation meter: 0.", " 分离度量：0。") if m["separation_meter"] < HELD else
              Text(f" Separation meter: {m['separation_meter']:.2g}.", f" 分离度量：{m['separation_meter']:.2g}。"))
    return Text(first.en + second.en, first.zh + second.zh)


LESSON = Lesson(
    "network", 18, KNOBS, compute, all_figures, answer=1, tasks=TASKS, exam=exam,
    source="Sinopoli, Schenato, Franceschetti, Poolla, Jordan, Sastry: Kalman filtering with intermittent observations, 2004",
    words=read_prose(Path(__file__).parent), job=Job(Text(f"Average {RUNS} runs", f"平均 {RUNS} 次运行"), average), carry=carry)

__all__ = ["LESSON"]
