"""Define the knobs of lesson 4, on the platform's deck."""

from __future__ import annotations

from dataclasses import replace

from observer_lab.course.knobs import Number, Switch
from observer_lab.plants import MODELS
from observer_lab.plants.bodies.body import GHOST_NAME, PartName
from observer_lab.text import text

from ..toolkit.knobs import method_knobs, pole_knobs, pull_knobs, run_knobs

MOTION_GAIN = (
    30.0  # times that the stage exaggerates motion: what an observer's pole does to the ghost is to be seen from the first drag on
)
NAMES = (
    PartName(text("deck"), "deck", (-0.45, 0.0, 0.55), at=(-1.3, 0.0, 0.09)),
    PartName(text("coil"), "coil right", (0.28, -0.4, 0.15)),
    PartName(text("spring"), "seat left", (0.75, -0.4, 0.1)),
    PartName(GHOST_NAME, "deck", (0.1, -0.3, -0.5), True, (-0.2, -0.65, 0.0)),
)  # each where the deck is free of its ghost at the start of the run
MODEL = replace(MODELS["deck"], body=replace(MODELS["deck"].body, gain=MOTION_GAIN, names=NAMES))
KNOBS = (
    *method_knobs(),
    *pole_knobs(MODEL),
    Number("stiffness_error", r"\delta_k", text("stiffness error in the model"), "%", low=-30.0, high=30.0,
           default=0.0, step=1.0, hint=text("The observer's model has springs this much stiffer than the plant's.")),
    Number("delay", r"\tau", text("input delay"), "ms", low=0.0, high=60.0, default=0.0, step=6.0,
           hint=text("The force acts later than the observer assumes.")),
    Switch("limited", "", text("limit the coils"),
           hint=text("Clip every coil; the observer still gets the commanded force.")),
    Number("u_max", r"u_{\max}", text("coil limit"), "N", low=0.2, high=4.0, default=0.5, step=0.1,
           hint=text("The largest force that a coil can give."), when=("limited", (True,))),
    Number("command", "r", text("command for the height"), "mm", low=-3.0, high=3.0, default=0.0, step=0.1,
           hint=text("A step at the start: the height that the deck is asked to take, measured from its rest.")),
    Switch("integral", "", text("integral action"),
           hint=text("Integrate the difference between command and measured height, and add a force from it.")),
    Number("noise", r"\sigma_v", text("sensor noise"), "mm/s", low=0.0, high=5.0, default=0.0, step=0.1,
           hint=text("Standard deviation of each velocity sample; the noise itself is drawn from the seed.")),
    *run_knobs(MODEL.horizon),
    *pull_knobs(MODEL),
)
