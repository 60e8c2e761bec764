"""Lay the path of lesson 18: from one lost packet to the share that may be lost, and to late inputs."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Read, Scene, Solve

PATH = (
    Scene("recall", Choose(answer=1), minutes=0.5),
    Scene("meet", Press("play"), minutes=1.0),
    Scene("packets", Read(), figures=("teeth",), formulas=("mean",), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), play={"loss": 0.75}, minutes=1.5),
    Scene("why", Read(), formulas=("edge", "growth"), minutes=2.0),
    Scene("ridge", Move(("a",)), knobs=("a",), figures=("means",), minutes=2.0, set={"loss": 0.3}),
    Scene("surprise", Choose(Question.SECOND), set={"loss": 0.3, "a": 1.2}, play={"delay": 1}, minutes=2.0),
    Scene("ahead", Move(("told",)), knobs=("told",), figures=("spectrum",), minutes=2.0),
    Scene("inputs", Move(("loss_u",)), knobs=("loss_u",), figures=("growth",), minutes=4.0, core=False,
          set={"delay": 0, "told": "applied", "case": "chip-runaway", "loss_u": 0.3}),
    Scene("task", Solve("edge"), knobs=("a", "loss"), figures=("means",), minutes=2.5,
          set={"delay": 0, "told": "applied", "case": "scalar", "loss_u": 0.1, "a": 1.4}),
    Scene("remember", Read(), figures=("means",), minutes=1.0),
)
