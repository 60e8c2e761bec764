"""Lay the path of lesson 17: seven observers, thresholds from the noise, and a loop that reacts."""

from __future__ import annotations

from types import MappingProxyType

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

DRIFT = MappingProxyType({"place": "VR", "kind": "drift", "drift": 4.0, "loop": "blind"})
PATH = (
    Scene("recall", Choose(answer=1), set={"place": "none"}, minutes=0.5),
    Scene("meet", Press("kick"), minutes=1.0),
    Scene("bank", figures=("members",), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), set={"bias": 3.0}, play={"place": "HL"}, minutes=1.5),
    Scene("why", figures=("isolation",), formulas=("statistic",), minutes=2.0),
    Scene("choose", Move(("place",)), knobs=("place", "bias"), figures=("isolation",), minutes=1.5),
    Scene("surprise", Choose(Question.SECOND), set={"place": "HL", "bias": 1.5, "window": 25}, play={"window": 100}, minutes=2.0),
    Scene("threshold", Move(("rate",)), set={"window": 25, "bias": 3.0}, knobs=("rate", "window"), figures=("counts",),
          formulas=("threshold",), minutes=3.0, core=False),
    Scene("loop", set={**DRIFT, "window": 25}, figures=("pitch",), minutes=1.5),
    Scene("task", Solve("limp"), knobs=("loop", "statistic", "window"), figures=("pitch",), minutes=2.5),
    Scene("remember", set={"place": "HL", "kind": "bias", "bias": 3.0}, figures=("isolation",), minutes=1.0),
)
