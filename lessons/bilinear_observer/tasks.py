"""Tasks of the lesson and its exam item: the slip, the plant that runs away, no derivative, three sensors."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .page import FATAL, NONE
from .problems import PAPER, PRINTED
from .study import FILTERED, Study


def _number(value: float) -> str:
    return f"{value:.3g}".replace("-", "−")


def _slip(outcome: Outcome[Study]) -> Verdict:
    line, pole = outcome.design["line"], outcome.metrics["pole"]
    if line == NONE:
        return Verdict(False, Text("No line is in doubt yet; walk through the steps and compare.",
                                   "还没有选定可疑的行；请逐步对照。"))
    if line != FATAL:
        return Verdict(False, Text("That line is no worse than rounding: by itself it leaves the pole at −30 or next to it.",
                                   "这一行不过是舍入：只用它，极点仍在 −30 或其近旁。"))
    if outcome.design["problem"] != PAPER or outcome.design["gain"] != PRINTED:
        return Verdict(False, Text("That is the line. Now run the gain as printed and see what it does.",
                                   "就是这一行。再照论文所印的增益运行，看看后果。"))
    return Verdict(True, Text(f"L₄ must be π = 9.29. As printed the pole is +{_number(pole)}, and the error at the end of the "
                              f"run is {outcome.metrics['late_error']:.1e}.",
                              f"L₄ 应等于 π = 9.29。照论文所印，极点为 +{_number(pole)}，运行结束时误差达 "
                              f"{outcome.metrics['late_error']:.1e}。"))


def _runaway(outcome: Outcome[Study]) -> Verdict:
    m = outcome.metrics
    peak, late = m["late_g"], m["late_error"]
    if peak < 1000:
        return Verdict(False, Text(f"In the last tenth of the run |g| is at most {_number(peak)}; drive it beyond 1000.",
                                   f"在运行的最后十分之一，|g| 最多为 {_number(peak)}；请使它超过 1000。"))
    if late > 1e-6 or m["law_gap"] > 1e-6:
        return Verdict(False, Text(f"|g| passes 1000, but ε does too much: {late:.1e} at the end. Take an observer whose pole "
                                   "is on the left and which needs no differentiator.",
                                   f"|g| 超过了 1000，但末段误差为 {late:.1e}。请用极点在左侧、不靠微分器的观测器。"))
    return Verdict(True, Text(f"|g| reaches {_number(peak)} and ε is down to {late:.0e}: the observer does not notice.",
                              f"|g| 达到 {_number(peak)}，而 ε 已降到 {late:.0e}：观测器丝毫不受影响。"))


def _lag(outcome: Outcome[Study]) -> Verdict:
    late = outcome.metrics["half_error"]
    if outcome.design["form"] != FILTERED:
        return Verdict(False, Text("The ghost does not use the differentiator yet; choose that form.",
                                   "虚影还没有使用微分器，请选那种形式。"))
    if outcome.metrics["pole"] >= 0 or outcome.design["problem"] != PAPER:
        return Verdict(False, Text("Take the paper's problem and a pole on the left.", "请用论文的问题，极点取在左侧。"))
    if late > 0.02:
        return Verdict(False, Text(f"In the second half of the run |ε| is up to {_number(late)}; bring it to 0.02 or less.",
                                   f"在运行的后一半 |ε| 最多为 {_number(late)}；请降到 0.02 以下。"))
    return Verdict(True, Text(f"|ε| stays below {_number(late)}. Without ẏ it is {outcome.metrics['plain_half']:.0e} with "
                              "nothing to tune.",
                              f"|ε| 不超过 {_number(late)}。而不用 ẏ 时，无须调节便是 {outcome.metrics['plain_half']:.0e}。"))


def _three(outcome: Outcome[Study]) -> Verdict:
    observer, m = outcome.study.observer, outcome.metrics
    if observer.plant.m > 3:
        return Verdict(False, Text("Four sensors are still in use; the task allows three.", "现在还用着四个传感器，本题只许用三个。"))
    if not observer.solved:
        return Verdict(False, Text("With these three sensors this g has no such observer: (21) fails, look at the lights.",
                                   "用这三个传感器，这个 g 没有此类观测器：(21) 不成立，请看指示灯。"))
    if m["law_gap"] > 1e-6:
        return Verdict(False, Text("An observer exists, but the form in use does not follow its law; leave the differentiator.",
                                   "观测器存在，但现在的实现偏离了规律；请不要用微分器。"))
    return Verdict(True, Text(f"Three sensors, one L and one pole, {_number(m['pole'])}: case 2.",
                              f"三个传感器，唯一的 L，唯一的极点 {_number(m['pole'])}：情形 2。"))


TASKS = (
    Task("slip", _slip, {"line": FATAL, "gain": PRINTED}),
    Task("runaway", _runaway, {"input": "step", "amplitude": 3.0}),
    Task("lag", _lag, {"form": FILTERED, "tau": 0.003}),
    Task("three-sensors", _three, {"problem": "three-fitting"}),
)


def exam(seed: int) -> ExamItem:
    """Scalar A*, B* and a pole p: π = (A* − p)/B*."""
    rng = np.random.default_rng(seed)
    a, b, p = -float(rng.integers(10, 90)) / 10, float(rng.integers(11, 49)) / 10, -float(rng.integers(12, 45))
    return ExamItem({"a": f"{a:g}", "b": f"{b:g}", "p": f"{p:g}"}, (a - p) / b, 0.006)
