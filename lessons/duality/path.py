"""Lay the path of lesson 5: from a gain found twice to an ellipse and its mirror image."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

BOARDS = ("controller", "observer")
PATH = (
    Scene("recall", Choose(answer=1), minutes=0.5),
    Scene("meet", Press("kick"), minutes=1.0),
    Scene("boards", boards=BOARDS, formulas=("K",), minutes=1.0),
    Scene("predict", Choose(Question.FIRST), boards=BOARDS, minutes=1.5),
    Scene("why", boards=BOARDS, formulas=("twin", "L"), minutes=2.0),
    Scene("drag", Move(("poles",)), boards=BOARDS, figures=("gains",), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), play={"sensor": 90.0}, boards=BOARDS, minutes=2.0),
    Scene("riccati", Move(("q",)), set={"method": "weights", "sensor": 0.0}, knobs=("q",), figures=("riccati",), minutes=2.5,
          core=False),
    Scene("backward", Press("play"), set={"method": "poles"}, figures=("pairing",), minutes=2.0, core=False),
    Scene("task", Solve("mirror"), set={"method": "poles", "sensor": 0.0}, knobs=("sensor",), figures=("reach", "seen"), minutes=2.5),
    Scene("remember", figures=("gains",), minutes=1.0),
)
