"""Lay the path of lesson 8: from a fast, noisy observer to the student's own choice of poles."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

KALMAN = (-2.14 - 2.34j, -2.14 + 2.34j)  # the filter's poles at the lesson's noises, to two digits

PATH = (
    Scene("recall", Choose(answer=0), minutes=0.5),
    Scene("meet", Press("play"), set={"method": "speed", "speed": 5.0, "v": 0.0004}, figures=("velocity",), minutes=1.0),
    Scene("predict", Choose(Question.FIRST), play={"speed": 10.0}, minutes=1.5),
    Scene("why", set={"speed": 5.0}, figures=("shares",), formulas=("lyapunov",), minutes=2.0),
    Scene("valley", Move(("speed",)), knobs=("speed",), figures=("valley",), minutes=2.0),
    Scene("peaking", Move(("speed",)), knobs=("speed",), figures=("peaks",), minutes=3.0, core=False),
    Scene("surprise", Choose(Question.SECOND), set={"speed": 1.0}, play={"v": 0.0064}, boards=("kalman",), minutes=2.0),
    Scene("procedure", set={"v": 0.0004, "method": "poles", "observer_poles": KALMAN}, boards=("kalman", "observer"), minutes=1.5),
    Scene("task", Solve("bargain"), boards=("observer",), figures=("valley",), minutes=2.5),
    Scene("choice", Move(("observer_poles",)), boards=("observer",), figures=("valley", "error"), minutes=2.0),
    Scene("remember", set={"method": "speed"}, figures=("valley",), minutes=1.0),
)
