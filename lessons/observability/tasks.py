"""The tasks of lesson 3 and its exam item: one sensor for all, a wrong sentence, full rank nearly hidden, low rank."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .criteria import DET, GRAMIAN
from .study import Study

CLEARLY = 0.05  # distance of the weakest mode asked of one sensor
BLIND = 0.002  # distance below which a direction of the notes' sensor counts as blind
PAPER = 1e-4  # distance below which full rank is only on paper


def _one_sensor(outcome: Outcome[Study]) -> Verdict:
    design, d = outcome.design, outcome.metrics["weakest"]
    if design["plant"] != "deck":
        return Verdict(False, Text("This task is about the deck; choose it as the plant.", "本题针对平台台面，请选它作为对象。"))
    count = sum(design[f"{k}_on"] for k in ("left", "right", "across"))
    if count != 1:
        return Verdict(False, Text(f"{count} sensors are on; the task wants exactly one.", f"现在开着 {count} 个传感器；本题只要一个。"))
    if outcome.metrics["hidden"] > 0:
        return Verdict(False, Text(f"{outcome.metrics['hidden']:.0f} of 6 states leave no trace in this sensor.",
                                   f"6 个状态中有 {outcome.metrics['hidden']:.0f} 个在这个传感器里不留痕迹。"))
    if d < CLEARLY:
        return Verdict(False, Text(f"Every mode is seen, but the weakest is only {d:.2g} from hidden; reach {CLEARLY:g}.",
                                   f"每个模态都可见，但最弱的离隐藏只有 {d:.2g}；请达到 {CLEARLY:g}。"))
    return Verdict(True, Text(f"One sensor sees all three modes; the weakest is {d:.2g} from hidden.",
                              f"一个传感器看得见全部三个模态；最弱的离隐藏 {d:.2g}。"))


def _wrong_sentence(outcome: Outcome[Study]) -> Verdict:
    design, found = outcome.design, outcome.study
    if design["plant"] != "notes":
        return Verdict(False, Text("Choose the plant of the notes first.", "请先选择讲义的对象。"))
    if design["criterion"] == DET:
        return Verdict(False, Text("C e^{At} is 1×2 here and has no determinant: this sentence cannot be tested.",
                                   "这里 C e^{At} 是 1×2 矩阵，没有行列式：这句话无从检验。"))
    if design["criterion"] != GRAMIAN:
        return Verdict(False, Text("That sentence is right, but it does not speak of C e^{At} over time; one of them does.",
                                   "这句话没错，但它没有涉及 C e^{At} 随时间的变化；其中有一句涉及。"))
    d = found.weakest.distance
    if d > BLIND:
        return Verdict(False, Text(f"The sentence is right. Now turn the sensor until it all but fails: "
                                   f"the nearest mode is still {d:.2g} from hidden.",
                                   f"这句话是对的。再转动传感器，使它几乎不成立：现在最近的模态离隐藏 {d:.2g}。"))
    return Verdict(True, Text(f"At {design['angle']:.4g}° a mode is {d:.1g} from hidden and the Gramian's least eigenvalue is "
                              f"{outcome.metrics['least_energy']:.1g}.".replace("-", "−"),
                              f"在 {design['angle']:.4g}°，有一个模态离隐藏 {d:.1g}，Gram 矩阵的最小特征值为 "
                              f"{outcome.metrics['least_energy']:.1g}。".replace("-", "−")))


def _on_paper(outcome: Outcome[Study]) -> Verdict:
    m = outcome.metrics
    rank, n, d = int(m["rank"]), int(m["states"]), m["weakest"]
    if rank < n:
        return Verdict(False, Text(f"rank(O) = {rank} of {n}; the task wants full rank at this tolerance.",
                                   f"rank(O) = {rank}/{n}；本题要求在此容差下满秩。"))
    if m["hidden"] > 0 or d > PAPER:
        return Verdict(False, Text(f"Full rank, and the weakest mode is {d:.2g} from hidden; bring it below {PAPER:g}.",
                                   f"满秩，最弱模态离隐藏 {d:.2g}；请降到 {PAPER:g} 以下。"))
    return Verdict(True, Text(f"rank(O) = {n}, and a change of {d:.1g} in the plant would hide a mode.",
                              f"rank(O) = {n}，但对象只要变化 {d:.1g} 就会有模态隐藏。"))


def _low_rank(outcome: Outcome[Study]) -> Verdict:
    m = outcome.metrics
    rank, n, d = int(m["rank"]), int(m["states"]), m["weakest"]
    if m["hidden"] > 0 or d < 0.4:
        return Verdict(False, Text(f"The weakest mode is {d:.2g} from hidden; the task wants every mode beyond 0.4.",
                                   f"最弱模态离隐藏 {d:.2g}；本题要求每个模态都超过 0.4。"))
    if 2 * rank >= n:
        return Verdict(False, Text(f"rank(O) = {rank} of {n}; the task wants less than half of n.",
                                   f"rank(O) = {rank}/{n}；本题要求小于 n 的一半。"))
    return Verdict(True, Text(f"rank(O) = {rank} of {n}, yet every mode is at least {d:.2g} from hidden: the number was rounding.",
                              f"rank(O) = {rank}/{n}，而每个模态离隐藏至少 {d:.2g}：那个秩只是舍入的产物。"))


TASKS = (
    Task("one-sensor", _one_sensor, {"left": -0.15}),
    Task("find-the-error", _wrong_sentence, {"plant": "notes", "criterion": GRAMIAN, "angle": 55.5}),
    Task("on-paper", _on_paper, {"plant": "pair", "gap": 1e-5}),
    Task("low-rank", _low_rank, {"plant": "many", "count": 20}),
)


def exam(seed: int) -> ExamItem:
    """A = [a b; c d], C = [1 0], y(0) and ẏ(0) given: x₂(0) = (ẏ(0) − a y(0))/b."""
    rng = np.random.default_rng(seed)
    a, b, c, d = (float(v) for v in (rng.integers(-4, 5), rng.choice([-5, -4, -2, 2, 4, 5]), *rng.integers(-4, 5, 2)))
    y, x2 = float(rng.integers(1, 6)), float(rng.integers(-12, 13)) / 2
    return ExamItem({k: f"{v:g}" for k, v in (("a", a), ("b", b), ("c", c), ("d", d), ("y", y), ("dy", a * y + b * x2))},
                    x2, 1e-6)
