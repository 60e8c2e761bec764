"""The tasks of lesson 7 and its exam item."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .knobs import APPLIED, KNOBS
from .study import EXACT, Study, amount, slowest

CONTROLLER = next(knob for knob in KNOBS if knob.name == "controller_poles")
FAST = (-16 + 0j, -15 + 0j, -14 + 0j, -13 + 0j)

ASKED = MappingProxyType({"angle0": 4.0, "error0": 8.0, "kick": -1.0, "controller_poles": CONTROLLER.check(CONTROLLER.default)})


def _false_sentence(outcome: Outcome[Study]) -> Verdict:
    meter, clipped = outcome.metrics["separation_meter"], outcome.metrics["clipped_for"]
    if clipped < 0.1:
        return Verdict(False, Text(f"The force is clipped for only {clipped:.2f} s; a counterexample needs at least 0.1 s.",
                                   f"力只被限幅 {clipped:.2f} s；反例至少需要 0.1 s。"))
    if meter >= EXACT:
        return Verdict(False, Text(f"Clipped for {clipped:.2f} s, but the meter reads {amount(meter)}; it must be below 1e-9.",
                                   f"限幅 {clipped:.2f} s，但分离度量为 {amount(meter)}；应小于 1e-9。"))
    return Verdict(True, Text(f"Clipped for {clipped:.2f} s and the meter reads {meter:.0e}: the sentence is false as it stands.",
                              f"限幅 {clipped:.2f} s，分离度量仅 {meter:.0e}：那句话按原样不成立。"))


def _lost_by_belief(outcome: Outcome[Study]) -> Verdict:
    m = outcome.metrics
    if m["separation_meter"] >= EXACT:
        return Verdict(False, Text(f"The error does not obey A − LC: the meter reads {amount(m['separation_meter'])}.",
                                   f"误差并不服从 A − LC：分离度量为 {amount(m['separation_meter'])}。"))
    if not m["known_comes_home"]:
        return Verdict(False, Text("This start is lost even with x known; lean the pole less.",
                                   "即使 x 已知，这一初态也不能恢复；请减小倾角。"))
    if m["comes_home"]:
        return Verdict(False, Text("This start comes home; make the first belief worse.", "这一初态能恢复；让最初的判断更差些。"))
    return Verdict(True, Text(f"The meter reads {m['separation_meter']:.0e}, x known would save the pole, the estimate does not.",
                              f"分离度量 {m['separation_meter']:.0e}；若 x 已知则能恢复，用估计却不能。"))


def _better_observer(outcome: Outcome[Study]) -> Verdict:
    d, m = outcome.design, outcome.metrics
    if any(d[name] != asked for name, asked in ASKED.items()) or d["u_max"] > 4.0:
        return Verdict(False, Text(f"Angle 4°, error 8°, at most 4 N, no kick, the lesson's controller: you have {d['angle0']:g}°, "
                                   f"{d['error0']:g}°, {d['u_max']:g} N.",
                                   f"要求：角度 4°、误差 8°、限幅不超过 4 N、无冲击、控制器极点不变；现在是 {d['angle0']:g}°、"
                                   f"{d['error0']:g}°、{d['u_max']:g} N。"))
    if not m["comes_home"]:
        worst = slowest(outcome, "observer")
        return Verdict(False, Text(f"The pole is lost after {m['stopped_at']:.2f} s; the observer's slowest pole is at "
                                   f"{worst:.3g}.",
                                   f"摆杆在 {m['stopped_at']:.2f} s 倒下；观测器最慢极点在 {worst:.3g}。"))
    return Verdict(True, Text(f"It comes home with {d['u_max']:g} N; only the observer has changed.",
                              f"限幅 {d['u_max']:g} N 时恢复成功；改变的只有观测器。"))


def exam(seed: int) -> ExamItem:
    """Double integrator, observer poles both −p, told u but given less by d: e₂ settles at −2d/p (e = x − x̂)."""
    rng = np.random.default_rng(seed)
    p, limit, excess = int(rng.integers(2, 9)), int(rng.integers(1, 5)), int(rng.integers(1, 7))
    return ExamItem({"p": str(p), "asked": str(limit + excess), "given": str(limit)}, -2.0 * excess / p, 6e-3)


TASKS = (
    Task("false-sentence", _false_sentence, {"fed": APPLIED}),
    Task("lost-by-belief", _lost_by_belief, {"fed": APPLIED, "angle0": 8.0, "error0": 12.0}),
    Task("better-observer", _better_observer,
         {"fed": APPLIED, "angle0": 4.0, "error0": 8.0, "u_max": 4.0, "observer_poles": FAST}),
)
