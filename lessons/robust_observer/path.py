"""Lay the path of lesson 15: a small observer for one number, and what a wrong model does to it."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

BOARD = ("observer",)
PATH = (
    Scene("recall", Choose(answer=1), minutes=0.5),
    Scene("meet", Press("play"), minutes=1.0),
    Scene("functional", boards=BOARD, formulas=("law",), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), set={"pole": (-10 + 0j,)}, play={"pole": (-5 / 3 + 0j,)}, boards=BOARD, minutes=1.5),
    Scene("why", boards=BOARD, figures=("criterion",), formulas=("J",), minutes=2.0),
    Scene("drag", Move(("pole",)), boards=BOARD, figures=("e_u",), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), set={"pole": (-5 + 0j,), "c": 0.05}, play={"c": 0.0}, boards=BOARD, minutes=2.0),
    Scene("task", Solve("kink"), set={"c": 0.05}, knobs=("pole",), boards=BOARD, figures=("criterion",), minutes=2.0),
    Scene("blind", set={"pole": (-5 / 3 + 0j,)}, figures=("gain",), minutes=3.0, core=False),
    Scene("order", set={"example": "2"}, boards=BOARD, figures=("ranks",), minutes=3.0, core=False),
    Scene("remember", set={"example": "1"}, boards=BOARD, figures=("criterion",), minutes=1.0),
)
