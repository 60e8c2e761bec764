"""Lay the path of lesson 2: from a known force that cancels to an error that only the poles decide."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

PATH = (
    Scene("recall", Choose(answer=1), minutes=0.5),
    Scene("meet", Press("play"), set={"input": "none"}, minutes=1.0),
    Scene("predict", Choose(Question.FIRST), play={"input": "sine"}, minutes=1.5),
    Scene("why", formulas=("law",), minutes=1.5),
    Scene("steer", Move(("input", "amplitude")), knobs=("input", "amplitude"), figures=("components",), minutes=2.0),
    Scene("kick", Press("kick"), figures=("error",), minutes=1.5),
    Scene("poles", Move(("observer_poles",)), boards=("observer",), figures=("error",), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), play={"guess_q": -1.0}, minutes=2.0),
    Scene("printed", set={"guess_q": 0.0}, play={"method": "printed", "input": "step"}, figures=("components",), minutes=2.0,
          core=False),
    Scene("task", Solve("calm-speed"), set={"method": "poles", "input": "sine", "guess_q": 0.0}, boards=("observer",),
          figures=("components",), minutes=2.5),
    Scene("remember", figures=("proof",), minutes=1.0),
)
