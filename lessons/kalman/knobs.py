"""Define the knobs of lesson 9: assumed noise, true noise, report line to doubt."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Number
from observer_lab.plants import MODELS
from observer_lab.text import Text, text, text_in

from ..toolkit.knobs import run_knobs

MODEL = MODELS["deck"]
DT, SAMPLE_COUNT = 0.04, 301  # s and samples: 12 s
HORIZON = DT * (SAMPLE_COUNT - 1)
WHITE, COLOURED, CARRIED = "white", "coloured", "carried"
NONE, GAIN_LINE, JOSEPH, SHORT_FORM_LINE, NEAR_R, MEANS = "none", "gain", "joseph", "short", "near-r", "means"
WRONG_LINES = (SHORT_FORM_LINE, NEAR_R, MEANS)
REPORT_LINES = (
    (NONE, text_in("kalman", "none")),
    (GAIN_LINE, text("(57): gain with S inverted")),
    (JOSEPH, text("(59): covariance update")),
    (SHORT_FORM_LINE, text("Algorithm 1, line 11")),
    (NEAR_R, text("innovation covariance close to R")),
    (MEANS, text("(61): means close to zero")),
)
PREDICT, UPDATE = "predict", "update"
STEP, ERRORS, GAIN = "step", "errors", "gain"  # what stands above the deck
SINGLE, FROZEN = "single", "frozen"
VZ_INDEX = 4  # of v_z in the state
LAST_SAMPLE = 60  # the latest sample that can be looked at step by step


def _belief(name: str, symbol: str, label: Text, default: float, high: float, hint: Text) -> Number:
    return Number(name, symbol, label, low=0.01, high=high, default=default, scale="log", hint=hint)


SHEET = text("Data sheet")


def _sheet(name: str, symbol: str, label: Text, unit: str, low: float, high: float, default: float, hint: Text) -> Number:
    return Number(name, symbol, label, unit, low=low, high=high, default=default, scale="log", group=SHEET, hint=hint)


KNOBS = (
    Choice("noise", "", text("sensor noise"), default=WHITE,
           options=((WHITE, text("white")), (COLOURED, text("converter, taken for white")),
                    (CARRIED, text("converter, carried as states"))),
           hint=text("White, or the 1/f noise of a converter, and what the filter makes of it.")),
    _belief("q", "q", text("assumed Q / true Q"), 0.05, 100.0,
            text("Below 1 the filter trusts its model too much.")),
    _belief("r", "r", text("assumed R / true R"), 1.73, 100.0,
            text("Below 1 the filter trusts its sensors too much.")),
    _belief("p0", "p_0", text("assumed / true P(0)"), 1.0, 1e4,
            text("How unsure the filter is before the first sample.")),
    Number("k", "k", text("sample to look at"), low=1, high=LAST_SAMPLE, default=1, scale="integer",
           hint=text("The tab One step shows this sample.")),
    Choice("phase", "", text("the step"), default=PREDICT,
           options=((PREDICT, text("predict")), (UPDATE, text("predict and update"))),
           hint=text("Before or after the sample is taken in.")),
    Choice("above", "", text("shown above the deck"), default=STEP,
           options=((STEP, text("ellipsoids of one sample")), (ERRORS, text("stated and actual errors")), (GAIN, text("size of the gain"))),
           hint=text("Ellipsoids of one sample, the errors beside them, or the gain at each time.")),
    Number("force", "F", text("known force at 0.16 Hz"), "N", low=0.0, high=2.0, default=1.0, step=0.1,
           hint=text("Amplitude on the vertical coils, half of it on the horizontal one; the filter gets this force.")),
    Choice("arithmetic", "", text("updates compared"), default=SINGLE,
           options=((SINGLE, text("in single precision")), (FROZEN, text(
               "with the final gain all along"))),
           hint=text("Joseph's form beside the short form, tab Gain.")),
    Choice("line", "", text("line of the report in doubt"), default=NONE, options=REPORT_LINES,
           hint=text("The tab Report shows what this filter says about it.")),
    _sheet("density", "n", text("noise density of a sensor"), "mm/s/√Hz", 0.01, 10.0, 0.28,
           text("One-sided. The tab Data sheet makes R of it.")),
    _sheet("step", r"\Delta", text("quantisation step"), "mm/s", 0.01, 10.0, 0.1,
           text("Smallest change that a reading shows.")),
    _sheet("push", "d", text("density of a vertical force"), "N/√Hz", 0.001, 1.0, 0.025,
           text("One-sided density of the unknown force. The tab Data sheet makes Q of it.")),
    _sheet("period", "T", text("sampling period of the sheet"), "s", 0.001, 0.2, DT,
           text("Only for the tab Data sheet; the run keeps its 0.04 s.")),
    *(Number(name, symbol, label, low=0.5, high=16.0, default=default, scale="log", group=text("One number"), hint=hint)
      for name, symbol, label, default, hint in (
          ("one_p", "P^-", text("variance of the estimate P⁻"), 4.0, text("How unsure the estimate of one number is before the reading.")),
          ("one_r", "R", text("variance of the reading R"), 2.0, text("Small: a good sensor. Only for the tab One number.")))),
    *run_knobs(HORIZON),
)
