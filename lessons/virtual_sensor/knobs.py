"""The knobs of lesson 1, on a chip that cools and on one that runs away."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number, Poles
from app.plants import MODELS, chip
from app.text import text

from ..toolkit.knobs import run_knobs

TAME, RUNAWAY, HORIZON = chip.MODEL.id, chip.RUNAWAY.id, chip.MODEL.horizon
WINDOW = MODELS[TAME].observer_window
DT = MODELS[TAME].dt
MOST_TRUST = 2.0
KNOBS = (
    Choice("plant", "", text("chip"), default=TAME, options=(
        (TAME, text("cools by itself")), (RUNAWAY, text("runs away"))),
        hint=text("Leakage current that grows with temperature can make the chip heat itself without end.")),
    Number("trust", r"\theta", text("trust in the sensor θ"), low=0.0, high=MOST_TRUST, default=1.0,
           step=0.01, hint=text("The gain is θ times the one for the poles below; θ = 0 is the open-loop copy.")),
    Poles("observer_poles", "q", text("Observer poles at θ = 1"), "rad/s",
          default=MODELS[TAME].observer_poles, re_low=WINDOW.re_low, re_high=WINDOW.re_high, im_high=WINDOW.im_high,
          role="estimate", hint=text("The error dies as fast as the rightmost of these; far left asks for a large "
                                     "gain.")),
    Number("guess_core", r"\hat T_1(0)", text("first guess of the core"), "K", low=-40.0, high=80.0,
           default=0.0, step=1.0, hint=text("Above ambient. The core really starts at 45 K, or 12 K if it runs "
                                            "away.")),
    Number("guess_case", r"\hat T_2(0)", text("first guess of the case"), "K", low=-40.0, high=80.0,
           default=0.0, step=1.0, hint=text("Above ambient. The case really starts at 20 K, or 6 K if it runs "
                                            "away.")),
    Number("air_error", r"\delta_R", text("case-to-air resistance wrong by"), "%", low=-50.0,
           high=50.0, default=0.0, step=1.0,
           hint=text("What both models believe of the fan: positive, they think it cools worse than it does.")),
    Number("power", "P", text("computing power"), "W", low=0.0, high=40.0, default=10.0, step=1.0,
           hint=text("Work for 3 s, then a quarter of it for 3 s. Chip, copy and observer are all told.")),
    Number("noise", r"\sigma", text("sensor noise"), "K", low=0.0, high=2.0, default=0.0, step=0.05,
           hint=text("Standard deviation of each reading, one every 30 ms.")),
    *run_knobs(HORIZON),
)
