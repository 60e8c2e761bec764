"""Define the tasks of lesson 8."""

from __future__ import annotations

import numpy as np

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import text

from ..toolkit.knobs import untouched
from .knobs import KNOBS
from .study import Study

GIVEN = tuple(knob.default for name in ("w", "v") for knob in KNOBS if knob.name == name)  # W and V of the start
MAX_VARIANCE_RATIO = 1.01  # of the least variances: the bottom of the valley
TWIN_SPEED = 0.3  # times Kalman: the slow observer whose fast twin is asked for
MAX_PEAK_M_S, MAX_SETTLING_S = 0.5, 1.4  # m/s and s
SETTLING_BAND_S, FLAT = (1.2, 1.3), 1.1  # s to settle in, and of the least variances what may be paid for it


def _by_hand(outcome: Outcome[Study]) -> Verdict:
    ratio = outcome.metrics["worst_ratio"]
    if outcome.design["method"] != "poles":
        return Verdict(False, text("Drag the poles yourself: here the Kalman filter is not to help."))
    if (outcome.design["w"], outcome.design["v"]) != GIVEN:
        return Verdict(False, text("Put the noises back to W = {given:g} and V = {given2:g}; move the poles to the minimum, not the "
                                   "minimum to the poles.",
                                   given=GIVEN[0], given2=GIVEN[1]))
    if ratio > MAX_VARIANCE_RATIO:
        return Verdict(False, text("The worse of the two variances is {ratio:.3f} times the least; at most "
                                   "{wanted} is wanted.",
                                   ratio=ratio, wanted=MAX_VARIANCE_RATIO))
    return Verdict(True, text("Both variances are within {ratio:.2f} % of the least possible.",
                              ratio=100 * (ratio - 1)))


def _other_side(outcome: Outcome[Study]) -> Verdict:
    sweep, m = outcome.study.sweep, outcome.metrics
    if outcome.design["method"] != "speed" or outcome.design["watch"] != "velocity":
        return Verdict(False, text("Use the Kalman pattern and judge by velocity."))
    wanted = float(np.exp(np.interp(np.log(TWIN_SPEED * m["kalman_speed"]), np.log(sweep.along),
                                    0.5 * np.log(sweep.process[:, 1] + sweep.sensor[:, 1]))))
    gap = m["velocity_rms"] / wanted - 1
    numbers = f"σ = {m['velocity_rms']:.3g} m/s, {wanted:.3g} m/s"
    if outcome.design["speed"] <= 1:
        return Verdict(False, text("This one is not faster than Kalman; σ = {velocity_rms:.3g} m/s, wanted "
                                   "{wanted:.3g} m/s.",
                                   velocity_rms=m["velocity_rms"], wanted=wanted))
    if abs(gap) > 0.05:
        return Verdict(False, text("σ = {velocity_rms:.3g} m/s; the slow observer has {wanted:.3g} m/s. Come within 5 "
                                   "%.",
                                   velocity_rms=m["velocity_rms"], wanted=wanted))
    return Verdict(True, text("{numbers} for the slow observer: equally bad, but now {sensor_share:.0f} % is sensor "
                              "noise.",
                              numbers=numbers, sensor_share=100 * m["sensor_share"]))


def _quiet_start(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    if d["error0"] < 0.3:
        return Verdict(False, text("The starting error is {error0:.3g} m; keep 0.3 m or more.", error0=d["error0"]))
    if not untouched(d):
        return Verdict(False, text("Leave kicks and pulls out."))
    numbers = (text("Peak {peak:.3g} m/s, not settled in this run", peak=m["peak"]) if np.isinf(m["settled_after"]) else
               text("Peak {peak:.3g} m/s, settled after {settled_after:.2f} s", peak=m["peak"], settled_after=m["settled_after"]))
    if m["peak"] > MAX_PEAK_M_S or m["settled_after"] > MAX_SETTLING_S:
        return Verdict(False, text("{numbers}; wanted at most {peak:g} m/s and {settled:g} s.",
                                   numbers=numbers, peak=MAX_PEAK_M_S, settled=MAX_SETTLING_S))
    return Verdict(True, text("{numbers}: fast enough, and the estimate has no large peak.", numbers=numbers))


def _bargain(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    if (d["w"], d["v"]) != GIVEN or d["error0"] < 0.3 or not untouched(d):
        return Verdict(False, text("Keep W = {given:g}, V = {given2:g}, a starting error of 0.3 m or more, and no kick or pull.",
                                   given=GIVEN[0], given2=GIVEN[1]))
    found = (text("Not settled in this run, and the worse of the two variances is {ratio:.3f} times the least", ratio=m["worst_ratio"])
             if np.isinf(m["settled_after"]) else
             text("Settled after {settled_after:.2f} s, and the worse of the two variances is {ratio:.3f} times the least",
                  settled_after=m["settled_after"], ratio=m["worst_ratio"]))
    if not SETTLING_BAND_S[0] <= m["settled_after"] <= SETTLING_BAND_S[1] or m["worst_ratio"] > FLAT:
        return Verdict(
            False,
            text(
                "{found}; wanted are {low:g} to {high:g} s and at most {most:g} times.",
                found=found,
                low=SETTLING_BAND_S[0],
                high=SETTLING_BAND_S[1],
                most=FLAT,
            ),
        )
    return Verdict(True, text("{found}.", found=found))


OFFSET = Typed("(4*d^2/V)^(1/3)", ("d", "V"), slips=(
    ("(2*d^2/V)^(1/3)", text("The derivative of d²/L² is −2 d²/L³.")),
    ("sqrt(2*d/V)", text("The offset counts by its square."))))
BOTH_IN_ONE_PLACE = Typed("(3*W/(5*V))^(1/4)", ("W", "V"), slips=(
    ("(W/V)^(1/4)", text("There the Kalman filter has its poles, 45° off the axis; two poles in one place balance otherwise.")),
    ("(W/(5*V))^(1/4)", text("The derivative of p⁻³ is −3 p⁻⁴."))))

TASKS = (
    Task("by-hand", _by_hand, {"method": "poles", "observer_poles": (-2.14 - 2.34j, -2.14 + 2.34j)}),
    Task("other-side", _other_side, {"speed": 1.77}),
    Task("quiet-start", _quiet_start, {"method": "poles", "observer_poles": (-4 - 2j, -4 + 2j)}),
    Task("bargain", _bargain, {"method": "poles", "observer_poles": (-3 - 2.3j, -3 + 2.3j)}),
    typed_task("both-in-one-place", BOTH_IN_ONE_PLACE),
    typed_task("offset", OFFSET),
)
