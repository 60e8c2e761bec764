"""Nonlinear: extended and unscented filters where the world bends, judged by whether they know how wrong they are."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from app.lesson.knobs import Choice, Number, Switch
from app.lesson.lesson import Check, Design, Formula, Job, Lesson, Outcome, Stage
from app.lesson.prose import read_prose
from app.text.words import Text, same

from ..toolkit.knobs import run_knobs
from ..toolkit.latex import number
from .cases import EKF, FALL, KF, PENDULUM, PLATFORM, UKF
from .pictures import all_figures, verdict
from .report import LINES, NONE
from .runs import FILTERS, MANY, Study, draft, studies
from .tasks import TASKS, exam

HORIZON = 30.0  # s, of the longest record
BLOCK = 3  # samples of the job between two looks at the mailbox
VIEWS = ("line",)  # knobs that change no run
SHOWN = ("filter",)  # knobs that change no run where nobody steers

KNOBS = (
    Choice("case", "", Text("case", "对象"), default=FALL,
           options=((PLATFORM, Text("platform, hardening springs", "隔振平台（硬化弹簧）")),
                    (PENDULUM, Text("pole in the fog", "雾中的倒立摆")),
                    (FALL, Text("falling body, radar", "下落体与雷达"))),
           hint=Text("The last one is the classic of Athans, Wishner and Bertolini, and of Julier and Uhlmann.",
                     "最后一个是 Athans 等人与 Julier、Uhlmann 的经典算例。")),
    Choice("filter", "", Text("the ghost is the", "虚影显示"), default=EKF,
           options=((KF, Text("KF, expanded once", "KF（只线性化一次）")),
                    (EKF, Text("EKF, expanded at every estimate", "EKF（在每个估计处线性化）")),
                    (UKF, Text("UKF, sigma points", "UKF（sigma 点）"))),
           hint=Text("Whose estimate and 3σ are drawn, and who steers where somebody steers.",
                     "显示谁的估计与 3σ；需要控制时，也由它提供估计。")),
    Number("hardening", r"\gamma", Text("hardening γ", "硬化系数 γ"), low=0.0, high=1.0, default=0.3, step=0.05, when=("case", (PLATFORM,)),
           hint=Text("A spring stretched by 5 mm is 1 + γ times as stiff.", "弹簧伸长 5 mm 时，刚度为 1 + γ 倍。")),
    Number("weakening", r"\nu", Text("weakening of the coils ν", "线圈减弱系数 ν"), low=0.0, high=1.0, default=0.2, step=0.05,
           when=("case", (PLATFORM,)), hint=Text("The force falls by e^(−ν) for every 5 mm of gap.", "间隙每增大 5 mm，出力乘以 e^(−ν)。")),
    Number("force", "F", Text("known force", "已知力"), "N", low=0.0, high=4.0, default=1.0, step=0.1, when=("case", (PLATFORM,)),
           hint=Text("Amplitude at 0.16 Hz, and every filter is told.", "0.16 Hz 的幅值，各滤波器都知道。")),
    Number("size", r"\sigma_0", Text("unknown start, times", "初始不确定度倍数"), low=0.2, high=2.0, default=1.0, step=0.05,
           hint=Text("Standard deviation of the start, and the filters know it: 1 is 2 mm, 5.7° or that of the papers.",
                     "初始状态的标准差，滤波器知道它：取 1 时为 2 mm、5.7° 或论文的取值。")),
    Number("wind", "q", Text("process noise Q, times", "过程噪声 Q 的倍数"), low=0.1, high=10.0, default=1.0, scale="log",
           when=("case", (PLATFORM, PENDULUM)), hint=Text("True and believed alike; the falling body has none.",
                                                         "真值与设定值相同；下落体没有过程噪声。")),
    Number("sensor", "r", Text("sensor noise σ, times", "测量噪声 σ 的倍数"), low=0.1, high=10.0, default=1.0, scale="log",
           hint=Text("True and believed alike. Better sensors make the bends matter more.",
                     "真值与设定值相同。传感器越准，非线性越要紧。")),
    Switch("steer", "", Text("LQR on the estimate", "用估计作 LQR 反馈"), default=False, when=("case", (PLATFORM,)),
           hint=Text("The deck is steered by the ghost's estimate; the pole always is.", "用虚影的估计控制平台；倒立摆始终如此。")),
    Number("alpha", r"\alpha", Text("UKF spread α", "UKF 的 α"), low=0.1, high=1.0, default=1.0, step=0.05,
           hint=Text("How far out the sigma points lie: √(α²(n + κ)) standard deviations.", "sigma 点离中心 √(α²(n + κ)) 个标准差。")),
    Number("beta", r"\beta", Text("UKF weight β", "UKF 的 β"), low=0.0, high=4.0, default=2.0, step=0.1,
           hint=Text("Added to the middle point's weight in covariances; 2 for a Gaussian.", "加在中心点的协方差权重上；高斯分布取 2。")),
    Number("kappa", r"\kappa", Text("UKF spread κ", "UKF 的 κ"), low=-1.0, high=3.0, default=0.0, step=0.1,
           hint=Text("Moves the points like α; 3 − n matches one fourth moment.", "与 α 一样移动各点；取 3 − n 可匹配一个四阶矩。")),
    Switch("redraw", "", Text("sigma points drawn anew", "重抽 sigma 点"), default=True,
           hint=Text("Off: Algorithm 3 of the report as printed.", "关：按报告印出的算法 3。")),
    Choice("line", "", Text("line of the report in doubt", "报告中可疑的一行"), default=NONE, options=LINES,
           hint=Text("The tab Algorithm 3 says what the engine finds.", "“算法 3”标签页给出计算结果。")),
    *run_knobs(HORIZON),
)


def compute(design: Design) -> Outcome:
    """A few runs of the case, watched by three filters."""
    return outcome_of(design, draft(design))


def outcome_of(design: Design, study: Study) -> Outcome:
    """What a study shows."""
    who, case = design["filter"], study.case
    metrics = _metrics(study)
    spread = 3 * case.scale * case.error_gain * study.sigmas[who][:, case.state]
    away = np.clip(study.means[who] - study.x, -1e9, 1e9)
    stage = Stage(case.body, study.t, study.x, study.x + case.error_gain * away, study.u if study.u.shape[1] else
                  np.zeros((len(study.t), 1)), spread)
    if case.id == FALL:
        stage = _smooth(stage)
    return Outcome(design, {}, {}, metrics, _checks(study, metrics), None, (), stage, _formulas(design, study), _live(design, study),
                   study)


def _smooth(stage: Stage) -> Stage:
    """A sample a second is too coarse to watch: straight lines between."""
    t = np.linspace(0.0, float(stage.t[-1]), 10 * (len(stage.t) - 1) + 1)

    def fine(values: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(t, stage.t, column) for column in values.T], axis=1)

    assert stage.xhat is not None and stage.spread is not None
    return Stage(stage.body, t, fine(stage.x), fine(stage.xhat), np.zeros((len(t), 1)), np.interp(t, stage.t, stage.spread))


def _metrics(s: Study) -> dict[str, float]:
    found = {f"nees_{n}": s.ratio(n) for n in FILTERS}
    found |= {f"nis_{n}": float(min(np.mean(s.nis[n]) / len(s.case.R), 1e9)) for n in FILTERS}
    found |= {f"largest_{n}": float(np.max(s.nees[n])) for n in FILTERS}
    found |= {f"apart_{n}": float(min(s.apart[n], 1e9)) for n in (EKF, UKF)}
    found |= {f"lost_{n}": float(s.lost[n]) for n in FILTERS}
    return found | {"runs": float(s.runs), "fallen": float(s.fallen), "horizon": float(s.t[-1])}


def _checks(s: Study, m: dict[str, float]) -> tuple[Check, ...]:
    n = s.x.shape[1]

    def held(name: str) -> bool:
        return verdict(s.nees[name], n, s.runs).en == "consistent"

    return (
        *(Check(f"{f}_consistent", Text(f"{f.upper()}: NEES in its band", f"{f.upper()}：NEES 在带内"), held(f), m[f"nees_{f}"])
          for f in FILTERS),
        Check("same", Text("EKF and UKF are the KF, to rounding", "EKF、UKF 与 KF 相同（舍入误差内）"),
              max(m["apart_ekf"], m["apart_ukf"]) < 1e-6, max(m["apart_ekf"], m["apart_ukf"])),
    )


def _formulas(design: Design, s: Study) -> tuple[Formula, ...]:
    n = s.x.shape[1]
    reach = design["alpha"]**2 * (n + design["kappa"])
    first = 1 - n / reach
    law = {
        PLATFORM: rf"F_k = k e\,(1 + {number(design['hardening'])}\,(e/\ell)^2)",
        PENDULUM: r"\ell\ddot\theta = g\sin\theta - \ddot p\cos\theta",
        FALL: r"\dot v = -e^{-\kappa h} v^2 \beta, \quad y = \sqrt{M^2 + (h - H)^2}",
    }[design["case"]]
    out = [Formula("law", law),
           Formula("weights", rf"W_0^m = {number(first)}, \quad W_0^c = {number(first + 1 - design['alpha']**2 + design['beta'])}, \quad "
                   rf"W_i = {number(0.5 / reach)}", Text(f"of {2 * n + 1} points", f"共 {2 * n + 1} 个点")),
           Formula("nees", rf"\mathrm{{NEES}} / {n} = {number(s.ratio(KF))},\; {number(s.ratio(EKF))},\; {number(s.ratio(UKF))}",
                   same("KF, EKF, UKF"))]
    if design["case"] == PLATFORM:
        out.insert(1, Formula("coil", rf"F_u = u\, e^{{-{number(design['weakening'])}\, d/\ell}}, \quad \ell = 5\,\mathrm{{mm}}"))
    return tuple(out)


def _live(design: Design, s: Study) -> Text:
    n = s.x.shape[1]
    who = design["filter"]
    words = verdict(s.nees[who], n, s.runs)
    each = [f"{f.upper()} {s.ratio(f):.3g}" for f in FILTERS]
    return Text(f"NEES per state over {s.runs} runs (1 expected): {', '.join(each)}. The {who.upper()} is {words.en}.",
                f"{s.runs} 次运行中每个状态的 NEES（应为 1）：{'，'.join(each)}。{who.upper()} {words.zh}。")


# --- many runs -----------------------------------------------------------------------------------------------------------
def try_often(outcome: Outcome) -> Iterator[tuple[float, Outcome]]:
    """The job: the whole record, many runs at once."""
    design, count = outcome.design, outcome.study.case.full
    for k, study in enumerate(studies(design, MANY, count, BLOCK), start=1):
        if study is None:
            yield min(k * BLOCK / count, 0.99), outcome
        else:
            yield 1.0, outcome_of(design, study)


def carry(before: Outcome, after: Outcome) -> Outcome:
    """The many runs go over where only what is looked at has changed."""
    old, new = before.study, after.study
    if old.runs <= new.runs:
        return after
    steered = old.case.id == PENDULUM or (old.case.id == PLATFORM and after.design["steer"])
    views = VIEWS if steered else VIEWS + SHOWN
    return outcome_of(after.design, old) if before.design.same_but_for(after.design, views) else after


LESSON = Lesson(
    "nonlinear", 14, KNOBS, compute, all_figures, answer=2, tasks=TASKS, exam=exam,
    source="Platform report (003), chapter 4, Algorithms 1–3, and appendix B; Athans, Wishner and Bertolini (1968); Julier, Uhlmann and "
           "Durrant-Whyte (2000)",
    words=read_prose(Path(__file__).parent), job=Job(Text(f"Try {MANY} runs", f"试验 {MANY} 次"), try_often), carry=carry)

__all__ = ["LESSON"]
