"""Lay the path of lesson 7: from a clipped force to an observer that is told the applied force."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

from .knobs import APPLIED, COMMANDED

PATH = (
    Scene("recall", Choose(answer=0), minutes=0.5),
    Scene("meet", Press("play"), set={"fed": COMMANDED, "angle0": 6.0, "error0": 4.0, "u_max": 4.0}, minutes=1.5),
    Scene("clipped", figures=("input",), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), play={"fed": APPLIED}, minutes=2.0),
    Scene("why", figures=("error",), formulas=("error",), minutes=2.0),
    Scene("windup", set={"fed": COMMANDED}, formulas=("clipped",), minutes=3.0, core=False),
    Scene("belief", Move(("error0",)), set={"fed": APPLIED}, knobs=("error0",), figures=("state0",), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), set={"fed": COMMANDED}, play={"error0": 0.0}, minutes=2.0),
    Scene("ceiling", Move(("u_max",)), set={"fed": APPLIED}, knobs=("u_max",), minutes=3.0, core=False),
    Scene("task", Solve("better-observer"), set={"angle0": 4.0, "error0": 8.0}, boards=("observer",), figures=("state0",),
          minutes=3.0),
    Scene("remember", set={"angle0": 6.0, "error0": 4.0}, figures=("error",), minutes=1.0),
)
