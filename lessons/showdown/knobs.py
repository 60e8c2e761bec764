"""Define the knobs of lesson 13: controller shown, noise, test, hardware effects."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Number, Switch
from observer_lab.text import Text, text

from ..toolkit.knobs import run_knobs
from .controllers import CONTROLLER_NAMES, DT, LQE, ORDER, OWN_PAIR, PUBLISHED_PAIR
from .simulation import RUN_SAMPLES

REAL = text("Real life")
OF_RUN, IN_BAND, WHOLE, REDUCED, LATE = "run", "band", "whole", "reduction", "late"  # what bars on the stage show
MOST_DELAY_MS = 10.0


def _error(name: str, symbol: str, label: Text, unit: str, high: float, hint: Text) -> Number:
    return Number(name, symbol, label, unit, low=-high, high=high, default=0.0, hint=hint, group=REAL)


KNOBS = (
    Choice("play", "", text("controller on the stage"), default=LQE,
           options=tuple(zip(ORDER, CONTROLLER_NAMES, strict=True)),
           hint=text("The solid deck is under this controller, the ghost under none; the same ground moves both.")),
    Number("v", "V", text("assumed noise V"), "(m/s)² s", low=1e-18, high=1e-7,
           default=1e-10, scale="log", hint=text("The intensity V in the design of all three LQGs.")),
    Number("sensor", "V_0", text("true noise V₀"), "(m/s)² s", low=1e-18, high=1e-7, default=1e-10,
           scale="log", hint=text("The true sensor noise. No controller has this value.")),
    Choice("pair", "", text("SISO loops"), default=OWN_PAIR,
           options=((OWN_PAIR, text("ours, made for 1 kHz")), (PUBLISHED_PAIR, text("the "
                                                                                                         "report's"))),
           hint=text("C_v and C_h; the pitch loop stays open in both.")),
    Choice("ground", "", text("ground motion"), default="white",
           options=(("white", text("white, σ_w² = 10⁻¹² m² s")),
                    ("shaped", text("falling as 1/f²"))),
           hint=text("White displacement as in the report's design, or a density like that of real ground.")),
    Choice("test", "", text("test"), default="touch",
           options=(("touch", text("a touch of the deck")), ("step", text("a step of the ground"))),
           hint=text("A touch changes the velocities at once; the step moves the ground 20 µm up and aside.")),
    Switch("limited", "", text("coils have a limit"), default=False, group=REAL,
           hint=text("Clip what each coil can give.")),
    Number("limit", r"u_{\max}", text("coil limit"), "N", low=1e-3, high=1.0, default=0.05, scale="log",
           when=("limited", (True,)), group=REAL, hint=text("Most that a coil gives, either way.")),
    Choice("driver", "", text("coil drivers"), default="ideal", group=REAL,
           options=(("ideal", text("ideal")), ("first", text("first-order lag")),
                    ("second", text("second-order lag"))),
           hint=text("How the force follows the command.")),
    Number("bandwidth", "f_b", text("driver bandwidth"), "Hz", low=1.0, high=1000.0, default=100.0, scale="log",
           when=("driver", ("first", "second")), group=REAL, hint=text("The driver is 3 dB down there.")),
    Number("delay", r"\tau", text("computing delay"), "ms", low=0.0, high=MOST_DELAY_MS, default=0.0, step=0.1, group=REAL,
           hint=text("From reading the sensors to giving the command; fractions of a sample count.")),
    Number("adc", "q", text("converter step"), "µm/s", low=0.0, high=1000.0, default=0.0, step=5.0, group=REAL,
           hint=text("Readings are rounded to whole steps; the spectra count it as noise of q²/12.")),
    Number("drift", r"\sigma_b", text("bias drift"), "µm/s/√s", low=0.0, high=20.0, default=0.0, step=0.1, group=REAL,
           hint=text("The zero of every sensor walks at random; this far in one second.")),
    Number("friction", "F_c", text("friction of each guide"), "mN", low=0.0, high=20.0, default=0.0, step=0.1,
           when=("ground", ("shaped",)), group=REAL,
           hint=text("Where each spring meets the ground: this force against sliding, and up to it to stick. The tabs Stage "
                     "and Ranking include it; spectra, test and trials do not.")),
    _error("stiffness", r"\varepsilon_k", text("stiffness error"), "%", 30.0,
           text("The true springs are stiffer by this much than those of the design model.")),
    _error("damping", r"\varepsilon_c", text("damping error"), "%", 90.0,
           text("The true dashpots differ by this much.")),
    _error("placement", r"\varepsilon_s", text("sensor placement error"), "mm", 60.0,
           text("The sensors stand this much farther from the middle.")),
    Choice("bars", "", text("bars on the stage"), default=OF_RUN,
           options=((OF_RUN, text("velocity in this run")), (IN_BAND, text("velocity, 0.5–3 Hz")),
                    (WHOLE, text("velocity, all frequencies")), (REDUCED, text("reduction of the rotation")),
                    (LATE, text("velocity in this run, and the delay"))),
           hint=text("The measure that bars before the two decks show. Velocities and reductions are predicted by spectra.")),
    *run_knobs(RUN_SAMPLES * DT - DT),
)
