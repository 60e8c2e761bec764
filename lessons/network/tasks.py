"""Tasks of the lesson: the edge, faster sampling, the gap between the bounds, the wall; and the exam item."""

from __future__ import annotations

import math

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .cases import CART, SCALAR, TWO
from .study import AHEAD, HELD, Study


def _edge(outcome: Outcome[Study]) -> Verdict:
    d, m = outcome.design, outcome.metrics
    if d["case"] != SCALAR or d["a"] < 1.3:
        return Verdict(False, Text("This task is about the scalar plant with a of at least 1.3.", "本题针对标量对象，a 不小于 1.3。"))
    now = Text(f"{100 * d['loss']:.1f} % are lost, {100 * m['critical']:.1f} % is the edge",
               f"丢包率 {100 * d['loss']:.1f} %，临界值 {100 * m['critical']:.1f} %")
    if d["loss"] >= m["critical"]:
        return Verdict(False, Text(f"{now.en}: the mean diverges.", f"{now.zh}：均值发散。"))
    if d["loss"] < m["critical"] - 0.02:
        return Verdict(False, Text(f"{now.en}: more could be lost.", f"{now.zh}：还可以多丢一些。"))
    return Verdict(True, Text(f"{now.en}: bounded, and close.", f"{now.zh}：有界，而且贴近边缘。"))


def _faster(outcome: Outcome[Study]) -> Verdict:
    d, m = outcome.design, outcome.metrics
    if d["case"] != CART or d["loss"] < 0.8:
        return Verdict(False, Text(f"{100 * d['loss']:.0f} % lost; take the pole on a cart and lose at least 80 %.",
                                   f"丢包率 {100 * d['loss']:.0f} %；请选小车倒立摆，丢包率不低于 80 %。"))
    if d["loss"] >= m["safe"]:
        return Verdict(False, Text(f"Sampled every {1e3 * m['period']:.0f} ms only {100 * m['safe']:.1f} % may be lost.",
                                   f"采样周期 {1e3 * m['period']:.0f} ms 时最多只能丢 {100 * m['safe']:.1f} %。"))
    return Verdict(True, Text(f"Sampled every {1e3 * m['period']:.0f} ms {100 * m['safe']:.1f} % may be lost.",
                              f"采样周期 {1e3 * m['period']:.0f} ms 时可以丢 {100 * m['safe']:.1f} %。"))


def _gap(outcome: Outcome[Study]) -> Verdict:
    d, m = outcome.design, outcome.metrics
    if d["case"] != TWO:
        return Verdict(False, Text("Choose the plant with two unstable modes.", "请选有两个不稳定模态的对象。"))
    if not m["safe"] < d["loss"] < m["critical"]:
        side = Text("both bounds stay finite", "上下界都有限") if d["loss"] <= m["safe"] else Text("both bounds diverge", "上下界都发散")
        return Verdict(False, Text(f"At {100 * d['loss']:.1f} % {side.en}.", f"丢包率 {100 * d['loss']:.1f} % 时{side.zh}。"))
    return Verdict(True, Text(f"At {100 * d['loss']:.1f} % the lower bound has a limit and the upper one has none.",
                              f"丢包率 {100 * d['loss']:.1f} % 时下界有极限，上界没有。"))


def _wall(outcome: Outcome[Study]) -> Verdict:
    d, m = outcome.design, outcome.metrics
    if d["case"] != CART or d["delay"] < 2:
        return Verdict(False, Text("Take the pole on a cart and a delay of at least 2 samples.", "请选小车倒立摆，时延不少于 2 个周期。"))
    if m["separation_meter"] > HELD:
        read = f"{m['separation_meter']:.2g}"
        return Verdict(False, Text(f"The meter reads {read}: the observer counts with an input that does not act.",
                                   f"度量为 {read}：观测器用的输入不是实际起作用的输入。"))
    if m["loop_radius"] >= 1:
        return Verdict(False, Text(f"The meter reads 0, but the loop has a pole of modulus {m['loop_radius']:.3f}.",
                                   f"度量为 0，但闭环有模为 {m['loop_radius']:.3f} 的极点。"))
    return Verdict(True, Text(f"The meter reads 0 and the largest modulus is {m['loop_radius']:.3f}, as designed.",
                              f"度量为 0，最大模为 {m['loop_radius']:.3f}，与设计一致。"))


def exam(seed: int) -> ExamItem:
    """ẋ = s x + u sampled every h: 100 e^{−2 s h} per cent may be lost."""
    rng = np.random.default_rng(seed)
    s, h = int(rng.integers(2, 13)) / 2, int(rng.integers(2, 11)) * 10
    return ExamItem({"s": f"{s:g}", "h": str(h)}, 100 * math.exp(-2 * s * h / 1000), 0.2)


TASKS = (
    Task("edge", _edge, {"a": 1.4, "loss": 0.5}),
    Task("faster", _faster, {"case": CART, "loss": 0.8, "stretch": 0.5}),
    Task("gap", _gap, {"case": TWO, "loss": 0.58}),
    Task("wall", _wall, {"case": CART, "delay": 2.0, "told": AHEAD}),
)
