"""Define the tasks of lesson 12."""

from __future__ import annotations

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import text

from .balanced_platform import MASSES_AGAINST_MODE, STATE_COUNT
from .body import NOMINAL, share
from .figures import show
from .platform_study import PlatformStudy
from .study import RELATIVE, cut

MAX_MODEL_ERROR = 0.2  # error that the second task allows
MIN_RELATIVE_TOLERANCE = 1e-6  # least relative tolerance of the third
CENTRE_TOLERANCE_M = 0.10  # m that a sensor may stand off the centre in the fourth task
WEAKEST = 10 * 8.852673e-05  # ten times the σ9 of the start


def _face(outcome: Outcome[PlatformStudy]) -> Verdict:
    s, order, pair = outcome.study.system, outcome.study.cut.order, int(outcome.design["pair"]) - 1
    motion = s.motions[pair]
    held = [share(s, m, order) > 0.5 for m in s.motions]
    if motion.kind != MASSES_AGAINST_MODE:
        return Verdict(False, text("On the stage: {name}. The report cuts away another motion.", name=motion.name))
    if held != [k != pair for k in range(len(held))]:
        return Verdict(False, text("A model of {order} states holds {held} of the five motions; it should lack "
                                   "this one alone.",
                                   order=order, held=sum(held)))
    return Verdict(True, text("σ = {hankel}: the masses swing at {frequency:.3g} Hz and the ghost's stand still.",
                              hankel=show(s.hankel[2 * pair]), frequency=motion.frequency))


def _wider(outcome: Outcome[PlatformStudy]) -> Verdict:
    s, c, compared = outcome.study.system, outcome.study.cut, outcome.study.compared
    if c.peak > MAX_MODEL_ERROR:
        return Verdict(False, text("{order} states err by {peak}; at most {small} is allowed.",
                                   order=c.order, peak=show(c.peak), small=MAX_MODEL_ERROR))
    if c.order > 1 and cut(s, c.order - 1).peak <= MAX_MODEL_ERROR:
        size = show(c.peak) if c.order < STATE_COUNT else "0"
        return Verdict(False, text("{order} states err by {size}: good enough, but fewer states will do as well.",
                                   order=c.order, size=size))
    if compared.extra is None or compared.extra > 1e-3:
        return Verdict(False, text("The model will do, but the LQG designed on it costs more than 0.1 % extra on "
                                   "ten states."))
    return Verdict(True, text("{order} states err by {peak}, and the LQG on them costs {extra} % more.",
                              order=c.order, peak=show(c.peak), extra=show(100 * compared.extra, 2)))


def _clock(outcome: Outcome[PlatformStudy]) -> Verdict:
    d, r = outcome.design, outcome.study.ranks
    now = r.at(d["tolerance"], d["measure"])
    said = text("ranks {now} and {now2} with time in units of {clock} s",
                now=now[0], now2=now[1], clock=show(r.clock))
    if d["measure"] != RELATIVE or d["tolerance"] < MIN_RELATIVE_TOLERANCE * (1 - 1e-9):
        return Verdict(False, text("Measure the singular values against the largest, with a tolerance of at least 10⁻⁶."))
    if now != (STATE_COUNT, STATE_COUNT):
        return Verdict(False, text("At τ = {tolerance}: {said}.", tolerance=show(d["tolerance"]), said=said))
    return Verdict(True, text("At τ = {tolerance}: {said}. The plant is the same.",
                              tolerance=show(d["tolerance"]), said=said))


def _geometry(outcome: Outcome[PlatformStudy]) -> Verdict:
    s = outcome.study.system
    weakest = s.hankel[-2]
    if s.parameters.mu > NOMINAL.mu * (1 + 1e-9):
        return Verdict(False, text("Leave the test masses at 50 g or less."))
    if s.unit != 1 or s.parameters.s > CENTRE_TOLERANCE_M * (1 + 1e-9):
        return Verdict(
            False,
            text("Count the ground in metres and leave the sensors within {near:.0f} cm of the centre.", near=100 * CENTRE_TOLERANCE_M),
        )
    times = 10 * weakest / WEAKEST
    if abs(times - 10) > 0.5:
        return Verdict(False, text("σ₉ = {weakest}, {times:.3g} times the old one; 10 times within 5 % are wanted.",
                                   weakest=show(weakest), times=times))
    return Verdict(True, text("σ₉ = {weakest}, {times:.3g} times the old one, by geometry alone.", weakest=show(weakest), times=times))


ONE_LAG = Typed("b*c/(2*a)", ("a", "b", "c"), slips=(
    ("b*c/a", text("That is the gain at rest: twice the Hankel value, the error of dropping the state.")),
    ("b^2*c^2/(4*a^2)", text("That is the product of the two Gramians; take its root."))))
ALMOST_TWINS = Typed("(a-b)^2/(4*a*b*(a+b)^2)", ("a", "b"), slips=(
    ("1/(4*a*b)", text("That is without what stands off the diagonal: the lags share their input.")),
    ("((a-b)^2/(4*a*b*(a+b)^2))^2", text("That is the square of the product; take its root."))))

def _overstated(outcome: Outcome[PlatformStudy]) -> float:
    return outcome.metrics["bound"] / outcome.metrics["error"]


def _fall(outcome: Outcome[PlatformStudy]) -> float:
    values, order = outcome.study.system.hankel, outcome.study.cut.order
    return float(values[order - 1] / values[order])


TASKS = (
    Task("face", _face, {"pair": "5", "order": 8}, Typed(_overstated)),
    Task("wider", _wider, {"order": 6}, Typed(_fall)),
    Task("clock", _clock, {"clock": 5e-3, "tolerance": 1e-6}),
    Task("geometry", _geometry, {"s": 0.1, "h": 0.052}),
    typed_task("one-lag", ONE_LAG),
    typed_task("almost-twins", ALMOST_TWINS),
)
