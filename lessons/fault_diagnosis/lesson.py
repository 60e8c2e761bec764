"""Fault diagnosis: which sensor lies? A bank of observers, thresholds from the noise, and a loop that acts on the verdict."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from app.lesson.knobs import Choice, Knob, Number
from app.lesson.lesson import Board, Check, Design, Formula, Job, Lesson, Outcome, Stage
from app.lesson.prose import read_prose
from app.text.words import Text

from ..toolkit.boards import listed
from ..toolkit.knobs import run_knobs
from ..toolkit.latex import matrix, number
from .bank import COUNT, DT, HORIZON, MODEL, PLACES, guard
from .body import BODY
from .diagnosis import ENERGY, MEAN
from .pictures import PLACE_NAMES, all_figures
from .runs import BIAS, BLIND, DRIFT, NONE, OPEN, STUCK, SWITCH
from .study import RUNS, Study, healthy_case, study, try_often, unknown_coil
from .tasks import TASKS, exam, hourly

FAULT, TEST, LOOP = Text("Fault", "故障"), Text("Diagnosis", "诊断"), Text("Loop", "回路")
SENSOR_PLACES, COIL_PLACES = PLACES[:4], PLACES[4:]

KNOBS: tuple[Knob, ...] = (
    Choice("place", "", Text("what fails", "故障部件"), default="HL", group=FAULT,
           options=((NONE, Text("nothing", "无")), *((p, PLACE_NAMES[i]) for i, p in enumerate(PLACES))),
           hint=Text("The bank does not know it.", "诊断器并不知道。")),
    Choice("kind", "", Text("how it lies", "故障类型"), default=BIAS, when=("place", SENSOR_PLACES), group=FAULT,
           options=((BIAS, Text("bias", "恒定偏差")), (DRIFT, Text("drift", "漂移")), (STUCK, Text("stuck", "卡死"))),
           hint=Text("A constant added, a growing error, or a reading frozen at its last value.",
                     "加一个常数、误差不断增长，或读数停在最后的值。")),
    Number("bias", "b", Text("bias", "偏差"), "mm/s", low=0.5, high=20.0, default=3.0, scale="log",
           when=("kind", (BIAS,)), group=FAULT, hint=Text("The noise of a reading is 1 mm/s.", "读数噪声的标准差为 1 mm/s。")),
    Number("drift", "c", Text("drift", "漂移速率"), "mm/s²", low=0.5, high=10.0, default=4.0, scale="log",
           when=("kind", (DRIFT,)), group=FAULT, hint=Text("How fast the error grows.", "误差增长的速率。")),
    Number("loss", r"\eta", Text("force lost", "失效比例"), "%", low=5.0, high=100.0, default=60.0, step=1.0,
           when=("place", COIL_PLACES), group=FAULT,
           hint=Text("How much of what is asked the coil does not deliver.", "线圈未能输出的指令比例。")),
    Number("at", "t_f", Text("fails at", "故障时刻"), "s", low=1.0, high=10.0, default=4.0, step=0.1,
           when=("place", PLACES), group=FAULT, hint=Text("When the fault sets in.", "故障开始的时间。")),
    Choice("statistic", "T", Text("statistic", "统计量"), default=ENERGY, group=TEST,
           options=((ENERGY, Text("sum of squares", "平方和")), (MEAN, Text("square of the mean", "均值的平方"))),
           hint=Text("Squares see every shape; the mean sees lasting errors sooner and sines hardly at all.",
                     "平方和对任何形状有效；均值对持久误差更灵敏，对正弦几乎无效。")),
    Number("window", "N", Text("window", "窗口"), low=1, high=150, default=25, scale="integer", group=TEST,
           hint=Text("Samples of 0.02 s that are judged together.", "一起判断的采样数，每个 0.02 s。")),
    Number("rate", r"\alpha", Text("false-alarm rate", "误报率"), low=1e-6, high=0.1, default=1e-3, scale="log", group=TEST,
           hint=Text("Of one window of one healthy member; the threshold follows from it.",
                     "健康时一个成员一个窗口的误报概率，阈值由它算出。")),
    Choice("loop", "", Text("the loop", "回路"), default=BLIND, group=LOOP,
           options=((OPEN, Text("open", "开环")), (BLIND, Text("closed, nobody acts", "闭环，无人处理")),
                    (SWITCH, Text("closed, acts on the verdict", "闭环，按判决切换"))),
           hint=Text("Acting: leave the accused sensor out, or stop using the accused coil.",
                     "切换：去掉被指认的传感器，或停用被指认的线圈。")),
    Number("force", "F", Text("known force", "已知力"), "N", low=0.0, high=4.0, default=1.0, step=0.1, group=LOOP,
           hint=Text("A sine on all three coils; the bank is told.", "三个线圈上的正弦力，诊断器知道它。")),
    Number("tone", "f", Text("its frequency", "其频率"), "Hz", low=0.2, high=5.0, default=0.5, scale="log", group=LOOP,
           hint=Text("The deck's own modes lie at 1.0, 1.2 and 1.5 Hz.", "平台自身的模态在 1.0、1.2 和 1.5 Hz。")),
    Number("stiffer", r"\delta", Text("springs stiffer than the model", "弹簧比模型硬"), "%", low=-20.0, high=20.0, default=0.0, step=0.5,
           group=LOOP, hint=Text("The bank keeps believing its model.", "诊断器仍相信原来的模型。")),
    *run_knobs(HORIZON),
)


def compute(design: Design) -> Outcome:
    """The run with its fault, the bank, the verdict, and what it does to the loop."""
    s = study(design)
    return _outcome(design, s)


def _outcome(design: Design, s: Study) -> Outcome:
    members = guard().bank.members
    coil = s.case.coil or 0
    return Outcome(design, {"L": guard().whole.K}, {m.name: m.poles for m in members}, _metrics(s), _checks(s), None, _boards(s),
                   _stage(s), _formulas(s, coil), _live(s), s)


def _metrics(s: Study) -> dict[str, float]:
    v, t = s.verdict, s.trials
    found = {"trials": float(t.runs), "windows": float(t.windows), "worst_share": float(t.alarms.max()) / t.windows,
             "right": float(t.right), "wrong": float(t.wrong)} if t is not None else {}
    return {
        "threshold": s.test.threshold, "dof": float(s.test.dof), "needed": s.test.needed, "hourly": hourly(s),
        "accused": -1.0 if v.who is None else float(PLACES.index(v.who)), "right_verdict": float(s.right),
        "delay": -1.0 if s.delay is None else s.delay,
        "expected_delay": -1.0 if s.forecast.delay is None else DT * s.forecast.delay,
        "pitch": s.calm, **found,
    }


def _checks(s: Study) -> tuple[Check, ...]:
    signature = guard().bank.signature
    single = len({tuple(column) for column in signature.T}) == len(PLACES)
    early = s.verdict.decided is not None and s.verdict.decided < s.case.start
    conditions = [unknown_coil(j) for j in range(3)]
    return (
        Check("signatures", Text("every fault has a signature of its own", "每个故障都有独特的特征"), single, float(single)),
        Check("rank", Text("rank(CE) = rank(E) for every coil", "每个线圈都满足 rank(CE) = rank(E)"),
              all(c.rank_CE == c.rank_E for c in conditions), float(min(c.rank_CE for c in conditions))),
        Check("right", Text("the right part is accused", "指认正确") if s.case.place != NONE else
              Text("nobody is accused", "无人被指认"), s.right if s.case.place != NONE else s.verdict.who is None,
              -1.0 if s.delay is None else s.delay),
        Check("patient", Text("nobody is accused before the fault", "故障之前无人被指认"), not early, float(early)),
        Check("expected", Text("the fault is large enough to count on that", "故障足够大，可以指望检出"),
              s.forecast.delay is not None, -1.0 if s.forecast.delay is None else DT * s.forecast.delay),
    )


def _boards(s: Study) -> tuple[Board, Board]:
    zeros = unknown_coil(s.case.coil or 0).zeros
    poles = guard().bank.members[_ignoring(s)].poles
    lively = np.log(poles[np.abs(poles) > 1e-6].astype(complex)) / DT
    w = MODEL.observer_window
    return (
        Board("deck", Text("deck: poles ×, zero ○", "平台：极点 ×，零点 ○"), tuple(MODEL.plant.poles),
              zeros=() if zeros is None else tuple(complex(z) for z in zeros), side="left", re_low=-6.0, re_high=2.0, im_high=12.0),
        Board("member", Text("poles of the quiet member", "安静成员的极点"), listed(lively),
              role="estimate", side="right", re_low=w.re_low, re_high=w.re_high, im_high=w.im_high),
    )


def _ignoring(s: Study) -> int:
    """The member that ignores the true fault; the first one if there is none."""
    return 0 if s.column is None else s.column


def _stage(s: Study) -> Stage:
    fails, accused = np.zeros((COUNT, 7)), np.zeros((COUNT, 7))
    if s.column is not None:
        fails[s.case.start:, s.column] = 1.0
    if s.verdict.who is not None:
        accused[s.verdict.decided:, PLACES.index(s.verdict.who)] = 1.0
    t = DT * np.arange(COUNT)
    return Stage(BODY, t, np.hstack([s.record.x, fails, accused]), np.hstack([s.record.xhat, np.zeros((COUNT, 14))]),
                 s.record.applied)


def _formulas(s: Study, coil: int) -> tuple[Formula, ...]:
    quiet = guard().bank.members[_ignoring(s)]
    name = quiet.name.replace("−", "-")
    total = (rf"T = \sum_{{i=0}}^{{{s.test.window - 1}}} \nu_{{k-i}}^{{\mathsf T}} S^{{-1}} \nu_{{k-i}}" if s.test.statistic == ENERGY
             else rf"T = \tfrac{{1}}{{{s.test.window}}} \| \sum_i S^{{-1/2}} \nu_{{k-i}} \|^2")
    zeros = unknown_coil(coil).zeros
    return (
        Formula("statistic", total, Text("of each member", "每个成员的统计量")),
        Formula("threshold", rf"\chi^2_{{{s.test.dof},\,1-\alpha}} = {number(s.test.threshold, 4)}, "
                             rf"\quad \alpha = {number(s.test.rate, 2)}",
                Text("threshold", "阈值")),
        Formula("S", rf"S_{{{name}}} = {matrix(1e6 * quiet.S)}", Text("covariance of its innovation in mm²/s²", "新息协方差，单位 mm²/s²")),
        Formula("coil", rf"\mathrm{{rank}}\, C b_{{{coil + 1}}} = \mathrm{{rank}}\, b_{{{coil + 1}}} = 1, \quad "
                        rf"s_0 = {number(0.0 if zeros is None else float(abs(zeros[0])) if abs(zeros[0]) > 1e-9 else 0.0)}",
                Text("a coil as unknown input: its zero", "线圈作为未知输入：其零点")),
    )


def _live(s: Study) -> Text:
    v, place = s.verdict, s.case.place
    if v.who is None:
        alarms = "" if v.first is None else f" First alarm at {DT * v.first:.2f} s."
        alarms_zh = "" if v.first is None else f"首次报警在 {DT * v.first:.2f} s。"
        healthy = Text("Nothing fails and nobody is accused.", "没有故障，也无人被指认。")
        missed = Text(f"{place} fails at {DT * s.case.start:.1f} s and nobody is accused.",
                      f"{place} 在 {DT * s.case.start:.1f} s 失效，但无人被指认。")
        said = healthy if place == NONE else missed
        return Text(said.en + alarms, said.zh + alarms_zh)
    at = DT * (v.decided or 0)
    if place == NONE or not s.right:
        return Text(f"{v.who} is accused at {at:.2f} s, wrongly.", f"{at:.2f} s 时指认 {v.who}，指认错误。")
    due = Text("", "") if s.forecast.delay is None else Text(f" The design promises it within {DT * s.forecast.delay:.2f} s.",
                                                         f"按设计应在 {DT * s.forecast.delay:.2f} s 内判出。")
    return Text(f"{v.who} is accused {s.delay:.2f} s after it failed, rightly.{due.en}",
                f"{v.who} 失效 {s.delay:.2f} s 后被正确指认。{due.zh}")


def _often(outcome: Outcome) -> Iterator[tuple[float, Outcome]]:
    """The job: drawn runs, healthy ones for the false alarms and faulty ones for the verdicts."""
    for fraction, better in try_often(outcome.study, int(outcome.design["seed"])):
        yield fraction, replace(outcome, study=better, metrics=_metrics(better))


def carry(before: Outcome, after: Outcome) -> Outcome:
    """Counts go over where neither the fault nor the test has changed: acting on a verdict and a kick do not touch them."""
    old, new = before.study, after.study
    alike = (old.test == new.test and healthy_case(old.case) == healthy_case(new.case)
             and replace(old.case, loop=BLIND, kick=-1.0) == replace(new.case, loop=BLIND, kick=-1.0)
             and before.design["seed"] == after.design["seed"])
    if old.trials is None or not alike or (new.trials is not None and new.trials.runs >= old.trials.runs):
        return after
    kept = replace(new, trials=old.trials)
    return replace(after, study=kept, metrics=_metrics(kept))


LESSON = Lesson(
    "fault-diagnosis", 17, KNOBS, compute, all_figures, answer=2, tasks=TASKS, exam=exam,
    source="Chen and Patton, Robust Model-Based Fault Diagnosis for Dynamic Systems (1999), chapter 3; platform report (003), section 3.1",
    words=read_prose(Path(__file__).parent), job=Job(Text(f"Try {RUNS} runs", f"试验 {RUNS} 次"), _often), carry=carry)

__all__ = ["LESSON"]
