"""Tasks of the lesson: twenty decibels everywhere, an optimum that is beaten, a delay that one side survives; the exam."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .study import Study

WANTED = 20.0  # dB in every channel
BEST_SENSOR = 1e-11  # (m/s)² s: the quietest that can be bought in the first task
AHEAD = 10.0  # dB by which the optimum is to be beaten
KEPT = 12.0  # dB that the full LQG is to keep while the SISO pair is lost
CHANNELS = ("vertical", "rotation", "horizontal")


def _band(outcome: Outcome[Study], player: str) -> list[float]:
    return [outcome.metrics[f"{player}_{channel}_band_db"] for channel in CHANNELS]


def _words(values: list[float]) -> str:
    return " / ".join(f"{v:.1f}" for v in values).replace("-", "−")


def _twenty(outcome: Outcome[Study]) -> Verdict:
    d, m, got = outcome.design, outcome.metrics, _band(outcome, "lqe")
    if d["sensor"] < BEST_SENSOR * (1 - 1e-9) or d["ground"] != "white":
        return Verdict(False, Text(f"V₀ = {d['sensor']:.1e}: no better sensors than 1e-11 are for sale, and the ground is white.",
                                   f"V₀ = {d['sensor']:.1e}：能买到的最好的传感器是 1e-11，且地面为白噪声。"))
    if not m["lqe_stable"] or min(got) < WANTED:
        return Verdict(False, Text(f"Vertical, rotation, horizontal: {_words(got)} dB; {WANTED:g} dB are wanted in each.",
                                   f"竖直、转动、水平：{_words(got)} dB；要求各不低于 {WANTED:g} dB。"))
    return Verdict(True, Text(f"{_words(got)} dB: more than {WANTED:g} dB in every channel.",
                              f"{_words(got)} dB：各通道都超过 {WANTED:g} dB。"))


def _beaten(outcome: Outcome[Study]) -> Verdict:
    m, siso, lqg = outcome.metrics, _band(outcome, "siso"), _band(outcome, "lqe")
    if not (m["siso_stable"] and m["lqe_stable"]):
        return Verdict(False, Text("Both loops must be stable.", "两个回路都必须稳定。"))
    ahead = [a - b for a, b in zip(siso, lqg, strict=True)]
    if min(ahead) < AHEAD:
        return Verdict(False, Text(f"The SISO loops are ahead by {_words(ahead)} dB; {AHEAD:g} dB are wanted in every channel.",
                                   f"SISO 回路领先 {_words(ahead)} dB；要求各通道都领先 {AHEAD:g} dB。"))
    return Verdict(True, Text(f"Ahead by {_words(ahead)} dB: the LQG is optimal for noise that is not there.",
                              f"领先 {_words(ahead)} dB：LQG 是为并不存在的噪声而最优。"))


def _late(outcome: Outcome[Study]) -> Verdict:
    d, m, got = outcome.design, outcome.metrics, _band(outcome, "lqe")
    if d["pair"] != "own" or d["limited"]:
        return Verdict(False, Text("Use our SISO pair, and coils without a limit.", "请采用自行设计的 SISO 回路，线圈不限幅。"))
    if m["siso_stable"]:
        return Verdict(False, Text(f"With a delay of {d['delay']:g} ms the SISO loops are still stable.",
                                   f"时延 {d['delay']:g} ms 时 SISO 回路仍然稳定。"))
    if not m["lqe_stable"] or min(got) < KEPT:
        return Verdict(False, Text(f"The SISO loops are lost, but the full LQG gains only {_words(got)} dB; keep {KEPT:g} dB.",
                                   f"SISO 回路已失稳，但完整 LQG 只有 {_words(got)} dB；要求保持 {KEPT:g} dB。"))
    return Verdict(True, Text(f"At {d['delay']:g} ms the SISO loops are lost; the full LQG still gains {_words(got)} dB.",
                              f"时延 {d['delay']:g} ms：SISO 回路失稳，完整 LQG 仍有 {_words(got)} dB。"))


def exam(seed: int) -> ExamItem:
    """Two coils with u = −k v each on a free mass m, sampled at f and held: v⁺ = (1 − 2k/(m f)) v, stable up to k = m f."""
    rng = np.random.default_rng(seed)
    m, f = int(rng.integers(4, 25)), int(rng.choice([200, 250, 400, 500, 800, 1000, 1200, 1600, 2000]))
    return ExamItem({"m": str(m), "f": str(f)}, float(m * f), 0.005 * m * f)


TASKS = (
    Task("twenty", _twenty, {"sensor": 1e-11, "v": 1e-11}),
    Task("beaten", _beaten, {"sensor": 1e-14}),
    Task("late", _late, {"delay": 8.0}),
)
