"""Define the knobs of lesson 16: step, problem, input, pole, gain, form."""

from __future__ import annotations

from collections.abc import Sequence

from observer_lab.course.knobs import Choice, Knob, Number, Poles, Track
from observer_lab.plants.bilinear import POLE
from observer_lab.text import Text, same, text, text_in

from ..toolkit.knobs import run_knobs
from .input_signals import FORMS, HORIZON, PLAIN_FORM, number_of
from .paper_example import OPTIONS
from .problems import AS_PRINTED, COMPUTED_GAIN, PAPER_PROBLEM, PROBLEMS, ROUNDED_GAIN, TYPED_GAIN
from .study import FORM_NAMES, OBSERVER_WINDOW

MOST_INPUT = 4.0
MOVING = ("sine", "square", "sweep")
SHAPED = ("step", *MOVING, "random")
SIGNALS = (("none", text_in("bilinear-observer", "none")), ("sine", text("sine")), ("step", text("step")), ("square", text("square wave")),
           ("sweep", text("sweep")), ("random", text("random")), ("hand", text("your own hand")))  # of an input
STEP = Number("step", "", text("step of the algorithm"), low=1, high=8, default=1, scale="integer",
              hint=text("The formulas and the tab Eight steps show this step."))
FORM = Choice("form", "", text("form of the observer"), default=PLAIN_FORM, options=tuple(zip(FORMS, FORM_NAMES, strict=True)),
              hint=text("Which estimate the ghost shows; the first is (18) with (19), the second (17) with (13)."))
FIRST_LABELS = (text("input"), text("amplitude"), text_in("bilinear-observer", "frequency"), text("random seed"), text("input by hand"))


def input_knobs(which: int, labels: Sequence[Text], hints: Sequence[Text], unit: str, sizes: tuple[float, float, float],
                omega: float) -> tuple[Knob, ...]:
    """What drives an input; `sizes`: the amplitude at first, the largest and its step; hints of the input, amplitude and frequency."""
    number, (size, most, step) = number_of(which), sizes
    kind, symbol = f"input{number}", f"u_{number}" if which else "u"
    return (
        Choice(kind, symbol, labels[0], default="sine", options=SIGNALS, hint=hints[0]),
        Number(f"amplitude{number}", "u_0", labels[1], unit, low=0.0, high=most, default=size, step=step, when=(kind, SHAPED),
               hint=hints[1]),
        Number(f"omega{number}", r"\omega", labels[2], "rad/s", low=omega / 4, high=20 * omega, default=omega, scale="log",
               when=(kind, MOVING), hint=hints[2]),
        Number(f"seed{number}", f"s_{number or 0}", labels[3], low=0, high=9999, default=which + 1, scale="integer",
               when=(kind, ("random",)), hint=text("The same seed gives the same input.")),
        Track(f"hand{number}", symbol, labels[4], unit, low=-most, high=most, when=(kind, ("hand",)),
              hint=text("Slow the clock down, press play and move this.")),
    )


KNOBS = (
    STEP,
    Choice("problem", "", text("problem"), default=PAPER_PROBLEM,
           options=tuple((p.id, p.label) for p in PROBLEMS.values()),
           hint=text("Which gauges are lit, and which number is wanted.")),
    *input_knobs(0, FIRST_LABELS, (
        text("u pushes the plant and also multiplies its state; the paper takes sin 2t."),
        text("A constant u of 3 makes the plant itself unstable."), text("The sweep is cos ωt², with ω in rad/s².")),
        "", (1.0, MOST_INPUT, 0.05), 2.0),
    Poles("pole", "p", text("Observer pole"), "rad/s", default=(complex(POLE),), re_low=OBSERVER_WINDOW.re_low,
          re_high=OBSERVER_WINDOW.re_high, im_high=OBSERVER_WINDOW.im_high, role="estimate", when=("problem", (PAPER_PROBLEM,)),
          hint=text("Real, since the observer has one state; step 6 finds π for it.")),
    Choice("gain", "L", text("gain"), default=COMPUTED_GAIN, when=("problem", (PAPER_PROBLEM,)), options=(
        (COMPUTED_GAIN, text("computed")), (AS_PRINTED, text("L as the paper prints it")),
        (TYPED_GAIN, text("with L₄ typed")), (ROUNDED_GAIN, text("step 8 in printed decimals"))),
        hint=text("The numbers in use: ours, or those printed in the paper.")),
    Number("l4", r"L_4", same("L₄"), low=0.0, high=14.0, default=9.0, step=0.01, when=("gain", (TYPED_GAIN,)),
           hint=text("The other entries stay as computed.")),
    FORM,
    Number("tau", r"\tau", text("differentiator's time constant"), "s", low=0.001, high=0.1, default=0.02,
           scale="log", hint=text("ẏ is replaced by s/(τs + 1) y.")),
    Number("noise", r"\sigma", text("noise of each sensor"), low=0.0, high=0.1, default=0.0, step=0.001,
           hint=text("The standard deviation of each sensor's noise, drawn again every 5 ms.")),
    Number("chi0", r"\chi(0)", text("first χ"), low=-30.0, high=30.0, default=0.0, step=0.5,
           hint=text("The paper starts at 0; ĝ then starts 15.5 below g.")),
    Choice("line", "", text("printed line in doubt"), default=OPTIONS[0][0], options=OPTIONS,
           hint=text("The tab Eight steps says which pole this line leads to by itself.")),
    run_knobs(HORIZON)[1],
)
