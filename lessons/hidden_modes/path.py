"""Lay the path of lesson 6: from a fixed mode that decays to one that no gain can stop, and the cure."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

BOARDS = ("controller", "observer")
SOFT_SPRINGS, MAGNETS, PUSHED_APART = "unseen-stable", "unseen-unstable", "unmoved-unstable"
SLOW_CONTROLLER = (-0.9 - 1.2j, -0.9 + 1.2j, -1.5 - 3j, -1.5 + 3j)
PATH = (
    Scene("recall", Choose(answer=0), minutes=0.5),
    Scene("meet", Press("kick"), set={"plant": SOFT_SPRINGS}, minutes=1.0),
    Scene("fixed", Move(("observer_part",)), boards=("observer",), formulas=("seen",), minutes=2.0),
    Scene("predict", Choose(Question.FIRST), play={"plant": MAGNETS}, boards=("observer",), minutes=1.5),
    Scene("why", figures=("measured", "error_parts"), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), play={"controller_all": (-4 - 1j, -4 + 1j, -4.5 - 3j, -4.5 + 3j)},
          boards=BOARDS, minutes=2.0),
    Scene("detectable", Choose(answer=2), set={"controller_all": SLOW_CONTROLLER}, play={"plant": SOFT_SPRINGS}, figures=("lights",),
          minutes=1.5),
    Scene("dual", play={"plant": PUSHED_APART}, boards=BOARDS, figures=("state_parts",), minutes=2.0, core=False),
    Scene("taken-apart", set={"plant": MAGNETS}, figures=("decomposed",), minutes=2.0, core=False),
    Scene("task", Solve("cure"), set={"plant": MAGNETS}, knobs=("plant",), boards=BOARDS, minutes=3.0),
    Scene("remember", figures=("margins",), minutes=1.0),
)
