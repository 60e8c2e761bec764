"""Define the knobs for an own bilinear plant: wanted g, inputs, poles, form, noise."""

from __future__ import annotations

from observer_lab.course.knobs import Choice, Knob, Number, Poles, Track
from observer_lab.text import text, text_in

from ..toolkit.knobs import run_knobs
from .input_signals import FILTERED_DERIVATIVE
from .knobs import FORM, MOVING, SHAPED, SIGNALS, STEP
from .own_plant import Here, omega_of

STRONGEST = 4.0  # times the natural input


def own_knobs(here: Here) -> tuple[Knob, ...]:
    """The knobs of a plant: those of the paper's page that any plant has, in this plant's own sizes."""
    unit, strength = here.units[0], float(here.strength[0])
    most, omega = STRONGEST * strength, omega_of(here.horizon)
    return (
        STEP,
        Choice("wanted", "K", text("wanted, g = K x"), default=here.wanted[0].id, options=tuple((w.id, w.label) for w in here.wanted),
               hidden=len(here.wanted) == 1, hint=text("The rows of K in the file, together or alone, or one state that y does not give.")),
        Choice("input", "u", text("input"), default="sine", options=SIGNALS, hint=
            text("u is {name}. The plant is linear: F is zero, and u multiplies nothing.", name=here.names[0]) if here.linear else
            text("u pushes the plant and also multiplies its state: {name}.", name=here.names[0])),
        Number("amplitude", r"u_0", text("amplitude"), unit, low=0.0, high=most, default=strength, step=most / 100,
               when=("input", SHAPED), hint=text("At first half of what a regulator would ask for.") if here.linear else
               text("At first the input with which u F is half as fast as the plant.") if here.plant.inputs == 1 else
               text("At first all inputs together make the plant at most half as fast again.")),
        Number("omega", r"\omega", text_in("bilinear-observer", "frequency"), "rad/s", low=omega / 4, high=20 * omega, default=omega,
               scale="log", when=("input", MOVING), hint=text("The sweep ends four times as fast as it says here.")),
        Number("seed", r"s_0", text("random seed"), low=0, high=9999, default=1, scale="integer", when=("input", ("random",)),
               hint=text("The same seed gives the same input.")),
        Track("hand", "u", text("input by hand"), unit, low=-most, high=most, when=("input", ("hand",)),
              hint=text("Slow the clock down, press play and move this.")),
        *(knob for j in range(1, here.plant.inputs) for knob in _further(here, j)),
        *(Poles(f"poles_{w.id}", "p", text("Observer poles"), "rad/s", default=w.poles, re_low=w.window.re_low, re_high=w.window.re_high,
                im_high=w.window.im_high, role="estimate", when=("wanted", (w.id,)),
                hint=text("The poles that π moves; poles that are the same for every L are fixed modes.")) for w in here.wanted if w.poles),
        FORM,
        Number("tau", r"\tau", text("differentiator's time constant"), "s", low=here.horizon / 2000, high=here.horizon / 20,
               default=here.horizon / 100, scale="log", when=("form", (FILTERED_DERIVATIVE,)), hint=text("ẏ is replaced by s/(τs + 1) y.")),
        Number("noise", r"\sigma", text("noise of each sensor"), "%", low=0.0, high=10.0, default=0.0, step=0.1,
               hint=text("The standard deviation of what each sensor adds to y, as a share of what it reads at most in the first run.")),
        run_knobs(here.horizon)[1],
    )


def _further(here: Here, which: int) -> tuple[Knob, ...]:
    """The drive of the second input or of one that follows."""
    name, strength, omega, number = here.names[which], float(here.strength[which]), omega_of(here.horizon, which), which + 1
    most = STRONGEST * strength
    return (
        Choice(f"input{number}", f"u_{number}", text("input {name}", name=name), default="sine", options=SIGNALS,
               hint=text("It multiplies the state by a matrix of its own, F{number}.", number=number)),
        Number(f"amplitude{number}", "u_0", text("amplitude of {name}", name=name), here.units[which], low=0.0, high=most, default=strength,
               step=most / 100, when=(f"input{number}", SHAPED),
               hint=text("At first all inputs together make the plant at most half as fast again.")),
        Number(f"omega{number}", r"\omega", text("frequency of {name}", name=name), "rad/s", low=omega / 4, high=20 * omega, default=omega,
               scale="log", when=(f"input{number}", MOVING),
               hint=text("The sweep ends four times as fast as it says here.")),
        Number(f"seed{number}", f"s_{number}", text("random seed of {name}", name=name), low=0, high=9999, default=number, scale="integer",
               when=(f"input{number}", ("random",)), hint=text("The same seed gives the same input.")),
        Track(f"hand{number}", f"u_{number}", text("{name} by hand", name=name), here.units[which], low=-most, high=most,
              when=(f"input{number}", ("hand",)), hint=text("Slow the clock down, press play and move this.")),
    )
