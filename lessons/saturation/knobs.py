"""The knobs of lesson 7, on a cart with a pole."""

from __future__ import annotations

from dataclasses import replace

from app.lesson.knobs import Choice, Number
from app.plants import MODELS
from app.text.words import Text

from ..toolkit.knobs import pole_knobs, run_knobs

MODEL = MODELS["cart-pendulum"]
HORIZON = 8.0  # s
COMMANDED, APPLIED = "commanded", "applied"
KNOBS = (
    Choice("fed", "", Text("the observer is told", "送给观测器的是"), default=COMMANDED,
           options=((COMMANDED, Text("the commanded force", "指令力")), (APPLIED, Text("the applied force", "实际力"))),
           hint=Text("What the controller asked for, or what the motor really gave.", "控制器要的力，或电机真正给出的力。")),
    Number("u_max", r"u_{\max}", Text("force limit", "力的限幅"), "N", low=1.0, high=10.0, default=4.0, step=0.1,
           hint=Text("The motor gives at most this much, either way.", "电机在两个方向上最多给出这么大的力。")),
    Number("angle0", r"\theta(0)", Text("true angle at the start", "初始真实角度"), "°", low=-20.0, high=20.0, default=6.0,
           step=0.5, hint=Text("Where the pole really leans when the run begins; the cart is at rest.",
                               "运行开始时摆杆的真实倾角；小车静止。")),
    Number("error0", r"e_\theta(0)", Text("error of its estimate", "角度的初始估计误差"), "°", low=-20.0, high=20.0,
           default=4.0, step=0.5, hint=Text("The observer believes θ(0) minus this error.", "观测器认为角度是 θ(0) 减去这一误差。")),
    *(replace(knob, when=None) for knob in pole_knobs(MODEL)),
    *run_knobs(HORIZON),
)
