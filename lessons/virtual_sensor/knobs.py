"""Define the knobs of lesson 1, on a stable chip and on one with thermal runaway."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Number, Poles, Switch
from observer_lab.plants import MODELS, chip
from observer_lab.text import text

from ..toolkit.knobs import run_knobs

STABLE_ID, RUNAWAY_ID, HORIZON = chip.MODEL.id, chip.RUNAWAY_MODEL.id, chip.MODEL.horizon
OBSERVER_WINDOW = MODELS[STABLE_ID].observer_window
DT = MODELS[STABLE_ID].dt
MOST_TRUST = 2.0
KNOBS = (
    Choice(
        "plant",
        "",
        text("chip"),
        default=STABLE_ID,
        options=((STABLE_ID, text("cools by itself")), (RUNAWAY_ID, text("runs away"))),
        hint=text("Leakage current that grows with temperature can make the chip heat itself without end."),
    ),
    Number(
        "trust",
        r"\theta",
        text("trust in the sensor θ"),
        low=0.0,
        high=MOST_TRUST,
        default=1.0,
        step=0.01,
        hint=text("The gain is θ times the one for the poles below; θ = 0 is the open-loop copy."),
    ),
    Poles(
        "observer_poles",
        "q",
        text("Observer poles at θ = 1"),
        "rad/s",
        default=MODELS[STABLE_ID].observer_poles,
        re_low=OBSERVER_WINDOW.re_low,
        re_high=OBSERVER_WINDOW.re_high,
        im_high=OBSERVER_WINDOW.im_high,
        role="estimate",
        hint=text("The error dies as fast as the rightmost of these; far left asks for a large gain."),
    ),
    Number(
        "guess_core",
        r"\hat T_1(0)",
        text("first guess of the core"),
        "K",
        low=-40.0,
        high=80.0,
        default=0.0,
        step=1.0,
        hint=text("Above ambient. The core really starts at 45 K, or 12 K if it runs away."),
    ),
    Number(
        "guess_case",
        r"\hat T_2(0)",
        text("first guess of the case"),
        "K",
        low=-40.0,
        high=80.0,
        default=0.0,
        step=1.0,
        hint=text("Above ambient. The case really starts at 20 K, or 6 K if it runs away."),
    ),
    Number(
        "air_error",
        r"\delta_R",
        text("case-to-air resistance wrong by"),
        "%",
        low=-50.0,
        high=50.0,
        default=0.0,
        step=1.0,
        hint=text("Error of both models in the fan's resistance; if positive, they underestimate the cooling."),
    ),
    Number(
        "power",
        "P",
        text("computing power"),
        "W",
        low=0.0,
        high=40.0,
        default=10.0,
        step=1.0,
        hint=text("Work for 3 s, then a quarter of it for 3 s. Chip, copy and observer all get it."),
    ),
    Number(
        "noise",
        r"\sigma",
        text("sensor noise"),
        "K",
        low=0.0,
        high=2.0,
        default=0.0,
        step=0.05,
        hint=text("Standard deviation of each reading, one every 30 ms."),
    ),
    Switch("reduced", "", text("reduced-order observer too"),
           hint=text("Also run an observer of one state, for the core alone. Its pole is the rightmost of the two above.")),
    *run_knobs(HORIZON),
)
