"""Define the tasks of lesson 7."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import Text, text

from ..toolkit.knobs import untouched
from .knobs import APPLIED, COMMANDED, KNOBS
from .study import ERROR_LAW_RTOL, Study, amount, ends, slowest

CONTROLLER = next(knob for knob in KNOBS if knob.name == "controller_poles")
FAST_POLES = (-16 + 0j, -15 + 0j, -14 + 0j, -13 + 0j)

ASKED = MappingProxyType({"angle0": 4.0, "error0": 8.0, "kick": -1.0, "controller_poles": CONTROLLER.check(CONTROLLER.default)})

FORCE, TRACK = (3.6, 3.9), 0.36  # N that may be asked for at most, m that the cart may move
HARDLY, LEAN, BELIEVED = 2.0, 8.0, 4.0  # N; degrees of the angle and of its error


def _open(outcome: Outcome[Study]) -> Text | None:
    return None if outcome.study.end.decided else ends(outcome.study)


def _false_sentence(outcome: Outcome[Study]) -> Verdict:
    meter, clipped = outcome.metrics["separation_meter"], outcome.metrics["clipped_for"]
    if abs(clipped - 0.5) > 0.051:
        return Verdict(False, text("The force is clipped for {clipped:.2f} s; the counterexample asked for has 0.5 s within 10 %.",
                                   clipped=clipped))
    if not outcome.metrics["comes_home"]:
        return Verdict(False, _open(outcome) or text(
            "The pole does not recover; the force was clipped for {clipped_for:.2f} s.", clipped_for=clipped))
    if meter >= ERROR_LAW_RTOL:
        return Verdict(False, text("Clipped for {clipped:.2f} s, but the meter reads {meter}; it must be below 10⁻⁹.",
                                   clipped=clipped, meter=amount(meter)))
    return Verdict(True, text("Clipped for {clipped:.2f} s and the meter reads {meter:.0e}: the sentence is false "
                              "as it stands.",
                              clipped=clipped, meter=meter))


def _lost_by_belief(outcome: Outcome[Study]) -> Verdict:
    """Lost through the first belief alone: both experts' poles on the left, the error's law intact."""
    m = outcome.metrics
    if max(slowest(outcome, "controller"), slowest(outcome, "observer")) >= 0:
        return Verdict(False, text("A pole is not in the left half plane: this start is lost by the poles, not by the estimate."))
    if m["separation_meter"] >= ERROR_LAW_RTOL:
        return Verdict(False, text("The error does not obey A − LC: the meter reads {separation_meter}.",
                                   separation_meter=amount(m["separation_meter"])))
    if not (outcome.study.end.decided and outcome.study.known_end.decided):
        return Verdict(False, ends(outcome.study))
    if not m["known_comes_home"]:
        return Verdict(False, text("This start is lost even with x known; let the pole lean less."))
    if m["comes_home"]:
        return Verdict(False, text("This start recovers; make the first estimate worse."))
    return Verdict(True, text("The meter reads {separation_meter:.0e}, with x known the pole recovers, with the "
                              "estimate it does not.",
                              separation_meter=m["separation_meter"]))


def _better_observer(outcome: Outcome[Study]) -> Verdict:
    d, m = outcome.design, outcome.metrics
    if any(d[name] != asked for name, asked in ASKED.items()) or not untouched(d) or d["u_max"] > 4.0:
        return Verdict(False, text("Angle 4°, error 8°, at most 4 N, no kick or pull, the lesson's controller: you have "
                                   "{angle0:g}°, {error0:g}°, {u_max:g} N.",
                                   angle0=d["angle0"], error0=d["error0"], u_max=d["u_max"]))
    if not m["comes_home"] and np.isinf(m["stopped_at"]):
        return Verdict(False, ends(outcome.study))
    if not m["comes_home"]:
        worst = slowest(outcome, "observer")
        return Verdict(False, text("The pole is lost after {stopped_at:.2f} s; the observer's slowest pole is at "
                                   "{worst:.3g}.",
                                   stopped_at=m["stopped_at"], worst=worst))
    return Verdict(True, text("It recovers with {u_max:g} N; only the observer has changed.", u_max=d["u_max"]))


def _never_clipped(outcome: Outcome[Study]) -> Verdict:
    """The lesson's start under the commanded force, with poles that use what the motor has and never ask for more."""
    d, m, run = outcome.design, outcome.metrics, outcome.run
    if d["fed"] != COMMANDED or d["angle0"] != 6.0 or d["error0"] != 4.0 or not untouched(d) or d["u_max"] != 4.0:
        return Verdict(False, text("Leave the commanded force, 6°, 4° and 4 N as the lesson has them, without a kick or pull."))
    if not m["comes_home"] or run is None:
        return Verdict(False, _open(outcome) or text("The pole does not recover; the force was clipped for {clipped_for:.2f} s.",
                                   clipped_for=m["clipped_for"]))
    asked, path = m["largest_asked"], float(np.max(np.abs(run.x[:, 0])))
    if not FORCE[0] <= asked <= FORCE[1]:
        return Verdict(False, text("It recovers and asks for {asked:.3g} N at most; it should be {low:g} to {high:g} N.", asked=asked,
                                   low=FORCE[0], high=FORCE[1]))
    if path > TRACK:
        return Verdict(False, text("It asks for {asked:.3g} N, but the cart moves by {path:.3g} m; at most {most:g} m.", asked=asked,
                                   path=path, most=TRACK))
    return Verdict(True, text("It asks for {asked:.3g} N and the cart moves by {path:.3g} m. Nothing is clipped, so the meter reads 0.",
                              asked=asked, path=path))


def _near_the_ceiling(outcome: Outcome[Study]) -> Verdict:
    """A start close to the ceiling of a weak motor, brought home by poles that spend no force on the cart."""
    d, m = outcome.design, outcome.metrics
    if d["angle0"] != LEAN or d["error0"] != BELIEVED or not untouched(d):
        return Verdict(False, text("Start at 8° with an error of 4°, without a kick or pull."))
    if d["u_max"] > HARDLY:
        return Verdict(False, text("{u_max:g} N is more than the task allows; at most {most:g} N.", u_max=d["u_max"], most=HARDLY))
    if not m["comes_home"]:
        return Verdict(False, _open(outcome) or text(
            "The pole does not recover with {u_max:g} N, whose ceiling is {ceiling:.3g}°.", u_max=d["u_max"],
                                   ceiling=m["ceiling"]))
    return Verdict(True, text("It recovers with {u_max:g} N, whose ceiling is {ceiling:.3g}°; clipped for {clipped_for:.2f} s.",
                              u_max=d["u_max"], ceiling=m["ceiling"], clipped_for=m["clipped_for"]))


LAST_START = Typed("b*U/k^2 - w/k", ("b", "U", "k", "w"), slips=(
    ("b*U/k^2", text("That holds from rest; a start that already moves is further out: z = θ + θ̇/k.")),
    ("b*U/k^2 + w/k", text("It moves away from the top: the speed takes room, it gives none."))))

TASKS = (
    Task("false-sentence", _false_sentence, {"fed": APPLIED, "u_max": 3.7}),
    Task("lost-by-belief", _lost_by_belief, {"fed": APPLIED, "angle0": 8.0, "error0": 12.0}),
    Task("better-observer", _better_observer,
         {"fed": APPLIED, "angle0": 4.0, "error0": 8.0, "u_max": 4.0, "observer_poles": FAST_POLES}),
    Task("never-clipped", _never_clipped, {"controller_poles": (-4.5, -4.4, -0.8 - 0.8j, -0.8 + 0.8j)}),
    typed_task("last-start", LAST_START),
    Task("near-the-ceiling", _near_the_ceiling, {
        "fed": APPLIED, "angle0": LEAN, "error0": BELIEVED, "u_max": 2.0,
        "controller_poles": (-3 - 1j, -3 + 1j, -1 - 0.5j, -1 + 0.5j)}),
)
