"""Lay the path of lesson 3: from two starts with one reading to how far a mode is from being hidden."""

from __future__ import annotations

from types import MappingProxyType

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

ALL_ROWS = MappingProxyType({"rows_deck": 6})
PATH = (
    Scene("recall", Choose(answer=1), minutes=0.5),
    Scene("meet", Press("play"), set={"left_on": False, "across_on": True, **ALL_ROWS}, minutes=1.0),
    Scene("twins", Choose(answer=1), minutes=1.5),
    Scene("both", Move(("left_on",)), knobs=("left_on", "apart"), figures=("two-readings", "two-states"), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), set={"left_on": True, "across_on": False}, minutes=1.5),
    Scene("why", figures=("matrix",), formulas=("rank",), minutes=2.0),
    Scene("move", Move(("left",)), knobs=("left",), figures=("modes",), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), set={"left": 0.0}, play={"noise": 0.003}, minutes=2.0),
    Scene("near", Move(("gap",)), set={"plant": "pair", "noise": 0.03}, knobs=("gap",), figures=("modes",), minutes=2.5, core=False),
    Scene("different", Move(("across_on",)), set={"plant": "deck", "left": -0.12, "noise": 0.03}, knobs=("across_on",),
          figures=("halves",), minutes=2.0, core=False),
    Scene("task", Solve("one-sensor"), set={"left": 0.0, "across_on": False}, knobs=("left",), figures=("sweep",), minutes=2.5),
    Scene("remember", figures=("modes",), minutes=1.0),
)
