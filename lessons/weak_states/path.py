"""Lay the path of lesson 12: from a rank that depends on units to the two states that were cut."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Read, Scene, Solve

PATH = (
    Scene("recall", Choose(answer=0), minutes=0.5),
    Scene("meet", Press("play"), minutes=1.0),
    Scene("rank", Move(("clock",)), knobs=("clock",), figures=("ranks",), minutes=2.0),
    Scene("predict", Choose(Question.FIRST), set={"clock": 1.0}, play={"pair": "5"}, minutes=1.5),
    Scene("why", Read(), figures=("staircase",), formulas=("hankel",), minutes=2.0),
    Scene("cut", Move(("order",)), knobs=("order",), figures=("error",), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), set={"order": 8}, play={"order": 9}, minutes=2.0),
    Scene("bound", Read(), figures=("error",), formulas=("bound",), minutes=3.0, core=False, set={"order": 8}),
    Scene("geometry", Move(("s",)), knobs=("s",), figures=("forms",), formulas=("against",), minutes=4.0, core=False, set={"order": 8}),
    Scene("task", Solve("clock"), knobs=("clock", "tolerance"), figures=("ranks",), minutes=2.5,
          set={"order": 8, "s": 0.072391, "tolerance": 1e-6}),
    Scene("remember", Read(), figures=("staircase",), minutes=1.0),
)
