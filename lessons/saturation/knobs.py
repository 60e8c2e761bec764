"""Define the knobs of lesson 7, on a cart-pendulum."""

from __future__ import annotations

from dataclasses import replace

from observer_lab.course.knobs import Choice, Number, Switch
from observer_lab.plants import MODELS
from observer_lab.text import text

from ..toolkit.knobs import pole_knobs, pull_knobs, run_knobs

MODEL = replace(MODELS["cart-pendulum"], horizon=8.0, dt=0.02)
COMMANDED, APPLIED = "commanded", "applied"
KNOBS = (
    Choice("fed", "", text("input of the observer"), default=COMMANDED,
           options=((COMMANDED, text("the commanded force")), (APPLIED, text("the applied force"))),
           hint=text("The commanded force, or the applied force.")),
    Number("u_max", r"u_{\max}", text("force limit"), "N", low=1.0, high=10.0, default=4.0, step=0.1,
           hint=text("The motor gives at most this much, either way.")),
    Number("angle0", r"\theta(0)", text("true angle at the start"), "°", low=-20.0, high=20.0, default=6.0,
           step=0.5, hint=text("Where the pole really leans when the run begins; the cart is at rest.")),
    Number("error0", r"e_\theta(0)", text("error of its estimate"), "°", low=-20.0, high=20.0,
           default=4.0, step=0.5, hint=text("The observer starts from θ(0) minus this error.")),
    Switch("fog", "", text("fog hides the pole"), default=False,
           hint=text("Only the cart can be seen. The stage and the plot of the angle show the estimate of the pole alone.")),
    *(replace(knob, when=None) for knob in pole_knobs(MODEL)),
    *run_knobs(MODEL.horizon),
    *pull_knobs(MODEL),
)
