"""Tasks of the lesson: tune, the other decoy, the converter, the report; and the exam item."""

from __future__ import annotations

import numpy as np

from app.lesson import ExamItem, Outcome, Task, Verdict
from app.words import Text

from .report import NEAR_R, NONE, SLIPS


def _state(o: Outcome) -> Text:
    m = o.metrics
    return Text(f"NIS {m['nis_mean']:.2f}, NEES {m['nees_mean']:.3g}, p-value of whiteness {m['white_p']:.2g}",
                f"NIS {m['nis_mean']:.2f}，NEES {m['nees_mean']:.3g}，白性检验 p 值 {m['white_p']:.2g}")


def _holds(o: Outcome) -> bool:
    return all(c.holds for c in o.checks if c.id in ("centred", "white", "nis", "nees"))


def _tune(o: Outcome) -> Verdict:
    said = _state(o)
    if o.design["noise"] != "white":
        return Verdict(False, Text("This task is about white sensor noise.", "本题针对白测量噪声。"))
    if not _holds(o):
        return Verdict(False, Text(f"{said.en}: at least one test still flags the filter.", f"{said.zh}：至少有一项检验仍在报警。"))
    return Verdict(True, Text(f"{said.en}: no test flags it.", f"{said.zh}：没有检验报警。"))


def _decoy(o: Outcome) -> Verdict:
    said, held = _state(o), {c.id: c.holds for c in o.checks}
    if o.design["noise"] != "white" or o.design["q"] < 5:
        return Verdict(False, Text(f"q = {o.design['q']:.3g}; white sensor noise and q of at least 5 are wanted.",
                                   f"q = {o.design['q']:.3g}；要求白测量噪声且 q 不小于 5。"))
    if not held["nis"]:
        return Verdict(False, Text(f"{said.en}: NIS gives it away already.", f"{said.zh}：NIS 已经报警。"))
    if held["white"]:
        return Verdict(False, Text(f"{said.en}: the innovations look white.", f"{said.zh}：新息看起来是白的。"))
    return Verdict(True, Text(f"{said.en}: NIS is content, colour gives the filter away.", f"{said.zh}：NIS 满意，颜色却露了馅。"))


def _converter(o: Outcome) -> Verdict:
    said = _state(o)
    if o.design["noise"] == "white":
        return Verdict(False, Text("Switch the sensor noise to the converter.", "请把测量噪声切换为 ADC 噪声。"))
    if not _holds(o):
        return Verdict(False, Text(f"{said.en}: the noise of the converter is still visible.", f"{said.zh}：ADC 噪声仍然露在外面。"))
    return Verdict(True, Text(f"{said.en}: what was colour is now state.", f"{said.zh}：颜色已经变成了状态。"))


def _report(o: Outcome) -> Verdict:
    line, m = o.design["line"], o.metrics
    if line == NONE:
        return Verdict(False, Text("Choose a line of the report.", "请选择报告中的一行。"))
    if line not in SLIPS:
        return Verdict(False, Text("That line holds.", "这一行成立。"))
    if line != NEAR_R:
        return Verdict(False, Text("A slip indeed, but not about what a converged filter's innovations should look like.",
                                   "确有错误，但说的不是收敛后新息协方差应当是什么。"))
    if not _holds(o):
        return Verdict(False, Text("The right line; now show it with a filter that no test flags.",
                                   "选对了；请用一个不报警的滤波器来证明。"))
    return Verdict(True, Text(f"Tuned, and yet the innovations have {m['seen_over_R']:.2f} R; S promised {m['S_over_R']:.2f} R.",
                              f"已调好，新息方差却是 R 的 {m['seen_over_R']:.2f} 倍；S 预言 {m['S_over_R']:.2f} 倍。"))


def exam(seed: int) -> ExamItem:
    """One step of a scalar filter: p⁻ = a² p + Q, p⁺ = p⁻ R/(p⁻ + R)."""
    rng = np.random.default_rng(seed)
    a, p, Q, R = float(rng.integers(5, 15)) / 10, int(rng.integers(1, 7)), int(rng.integers(1, 6)), int(rng.integers(1, 9))
    prior = a * a * p + Q
    return ExamItem({"a": f"{a:g}", "p": str(p), "Q": str(Q), "R": str(R)}, prior * R / (prior + R), 0.01)


TASKS = (
    Task("tune", _tune, {"q": 1.0, "r": 1.0}),
    Task("decoy", _decoy, {"q": 20.0, "r": 0.47}),
    Task("converter", _converter, {"noise": "carried", "q": 1.0, "r": 1.0}),
    Task("report", _report, {"q": 1.0, "r": 1.0, "line": NEAR_R}),
)
