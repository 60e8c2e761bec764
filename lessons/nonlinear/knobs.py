"""Define the knobs of lesson 14: case, laws, noise, filters, sigma points, report line."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Number, Switch
from observer_lab.text import text, text_in

from ..toolkit.knobs import run_knobs
from .cases import EKF, FALL_CASE, KF, PENDULUM_CASE, PLATFORM, UKF
from .report_algorithms import NONE, REPORT_LINES

HORIZON = 30.0  # s, of the longest record
ERRORS, TESTS = "errors", "tests"
KNOBS = (
    Choice("case", "", text_in("nonlinear", "case"), default=FALL_CASE,
           options=((PLATFORM, text("platform, hardening springs")),
                    (PENDULUM_CASE, text("pole in the fog")),
                    (FALL_CASE, text("falling body, radar"))),
           hint=text("The last one is the classic of Athans, Wishner and Bertolini, and of Julier and Uhlmann.")),
    Choice("filter", "", text("filter of the ghost"), default=EKF,
           options=((KF, text("KF, expanded once")),
                    (EKF, text("EKF, expanded at every estimate")),
                    (UKF, text("UKF, sigma points"))),
           hint=text("The filter whose estimate and 3σ are drawn, and which the controller uses where there is one.")),
    Choice("bars", "", text("bars of the stage"), default=ERRORS,
           options=((ERRORS, text("stated σ and RMS error")), (TESTS, text("NEES and NIS"))),
           hint=text("Two values of the filter of the ghost at each time, as bars before the body.")),
    Number("hardening", r"\gamma", text("hardening γ"), low=0.0, high=1.0, default=0.3, step=0.05, when=("case", (PLATFORM,)),
           hint=text("A spring stretched by 5 mm pulls 1 + γ times as hard as a linear one.")),
    Number("weakening", r"\nu", text("weakening of the coils ν"), low=0.0, high=1.0, default=0.2, step=0.05,
           when=("case", (PLATFORM,)), hint=text("The force is multiplied by e^(−ν) for every 5 mm of gap.")),
    Number("force", "F", text("known force"), "N", low=0.0, high=4.0, default=1.0, step=0.1, when=("case", (PLATFORM,)),
           hint=text("Amplitude at 0.16 Hz; every filter gets this input.")),
    Number("size", r"\sigma_0", text("unknown start, times"), low=0.2, high=2.0, default=1.0, step=0.05,
           hint=text("Standard deviation of the start, known to the filters: 1 is 2 mm, 5.7° or that of the papers.")),
    Number("wind", "q", text("process noise Q, times"), low=0.1, high=10.0, default=1.0, scale="log",
           when=("case", (PLATFORM, PENDULUM_CASE)), hint=text("True value and value in the filters; the falling body has none.")),
    Number("sensor", "r", text("sensor noise σ, times"), low=0.1, high=10.0, default=1.0, scale="log",
           hint=text("True value and value in every filter.")),
    Switch("steer", "", text("LQR on the estimate"), default=False, when=("case", (PLATFORM,)),
           hint=text("Feedback of the ghost's estimate moves the deck; the pole always has this feedback.")),
    Number("alpha", r"\alpha", text("UKF spread α"), low=0.1, high=1.0, default=1.0, step=0.05,
           hint=text("Distance of the sigma points from the mean: √(α²(n + κ)) standard deviations.")),
    Number("beta", r"\beta", text("UKF weight β"), low=0.0, high=4.0, default=2.0, step=0.1,
           hint=text("Added to the middle point's weight in covariances; 2 for a Gaussian.")),
    Number("kappa", r"\kappa", text("UKF spread κ"), low=-1.0, high=3.0, default=0.0, step=0.1,
           hint=text("Moves the points like α; 3 − n matches one fourth moment.")),
    Switch("redraw", "", text("sigma points redrawn"), default=True,
           hint=text("Off: Algorithm 3 of the report as printed.")),
    Choice("line", "", text("line of the report in doubt"), default=NONE, options=REPORT_LINES,
           hint=text("The tab Algorithm 3 says what the engine finds.")),
    *run_knobs(HORIZON),
)
