"""Lay the path of lesson 13: from two measures of isolation to filters with a wrong noise."""

from __future__ import annotations

from types import MappingProxyType

from observer_lab.course.scenes import Choose, Move, Press, Question, Read, Scene, Solve

SCORES = ("suppression",)
DEFAULT_NOISE = MappingProxyType({"sensor": 1e-10, "v": 1e-10})
PATH = (
    Scene("recall", Choose(answer=2), minutes=0.5),
    Scene("meet", Press("kick"), minutes=1.0),
    Scene("rivals", Move(("play",)), knobs=("play",), figures=("stage_velocity",), minutes=1.5),
    Scene("measures", Choose(answer=0), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), play={"sensor": 1e-14}, minutes=1.5),
    Scene("why", Read(), figures=SCORES, formulas=("gain",), minutes=1.5),
    Scene("tell", Move(("v",)), knobs=("v",), figures=SCORES, minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), set=DEFAULT_NOISE, play={"damping": -90.0}, minutes=2.0),
    Scene("delay", Move(("delay",)), knobs=("delay",), figures=SCORES, minutes=4.0, core=False, set={**DEFAULT_NOISE, "damping": 0.0}),
    Scene("task", Solve("twenty"), knobs=("sensor", "v"), figures=SCORES, minutes=2.5,
          set={**DEFAULT_NOISE, "damping": 0.0, "delay": 0.0}),
    Scene("remember", Read(), figures=("sizes",), minutes=1.0),
)
