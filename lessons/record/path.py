"""Lay the path of lesson 21: from a record to a filter that is judged by rows it has not seen."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Scene, Solve

PATH = (
    Scene("recall", Choose(answer=0), minutes=0.5),
    Scene("meet", Press("play"), figures=("output",), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), minutes=1.5),
    Scene("why", figures=("values",), minutes=1.5),
    Scene("order", Move(("order",)), knobs=("order",), figures=("whiteness",), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), set={"order": 2, "factor": 1.0}, play={"factor": 100.0}, minutes=2.0),
    Scene("smoother", Move(("smoother",)), set={"factor": 1.0}, knobs=("smoother",), figures=("gap",), minutes=2.0),
    Scene("measured", set={"data": "furnace", "smoother": False}, figures=("nis",), minutes=2.0, core=False),
    Scene("task", Solve("over-confident"), set={"data": "spring"}, knobs=("factor",), figures=("nis",), minutes=2.5),
    Scene("remember", set={"factor": 1.0}, figures=("output",), minutes=1.0),
)
