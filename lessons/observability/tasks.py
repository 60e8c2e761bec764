"""Define the tasks of lesson 3."""

from __future__ import annotations

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import text

from .criteria import DET, GRAMIAN
from .initial_state import SAME_READING
from .study import Study

CLEARLY, MAX_WEAKEST_DISTANCE = 0.05, 0.053  # distance of the weakest mode asked of one sensor
HALF_AXIS_BAND, MIN_NOISE = (0.09, 0.1), 0.03  # half axis of the cloud that two sensors are to leave, and the least noise they have
MIN_DIFFERENCE = 1.5  # of two starts, in typical sizes
BLIND_DISTANCE = 0.002  # distance below which a direction of the notes' sensor counts as blind
MIN_TOLERANCE = 1e-12  # tolerance above which a rank is cut by choice and not by rounding
PAPER_RANK_DISTANCE = 1e-5  # distance at which full rank is only on paper


SENSOR_KNOBS = ("left", "right", "across")


def _one_sensor(outcome: Outcome[Study]) -> Verdict:
    design, d = outcome.design, outcome.metrics["weakest"]
    if design["plant"] != "deck":
        return Verdict(False, text("This task is about the deck; choose it as the plant."))
    count = sum(design[f"{k}_on"] for k in SENSOR_KNOBS)
    if count != 1:
        return Verdict(False, text("Sensors on: {count}; switch on exactly one.", count=count))
    if outcome.metrics["hidden"] > 0:
        return Verdict(False, text("{hidden:.0f} of 6 states leave no trace in this sensor.",
                                   hidden=outcome.metrics["hidden"]))
    if d < CLEARLY:
        return Verdict(False, text("Every mode is seen, but the weakest is only {d:.2g} from hidden; reach "
                                   "{clearly:g}.",
                                   d=d, clearly=CLEARLY))
    if d > MAX_WEAKEST_DISTANCE:
        return Verdict(False, text("The weakest mode is {d:.3g} from hidden, more than is wanted: {clearly:g} to {most:g}.", d=d,
                                   clearly=CLEARLY, most=MAX_WEAKEST_DISTANCE))
    return Verdict(True, text("One sensor sees all three modes; the weakest is {d:.2g} from hidden.", d=d))


def _untold(outcome: Outcome[Study]) -> Verdict:
    """Two starts of the deck that one vertical sensor in the middle cannot tell apart."""
    design, gap = outcome.design, outcome.metrics["reading_gap"]
    on = [k for k in SENSOR_KNOBS if design[f"{k}_on"]]
    if design["plant"] != "deck" or on != ["left"] or design["left"] != 0 or design["apart"] < MIN_DIFFERENCE:
        return Verdict(False, text("Take the deck with the left sensor alone, at 0 m, and a difference of {least:g} or more.",
                                   least=MIN_DIFFERENCE))
    if gap > SAME_READING:
        return Verdict(False, text("The readings differ by up to {gap:.2g} of a typical reading; they should be the same.", gap=gap))
    return Verdict(True, text("The two readings agree at every time, although the starts differ by {apart:g}.", apart=design["apart"]))


def _two_sensors(outcome: Outcome[Study]) -> Verdict:
    """Every direction of the start known to a tenth, and hardly better, by two sensors."""
    design, m = outcome.design, outcome.metrics
    if design["plant"] != "deck":
        return Verdict(False, text("This task is about the deck; choose it as the plant."))
    count = sum(design[f"{k}_on"] for k in SENSOR_KNOBS)
    if count != 2 or design["noise"] < MIN_NOISE:
        return Verdict(False, text("Sensors on: {count}, with the noise {noise:.3g}; use two, and a noise of {least:g} or more.",
                                   count=count, noise=design["noise"], least=MIN_NOISE))
    found = text("Known to a tenth are {known:.0f} of 6 directions, and the ellipsoid's longest half axis is {longest:.4f}",
                 known=m["known"], longest=m["longest"])
    if not HALF_AXIS_BAND[0] <= m["longest"] <= HALF_AXIS_BAND[1]:
        return Verdict(False, text("{found}; wanted are {low:g} to {high:g}.", found=found, low=HALF_AXIS_BAND[0], high=HALF_AXIS_BAND[1]))
    return Verdict(True, text("{found}.", found=found))


def _wrong_sentence(outcome: Outcome[Study]) -> Verdict:
    design, found = outcome.design, outcome.study
    if design["plant"] != "notes":
        return Verdict(False, text("Choose the plant of the notes first."))
    if design["criterion"] == DET:
        return Verdict(False, text("C e^{At} is 1×2 here and has no determinant: this sentence cannot be tested."))
    if design["criterion"] != GRAMIAN:
        return Verdict(False, text("That sentence is right, but it does not speak of C e^{At} over time; one of "
                                   "them does."))
    d = found.weakest.distance
    if d > BLIND_DISTANCE:
        return Verdict(False, text("The sentence is right. Now turn the sensor until it almost fails: the nearest mode is still "
                                   "{d:.2g} from hidden.",
                                   d=d))
    return Verdict(True, text("At {angle:.4g}° a mode is {d:.1g} from hidden and the Gramian's least eigenvalue is {least:.1g}.",
                              angle=design["angle"], d=d, least=outcome.metrics["least_energy"]))


def _on_paper(outcome: Outcome[Study]) -> Verdict:
    m = outcome.metrics
    rank, n, d = int(m["rank"]), int(m["states"]), m["weakest"]
    if rank < n:
        return Verdict(False, text("rank(O) = {rank} of {n}; full rank is needed at this tolerance.",
                                   rank=rank, n=n))
    if m["hidden"] > 0 or not 0.9 * PAPER_RANK_DISTANCE <= d <= 1.1 * PAPER_RANK_DISTANCE:
        return Verdict(False, text("Full rank, and the weakest mode is {d:.2g} from hidden; bring it to {paper:g} within 10 %.",
                                   d=d, paper=PAPER_RANK_DISTANCE))
    return Verdict(True, text("rank(O) = {n}, and a change of {d:.1g} in the plant would hide a mode.", n=n, d=d))


def _low_rank(outcome: Outcome[Study]) -> Verdict:
    m = outcome.metrics
    rank, n, d = int(m["rank"]), int(m["states"]), m["weakest"]
    if m["hidden"] > 0 or d < 0.4:
        return Verdict(False, text("The weakest mode is {d:.2g} from hidden; every mode must be beyond 0.4.",
                                   d=d))
    tolerance = outcome.design["tolerance"]
    if tolerance > MIN_TOLERANCE:
        return Verdict(False, text("A tolerance of {tolerance:.2g} cuts the rank by choice, not by rounding; take {fine:.0g} or less.",
                                   tolerance=tolerance, fine=MIN_TOLERANCE))
    if 2 * rank >= n:
        return Verdict(False, text("rank(O) = {rank} of {n}; it must be less than half of n.", rank=rank, n=n))
    return Verdict(True, text("rank(O) = {rank} of {n}, yet every mode is at least {d:.2g} from hidden: the "
                              "number was rounding.",
                              rank=rank, n=n, d=d))


BLIND_ANGLE = Typed("b + g*(d-a) - c*g^2", ("a", "b", "c", "d", "g"), slips=(
    ("-b - g*(d-a) + c*g^2", text("The size is right; the sign follows the order C, then CA.")),
    ("b + g*d", text("The second row is C A, and its first entry is not zero."))))

TOLL = Typed("(p-a)*(q-a)/(b-a)", ("a", "b", "p", "q"), slips=(
    ("(p-a)*(q-a)/(a-b)", text("Mind the sign: at s = −a the term of l₁ is l₁ (b − a).")),
    ("(p-b)*(q-b)/(a-b)", text("That is l₂: put s = −a, where the term of l₂ vanishes."))))

TASKS = (
    Task("one-sensor", _one_sensor, {"left": -0.115}),
    Task("untold", _untold, {"second": "theta", "apart": 1.5}),
    Task("two-sensors", _two_sensors, {"across_on": True, "left": -0.106}),
    Task("find-the-error", _wrong_sentence, {"plant": "notes", "criterion": GRAMIAN, "angle": 55.5}),
    Task("on-paper", _on_paper, {"plant": "pair", "gap": 1.41e-5}),
    typed_task("toll", TOLL),
    Task("low-rank", _low_rank, {"plant": "many", "count": 20}, Typed(lambda o: o.design["count"] ** (o.design["count"] - 1))),
    typed_task("blind-angle", BLIND_ANGLE),
)
