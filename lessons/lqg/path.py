"""Lay the path of lesson 10: an optimal loop whose Nyquist curve comes close to −1, and recovery."""

from __future__ import annotations

from types import MappingProxyType

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

DOYLE = MappingProxyType({"case": "doyle", "q": 5.0, "sigma": 5.0, "recovery": 0.0, "gain": 1.0})

PATH = (
    Scene("recall", Choose(answer=0), minutes=0.5),
    Scene("meet", Press("kick"), set={"case": "platform"}, minutes=1.0),
    Scene("plant", set=DOYLE, boards=("regulator", "filter"), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), play={"q": 100.0, "sigma": 100.0}, minutes=2.0),
    Scene("why", set=DOYLE, figures=("nyquist",), formulas=("edge",), minutes=2.0),
    Scene("sharpen", Move(("sigma",)), knobs=("sigma",), figures=("nyquist",), minutes=2.0),
    Scene("gain", Move(("gain",)), knobs=("gain",), figures=("state0",), minutes=3.0, core=False),
    Scene("surprise", Choose(Question.SECOND), set=DOYLE, play={"recovery": 4.0}, minutes=2.0),
    Scene("task", Solve("recover"), set={"q": 1000.0, "sigma": 1000.0, "recovery": 0.0}, knobs=("recovery",), figures=("rings",),
          minutes=2.5),
    Scene("platform", Move(("recovery",)), set={"case": "platform"}, knobs=("recovery",), figures=("return",), minutes=3.0, core=False),
    Scene("remember", set={**DOYLE, "recovery": 4.0}, figures=("rings",), minutes=1.0),
)
