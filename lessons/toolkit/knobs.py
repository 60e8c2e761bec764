"""Knobs that many lessons share: seed and kick, poles, and gains by poles or by weights."""

from __future__ import annotations

import numpy as np

from app.lesson.knobs import Choice, Number, Poles
from app.lesson.lesson import Design
from app.plants.model import Model
from app.text.words import Text

BY_POLES, BY_WEIGHTS = "poles", "weights"


def run_knobs(horizon: float) -> tuple[Number, ...]:
    """Knobs that every run has and no slider shows: the seed of its noise and the time of a kick (−1: none)."""
    return (
        Number("seed", r"s_0", Text("noise seed", "噪声种子"), low=0, high=9999, default=1, scale="integer", hidden=True),
        Number("kick", r"t_k", Text("time of the kick", "冲击时刻"), "s", low=-1.0, high=horizon, default=-1.0,
               hidden=True),
    )


def pole_knobs(model: Model) -> tuple[Poles, Poles]:
    """The controller's and the observer's poles, inside the windows of their boards."""
    c, o = model.controller_window, model.observer_window
    when = ("method", (BY_POLES,))
    return (
        Poles("controller_poles", "p", Text("Controller poles", "控制器极点"), "rad/s", default=model.controller_poles,
              re_low=c.re_low, re_high=c.re_high, im_high=c.im_high, role="plant", when=when, hidden=not model.controller_poles,
              hint=Text("Where eig(A − BK) is to lie: farther left is faster and asks for more input.",
                        "eig(A − BK) 的位置：越靠左越快，所需的输入也越大。")),
        Poles("observer_poles", "q", Text("Observer poles", "观测器极点"), "rad/s", default=model.observer_poles,
              re_low=o.re_low, re_high=o.re_high, im_high=o.im_high, role="estimate", when=when, hidden=not model.observer_poles,
              hint=Text("Where eig(A − LC) is to lie: farther left forgets a wrong start sooner.",
                        "eig(A − LC) 的位置：越靠左，初始误差消失得越快。")),
    )


def method_knobs() -> tuple[Choice, Number, Number, Number, Number]:
    """Gains by poles or by weights: Q = α_Q CᵀC, R = α_R I for K; W = α_W B Bᵀ, V = α_V I for L."""
    weights = ("method", (BY_WEIGHTS,))

    def weight(name: str, symbol: str, en: str, zh: str, default: float, hint: Text) -> Number:
        return Number(name, symbol, Text(en, zh), low=1e-6, high=1e6, default=default, scale="log", when=weights,
                      hint=hint)
    return (
        Choice("method", "", Text("gains by", "增益由"), default=BY_POLES,
               options=((BY_POLES, Text("dragging poles", "拖动极点")), (BY_WEIGHTS, Text("Q/R weights", "Q/R 权重"))),
               hint=Text("Drag the poles yourself, or let LQR and its dual choose them from weights.",
                         "自己拖动极点，或由权重经 LQR 及其对偶给出极点。")),
        weight("q", r"\alpha_Q", "state weight α_Q", "状态权重 α_Q", 1e4,
               Text("Q = α_Q CᵀC: how much a moving plant costs.", "Q = α_Q CᵀC：对象运动的代价。")),
        weight("r", r"\alpha_R", "input weight α_R", "输入权重 α_R", 1.0,
               Text("R = α_R I: how much force costs. Only α_Q/α_R matters for K.", "R = α_R I：用力的代价。K 只取决于 α_Q/α_R。")),
        weight("w", r"\alpha_W", "process intensity α_W", "过程噪声强度 α_W", 1e2,
               Text("W = α_W I on the inputs: how far the model is to be distrusted.", "输入端的 W = α_W I：对模型的不信任程度。")),
        weight("v", r"\alpha_V", "sensor intensity α_V", "测量噪声强度 α_V", 1e-2,
               Text("V = α_V I: how far the sensors are to be distrusted. Only α_W/α_V matters for L.",
                    "V = α_V I：对传感器的不信任程度。L 只取决于 α_W/α_V。")),
    )


def by_hand(design: Design) -> bool:
    """Whether poles are chosen by hand: the method says so, or the lesson knows no other."""
    return dict(design.values).get("method", BY_POLES) == BY_POLES


def kicks(design: Design, model: Model) -> tuple[tuple[float, tuple[float, ...]], ...]:
    """The impulse that the kick button has put into the design, if any; a sampled plant feels it at the next sample."""
    step = model.plant.dt
    at = step * np.ceil(design["kick"] / step - 1e-9) if step else design["kick"]
    return ((float(at), model.kick),) if design["kick"] >= 0 else ()
