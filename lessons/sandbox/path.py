"""Lay the path of lesson 19: what full rank says of a plant, and what it leaves open."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

BOARDS = ("controller", "observer")
FAST_OBSERVER = (-7.18 + 0j, -6.87 + 0j, -5 - 2j, -5 + 2j)  # rad/s, for the example plant
PATH = (
    Scene("recall", Choose(answer=1), minutes=0.5),
    Scene("meet", Press("kick"), minutes=1.0),
    Scene("boards", boards=BOARDS, formulas=("L",), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), play={"observer_poles": FAST_OBSERVER}, boards=BOARDS, formulas=("L",), minutes=1.5),
    Scene("why", figures=("lights",), minutes=2.0),
    Scene("drag", Move(("observer_poles",)), boards=BOARDS, figures=("error",), formulas=("L",), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), set={"belief": 1.0}, play={"belief": 1000.0}, minutes=2.0),
    Scene("task", Solve("below-the-tolerance"), set={"belief": 1.0}, knobs=("tolerance",), figures=("sizes",), minutes=2.0),
    Scene("limit", Move(("fed",)), set={"tolerance": 1e-12, "limited": True, "u_max": 0.2}, knobs=("limited", "fed", "u_max"),
          figures=("input", "error"), minutes=3.0, core=False),
    Scene("own", set={"limited": False}, figures=("modes",), minutes=2.5, core=False),
    Scene("remember", figures=("lights",), minutes=1.0),
)
