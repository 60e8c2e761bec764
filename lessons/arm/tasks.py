"""Define the tasks of lesson 20."""

from __future__ import annotations

from math import isinf

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.figures.claims import claim
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.plants.arm import MOTOR_DATA, PARAMETERS
from observer_lab.text import joined, text

from .knobs import JOINT
from .study import SOLID, Study

CANCEL = Typed("(R+K)/(n*k)", ("R", "K", "n", "k"), slips=(
    ("R/(n*k)", text("That voltage holds the load, but −K î takes away what K asks for its current.")),
    ("-(R+K)/(n*k)", text("Mind the sign: a load that presses down asks for a voltage that lifts."))))
INJECTION = Typed("-J*p^3", ("J", "p"), slips=(
    ("J*p^3", text("Mind the sign: under a load the arm lags, θ − θ̂ is negative, and τ̂ must rise.")),
    ("-p^3", text("You left out the inertia."))))
DETERMINANT_FORMULA = Typed("n*k*R/(J^2*L)", ("n", "k", "R", "J", "L"), slips=(
    ("-n*k*R/(J^2*L)", text("The size is right; the sign follows the order i, ω, θ, τ of the state.")),
    ("n*k*R/(J*L)", text("ω̇ carries 1/J already, and the load enters with another 1/J."))))
ENCODER_COUNTS, DROOP, FOUND_AFTER_S, STRAY = 2000, 4.5, 0.28, 0.04
HEAVY = 2.4  # N m


def _droops(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    if d["load_state"] or d["load"] != 1.5 or d["target"] != 60.0 or d["gap"]:
        return Verdict(False, text("Leave load, target and gear as the lesson has them, and switch the observer's state for the load off."))
    if abs(m["droop"] - DROOP) > 0.02 * DROOP:
        return Verdict(False, text("The arm droops by {droop:.3g}°; asked are {asked:g}° within 2 %.", droop=m["droop"], asked=DROOP))
    if m["largest_input"] > MOTOR_DATA.voltage:
        return Verdict(False, text("It droops by {droop:.3g}°, but asks for {peak:.3g} V; keep to {limit:g} V.", droop=m["droop"],
                                   peak=m["largest_input"], limit=MOTOR_DATA.voltage))
    return Verdict(True, text("It droops by {droop:.3g}° and asks for {peak:.3g} V at most.", droop=m["droop"], peak=m["largest_input"]))


def _counts(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    if d["encoder"] != JOINT or round(d["counts"]) != ENCODER_COUNTS or d["gap"] or d["load"] != 1.5 or not d["load_state"]:
        return Verdict(False, text("Take the counting encoder at the joint with its {counts} counts, no play, the load of 1.5 N m.",
                                   counts=ENCODER_COUNTS))
    late, stray = m["found_after"], m["load_error"]
    if isinf(late):
        return Verdict(False, text("The load is not found to 5 % within this run."))
    if abs(late - FOUND_AFTER_S) > 0.05 * FOUND_AFTER_S:
        return Verdict(
            False, text("The load is found after {late:.3f} s; asked are {asked:g} s within 5 %.", late=late, asked=FOUND_AFTER_S)
        )
    if stray > STRAY:
        return Verdict(False, text("Found after {late:.3f} s, but the estimate strays by {stray:.2g} N m at the end; at most {most:g}.",
                                   late=late, stray=stray, most=STRAY))
    return Verdict(True, text("Found after {late:.3f} s, and it strays by {stray:.2g} N m only.", late=late, stray=stray))


def _play(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    if d["gap"] != 2.0 or d["load"] != 1.5 or d["target"] != 60.0 or not d["load_state"]:
        return Verdict(False, text("Give the gear 2° of play; leave load and target as the lesson has them."))
    if m["angle_error"] > 0.1:
        return Verdict(False, text("In the last tenth of the run the arm is {angle:.2g}° from its target; at most 0.1°.",
                                   angle=m["angle_error"]))
    if m["false_load"] > 0.1:
        return Verdict(False, text("Before the load came the estimate was up to {false:.2g} N m; it may be 0.1 at "
                                   "most.", false=m["false_load"]))
    if isinf(m["found_after"]):
        return Verdict(False, text("The load is not found to 5 % within this run."))
    if m["found_after"] > 0.45:
        return Verdict(False, text("The load is found after {late:.3f} s; at most 0.45 s.", late=m["found_after"]))
    return Verdict(True, text("{angle:.2g}° from the target, up to {false:.2g} N m estimated without a load, the load found after "
                              "{late:.3f} s.",
                              angle=m["angle_error"], false=m["false_load"], late=m["found_after"]))


def _supply(outcome: Outcome[Study]) -> Verdict:
    m, d = outcome.metrics, outcome.design
    least = MOTOR_DATA.resistance * HEAVY / PARAMETERS.torque
    if d["load"] != HEAVY or d["target"] != 60.0:
        return Verdict(False, text("Set the load to {heavy:g} N m and leave the target at 60°.", heavy=HEAVY))
    if d["gap"] or m["angle_error"] > 0.3:
        return Verdict(False, text("In the last tenth of the run the arm is {angle:.2g}° from its target; at most 0.3°, without play.",
                                   angle=m["angle_error"]))
    if d["u_max"] > 1.35 * least:
        return Verdict(False, text("It arrives with {u_max:g} V; it can with less.", u_max=d["u_max"]))
    plain = text("{u_max:g} V: the load alone takes {least:.3g} V.", u_max=d["u_max"], least=least)
    kept = text("The error never noticed the limit: the meter reads {meter:.0e}.", meter=m["separation_meter"])
    return Verdict(True, joined(plain, claim(kept, m["separation_meter"], below=SOLID)))


def _around(q: float, slope: float = 1 / 3) -> tuple[complex, ...]:
    return complex(-q, -slope * q), complex(-q, slope * q), complex(-q)


TASKS = (
    typed_task("cancel", CANCEL),
    typed_task("injection", INJECTION),
    typed_task("seen", DETERMINANT_FORMULA),
    Task("droop", _droops, {"load_state": False, "controller_poles": (-11 - 11j, -11 + 11j), "plain_poles": (-55 - 20j, -55 + 20j)}),
    Task("counts", _counts, {"encoder": JOINT, "observer_poles": _around(20.0)}),
    Task("play", _play, {"gap": 2.0, "encoder": JOINT, "observer_poles": _around(13.0)}),
    Task("supply", _supply, {"load": HEAVY, "u_max": 2.0}),
)
