"""Lay the path of lesson 20: a load without a sensor becomes a state of the observer."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

PATH = (
    Scene("recall", Choose(answer=0), minutes=0.5),
    Scene("meet", Press("play"), set={"load": 0.0, "load_state": True, "cancel": True}, minutes=1.0),
    Scene("state", formulas=("error",), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), play={"load": 1.5}, minutes=2.0),
    Scene("why", figures=("load",), formulas=("L",), minutes=2.0),
    Scene("without", Move(("load_state",)), knobs=("load_state",), figures=("angle",), minutes=2.0),
    Scene("faster", Move(("observer_poles",)), boards=("observer",), figures=("load",), minutes=2.5, core=False),
    Scene("surprise", Choose(Question.SECOND), play={"cancel": False}, minutes=2.0),
    Scene("play", Move(("gap",)), set={"cancel": True}, knobs=("gap",), figures=("load",), minutes=3.0, core=False),
    Scene("task", Solve("supply"), set={"load": 2.4, "u_max": 24.0}, knobs=("u_max",), figures=("angle",), minutes=2.5),
    Scene("remember", set={"load": 1.5}, figures=("load",), minutes=1.0),
)
