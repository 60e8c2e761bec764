"""Knobs of the lesson: the case, what happens on the way from the sensor, and on the way to the actuator."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number
from app.text import text, text_in

from ..toolkit.knobs import run_knobs
from .cases import CART, CHIP, DECK, HORIZON, KINDS, SCALAR, SLOWEST
from .study import AHEAD, APPLIED, ASKED, HOLD, ZERO

SENSOR, ACTUATOR = text("From the sensor"), text("To the actuator")
KNOBS = (
    Choice("case", "", text_in("network", "case"), default=SCALAR, options=tuple((name, kind.label) for name, kind in KINDS.items()),
           hint=text("Four that run away by themselves, and the deck, which does not.")),
    Number("a", "a", text("growth per sample a"), low=1.01, high=2.0, default=1.2, step=0.01, when=("case", (SCALAR,)),
           hint=text("x⁺ = a x + u + w: left alone, x is multiplied by a every sample.")),
    Number("stretch", r"h/h_0", text("sampling period"), "h₀", low=0.5, high=SLOWEST, default=1.0, step=0.05,
           when=("case", (CHIP, CART, DECK)),
           hint=text("In units of the normal one: chip 0.5 s, cart 50 ms, deck 40 ms.")),
    Number("noise", r"\sigma_v", text("sensor noise"), "σ₀", low=0.1, high=10.0, default=1.0, scale="log",
           hint=text("Standard deviation, in units of the normal one.")),
    Number("loss", "p", text("measurements lost"), low=0.0, high=0.99, default=0.3, step=0.01, group=SENSOR,
           hint=text("Each packet is lost with this probability, whatever happened to the others.")),
    Number("jitter", "J", text("late by up to (samples)"), low=0, high=4, default=0, scale="integer", group=SENSOR,
           hint=text("Each measurement comes late by none to this many samples, so they may overtake each other.")),
    Choice("order", "", text("late measurements"), default="stamped", group=SENSOR, when=("jitter", (1.0, 2.0, 3.0, 4.0)),
           options=(("stamped", text("put in place by time stamp")), ("arrival", text("taken "
                                                                                                            "for "
                                                                                                            "fresh"))),
           hint=text("With time stamps the filter goes back and takes each in where it belongs.")),
    Number("loss_u", "p_u", text("inputs lost"), low=0.0, high=0.95, default=0.1, step=0.01, group=ACTUATOR,
           hint=text("Each input packet is lost with this probability.")),
    Choice("lost", "", text("in place of a lost input"), default=HOLD, group=ACTUATOR,
           options=((HOLD, text("hold the last one")), (ZERO, text("apply zero"))),
           hint=text("What the actuator does when no packet comes.")),
    Number("delay", "d", text("delay of inputs (samples)"), low=0, high=4, default=0, scale="integer", group=ACTUATOR,
           hint=text("Every input acts this many samples after it was asked for.")),
    Choice("told", "", text("the observer counts with"), default=APPLIED, group=ACTUATOR,
           options=((ASKED, text("the input asked for")), (APPLIED, text("the input applied")),
                    (AHEAD, text("the input applied, u looks ahead"))),
           hint=text("Looking ahead: u = −K times the state predicted over the delay.")),
    *run_knobs(HORIZON),
)
