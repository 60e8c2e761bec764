"""The tasks of lesson 1 and its exam item."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .knobs import HORIZON, RUNAWAY, TAME
from .study import Study


def feel_the_core(outcome: Outcome[Study]) -> Verdict:
    """The core within 1 K after 2.2 s, from the given start, with the right model and a quiet sensor."""
    d, after = outcome.design, outcome.metrics["known_after"]
    if d["guess_core"] or d["guess_case"] or d["air_error"] or d["noise"] or d["plant"] != TAME:
        return Verdict(False, Text("Keep both guesses at 0 K, the model right, the sensor quiet and the chip that cools.",
                                   "请保持两个初始猜测为 0 K、模型准确、传感器无噪声，并用能自行冷却的芯片。"))
    if after <= 2.2:
        return Verdict(True, Text(f"The core is known within 1 K after {after:.2f} s, with L up to "
                                  f"{outcome.metrics['largest_gain']:.3g} and a first guess that shoots to "
                                  f"{outcome.metrics['largest_guess']:.0f} K.",
                                  f"{after:.2f} s 后内核误差小于 1 K；L 最大为 {outcome.metrics['largest_gain']:.3g}，"
                                  f"估计值曾冲到 {outcome.metrics['largest_guess']:.0f} K。"))
    late = Text(f"after {after:.2f} s", f"{after:.2f} s 之后") if after <= HORIZON else Text("never", "始终不行")
    return Verdict(False, Text(f"Known within 1 K: {late.en}; it should be after 2.2 s at most.",
                               f"误差小于 1 K：{late.zh}；应不晚于 2.2 s。"))


def tame_the_runaway(outcome: Outcome[Study]) -> Verdict:
    """The runaway chip, watched with a small gain."""
    m, d = outcome.metrics, outcome.design
    if d["plant"] != RUNAWAY or d["guess_core"] or d["guess_case"]:
        return Verdict(False, Text("Take the chip that runs away, with both guesses at 0 K.",
                                   "请选会热失控的芯片，两个初始猜测都为 0 K。"))
    if m["core_error"] <= 0.5 and m["largest_gain"] <= 1.5:
        return Verdict(True, Text(f"With no entry of L above {m['largest_gain']:.2g} the core error ends at "
                                  f"{m['core_error']:.2g} K; the copy's ends at {m['copy_core_error']:.3g} K.",
                                  f"L 的元素不超过 {m['largest_gain']:.2g}，内核误差末段为 {m['core_error']:.2g} K；"
                                  f"开环副本为 {m['copy_core_error']:.3g} K。"))
    return Verdict(False, Text(f"Largest entry of L: {m['largest_gain']:.3g} (at most 1.5); core error at the end: "
                               f"{m['core_error']:.2g} K (at most 0.5 K).",
                               f"L 的最大元素：{m['largest_gain']:.3g}（不超过 1.5）；末段内核误差：{m['core_error']:.2g} K"
                               "（不超过 0.5 K）。"))


def lucky_copy(outcome: Outcome[Study]) -> Verdict:
    """The copy of the runaway chip right from start to end."""
    m = outcome.metrics
    if outcome.design["plant"] != RUNAWAY:
        return Verdict(False, Text("Take the chip that runs away.", "请选会热失控的芯片。"))
    worst = m["largest_copy_error"]
    if worst <= 0.5:
        return Verdict(True, Text(f"The copy is never off by more than {worst:.2g} K. Now press kick.",
                                  f"开环副本的误差始终不超过 {worst:.2g} K。现在按一下“冲击”。"))
    return Verdict(False, Text(f"The copy is off by up to {worst:.3g} K; it should never be off by more than 0.5 K.",
                               f"开环副本最多差 {worst:.3g} K；应始终不超过 0.5 K。"))


def wrong_fan(outcome: Outcome[Study]) -> Verdict:
    """A right core in spite of a wrong fan: the core's entry of L is 1."""
    d, error = outcome.design, outcome.metrics["core_error"]
    if abs(d["air_error"]) < 30 or d["plant"] != TAME or d["power"] < 10 or d["noise"]:
        return Verdict(False, Text("Make the resistance wrong by 30 % or more, on the chip that cools, at 10 W or more and "
                                   "with a quiet sensor.",
                                   "请在能自行冷却的芯片上使热阻误差达到 30 % 以上，功率不低于 10 W，传感器无噪声。"))
    first = float(outcome.gains["L"][0, 0])
    if error <= 0.05:
        return Verdict(True, Text(f"The core error is at most {error:.2g} K at the end; the core's entry of L is {first:.3g}.",
                                  f"末段内核误差不超过 {error:.2g} K；L 中对应内核的元素为 {first:.3g}。"))
    return Verdict(False, Text(f"The core error at the end is {error:.2g} K; bring it to 0.05 K. The core's entry of L is "
                               f"{first:.3g}.",
                               f"末段内核误差为 {error:.2g} K，请降到 0.05 K。L 中对应内核的元素为 {first:.3g}。"))


def exam(seed: int) -> ExamItem:
    """A runaway chip with one state: e decays as e^{(a − L)t}; which L leaves a tenth of the error at time t?"""
    rng = np.random.default_rng(seed)
    a, t = float(rng.integers(2, 10)) / 10, float(rng.integers(2, 9)) / 2
    return ExamItem({"a": f"{a:g}", "t": f"{t:g}"}, a + float(np.log(10.0)) / t, 0.01)


TASKS = (
    Task("feel-the-core", feel_the_core, {"observer_poles": (-3.0, -3.5)}),
    Task("tame-the-runaway", tame_the_runaway, {"plant": RUNAWAY, "trust": 0.1}),
    Task("lucky-copy", lucky_copy, {"plant": RUNAWAY, "guess_core": 12.0, "guess_case": 6.0}),
    Task("wrong-fan", wrong_fan, {"air_error": 40.0, "trust": 0.21}),
)
