"""Define knobs that many lessons share: seed, kick, poles, gains by poles or weights."""

from __future__ import annotations

import numpy as np

from observer_lab.course.knobs import RELEASE_TIMES, SAMPLE_S, Choice, Number, Poles, Pull
from observer_lab.course.lesson import Design
from observer_lab.plants.grip import Grip
from observer_lab.plants.model import Model
from observer_lab.text import Text, text

BY_POLES, BY_WEIGHTS = "poles", "weights"
PULLS = ("pull", "pull_2")  # the names that grips give their records
PULL_STEPS = 20  # steps from no force to the largest


def run_knobs(horizon: float) -> tuple[Number, ...]:
    """Knobs that every run has and no slider shows: the seed of its noise and the time of a kick (−1: none)."""
    return (
        Number("seed", r"s_0", text("noise seed"), low=0, high=9999, default=1, scale="integer", hidden=True),
        Number("kick", r"t_k", text("time of the kick"), "s", low=-1.0, high=horizon, default=-1.0,
               hidden=True),
    )


def pole_knobs(model: Model) -> tuple[Poles, Poles]:
    """The controller's and the observer's poles, inside the windows of their boards."""
    c, o = model.controller_window, model.observer_window
    when = ("method", (BY_POLES,))
    return (
        Poles("controller_poles", "p", text("Controller poles"), "rad/s", default=model.controller_poles,
              re_low=c.re_low, re_high=c.re_high, im_high=c.im_high, role="plant", when=when, hidden=not model.controller_poles,
              hint=text("Where eig(A − BK) is to lie: farther left is faster and asks for more input.")),
        Poles("observer_poles", "q", text("Observer poles"), "rad/s", default=model.observer_poles,
              re_low=o.re_low, re_high=o.re_high, im_high=o.im_high, role="estimate", when=when, hidden=not model.observer_poles,
              hint=text("Where eig(A − LC) is to lie: farther left, a wrong start decays sooner.")),
    )


def method_knobs() -> tuple[Choice, Number, Number, Number, Number]:
    """Gains by poles or by weights: Q = α_Q CᵀC, R = α_R I for K; W = α_W B Bᵀ, V = α_V I for L."""
    weights = ("method", (BY_WEIGHTS,))

    def weight(name: str, symbol: str, label: Text, default: float, hint: Text) -> Number:
        return Number(name, symbol, label, low=1e-6, high=1e6, default=default, scale="log", when=weights,
                      hint=hint)
    return (
        Choice("method", "", text("gains by"), default=BY_POLES,
               options=((BY_POLES, text("dragging poles")), (BY_WEIGHTS, text("Q/R weights"))),
               hint=text("Drag the poles yourself, or let LQR and its dual choose them from weights.")),
        weight("q", r"\alpha_Q", text("state weight α_Q"), 1e4,
               text("Q = α_Q CᵀC: how much a moving plant costs.")),
        weight("r", r"\alpha_R", text("input weight α_R"), 1.0,
               text("R = α_R I: how much force costs. Only α_Q/α_R matters for K.")),
        weight("w", r"\alpha_W", text("process intensity α_W"), 1e2,
               text("W = α_W I on the inputs: a larger value trusts the model less.")),
        weight("v", r"\alpha_V", text("sensor intensity α_V"), 1e-2,
               text("V = α_V I: a larger value trusts the sensors less. Only α_W/α_V matters for L.")),
    )


def by_hand(design: Design) -> bool:
    """Whether poles are chosen by hand: the method says so, or the lesson knows no other."""
    return dict(design.values).get("method", BY_POLES) == BY_POLES


def pull_knobs(model: Model) -> tuple[Pull, ...]:
    """The records of a hand on the plant, one for each place where it can be pulled; no widget shows them."""
    return tuple(Pull(grip.knob, "F", grip.label, grip.unit, low=-RELEASE_TIMES * grip.most, high=RELEASE_TIMES * grip.most,
                      step=grip.most / PULL_STEPS, most=grip.most, hidden=True) for grip in model.grips)


def untouched(design: Design) -> bool:
    """Whether nobody has kicked or pulled the plant in this run."""
    return not any((name == "kick" and value >= 0) or (name in PULLS and value) for name, value in design.values)


def kicks(design: Design, model: Model, grid: tuple[float, float] | None = None) -> tuple[tuple[float, tuple[float, ...]], ...]:
    """The impulses of the kick button and of a hand, (time, jump of the state); a sampled plant feels them at the next sample.

    A force F that a hand holds for one sample of its record is the impulse F · SAMPLE_S at the grid point nearest to where the sample
    begins; `grid` is (its step, its end), None for the model's own.
    """
    step = model.plant.dt
    at = step * np.ceil(design["kick"] / step - 1e-9) if step else design["kick"]
    struck = ((float(at), model.kick),) if design["kick"] >= 0 else ()
    dt, horizon = grid or (model.plant.dt or model.dt, model.horizon)
    return (*struck, *pulls(design, model, dt, horizon))


def pulls(design: Design, model: Model, dt: float, horizon: float) -> tuple[tuple[float, tuple[float, ...]], ...]:
    """The impulses of a hand at grid points of the run: each force of a record holds until the next one."""
    values = dict(design.values)
    found = []
    for grip in model.grips:
        record = values.get(grip.knob, ())
        last = round(horizon / SAMPLE_S) + 1
        firsts = [round(t / SAMPLE_S) for t, _ in record]
        for (_, force), first, beyond in zip(record, firsts, (*firsts, last)[1:], strict=True):
            jump = tuple(SAMPLE_S * force * v for v in grip.push)
            found += [(dt * round(SAMPLE_S * k / dt), jump) for k in range(first, beyond) if force]
    return tuple(found)


def held(design: Design, model: Model) -> tuple[tuple[Grip, tuple[tuple[float, float], ...]], ...]:
    """Where the plant of a stage can be pulled, and the record of the hand there."""
    values = dict(design.values)
    return tuple((grip, values[grip.knob]) for grip in model.grips if grip.knob in values)
