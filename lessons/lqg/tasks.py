"""Tasks of the lesson: margins vanish, recovery, twenty decibels with time to spare, a rule turned round; the exam."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.plants.doyle import gains
from app.text.words import Text

from .cases import DOYLE, REPORT
from .knobs import NONE, SENSOR, UNITS
from .loops import real, setting_of
from .study import Study

EDGE = 1.001  # a gain that breaks the loop of the first task
HEAVY = 1000.0  # q and σ at least, in the second
UP, DOWN = 2.0, 0.5  # gain margins asked back
DECIBEL, SECONDS = 20.0, 0.1


def _on(outcome: Outcome[Study], case: str) -> bool:
    return outcome.study.case.id == case


def _vanish(outcome: Outcome[Study]) -> Verdict:
    if not _on(outcome, DOYLE):
        return Verdict(False, Text("Choose Doyle's plant first.", "请先选择 Doyle 的对象。"))
    high = outcome.study.real.margins.gain[1]
    if outcome.design["recovery"] > 0:
        return Verdict(False, Text("Leave recovery at 0: plain LQG is asked for.", "请保持 ρ = 0：要求的是普通 LQG。"))
    if high > EDGE:
        return Verdict(False, Text(f"It still bears a gain of {high:.5g}; an error of 0.1 % is to break it.",
                                   f"它还能承受 {high:.5g} 倍的增益；要求 0.1 % 的误差就使其失稳。"))
    return Verdict(True, Text(f"At {high:.6g} times the model's gain this optimal loop is lost.",
                              f"增益到模型值的 {high:.6g} 倍，这个最优回路就失稳。"))


def _recover(outcome: Outcome[Study]) -> Verdict:
    d, s = outcome.design, outcome.study
    if not _on(outcome, DOYLE) or d["q"] < HEAVY or d["sigma"] < HEAVY:
        return Verdict(False, Text("Doyle's plant with q and σ of at least 1000, please.", "请使用 Doyle 的对象，且 q、σ 都不小于 1000。"))
    low, high = s.real.margins.gain
    found = Text(f"Gains from {low:.3g} to {high:.4g} are borne", f"可承受的增益为 {low:.3g} 到 {high:.4g} 倍")
    if high < UP or low > DOWN:
        return Verdict(False, Text(f"{found.en}; from 0.5 to 2 is wanted.", f"{found.zh}；要求 0.5 到 2 倍。"))
    if s.density is None:
        return Verdict(False, Text("The margins are there, but the true gain m lies outside them.", "裕度有了，但真实增益 m 在裕度之外。"))
    price = np.linalg.norm(s.cost.sensors) / np.linalg.norm(s.plain_cost.sensors)
    return Verdict(True, Text(f"{found.en}; the sensors' noise now moves the input {price:.3g} times as much.",
                              f"{found.zh}；测量噪声引起的输入变为原来的 {price:.3g} 倍。"))


def _twenty(outcome: Outcome[Study]) -> Verdict:
    s = outcome.study
    if not _on(outcome, REPORT) or s.suppression is None:
        return Verdict(False, Text("A stable loop on the platform is asked for.", "要求平台上的一个稳定回路。"))
    worst = float(np.min(s.suppression))
    setting = setting_of(s.case, outcome.design)
    least = min(real(s.case, setting.factors, setting.recovery, i).margins.delay for i in range(s.case.plant.m))
    found = Text(f"The least of the three channels gains {worst:.1f} dB, the least delay margin is {least:.3g} s",
                 f"三个通道中最少降低 {worst:.1f} dB，最小时延裕度为 {least:.3g} s")
    if worst < DECIBEL or least < SECONDS:
        return Verdict(False, Text(f"{found.en}; wanted are 20 dB and 0.1 s.", f"{found.zh}；要求 20 dB 和 0.1 s。"))
    return Verdict(True, Text(f"{found.en}.", f"{found.zh}。"))


def _rule(outcome: Outcome[Study]) -> Verdict:
    rule, more = outcome.design["rule"], outcome.metrics.get("sensor_more", np.inf)
    if rule == NONE:
        return Verdict(False, Text("Choose the line that you doubt.", "请选择你所怀疑的一行。"))
    if rule == UNITS:
        return Verdict(False, Text("That one is a slip of units; a rule of tuning is asked for.",
                                   "那是单位上的笔误；这里要找的是一条调参规则。"))
    if rule != SENSOR:
        return Verdict(False, Text("This line holds; the table says why.", "这一行成立；表中说明了理由。"))
    if not more < 0.9:
        return Verdict(False, Text(f"Here ten times β_R leaves {more:.3g} times the noise in the input; find a loop with less than 0.9.",
                                   f"此处 β_R 增大十倍后，输入中的噪声为 {more:.3g} 倍；请找一个小于 0.9 倍的回路。"))
    return Verdict(True, Text(f"Ten times β_R leaves {more:.3g} times the noise in the input: suppressed more, not less.",
                              f"β_R 增大十倍，输入中的噪声只剩 {more:.3g} 倍：抑制增强，而不是减弱。"))


def exam(seed: int) -> ExamItem:
    """By how many per cent may the input's gain exceed the model's: 100/(d f)."""
    rng = np.random.default_rng(seed)
    roots = rng.integers(3, 13, size=2)  # √(4 + q) and √(4 + σ) are whole
    q, sigma = int(roots[0] ** 2 - 4), int(roots[1] ** 2 - 4)
    f, d = gains(q, sigma)
    answer = 100 / (d * f)
    return ExamItem({"q": str(q), "sigma": str(sigma)}, answer, 0.01 * answer)


TASKS = (
    Task("vanish", _vanish, {"case": DOYLE, "q": 1000.0, "sigma": 1000.0}),
    Task("recover", _recover, {"case": DOYLE, "q": 1000.0, "sigma": 1000.0, "recovery": 6.0}),
    Task("twenty", _twenty, {"beta_r": 1e8}),
    Task("rule", _rule, {"rule": SENSOR}),
)
