"""Define the knobs of lesson 18: case, link from the sensor, link to the actuator."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Number
from observer_lab.text import text, text_in

from ..toolkit.knobs import run_knobs
from .cases import CART_CASE, CASE_KINDS, CHIP_CASE, DECK_CASE, HORIZON, MAX_PERIOD_FACTOR, SCALAR_CASE
from .study import HOLD_INPUT, TOLD_AHEAD, TOLD_APPLIED, TOLD_COMMANDED, ZERO_INPUT

SENSOR_GROUP, ACTUATOR_GROUP = text("From the sensor"), text("To the actuator")
KNOBS = (
    Choice(
        "case",
        "",
        text_in("network", "case"),
        default=SCALAR_CASE,
        options=tuple((name, kind.label) for name, kind in CASE_KINDS.items()),
        hint=text("Four unstable plants, and the deck, which is stable."),
    ),
    Number(
        "a",
        "a",
        text("growth per sample a"),
        low=1.01,
        high=2.0,
        default=1.2,
        step=0.01,
        when=("case", (SCALAR_CASE,)),
        hint=text("x⁺ = a x + u + w: left alone, x is multiplied by a every sample."),
    ),
    Number(
        "stretch",
        r"h/h_0",
        text("sampling period"),
        "h₀",
        low=0.5,
        high=MAX_PERIOD_FACTOR,
        default=1.0,
        step=0.05,
        when=("case", (CHIP_CASE, CART_CASE, DECK_CASE)),
        hint=text("In units of the normal one: chip 0.5 s, cart 50 ms, deck 40 ms."),
    ),
    Number(
        "noise",
        r"\sigma_v",
        text("sensor noise"),
        "σ₀",
        low=0.1,
        high=10.0,
        default=1.0,
        scale="log",
        hint=text("Standard deviation, in units of the normal one."),
    ),
    Number(
        "loss",
        "p",
        text("measurements lost"),
        low=0.0,
        high=0.99,
        default=0.3,
        step=0.01,
        group=SENSOR_GROUP,
        hint=text("Each packet is lost with this probability, whatever happened to the others."),
    ),
    Number(
        "jitter",
        "J",
        text("late by up to (samples)"),
        low=0,
        high=4,
        default=0,
        scale="integer",
        group=SENSOR_GROUP,
        hint=text("Each measurement comes late by none to this many samples, so they may overtake each other."),
    ),
    Choice(
        "order",
        "",
        text("late measurements"),
        default="stamped",
        group=SENSOR_GROUP,
        when=("jitter", (1.0, 2.0, 3.0, 4.0)),
        options=(("stamped", text("put in place by time stamp")), ("arrival", text("taken for fresh"))),
        hint=text("With time stamps the filter goes back and takes each in where it belongs."),
    ),
    Number(
        "loss_u",
        "p_u",
        text("inputs lost"),
        low=0.0,
        high=0.95,
        default=0.1,
        step=0.01,
        group=ACTUATOR_GROUP,
        hint=text("Each input packet is lost with this probability."),
    ),
    Choice(
        "lost",
        "",
        text("in place of a lost input"),
        default=HOLD_INPUT,
        group=ACTUATOR_GROUP,
        options=((HOLD_INPUT, text("hold the last one")), (ZERO_INPUT, text("apply zero"))),
        hint=text("The input of the plant when no packet arrives."),
    ),
    Number(
        "delay",
        "d",
        text("delay of inputs (samples)"),
        low=0,
        high=4,
        default=0,
        scale="integer",
        group=ACTUATOR_GROUP,
        hint=text("Every input acts this many samples after it was asked for."),
    ),
    Choice(
        "told",
        "",
        text("input of the observer"),
        default=TOLD_APPLIED,
        group=ACTUATOR_GROUP,
        options=(
            (TOLD_COMMANDED, text("the input asked for")),
            (TOLD_APPLIED, text("the input applied")),
            (TOLD_AHEAD, text("the input applied, u looks ahead")),
        ),
        hint=text("Looking ahead: u = −K times the state predicted over the delay."),
    ),
    *run_knobs(HORIZON),
)
