"""Tasks of the lesson: the bottom by hand, the other side of the valley, a quiet start; and the exam item."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .knobs import KNOBS
from .study import Study

GIVEN = tuple(knob.default for name in ("w", "v") for knob in KNOBS if knob.name == name)  # W and V of the start
WANTED = 1.01  # of the least variances: the bottom of the valley
TWIN_SPEED = 0.3  # times Kalman: the slow observer whose fast twin is asked for
PEAK, SETTLED = 0.5, 1.4  # m/s and s


def _by_hand(outcome: Outcome[Study]) -> Verdict:
    ratio = outcome.metrics["worst_ratio"]
    if outcome.design["method"] != "poles":
        return Verdict(False, Text("Drag the poles yourself: here the Kalman filter is not to help.",
                                   "请自己拖动极点：本题不能借助卡尔曼的形状。"))
    if (outcome.design["w"], outcome.design["v"]) != GIVEN:
        return Verdict(False, Text(f"Put the noises back to W = {GIVEN[0]:g} and V = {GIVEN[1]:g}: the poles are to go to the bottom, "
                                   "not the bottom to the poles.",
                                   f"请把噪声恢复为 W = {GIVEN[0]:g}、V = {GIVEN[1]:g}：应当让极点走到谷底，而不是让谷底来迁就极点。"))
    if ratio > WANTED:
        return Verdict(False, Text(f"The worse of the two variances is {ratio:.3f} times the least; at most {WANTED} is wanted.",
                                   f"两个方差中较差的一个是最小值的 {ratio:.3f} 倍；要求不超过 {WANTED}。"))
    return Verdict(True, Text(f"Both variances are within {100 * (ratio - 1):.2f} % of the least possible.",
                              f"两个方差与最小值相差都不超过 {100 * (ratio - 1):.2f} %。"))


def _other_side(outcome: Outcome[Study]) -> Verdict:
    ray, m = outcome.study.ray, outcome.metrics
    if outcome.design["method"] != "speed" or outcome.design["watch"] != "velocity":
        return Verdict(False, Text("Use the Kalman pattern and judge by velocity.", "请使用卡尔曼的形状，并以速度误差评判。"))
    wanted = float(np.exp(np.interp(np.log(TWIN_SPEED * m["kalman_speed"]), np.log(ray.speed),
                                    0.5 * np.log(ray.process[:, 1] + ray.sensor[:, 1]))))
    gap = m["velocity_rms"] / wanted - 1
    numbers = f"σ = {m['velocity_rms']:.3g} m/s, {wanted:.3g} m/s"
    if outcome.design["speed"] <= 1:
        return Verdict(False, Text(f"This one is not faster than Kalman; σ = {m['velocity_rms']:.3g} m/s, wanted {wanted:.3g} m/s.",
                                   f"这个观测器不比卡尔曼快；σ = {m['velocity_rms']:.3g} m/s，目标 {wanted:.3g} m/s。"))
    if abs(gap) > 0.05:
        return Verdict(False, Text(f"σ = {m['velocity_rms']:.3g} m/s; the slow twin has {wanted:.3g} m/s. Come within 5 %.",
                                   f"σ = {m['velocity_rms']:.3g} m/s；慢的那个是 {wanted:.3g} m/s。请使二者相差不超过 5 %。"))
    return Verdict(True, Text(f"{numbers} for the slow twin: equally bad, but now {100 * m['sensor_share']:.0f} % is sensor noise.",
                              f"{numbers}（慢的那个）：同样差，但现在 {100 * m['sensor_share']:.0f} % 来自测量噪声。"))


def _quiet_start(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    if d["error0"] < 0.3 or d["kick"] >= 0:
        return Verdict(False, Text(f"The starting error is {d['error0']:.2g} m; keep 0.3 m or more, and no kick.",
                                   f"初始误差为 {d['error0']:.2g} m；请保持不小于 0.3 m，且没有冲击。"))
    numbers = Text(f"Peak {m['peak']:.3g} m/s, settled after {m['settled_after']:.2f} s",
                   f"峰值 {m['peak']:.3g} m/s，{m['settled_after']:.2f} s 后稳定")
    if m["peak"] > PEAK or m["settled_after"] > SETTLED:
        return Verdict(False, Text(f"{numbers.en}; wanted at most {PEAK:g} m/s and {SETTLED:g} s.",
                                   f"{numbers.zh}；要求不超过 {PEAK:g} m/s 和 {SETTLED:g} s。"))
    return Verdict(True, Text(f"{numbers.en}: fast enough, and the estimate never leaps.", f"{numbers.zh}：够快，估计也不会猛跳。"))


def exam(seed: int) -> ExamItem:
    """ẋ = −a x + w, y = x + v: the Kalman gain L = −a + √(a² + W/V)."""
    rng = np.random.default_rng(seed)
    a, W, V = int(rng.integers(1, 7)), int(rng.integers(2, 40)), float(rng.choice([0.1, 0.2, 0.5, 1.0, 2.0]))
    return ExamItem({"a": str(a), "W": str(W), "V": f"{V:g}"}, float(-a + np.sqrt(a * a + W / V)), 0.01)


TASKS = (
    Task("by-hand", _by_hand, {"method": "poles", "observer_poles": (-2.14 - 2.34j, -2.14 + 2.34j)}),
    Task("other-side", _other_side, {"speed": 1.77}),
    Task("quiet-start", _quiet_start, {"method": "poles", "observer_poles": (-4 - 2j, -4 + 2j)}),
)
