"""Tasks of the lesson: the face of what is cut, the wider gap, rank by another clock, geometry; and the exam item."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .body import NOMINAL, share
from .figures import show
from .study import RELATIVE, Study
from .system import AGAINST, STATES, cut

SMALL = 0.2  # error that the second task allows
FINE = 1e-6  # least relative tolerance of the third
WEAKEST = 10 * 8.852673e-05  # ten times the σ9 of the start


def _face(outcome: Outcome[Study]) -> Verdict:
    s, order, pair = outcome.study.system, outcome.study.cut.order, int(outcome.design["pair"]) - 1
    motion = s.motions[pair]
    held = [share(s, m, order) > 0.5 for m in s.motions]
    if motion.kind != AGAINST:
        return Verdict(False, Text(f"On the stage: {motion.name.en}. The report cuts away another motion.",
                                   f"场景中是“{motion.name.zh}”。报告截去的不是这种运动。"))
    if held != [k != pair for k in range(len(held))]:
        return Verdict(False, Text(f"A model of {order} states holds {sum(held)} of the five motions; it should lack this one alone.",
                                   f"{order} 阶模型保留了五种运动中的 {sum(held)} 种；应当只缺这一种。"))
    return Verdict(True, Text(f"σ = {show(s.hankel[2 * pair])}: the masses swing at {motion.frequency:.3g} Hz and the ghost's stand "
                              "still.", f"σ = {show(s.hankel[2 * pair])}：测试质量以 {motion.frequency:.3g} Hz 摆动，虚影中的却静止不动。"))


def _wider(outcome: Outcome[Study]) -> Verdict:
    s, c, compared = outcome.study.system, outcome.study.cut, outcome.study.compared
    if c.peak > SMALL:
        return Verdict(False, Text(f"{c.order} states err by {show(c.peak)}; at most {SMALL} is allowed.",
                                   f"{c.order} 个状态的误差为 {show(c.peak)}，不得超过 {SMALL}。"))
    if c.order > 1 and cut(s, c.order - 1).peak <= SMALL:
        size = show(c.peak) if c.order < STATES else "0"
        return Verdict(False, Text(f"{c.order} states err by {size}: good enough, but fewer states will do as well.",
                                   f"{c.order} 个状态的误差为 {size}：符合要求，但还可以更少。"))
    if compared.extra is None or compared.extra > 1e-3:
        return Verdict(False, Text("The model will do, but the LQG designed on it costs more than 0.1 % extra on ten states.",
                                   "模型可以，但据此设计的 LQG 用在十状态平台上，代价增加超过 0.1 %。"))
    return Verdict(True, Text(f"{c.order} states err by {show(c.peak)}, and the LQG on them costs {show(100 * compared.extra, 2)} % more.",
                              f"{c.order} 个状态的误差为 {show(c.peak)}，据此设计的 LQG 代价仅增加 {show(100 * compared.extra, 2)} %。"))


def _clock(outcome: Outcome[Study]) -> Verdict:
    d, r = outcome.design, outcome.study.ranks
    now = r.at(d["tolerance"], d["measure"])
    said = Text(f"ranks {now[0]} and {now[1]} with time in units of {show(r.clock)} s",
                f"以 {show(r.clock)} s 为时间单位，秩为 {now[0]} 与 {now[1]}")
    if d["measure"] != RELATIVE or d["tolerance"] < FINE * (1 - 1e-9):
        return Verdict(False, Text("Measure the singular values against the largest, with a tolerance of at least 1e-6.",
                                   "请以最大奇异值为基准，容差不小于 1e-6。"))
    if now != (STATES, STATES):
        return Verdict(False, Text(f"At τ = {show(d['tolerance'])}: {said.en}.", f"τ = {show(d['tolerance'])} 时，{said.zh}。"))
    return Verdict(True, Text(f"At τ = {show(d['tolerance'])}: {said.en}. The plant is the same.",
                              f"τ = {show(d['tolerance'])} 时，{said.zh}。对象没有变。"))


def _geometry(outcome: Outcome[Study]) -> Verdict:
    s = outcome.study.system
    weakest = s.hankel[-2]
    if s.parameters.mu > NOMINAL.mu * (1 + 1e-9):
        return Verdict(False, Text("Leave the test masses at 50 g or less.", "请保持测试质量不超过 50 g。"))
    if weakest < WEAKEST:
        return Verdict(False, Text(f"σ₉ = {show(weakest)}; at least {show(WEAKEST)} is wanted.",
                                   f"σ₉ = {show(weakest)}，要求不小于 {show(WEAKEST)}。"))
    return Verdict(True, Text(f"σ₉ = {show(weakest)}, {weakest / WEAKEST * 10:.0f} times the old one, by geometry alone.",
                              f"σ₉ = {show(weakest)}，为原来的 {weakest / WEAKEST * 10:.0f} 倍，只靠几何。"))


def exam(seed: int) -> ExamItem:
    """g s/(s² + c s + k) is cut away: both its Hankel values are g/(2c), so the bound 2Σσ is 2g/c."""
    rng = np.random.default_rng(seed)
    g, c, k = float(rng.integers(1, 10)), float(rng.choice([0.2, 0.4, 0.5, 0.8, 1.6, 2.5])), float(rng.integers(20, 90))
    return ExamItem({"g": f"{g:g}", "c": f"{c:g}", "k": f"{k:g}"}, 2 * g / c, 1e-6)


TASKS = (
    Task("face", _face, {"pair": "5", "order": 8}),
    Task("wider", _wider, {"order": 6}),
    Task("clock", _clock, {"clock": 5e-3, "tolerance": 1e-6}),
    Task("geometry", _geometry, {"s": 0.17}),
)
