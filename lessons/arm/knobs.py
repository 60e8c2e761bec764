"""The knobs of lesson 20, on a geared arm."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number, Poles, Switch
from app.plants.arm import MODEL, PARAMETERS, SHEET
from app.text import text

from ..toolkit.knobs import run_knobs

EXACT, MOTOR, JOINT = "exact", "motor", "joint"
SEEN, WINDOW = (True,), MODEL.observer_window
KNOBS = (
    Switch("load_state", "", text("a state for the load"), default=True,
           hint=text("τ̇ = 0 as a fourth equation of the observer, or an observer that knows of no load.")),
    Switch("cancel", "", text("cancel the load"), default=True, when=("load_state", SEEN),
           hint=text("The controller adds the voltage that holds τ̂ at rest.")),
    Number("load", r"\tau", text("load torque"), "N m", low=-3.0, high=3.0, default=1.5, step=0.1,
           hint=text("What presses on the arm from 1 s on; held level, a payload's weight is such a load. Nothing measures it.")),
    Number("target", r"\theta_r", text("target angle"), "°", low=10.0, high=120.0, default=60.0, step=5.0,
           hint=text("Where the arm is to go from level, at once at t = 0.")),
    Number("u_max", r"u_{\max}", text("supply voltage"), "V", low=0.5, high=SHEET.voltage, default=SHEET.voltage, step=0.5,
           hint=text("The drive gives at most this much, either way; the observer is told what it gives.")),
    Choice("encoder", "", text("encoder"), default=EXACT,
           options=((EXACT, text("exact, on the motor")), (MOTOR, text("counting, on the motor")), (JOINT, text("counting, at the joint"))),
           hint=text("On the motor a turn of the joint has 91/6 times as many counts; at the joint the encoder sees the arm itself.")),
    Number("counts", "n_c", text("counts of a turn"), "", low=64.0, high=16384.0, default=4.0 * PARAMETERS.lines, scale="log",
           when=("encoder", (MOTOR, JOINT)), hint=text("Whole counts alone are read, every 2 ms; the sheet's encoder has 2000.")),
    Number("gap", r"\delta", text("gear play"), "°", low=0.0, high=3.0, default=0.0, step=0.05,
           hint=text("How far the arm can be moved with the motor held. The observer knows nothing of it.")),
    Poles("controller_poles", "p", text("Controller poles"), "rad/s", default=MODEL.controller_poles,
          re_low=MODEL.controller_window.re_low, re_high=MODEL.controller_window.re_high, im_high=MODEL.controller_window.im_high,
          role="plant", hint=text("Two poles for angle and speed; that of the winding stays where the motor put it.")),
    Poles("observer_poles", "q", text("Observer poles"), "rad/s", default=MODEL.observer_poles, re_low=WINDOW.re_low,
          re_high=WINDOW.re_high, im_high=WINDOW.im_high, role="estimate", when=("load_state", SEEN),
          hint=text("Three poles for angle, speed and load; farther left finds the load sooner.")),
    Poles("plain_poles", "q", text("Observer poles"), "rad/s", default=MODEL.observer_poles[:2], re_low=WINDOW.re_low,
          re_high=WINDOW.re_high, im_high=WINDOW.im_high, role="estimate", when=("load_state", (False,)),
          hint=text("Two poles for angle and speed; the load is no part of this observer.")),
    *run_knobs(MODEL.horizon)[1:],
)
