"""Tasks of the lesson: the kink of J, two observers that are one, the slips of the printed paper; and the exam item."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .knobs import COLUMNS, LINES, ONE, REMARKS, TWO
from .paper import PRINTED_SIZES, claimed_columns, free_columns, remark_3, true_size
from .study import BEST, Story

FLOOR_J = 38 / 9


def _kink(outcome: Outcome[Story]) -> Verdict:
    d, J = outcome.design, outcome.metrics["J"]
    if d["example"] != ONE or any(d[name] != 1.0 for name in ("alpha", "beta", "gamma")):
        return Verdict(False, Text("This task is about Example 1 with all weights at 1.", "本题针对例 1，所有权重取 1。"))
    if J > FLOOR_J + 0.05:
        return Verdict(False, Text(f"J is {J:.3g}; it can be brought below {FLOOR_J + 0.05:.3g}.",
                                   f"现在 J = {J:.3g}；可以降到 {FLOOR_J + 0.05:.3g} 以下。"))
    return Verdict(True, Text(f"J is {J:.4g} at s = {d['pole'][0].real:.4g}; its least value is 38/9, at −5/3.",
                              f"s = {d['pole'][0].real:.4g} 时 J = {J:.4g}；最小值为 38/9，在 −5/3 处取得。"))


def _one_observer(outcome: Outcome[Story]) -> Verdict:
    d, gap = outcome.design, outcome.metrics["coordinate_gap"]
    if d["example"] != TWO or abs(d["w12"]) < 1:
        return Verdict(False, Text("Take Example 2 and keep |w| at 1 or more.", "请选例 2，并保持 |w| 不小于 1。"))
    if gap > 1e-6:
        return Verdict(False, Text(f"On the model e_u still differs from that of W = I by up to {gap:.3g}.",
                                   f"在模型上，e_u 与 W = I 时仍相差最多 {gap:.3g}。"))
    return Verdict(True, Text(f"W has w = {d['w12']:g}, and e_u equals that of W = I to {max(gap, 1e-16):.0e}: one observer, twice.",
                              f"w = {d['w12']:g} 时，e_u 与 W = I 时相同，相差仅 {max(gap, 1e-16):.0e}：本是同一个观测器。"))


def _remark(outcome: Outcome[Story]) -> Verdict:
    d = outcome.design
    if d["example"] != TWO:
        return Verdict(False, Text("Take Example 2, where Λ is a matrix and the order of factors matters.",
                                   "请选例 2：那里 Λ 是矩阵，相乘次序有影响。"))
    gaps = remark_3(d["remark"])
    if gaps.dynamics is None or gaps.output is None:
        return Verdict(False, Text(f"In {REMARKS[d['remark']]} the factors do not even fit together.",
                                   f"{REMARKS[d['remark']]} 中的矩阵尺寸不相容。"))
    if not gaps.met:
        return Verdict(False, Text(f"(2b) is missed by {gaps.dynamics:.2g} and (2c) by {gaps.output:.2g}, relative; both must be 0.",
                                   f"(2b) 的相对误差为 {gaps.dynamics:.2g}，(2c) 为 {gaps.output:.2g}；两者都应为 0。"))
    return Verdict(True, Text("Both conditions hold: a change of coordinates turns F into ΛFΛ⁻¹ and T into ΛT.",
                              "两个条件都成立：坐标变换把 F 变为 ΛFΛ⁻¹，把 T 变为 ΛT。"))


def _sizes(outcome: Outcome[Story]) -> Verdict:
    d = outcome.design
    if d["example"] != TWO:
        return Verdict(False, Text("Take Example 2: its lines are the ones to check.", "请选例 2：要检查的是它的各行。"))
    printed, true = PRINTED_SIZES[d["line"]], true_size(d["line"])
    if printed == true:
        return Verdict(False, Text(f"{LINES[d['line']]} is printed {true[0]}×{true[1]}, and that is right; look at another line.",
                                   f"{LINES[d['line']]} 印为 {true[0]}×{true[1]}，并无错误；请看另一行。"))
    claimed, right = claimed_columns(d["columns"]), free_columns()
    if claimed != right:
        return Verdict(False, Text(f"The line is found. {COLUMNS[d['columns']]} gives M′ {claimed} columns here; it has {right}.",
                                   f"有误的一行找到了。这里按 {COLUMNS[d['columns']]}，M′ 有 {claimed} 列；实际为 {right} 列。"))
    return Verdict(True, Text(f"{LINES[d['line']]} is {true[0]}×{true[1]}, printed {printed[0]}×{printed[1]}; "
                              f"M′ has {COLUMNS[d['columns']]} = {right} columns here.",
                              f"{LINES[d['line']]} 应为 {true[0]}×{true[1]}，印成了 {printed[0]}×{printed[1]}；"
                              f"这里 M′ 有 {COLUMNS[d['columns']]} = {right} 列。"))


def exam(seed: int) -> ExamItem:
    """J of example 1 at an integer s with integer weights: 2α|s| + β|s² + 4s + 3| + γ|50 + 30s|."""
    rng = np.random.default_rng(seed)
    s, a, b, c = -int(rng.integers(2, 10)), int(rng.integers(1, 5)), int(rng.integers(1, 5)), int(rng.integers(1, 5))
    answer = 2 * a * abs(s) + b * abs(s * s + 4 * s + 3) + c * abs(50 + 30 * s)
    return ExamItem({"s": str(s), "a": str(a), "b": str(b), "c": str(c)}, float(answer), 1e-6)


TASKS = (
    Task("kink", _kink, {"pole": (complex(BEST),)}),
    Task("one-observer", _one_observer, {"example": TWO, "w12": 1.2, "carried": True}),
    Task("remark-3", _remark, {"example": TWO, "remark": "similar"}),
    Task("sizes", _sizes, {"example": TWO, "line": "LC", "columns": "mp"}),
)
