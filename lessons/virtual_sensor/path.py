"""Lay the path of lesson 1: from a copy without a sensor to an observer and the price of its speed."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

DEFAULT_POLES = (-1.6 - 0.5j, -1.6 + 0.5j)
PATH = (
    Scene("meet", Press("play"), minutes=1.0),
    Scene("copy", Move(("guess_core",)), set={"trust": 0.0}, knobs=("guess_core",), minutes=1.0),
    Scene("predict", Choose(Question.FIRST), minutes=1.5),
    Scene("why", formulas=("observer",), minutes=1.5),
    Scene("trust", Move(("trust",)), knobs=("trust",), figures=("error",), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), set={"trust": 1.0}, play={"observer_poles": (-3.2 - 1j, -3.2 + 1j)},
          boards=("observer",), minutes=2.0),
    Scene("runaway", Move(("trust",)), set={"plant": "chip-runaway", "trust": 0.0, "observer_poles": DEFAULT_POLES},
          knobs=("trust",), figures=("error",), minutes=2.0),
    Scene("noise", Move(("noise",)), set={"plant": "chip", "trust": 1.0}, knobs=("noise", "trust"), figures=("core",),
          minutes=2.0, core=False),
    Scene("reduced", Move(("reduced",)), set={"noise": 0.5}, knobs=("reduced", "noise"), figures=("core", "error"),
          minutes=2.0, core=False),
    Scene("model", Move(("trust",)), set={"noise": 0.0, "air_error": 40.0, "trust": 0.3}, knobs=("trust",), figures=("core", "case"),
          minutes=2.5, core=False),
    Scene("task", Solve("feel-the-core"), set={"air_error": 0.0, "trust": 1.0}, boards=("observer",), minutes=2.5),
    Scene("remember", figures=("error",), minutes=1.0),
)
