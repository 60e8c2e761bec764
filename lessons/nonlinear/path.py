"""Lay the path of lesson 14: from two curved laws to filters that state too small an error."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Read, Scene, Solve

PATH = (
    Scene("recall", Choose(answer=1), set={"filter": "ukf"}, minutes=0.5),
    Scene("meet", Press("play"), minutes=1.0),
    Scene("laws", Read(), figures=("law", "law2"), formulas=("law",), minutes=2.0),
    Scene("predict", Choose(Question.FIRST), play={"filter": "ekf"}, minutes=1.5),
    Scene("why", Read(), figures=("nees",), formulas=("nees",), minutes=2.0),
    Scene("filters", Move(("filter",)), knobs=("filter",), figures=("errors",), minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), set={"filter": "kf"}, play={"sensor": 0.1}, minutes=2.0),
    Scene("readings", Choose(answer=1), set={"sensor": 1.0, "filter": "ekf"}, minutes=3.0, core=False),
    Scene("springs", Move(("hardening",)), knobs=("hardening",), figures=("nees",), minutes=4.0, core=False,
          set={"sensor": 1.0, "filter": "ekf", "case": "platform"}),
    Scene("task", Solve("small"), knobs=("size",), figures=("nees",), minutes=2.5,
          set={"sensor": 1.0, "filter": "ekf", "case": "platform", "hardening": 0.6}),
    Scene("remember", Read(), figures=("verdicts",), minutes=1.0),
)
