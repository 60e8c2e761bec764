"""Lay the path of lesson 9: an ellipsoid that grows and shrinks, and a filter that passes its tests."""

from __future__ import annotations

from types import MappingProxyType

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

RIGHT = MappingProxyType({"q": 1.0, "r": 1.0})
WRONG = MappingProxyType({"q": 0.05, "r": 1.73})  # two errors that cancel in the mean of NIS

PATH = (
    Scene("recall", Choose(answer=1), minutes=0.5),
    Scene("meet", Press("play"), set=RIGHT, minutes=1.0),
    Scene("grow", set={"k": 5.0, "phase": "predict"}, minutes=1.5),
    Scene("shrink", Move(("phase",)), knobs=("phase",), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), set={**WRONG, "phase": "update"}, minutes=2.0),
    Scene("why", figures=("tests",), formulas=("nis",), minutes=1.5),
    Scene("retune", Move(("q",)), knobs=("q",), figures=("nees",), minutes=1.5),
    Scene("gain", Move(("p0",)), set=RIGHT, knobs=("p0",), figures=("gain",), minutes=3.0, core=False),
    Scene("surprise", Choose(Question.SECOND), set=WRONG, play={"q": 100.0}, minutes=1.5),
    Scene("task", Solve("tune"), set=WRONG, knobs=("q", "r"), figures=("tests",), minutes=2.5),
    Scene("remember", set=RIGHT, minutes=1.0),
)
