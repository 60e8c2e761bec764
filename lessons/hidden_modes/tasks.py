"""Tasks of the lesson: slow but fine, the twin, silence, the cure; and the exam item."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .knobs import Case


def _number(value: float) -> str:
    return f"{value:.3g}".replace("-", "−")


def _slow_but_fine(outcome: Outcome[Case]) -> Verdict:
    case, rate = outcome.study, outcome.metrics["error_rate"]
    assert isinstance(case, Case)
    if case.seen.observable:
        return Verdict(False, Text("This sensor sees every mode; the task wants one that does not.",
                                   "这个传感器看得见所有模态；本题要的是看不全的。"))
    if rate >= 0:
        return Verdict(False, Text(f"The error still grows like e^({_number(rate)} t). No pole you can drag changes that.",
                                   f"误差仍按 e^({_number(rate)} t) 增长，能拖动的极点对此无能为力。"))
    return Verdict(True, Text(f"The sensor is as blind as before, and e dies out like e^({_number(rate)} t): detectable.",
                              f"传感器仍然看不全，而 e 按 e^({_number(rate)} t) 衰减：系统可检测。"))


def _twin(outcome: Outcome[Case]) -> Verdict:
    error, state = outcome.metrics["error_rate"], outcome.metrics["state_rate"]
    if error >= 0:
        return Verdict(False, Text(f"The estimate itself is lost: e grows like e^({_number(error)} t).",
                                   f"估计本身已经失效：e 按 e^({_number(error)} t) 增长。"))
    case = outcome.study
    if state < 0 or case.reached.stabilizable:
        return Verdict(False, Text(f"The estimate is right, but the plant can be held: its slowest pole is {_number(state)}.",
                                   f"估计没有问题，但对象也镇得住：最慢极点的实部为 {_number(state)}。"))
    return Verdict(True, Text(f"e dies out like e^({_number(error)} t), yet x grows like e^({_number(state)} t): "
                              "all is known and nothing can be done.",
                              f"e 按 e^({_number(error)} t) 衰减，x 却按 e^({_number(state)} t) 增长：了如指掌，却无能为力。"))


def _silence(outcome: Outcome[Case]) -> Verdict:
    case, left = outcome.study, outcome.metrics["error_end"]
    if case.seen.detectable:
        return Verdict(False, Text("Here the unstable motion is not hidden from the sensor; choose the distance sensor "
                                   "and the magnets.", "这里不稳定的运动并未对传感器隐藏；请选间距传感器与磁铁。"))
    if left > 1e-3:
        return Verdict(False, Text(f"At the end e is {_number(left)} times its start; bring it below 0.001.",
                                   f"末时刻 e 是初值的 {_number(left)} 倍，请降到 0.001 以下。"))
    return Verdict(True, Text(f"At the end e is {left:.1g} of its start: the hidden motion was never woken. One kick ends it.",
                              f"末时刻 e 仅为初值的 {left:.1g}：隐藏的运动没有被激发。但一次冲击就会前功尽弃。"))


def _cure(outcome: Outcome[Case]) -> Verdict:
    case, error, state = outcome.study, outcome.metrics["error_rate"], outcome.metrics["state_rate"]
    if not (case.seen.observable and case.reached.controllable):
        return Verdict(False, Text("A mode is still bolted: change where the sensor looks or where the force acts.",
                                   "仍有模态被螺栓固定：换一个测量位置或作用位置。"))
    if error > -2 or state > -1.2:
        return Verdict(False, Text(f"The slowest poles are {_number(error)} (observer, −2 or less) and {_number(state)} "
                                   "(controller, −1.2 or less).",
                                   f"最慢极点的实部：观测器 {_number(error)}（应不大于 −2），控制器 {_number(state)}"
                                   "（应不大于 −1.2）。"))
    return Verdict(True, Text(f"Nothing is hidden: observer {_number(error)}, controller {_number(state)}, as asked.",
                              f"没有隐藏模态：观测器 {_number(error)}，控制器 {_number(state)}，符合要求。"))


def exam(seed: int) -> ExamItem:
    """A = [a b; b a], C = [1 −1]: which eigenvalue of A − LC is the same for every L? The one of (1, 1): a + b."""
    rng = np.random.default_rng(seed)
    a, b = -float(rng.integers(2, 9)), float(rng.integers(1, 12))
    if a + b == 0:
        b += 1.0
    return ExamItem({"a": f"{a:g}", "b": f"{b:g}"}, a + b, 1e-6)


TASKS = (
    Task("slow-but-fine", _slow_but_fine, {"plant": "unseen-stable"}),
    Task("twin", _twin, {"plant": "unmoved-unstable"}),
    Task("silence", _silence, {"plant": "unseen-unstable", "centre": 0.0}),
    Task("cure", _cure, {"plant": "visible", "controller_all": (-1.4 - 1.2j, -1.4 + 1.2j, -1.8 - 3j, -1.8 + 3j)}),
)
