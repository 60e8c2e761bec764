"""Define the tasks of lesson 5, checked on the outcome."""

from __future__ import annotations

from observer_lab.course.exercises.typed_answers import Typed
from observer_lab.course.lesson import Outcome, Task, Verdict, typed_task
from observer_lab.text import format_number, text

from ..toolkit.knobs import BY_POLES, BY_WEIGHTS
from .dual_quantities import Twins, gap
from .study import BLOCK_SETTING

SAME_GAIN_RTOL = 0.01  # of L: two gains nearer than this are one
SLOWEST_CONTROLLER_POLE, SLOWEST_OBSERVER_POLE, POLE_TOLERANCE, MAX_GAIN_ENTRY = (
    -0.5,
    -1.5,
    0.02,
    3.0,
)  # slowest poles asked for, how nearly, and the largest entry of L
MEETING_DISTANCE = 0.3  # of two poles that count as met


def _published(outcome: Outcome[Twins]) -> Verdict:
    L, sensor = (outcome.metrics["L1"], outcome.metrics["L2"]), outcome.design["sensor"]
    shown = f"({L[0]:.3f}, {L[1]:.3f})".replace("-", "−")
    if sensor != 0:
        return Verdict(False, text("The sensor is turned by {sensor:g}°; measure the position (0°).", sensor=sensor))
    if max(abs(L[0] - 1.5), abs(L[1] + 0.75)) <= 0.05:
        return Verdict(True, text("L = {shown}, and the feedback of (Aᵀ, Cᵀ) holds the same two numbers.",
                                  shown=shown))
    return Verdict(False, text("L = {shown}; it should be (1.5, −0.75) within 0.05.", shown=shown))


def _ratio(outcome: Outcome[Twins]) -> Verdict:
    d = outcome.design
    if d["method"] != BY_WEIGHTS or d["mirror"]:
        return Verdict(False, text("Choose gains by weights and switch the mirror off."))
    scale = d["w"] / d["q"]
    L, mirrored = outcome.gains["L"], Twins(BLOCK_SETTING, d.with_values(mirror=True), BLOCK_SETTING.plant(d)).L_engine
    if max(scale, 1 / scale) < 10:
        return Verdict(False, text("α_W is {scale:.3g} times α_Q; make it at least ten times larger or smaller.",
                                   scale=scale))
    if gap(L, mirrored) > SAME_GAIN_RTOL:
        now, wanted = (f"({format_number(M[0, 0], '.3g')}, {format_number(M[1, 0], '.3g')})" for M in (L, mirrored))
        return Verdict(False, text("L is {now}; mirrored weights give {wanted}.", now=now, wanted=wanted))
    return Verdict(True, text("P is {scale:.3g} times as large, yet L is what mirrored weights give.", scale=scale))


def _mirror_image(outcome: Outcome[Twins]) -> Verdict:
    m = outcome.metrics["mirror_gap"]
    if m <= 0.02:
        return Verdict(True, text("The ellipses are mirror images to {m:.1g} %: the sensor sits where the force "
                                  "acts.",
                                  m=100 * m))
    return Verdict(False, text("Mirrored at the q axis, the ellipses still differ by {m:.0f} %; bring it to 2 %.",
                               m=100 * m))


def _threefold(outcome: Outcome[Twins]) -> Verdict:
    m = outcome.metrics
    controller, observer = m["slowest_controller"], m["slowest_observer"]
    largest = max(abs(m["L1"]), abs(m["L2"]))
    if outcome.design["method"] != BY_WEIGHTS:
        return Verdict(False, text("Let weights choose the gains, not poles."))
    if abs(controller - SLOWEST_CONTROLLER_POLE) > POLE_TOLERANCE * abs(SLOWEST_CONTROLLER_POLE) or abs(
        observer - SLOWEST_OBSERVER_POLE
    ) > POLE_TOLERANCE * abs(SLOWEST_OBSERVER_POLE):
        return Verdict(
            False,
            text(
                "The slowest poles are at {controller:.3g} and {observer:.3g}; wanted are {slow:g} and {quick:g}, within 2 %.",
                controller=controller,
                observer=observer,
                slow=SLOWEST_CONTROLLER_POLE,
                quick=SLOWEST_OBSERVER_POLE,
            ),
        )
    if largest > MAX_GAIN_ENTRY:
        return Verdict(False, text("The poles are right, but the largest entry of L is {largest:.3g}; at most {most:g}. Another ratio of "
                                   "the weights has the same slowest pole.", largest=largest, most=MAX_GAIN_ENTRY))
    return Verdict(True, text("Slowest poles at {controller:.3g} and {observer:.3g}, with no entry of L above {largest:.3g}.",
                              controller=controller, observer=observer, largest=largest))


def _meet(outcome: Outcome[Twins]) -> Verdict:
    poles = outcome.poles["controller"]
    if outcome.design["method"] != BY_WEIGHTS:
        return Verdict(False, text("Let weights choose the gains, not poles."))
    apart = float(abs(poles[0] - poles[1]))
    if apart > MEETING_DISTANCE:
        return Verdict(False, text("The LQR poles are {apart:.3g} apart; at most {most:g}.", apart=apart, most=MEETING_DISTANCE))
    return Verdict(True, text("The LQR poles are {apart:.2g} apart, near {place:.3g}.", apart=apart, place=float(poles.real.mean())))


READ_OFF = Typed("sqrt(2)*(W/V)^(1/4)", ("W", "V"), slips=(
    ("sqrt(W/V)", text("That is l₂: transposing a double integrator changes the order of its states.")),
    ("sqrt(2)*(V/W)^(1/4)", text("W takes the place of q, V that of r."))))

LISTEN = Typed("12*V/T^3", ("V", "T"), slips=(
    ("3*V/T^3", text("That holds if the position at the start is known: one over an entry of W is not an entry of W⁻¹.")),
    ("4*V/T", text("That is the variance of the position at the start."))))

TASKS = (
    Task("published", _published, {"method": BY_POLES, "poles": (-1 + 0j, -1 + 0j), "sensor": 0.0}),
    Task("ratio", _ratio, {"method": BY_WEIGHTS, "mirror": False, "w": 40.0, "v": 10.0}),
    Task("mirror", _mirror_image, {"sensor": 90.0}, easy="the sensor belongs where the force acts, which is its stop"),
    Task("meet", _meet, {"method": BY_WEIGHTS, "q": 7.62, "r": 1.0}),
    Task("threefold", _threefold, {"method": BY_WEIGHTS, "mirror": False, "q": 0.39, "w": 5.25}),
    typed_task("read-off", READ_OFF),
    typed_task("listen", LISTEN),
)
