"""Lay the path of lesson 16: one number of a bilinear plant, with an error that no input reaches."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

BOARD = ("observer",)
PAPER_POLE = (-30 + 0j,)
PATH = (
    Scene("recall", Choose(answer=1), minutes=0.5),
    Scene("meet", Press("kick"), minutes=1.0),
    Scene("split", set={"step": 1}, formulas=("x", "V2"), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), play={"input": "step", "amplitude": 3.0}, boards=BOARD, minutes=1.5),
    Scene("why", set={"step": 7}, boards=BOARD, figures=("error",), formulas=("A_L",), minutes=2.0),
    Scene("drag", Move(("pole",)), set={"step": 6}, boards=BOARD, figures=("error",), formulas=("pi",), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), set={"input": "sine", "amplitude": 1.0, "pole": PAPER_POLE, "form": "filtered"},
          play={"pole": (-60 + 0j,)}, boards=BOARD, minutes=2.0),
    Scene("task", Solve("lag"), set={"pole": PAPER_POLE, "tau": 0.02}, knobs=("tau",), figures=("forms",), minutes=2.0),
    Scene("sensors", set={"form": "plain", "problem": "three"}, figures=("error", "problems"), minutes=3.0, core=False),
    Scene("stuck", set={"problem": "stuck"}, boards=BOARD, figures=("problems",), minutes=2.5, core=False),
    Scene("remember", set={"problem": "paper"}, figures=("error",), minutes=1.0),
)
