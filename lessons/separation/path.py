"""Lay the path of lesson 4: from two sets of poles to what a wrong model changes."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

BOARDS = ("controller", "observer")
PATH = (
    Scene("recall", Choose(answer=1), minutes=0.5),
    Scene("meet", Press("kick"), minutes=1.0),
    Scene("boards", boards=BOARDS, minutes=1.0),
    Scene("predict", Choose(Question.FIRST), boards=BOARDS, minutes=1.5,
          play={"controller_poles": (-12 - 7j, -12 + 7j, -5 - 6j, -5 + 6j, -4 - 5j, -4 + 5j)}),
    Scene("why", boards=BOARDS, formulas=("loop",), minutes=2.0),
    Scene("drag", Move(("observer_poles",)), boards=BOARDS, figures=("error",), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), play={"stiffness_error": 10.0}, boards=BOARDS, minutes=2.0),
    Scene("command", Move(("integral",)), set={"command": 3.0}, knobs=("command", "integral"), figures=("command",),
          minutes=2.5, core=False),
    Scene("task", Solve("fast-observer"), set={"command": 0.0}, boards=BOARDS, minutes=2.5),
    Scene("remember", set={"stiffness_error": 0.0, "command": 0.0, "integral": False}, figures=("blocks",), minutes=1.0),
)
