"""Lay the path of lesson 11: from three channels to what decoupling does not give."""

from __future__ import annotations

from observer_lab.course.scenes import Choose, Move, Press, Question, Read, Scene, Solve

ROTATION = ("spectrum-rotation",)
PATH = (
    Scene("recall", Choose(answer=1), set={"horizontal": "open"}, minutes=0.5),
    Scene("meet", Press("kick"), minutes=1.0),
    Scene("channels", Read(), figures=("dominance",), formulas=("law",), minutes=1.5),
    Scene("predict", Choose(Question.FIRST), play={"horizontal": "published"}, minutes=1.5),
    Scene("why", Read(), figures=ROTATION, formulas=("law",), minutes=2.0),
    Scene("coil", Move(("lower",)), knobs=("lower",), figures=ROTATION, minutes=2.0),
    Scene("surprise", Choose(Question.SECOND), set={"lower": 0.0}, play={"mix": "best"}, minutes=2.0),
    Scene("band", Move(("f_low",)), knobs=("f_low",), figures=("index", *ROTATION), camera="bare", minutes=3.0, core=False),
    Scene("poles", Move(("control_poles", "observer_poles")), boards=("control", "observer"), formulas=("E",), minutes=4.0, core=False,
          set={"f_low": 0.1, "mix": "none", "horizontal": "poles"}),
    Scene("sensors", Move(("corner",)), knobs=("corner",), figures=("transmissibility-vertical", "sensor-noise"), minutes=3.0, core=False,
          set={"f_low": 0.1, "mix": "none", "horizontal": "open", "vertical": "shaped", "gain_v": 400.0, "sensors": "geophone"}),
    Scene("task", Solve("constant"), knobs=("gain_v",), figures=("spectrum-vertical",), minutes=2.5,
          set={"f_low": 0.1, "mix": "none", "horizontal": "published", "vertical": "shaped", "gain_v": 2000.0, "sensors": "ideal",
               "corner": 0.1}),
    Scene("remember", Read(), figures=ROTATION, minutes=1.0),
)
