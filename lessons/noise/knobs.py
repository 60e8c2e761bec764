"""Define the knobs of lesson 8: observer poles and the strength of both noises."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Number, Poles
from observer_lab.plants import MODELS
from observer_lab.text import text

from ..toolkit.knobs import pull_knobs, run_knobs

MODEL = MODELS["spring-damper"]
SPRING_PLANT = MODEL.plant
HORIZON, DT = 6.0, 0.012
RE_LOW, RE_HIGH, IM_HIGH = -16.0, 2.0, 13.0
POLES = (-8 - 6j, -8 + 6j)  # dragged from here
BY_SPEED, BY_POLES = "speed", "poles"
POSITION, VELOCITY = "position", "velocity"
KNOBS = (
    Choice("method", "", text("observer by"), default=BY_SPEED,
           options=((BY_SPEED, text("speed, in the Kalman pattern")),
                    (BY_POLES, text("dragging poles"))),
           hint=text("One factor on the Kalman filter's poles, or two poles of your own on the right board.")),
    Number("speed", r"\rho", text("speed, times Kalman"), low=0.1, high=10.0, default=5.0, scale="log",
           when=("method", (BY_SPEED,)), hint=text("Both poles are ρ times those of the Kalman filter.")),
    Poles("observer_poles", "q", text("Observer poles"), "rad/s", default=POLES, re_low=RE_LOW,
          re_high=RE_HIGH, im_high=IM_HIGH, role="estimate", when=("method", (BY_POLES,)),
          hint=text("eig(A − LC): farther left is faster.")),
    Number("w", "W", text("force noise W"), "N² s", low=1e-2, high=1.0, default=0.04, scale="log",
           hint=text("Intensity of the unknown force on the block.")),
    Number("v", "V", text("sensor noise V"), "m² s", low=1e-5, high=1e-2, default=4e-4, scale="log",
           hint=text("Intensity of the noise on the measured position.")),
    Number("error0", "e_1(0)", text("position error at the start"), "m", low=0.0, high=1.0, default=0.3,
           step=0.05, hint=text("Where the block really starts; the observer starts from 0.")),
    Choice("watch", "", text("judge by the error in"), default=VELOCITY,
           options=((POSITION, text("position, measured")),
                    (VELOCITY, text("velocity, not measured"))),
           hint=text("Which error the curves show.")),
    *run_knobs(HORIZON),
    *pull_knobs(MODEL),
)
