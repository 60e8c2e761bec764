"""Define the tasks of lesson 1."""

from __future__ import annotations

import numpy as np

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.engine import error_parts
from observer_lab.text import text

from .knobs import DT, RUNAWAY_ID, STABLE_ID
from .study import Study, believed

LISTENING, TREMBLE = (-1.45, -1.35), 0.2  # 1/s, where the slowest pole is to stand; K
DECAYS_BY = -2.0  # 1/s: with a slower pole the error of the core only swings through the band
PASSED_ON = 0.3  # K, the most that noise may move the estimate of the reduced-order observer


def feel_the_core(outcome: Outcome[Study]) -> Verdict:
    """The core within 1 K after 2.2 s, from the given start, with the right model and a quiet sensor."""
    d, after = outcome.design, outcome.metrics["known_after"]
    if d["guess_core"] or d["guess_case"] or d["air_error"] or d["noise"] or d["plant"] != STABLE_ID:
        return Verdict(False, text("Keep both guesses at 0 K, the model right, no sensor noise and the chip that cools."))
    slowest = float(np.max(outcome.poles["observer"].real))
    if 2.1 <= after <= 2.2 and slowest > DECAYS_BY:
        return Verdict(False, text("Known within 1 K after {after:.2f} s, but by a swing: the slowest pole is at {slowest:.3g}. Bring it "
                                   "left of {least:g}.", after=after, slowest=slowest, least=DECAYS_BY))
    if 2.1 <= after <= 2.2:
        return Verdict(True, text("The core is known within 1 K after {after:.2f} s, with L up to "
                                  "{largest_gain:.3g} and a first guess that shoots to {largest_guess:.0f} K.",
                                  after=after, largest_gain=outcome.metrics["largest_gain"],
                                  largest_guess=outcome.metrics["largest_guess"]))
    late = text("after {after:.2f} s", after=after) if np.isfinite(after) else text("never")
    return Verdict(False, text("Known within 1 K: {late}; it should be after 2.1 to 2.2 s.", late=late))


def tame_the_runaway(outcome: Outcome[Study]) -> Verdict:
    """The runaway chip, watched with a small gain."""
    m, d = outcome.metrics, outcome.design
    if d["plant"] != RUNAWAY_ID or d["guess_core"] or d["guess_case"]:
        return Verdict(False, text("Take the chip that runs away, with both guesses at 0 K."))
    if m["core_error"] <= 0.5 and m["largest_gain"] <= 1.5:
        return Verdict(True, text("With no entry of L above {largest_gain:.2g} the core error ends at "
                                  "{core_error:.2g} K; the copy's ends at {copy_core_error:.3g} K.",
                                  largest_gain=m["largest_gain"], core_error=m["core_error"],
                                  copy_core_error=m["copy_core_error"]))
    return Verdict(False, text("Largest entry of L: {largest_gain:.3g} (at most 1.5); core error at the end: "
                               "{core_error:.2g} K (at most 0.5 K).",
                               largest_gain=m["largest_gain"], core_error=m["core_error"]))


def lucky_copy(outcome: Outcome[Study]) -> Verdict:
    """The copy of the runaway chip right from start to end."""
    m = outcome.metrics
    if outcome.design["plant"] != RUNAWAY_ID:
        return Verdict(False, text("Take the chip that runs away."))
    worst = m["largest_copy_error"]
    if worst <= 0.5:
        return Verdict(True, text("The copy is never off by more than {worst:.2g} K. Now press kick.", worst=worst))
    return Verdict(False, text("The copy is off by up to {worst:.3g} K; it should never be off by more than 0.5 K.",
                               worst=worst))


def wrong_fan(outcome: Outcome[Study]) -> Verdict:
    """A right core in spite of a wrong fan: the core's entry of L is 1."""
    d, error = outcome.design, outcome.metrics["core_error"]
    if abs(d["air_error"]) < 30 or d["plant"] != STABLE_ID or d["power"] < 10 or d["noise"]:
        return Verdict(False, text("Make the resistance wrong by 30 % or more, on the chip that cools, at 10 W or more and without "
                                   "sensor noise."))
    first = float(outcome.gains["L"][0, 0])
    if error <= 0.05:
        return Verdict(True, text("The core error is at most {error:.2g} K at the end; the core's entry of L is "
                                  "{first:.3g}.",
                                  error=error, first=first))
    return Verdict(False, text("The core error at the end is {error:.2g} K; bring it to 0.05 K. The core's entry "
                               "of L is {first:.3g}.",
                               error=error, first=first))


def quiet_core(outcome: Outcome[Study]) -> Verdict:
    """A slowest pole in a narrow band, and little of the sensor's noise in the core, over all records."""
    d, slow = outcome.design, outcome.metrics["slowest_observer"]
    if d["plant"] != STABLE_ID or d["air_error"] or d["noise"] != 1.0:
        return Verdict(False, text("Take the chip that cools, the model right and 1 K of sensor noise."))
    if not LISTENING[0] <= slow <= LISTENING[1]:
        return Verdict(False, text("The slowest pole is at {slow:.3g}; it should stand between {low:g} and {high:g}.", slow=slow,
                                   low=LISTENING[0], high=LISTENING[1]))
    plant = believed(d["plant"], 0.0)
    heard = error_parts(plant, outcome.gains["L"], plant.B, np.zeros((plant.m, plant.m)), [[d["noise"] ** 2 * DT]]).sensor
    sigma = float(np.sqrt(heard[0, 0]))
    if sigma > TREMBLE:
        return Verdict(False, text("The slowest pole is at {slow:.3g}, but the noise shakes the core's estimate by σ = {sigma:.3g} K; "
                                   "at most {most:g} K.", slow=slow, sigma=sigma, most=TREMBLE))
    return Verdict(True, text("The slowest pole is at {slow:.3g}, and the noise shakes the core's estimate by σ = {sigma:.3g} K only.",
                              slow=slow, sigma=sigma))


def at_once(outcome: Outcome[Study]) -> Verdict:
    """Little of the sensor's noise in the core's estimate of the reduced-order observer."""
    d = outcome.design
    if not d["reduced"] or d["plant"] != STABLE_ID or d["air_error"] or d["noise"] != 1.0:
        return Verdict(False, text("Take the chip that cools, the model right, 1 K of sensor noise and the reduced-order observer."))
    sigma = outcome.metrics["reduced_sigma"]
    pole = float(np.max(np.real(d["observer_poles"])))
    return Verdict(sigma <= PASSED_ON, text(
        "With the pole at {pole:.3g} the noise moves its estimate of the core by σ = {sigma:.3g} K; at most {most:g} K is allowed.",
        pole=pole, sigma=sigma, most=PASSED_ON))


MATCH = Typed("a + (a-p)*(a-q)/b", ("a", "b", "p", "q"), slips=(
    ("a - (a-p)*(a-q)/b", text("Mind the sign: the determinant holds −b (a − l₁).")),
    ("(a-p)*(a-q)/b", text("You left out that the case warms the core: the entry is a − l₁."))))

TASKS = (
    Task("feel-the-core", feel_the_core, {"observer_poles": (-3.0, -3.5)}),
    Task("tame-the-runaway", tame_the_runaway, {"plant": RUNAWAY_ID, "trust": 0.1}),
    Task("lucky-copy", lucky_copy, {"plant": RUNAWAY_ID, "guess_core": 12.0, "guess_case": 6.0}),
    Task("wrong-fan", wrong_fan, {"air_error": 40.0, "trust": 0.21}),
    Task("quiet-core", quiet_core, {"noise": 1.0, "observer_poles": (-1.4, -1.4)}),
    Task("at-once", at_once, {"noise": 1.0, "reduced": True, "observer_poles": (-1.0, -1.0)}),
    typed_task("match", MATCH),
)
