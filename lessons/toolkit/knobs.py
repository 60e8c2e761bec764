"""Define knobs that many lessons share: seed, kick, poles, gains by poles or weights."""

from __future__ import annotations

import numpy as np

from observer_lab.course.knobs import Choice, Number, Poles
from observer_lab.course.lesson import Design
from observer_lab.plants.model import Model
from observer_lab.text import Text, text

BY_POLES, BY_WEIGHTS = "poles", "weights"


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


def kicks(design: Design, model: Model) -> tuple[tuple[float, tuple[float, ...]], ...]:
    """The impulse that the kick button has put into the design, if any; a sampled plant feels it at the next sample."""
    step = model.plant.dt
    at = step * np.ceil(design["kick"] / step - 1e-9) if step else design["kick"]
    return ((float(at), model.kick),) if design["kick"] >= 0 else ()
