"""Tasks of the lesson: what C_v really is, a mixing that works, the claim about pitch, living with pitch closed; the exam item."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .loops import BEST, NONE, POLES, SHAPED
from .study import Study

AS_WELL = (93.0, 94.0)  # dB: the published C_v gives 93.5
TENFOLD = 10.0
CLAIMED = 0.5  # rad/s
WIDE, LEAST_ROTATION, LEAST_HORIZONTAL = 1.0, 25.0, 15.0


def _constant(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    got = m["vertical"]
    if d["vertical"] != SHAPED:
        return Verdict(False, Text("Shape the vertical controller yourself.", "请自己整定竖直通道控制器。"))
    if not AS_WELL[0] <= got <= AS_WELL[1]:
        return Verdict(False, Text(f"The vertical peak comes down by {got:.1f} dB; the published C_v gives 93.5 dB.",
                                   f"竖直峰值降低 {got:.1f} dB；报告的 C_v 为 93.5 dB。"))
    if m["rightmost"] >= 0 or m["drift"] > 0:
        worst = max(m["rightmost"], m["drift"])
        return Verdict(False, Text(f"There is still a pole at {worst:+.2g} rad/s.", f"仍有极点 {worst:+.2g} rad/s。"))
    return Verdict(True, Text(f"The gain {d['gain_v']:.0f} N s/m alone brings the peak down by {got:.1f} dB, and no pole is "
                              "on the right.", f"仅用增益 {d['gain_v']:.0f} N·s/m 就使峰值降低 {got:.1f} dB，且没有右半平面极点。"))


def _mixing(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    factor = m["J_plain"] / max(m["J"], 1e-300)
    band = Text(f"{d['f_low']:g} to {d['f_high']:g} Hz", f"{d['f_low']:g} 至 {d['f_high']:g} Hz")
    if d["mix"] == NONE:
        return Verdict(False, Text("Nothing is mixed yet: a = b = 0.", "尚未混合：a = b = 0。"))
    if d["f_high"] < 3 * d["f_low"]:
        return Verdict(False, Text("Keep the band at least as wide as one to three.", "频带上下限之比至少为 3。"))
    if factor < TENFOLD:
        return Verdict(False, Text(f"From {band.en} J is 1/{factor:.2g} of its value without mixing; one tenth is asked.",
                                   f"在 {band.zh} 内 J 降为不混合时的 1/{factor:.2g}；要求降到十分之一。"))
    return Verdict(True, Text(f"From {band.en} J is 1/{factor:.3g} of its value without mixing.",
                              f"在 {band.zh} 内 J 降为不混合时的 1/{factor:.3g}。"))


def _claim(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    if not d["pitch"] or d["bandwidth"] > CLAIMED * (1 + 1e-9):
        return Verdict(False, Text("Close the pitch loop with a bandwidth of at most 0.5 rad/s.",
                                   "请闭合俯仰回路，带宽不超过 0.5 rad/s。"))
    if m["rightmost_pitch_open"] >= 0:
        return Verdict(False, Text("This loop is unstable with pitch open already; that proves nothing.",
                                   "俯仰开环时这个回路已不稳定，说明不了问题。"))
    if m["rightmost"] < 0:
        return Verdict(False, Text(f"The loop stays stable: rightmost pole {m['rightmost']:.3g} rad/s. Try another C_h.",
                                   f"闭环仍稳定：最右极点 {m['rightmost']:.3g} rad/s。换一个 C_h 试试。"))
    return Verdict(True, Text(f"Pitch open: {m['rightmost_pitch_open']:.2g} rad/s. Closed at {d['bandwidth']:g} rad/s: "
                              f"{m['rightmost']:+.2g} rad/s. The claim is true for this C_h.",
                              f"俯仰开环：{m['rightmost_pitch_open']:.2g} rad/s；以 {d['bandwidth']:g} rad/s 闭合："
                              f"{m['rightmost']:+.2g} rad/s。对这个 C_h，结论成立。"))


def _close(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    if d["horizontal"] != POLES or not d["pitch"] or d["bandwidth"] < WIDE:
        return Verdict(False, Text("Place the horizontal poles yourself and close pitch at 1 rad/s or more.",
                                   "请自己配置水平通道极点，并以不小于 1 rad/s 的带宽闭合俯仰回路。"))
    if m["rightmost"] >= 0:
        return Verdict(False, Text(f"The loop is unstable: rightmost pole {m['rightmost']:+.3g} rad/s.",
                                   f"闭环不稳定：最右极点 {m['rightmost']:+.3g} rad/s。"))
    both = Text(f"Rotation {m['rotation']:.1f} dB, horizontal {m['horizontal']:.1f} dB",
                f"转动 {m['rotation']:.1f} dB，水平 {m['horizontal']:.1f} dB")
    if m["rotation"] < LEAST_ROTATION or m["horizontal"] < LEAST_HORIZONTAL:
        return Verdict(False, Text(f"{both.en}; asked are {LEAST_ROTATION:g} and {LEAST_HORIZONTAL:g} dB.",
                                   f"{both.zh}；要求为 {LEAST_ROTATION:g} 与 {LEAST_HORIZONTAL:g} dB。"))
    return Verdict(True, Text(f"{both.en}, with all three loops closed and stable.", f"{both.zh}，三个回路都已闭合且稳定。"))


NEAR_THE_ZEROS = (-0.3 + 7.42j, -0.3 - 7.42j)
TASKS = (
    Task("constant", _constant, MappingProxyType({"vertical": SHAPED, "gain_v": 31250.0, "lag": 0.0, "lead": 0.0})),
    Task("mixing", _mixing, MappingProxyType({"mix": BEST, "f_low": 2.0, "f_high": 10.0})),
    Task("claim", _claim, MappingProxyType({"horizontal": POLES, "pitch": True, "bandwidth": 0.5})),
    Task("close-pitch", _close, MappingProxyType({
        "horizontal": POLES, "pitch": True, "bandwidth": 5.0, "control_poles": (-20 + 15j, -20 - 15j, *NEAR_THE_ZEROS),
        "observer_poles": (-60 + 45j, -60 - 45j, *NEAR_THE_ZEROS)})),
)


def exam(seed: int) -> ExamItem:
    """A = s − a, B = k, Φ = (s + c)²: E = s + a + 2c and F = (c + a)²/k."""
    rng = np.random.default_rng(seed)
    a, c, k = int(rng.integers(1, 6)), int(rng.integers(2, 9)), int(rng.integers(2, 6))
    return ExamItem({"a": str(a), "c": str(c), "k": str(k)}, (c + a) ** 2 / k, 1e-3 * (c + a) ** 2 / k)
