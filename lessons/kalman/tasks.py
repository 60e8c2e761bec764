"""Tasks of the lesson, judged over all records and not by the luck of one; and the exam item."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .knobs import NEAR_R, NONE, SLIPS
from .study import Expected, Study, expected

ENOUGH = 0.5  # share of the records that counts as found out


def _expected(o: Outcome[Study]) -> Expected:
    return expected(o.design["noise"], o.design["q"], o.design["r"])


def _said(e: Expected) -> Text:
    return Text(f"Over all records NIS averages {e.nis:.2f}, NEES {e.nees:.3g}, and whiteness flags {100 * e.flagged:.0f} %",
                f"对全体记录平均：NIS {e.nis:.2f}，NEES {e.nees:.3g}，白性检验报警 {100 * e.flagged:.0f} %")


def _tune(o: Outcome[Study]) -> Verdict:
    if o.design["noise"] != "white":
        return Verdict(False, Text("This task is about white sensor noise.", "本题针对白测量噪声。"))
    e = _expected(o)
    said = _said(e)
    if not e.right:
        return Verdict(False, Text(f"{said.en}: at least one test finds the filter out.", f"{said.zh}：至少有一项检验能识破。"))
    return Verdict(True, Text(f"{said.en}: no test finds it out.", f"{said.zh}：没有检验能识破它。"))


def _decoy(o: Outcome[Study]) -> Verdict:
    if o.design["noise"] != "white" or o.design["q"] < 5:
        return Verdict(False, Text(f"q = {o.design['q']:.3g}; white sensor noise and q of at least 5 are wanted.",
                                   f"q = {o.design['q']:.3g}；要求白测量噪声且 q 不小于 5。"))
    e = _expected(o)
    said = _said(e)
    if not e.nis_holds:
        return Verdict(False, Text(f"{said.en}: NIS gives it away already.", f"{said.zh}：NIS 已经报警。"))
    if e.flagged < ENOUGH:
        return Verdict(False, Text(f"{said.en}: the innovations mostly look white.", f"{said.zh}：新息多半看起来是白的。"))
    return Verdict(True, Text(f"{said.en}: NIS is content, colour gives the filter away.", f"{said.zh}：NIS 合格，颜色却露了馅。"))


def _converter(o: Outcome[Study]) -> Verdict:
    if o.design["noise"] == "white":
        return Verdict(False, Text("Switch the sensor noise to the converter.", "请把测量噪声切换为 ADC 噪声。"))
    e = _expected(o)
    said = _said(e)
    if not e.right:
        return Verdict(False, Text(f"{said.en}: the noise of the converter is still visible.", f"{said.zh}：ADC 噪声仍然露在外面。"))
    return Verdict(True, Text(f"{said.en}: what was colour is now state.", f"{said.zh}：颜色已经变成了状态。"))


def _report(o: Outcome[Study]) -> Verdict:
    line = o.design["line"]
    if line == NONE:
        return Verdict(False, Text("Choose a line of the report.", "请选择报告中的一行。"))
    if line not in SLIPS:
        return Verdict(False, Text("That line holds.", "这一行成立。"))
    if line != NEAR_R:
        return Verdict(False, Text("A line in doubt indeed, but not about what a converged filter's innovations should look like.",
                                   "这一行确有问题，但说的不是收敛后新息协方差应当是什么。"))
    e = _expected(o)
    if not e.right:
        return Verdict(False, Text("The right line; now show it with a filter that no test finds out.",
                                   "选对了；请用一个不会被识破的滤波器来证明。"))
    return Verdict(True, Text(f"Tuned, and yet the innovations have {e.over_R:.2f} R over all records; S promised {e.S_over_R:.2f} R.",
                              f"已调好，对全体记录新息方差却是 R 的 {e.over_R:.2f} 倍；按 S 应为 {e.S_over_R:.2f} 倍。"))


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
