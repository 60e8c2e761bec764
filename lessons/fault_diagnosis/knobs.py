"""Define the knobs of lesson 17: fault, diagnosis, loop."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Knob, Number
from observer_lab.text import text

from ..toolkit.knobs import run_knobs
from .body import BANK_SHOWN, DECK_ALONE
from .diagnosis import ENERGY, MEAN
from .observer_bank import FAULT_PLACES, HORIZON, PLACE_NAMES
from .runs import BIAS_FAULT, DRIFT_FAULT, KEEP_LOOP_OPEN, NO_REACTION, NONE, STUCK_FAULT, SWITCH_LOOP

FAULT, TEST, LOOP = text("Fault"), text("Diagnosis"), text("Loop")
SENSOR_PLACES, COIL_PLACES = FAULT_PLACES[:4], FAULT_PLACES[4:]
KNOBS: tuple[Knob, ...] = (
    Choice("place", "", text("what fails"), default="HL", group=FAULT,
           options=((NONE, text("nothing")), *((p, PLACE_NAMES[i]) for i, p in enumerate(FAULT_PLACES))),
           hint=text("The bank does not have this value.")),
    Choice("kind", "", text("kind of error"), default=BIAS_FAULT, when=("place", SENSOR_PLACES), group=FAULT,
           options=((BIAS_FAULT, text("bias")), (DRIFT_FAULT, text("drift")), (STUCK_FAULT, text("stuck"))),
           hint=text("A constant added, a growing error, or a reading frozen at its last value.")),
    Number("bias", "b", text("bias"), "mm/s", low=0.5, high=20.0, default=3.0, scale="log",
           when=("kind", (BIAS_FAULT,)), group=FAULT, hint=text("The noise of a reading is 1 mm/s.")),
    Number("drift", "c", text("drift"), "mm/s²", low=0.5, high=10.0, default=4.0, scale="log",
           when=("kind", (DRIFT_FAULT,)), group=FAULT, hint=text("How fast the error grows.")),
    Number("loss", r"\eta", text("force lost"), "%", low=5.0, high=100.0, default=60.0, step=1.0,
           when=("place", COIL_PLACES), group=FAULT,
           hint=text("How much of what is asked the coil does not deliver.")),
    Number("at", "t_f", text("fails at"), "s", low=1.0, high=10.0, default=4.0, step=0.1,
           when=("place", FAULT_PLACES), group=FAULT, hint=text("When the fault sets in.")),
    Choice("place2", "", text("what else fails"), default=NONE, when=("place", FAULT_PLACES), group=FAULT,
           options=((NONE, text("nothing")), *((p, PLACE_NAMES[i]) for i, p in enumerate(FAULT_PLACES))),
           hint=text("A second part; the same one again changes nothing.")),
    Number("bias2", "b_2", text("its bias"), "mm/s", low=-20.0, high=20.0, default=6.0, step=0.5, when=("place2", SENSOR_PLACES),
           group=FAULT, hint=text("The second sensor's error: it reads this much too high, or too low below zero.")),
    Number("loss2", r"\eta_2", text("its force lost"), "%", low=5.0, high=100.0, default=100.0, step=1.0, when=("place2", COIL_PLACES),
           group=FAULT, hint=text("How much of what is asked the second coil does not deliver.")),
    Number("at2", "t_2", text("it fails at"), "s", low=1.0, high=10.0, default=7.0, step=0.1, when=("place2", FAULT_PLACES), group=FAULT,
           hint=text("A time of its own, also before the other.")),
    Choice("statistic", "T", text("statistic"), default=ENERGY, group=TEST,
           options=((ENERGY, text("sum of squares")), (MEAN, text("square of the mean"))),
           hint=text("Squares detect errors of every shape; the mean detects lasting errors sooner and sines hardly at all.")),
    Number("window", "N", text("window"), low=1, high=150, default=25, scale="integer", group=TEST,
           hint=text("Samples of 0.02 s that are judged together.")),
    Number("rate", r"\alpha", text("false-alarm rate"), low=1e-6, high=0.1, default=1e-3, scale="log", group=TEST,
           hint=text("The false-alarm probability of one window of one fault-free member; it sets the threshold.")),
    Choice("shown", "", text("before the deck"), default=BANK_SHOWN, group=TEST, hidden=True,
           options=((BANK_SHOWN, text("a bar for each observer")), (DECK_ALONE, text("nothing"))),
           hint=text("A bar is the test value of an observer at this time of the run. Above the line there is an alarm.")),
    Choice("loop", "", text("the loop"), default=NO_REACTION, group=LOOP,
           options=((KEEP_LOOP_OPEN, text("open")), (NO_REACTION, text("closed, nobody acts")),
                    (SWITCH_LOOP, text("closed, acts on the verdict"))),
           hint=text("Acting: leave the diagnosed sensor out, or stop using the diagnosed coil.")),
    Number("force", "F", text("known force"), "N", low=0.0, high=4.0, default=1.0, step=0.1, group=LOOP,
           hint=text("A sine on all three coils; it is known to the bank.")),
    Number("tone", "f", text("its frequency"), "Hz", low=0.2, high=5.0, default=0.5, scale="log", group=LOOP,
           hint=text("The deck's own modes lie at 1.0, 1.2 and 1.5 Hz.")),
    Number("stiffer", r"\delta", text("springs stiffer than the model"), "%", low=-20.0, high=20.0, default=0.0, step=0.5,
           group=LOOP, hint=text("The model of the bank stays as it is.")),
    *run_knobs(HORIZON),
)
