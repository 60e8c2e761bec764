"""Define the tasks of lesson 6."""

from __future__ import annotations

import numpy as np

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import format_number, text

from ..toolkit.figures import settle_time
from ..toolkit.knobs import untouched
from ..toolkit.tasks import check_gentle_settling
from .knobs import KNOBS, Case

SETTLING_BAND_S, MAX_FORCE_N = (3.8, 4.0), 1.1  # s and N
CENTRE = next(knob.default for knob in KNOBS if knob.name == "centre")


def _number(value: float) -> str:
    return format_number(value, ".3g")


def _slow_but_fine(outcome: Outcome[Case]) -> Verdict:
    case, rate = outcome.study, outcome.metrics["error_rate"]
    if case.seen.observable:
        return Verdict(False, text("This sensor sees every mode; choose one that does not."))
    if rate >= 0:
        return Verdict(False, text("The error still grows like e^({rate} t). No pole you can drag changes that.",
                                   rate=_number(rate)))
    return Verdict(True, text("The sensor still does not measure every mode, and e decays like e^({rate} t): the plant is detectable.",
                              rate=_number(rate)))


def _twin(outcome: Outcome[Case]) -> Verdict:
    error, state = outcome.metrics["error_rate"], outcome.metrics["state_rate"]
    if error >= 0:
        return Verdict(False, text("The estimate itself is lost: e grows like e^({error} t).", error=_number(error)))
    case = outcome.study
    if state < 0 or case.reached.stabilizable:
        return Verdict(False, text("The estimate is right, but the plant can be held: its slowest pole is {state}.",
                                   state=_number(state)))
    return Verdict(True, text("e decays like e^({error} t), yet x grows like e^({state} t): every state is known, but the growing mode "
                              "is not controllable.",
                              error=_number(error), state=_number(state)))


def _silence(outcome: Outcome[Case]) -> Verdict:
    case, left = outcome.study, outcome.metrics["error_end"]
    if case.seen.detectable:
        return Verdict(False, text("Here the unstable motion is not hidden from the sensor; choose the distance "
                                   "sensor and the magnets."))
    if left > 1e-3:
        return Verdict(False, text("At the end e is {left} times its start; bring it below 0.001.",
                                   left=_number(left)))
    return Verdict(True, text("At the end e is {left:.1g} of its start: the hidden motion never started. One "
                              "kick starts it.",
                              left=left))


def _cure(outcome: Outcome[Case]) -> Verdict:
    case, error, state = outcome.study, outcome.metrics["error_rate"], outcome.metrics["state_rate"]
    if not (case.seen.observable and case.reached.controllable):
        return Verdict(False, text("There is still a fixed mode: move the sensor or the force."))
    if error > -2 or state > -1.2:
        return Verdict(False, text("The slowest poles are {error} (observer, −2 or less) and {state} (controller, "
                                   "−1.2 or less).",
                                   error=_number(error), state=_number(state)))
    return Verdict(True, text("Nothing is hidden: observer {error}, controller {state}, as asked.",
                              error=_number(error), state=_number(state)))


def _gentle_cure(outcome: Outcome[Case]) -> Verdict:
    case, run, d = outcome.study, outcome.run, outcome.design
    if run is None or not (case.seen.observable and case.reached.controllable):
        return Verdict(False, text("There is still a fixed mode: move the sensor or the force."))
    if d["centre"] != CENTRE or not untouched(d):
        return Verdict(False, text("Start with the common part of {centre:g} m, without a kick or pull.", centre=CENTRE))
    settled, force = settle_time(run.t, np.abs(run.x[:, :2]).max(axis=1)), float(np.max(np.abs(run.u_asked)))
    if settled is None:
        return Verdict(False, text("The blocks are not at rest by the end of the run."))
    found = text("Both blocks are at rest, below 2 % of their largest excursion, after {settled:.2f} s, with a force of up to "
                 "{force:.3g} N",
                 settled=settled, force=force)
    return check_gentle_settling(found, settled, SETTLING_BAND_S, force, MAX_FORCE_N)


UNLIKE = Typed("k*n/m", ("m", "n", "k"), slips=(
    ("k", text("Equal springs hide a motion only if the masses are equal too.")),
    ("k*m/n", text("The other way round: the heavier block needs the stiffer spring."))))

TASKS = (
    Task("slow-but-fine", _slow_but_fine, {"plant": "unseen-stable"},
         Typed(lambda o: np.log(100) / -o.metrics["hidden_rate"], tolerance=0.01)),
    Task("twin", _twin, {"plant": "unmoved-unstable"},
         Typed(lambda o: np.log(10) / o.metrics["hidden_rate"], tolerance=0.01)),
    Task("silence", _silence, {"plant": "unseen-unstable", "centre": 0.0}),
    Task("cure", _cure, {"plant": "visible", "controller_all": (-1.4 - 1.2j, -1.4 + 1.2j, -1.8 - 3j, -1.8 + 3j)}),
    Task("gentle-cure", _gentle_cure, {
        "plant": "visible", "controller_all": (-0.9 - 1.7j, -0.9 + 1.7j, -1.3 - 3.4j, -1.3 + 3.4j),
        "observer_all": (-2 - 1j, -2 + 1j, -2 - 3j, -2 + 3j)}),
    typed_task("unlike", UNLIKE),
)
