"""Separation on a person's own plant, whatever it is: the same loop, in its own measures."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from app.engine.design import typical_rate
from app.lesson.knobs import Knob, Number, Switch
from app.lesson.lesson import Lesson, Task
from app.plants import Model
from app.plants.names import called
from app.text.words import Text

from ..toolkit.gains import sizes, sped
from ..toolkit.knobs import method_knobs, pole_knobs, run_knobs
from ..toolkit.tasks import fair
from .figures import figures
from .study import Setting, compute
from .tasks import fast_observer


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """The knobs for a person's own plant: the same, in its own measures."""
    return (
        *method_knobs(),
        *pole_knobs(model),
        Number("mismatch", r"\delta", Text("the plant is faster than its model by", "对象比模型快"), "%", low=-30.0, high=30.0,
               default=0.0, step=1.0, hint=Text("A and B of what really moves are this much larger than what is believed.",
                                                "真实对象的 A、B 比模型大这么多。")),
        Number("delay", r"\tau", Text(f"input delay, steps of {model.dt:.3g} s", f"输入时延（每步 {model.dt:.3g} s）"), low=0, high=20,
               default=0, scale="integer", hint=Text("The input arrives later than the observer is told.",
                                                     "输入到达得比观测器所知道的晚。")),
        Switch("limited", "", Text("limit the inputs", "输入限幅"),
               hint=Text("Clip every input; the observer is still told what was asked for.",
                         "对每个输入限幅；观测器得到的仍是指令值。")),
        Number("u_max", r"u_{\max}", Text("limit", "限幅"), model.input_unit, low=0.05 * model.u_max, high=20 * model.u_max,
               default=model.u_max, scale="log", when=("limited", (True,)),
               hint=Text("The largest input that is given, either way.", "两个方向上所能给出的最大输入。")),
        Number("noise", r"\sigma_v", Text("sensor noise", "传感器噪声"), "%", low=0.0, high=20.0, default=0.0, step=0.5,
               hint=Text("Standard deviation of a sample, as a share of the outputs at the start.",
                         "单个采样值的标准差，以初始输出为单位。")),
        *run_knobs(model.horizon),
    )


def own_setting(model: Model) -> Setting:
    """A person's own plant: what it is believed to be is what was given, what really moves may be faster."""
    plant, unit = model.plant, sizes(model)
    u, y = called(plant, plant.input_names[0]), called(plant, plant.output_names[0])
    rate = typical_rate(plant) / (2 * np.pi)
    return Setting(
        model, lambda design: sped(plant, design["mismatch"]), lambda design: plant, lambda design: design["delay"] * model.dt,
        lambda design: None if design["noise"] == 0 else np.diag((design["noise"] / 100 * unit) ** 2) * model.dt,
        plant.B[:, :1], plant.C[:1],
        (Text("from {} (as a disturbance) to {}", "从 {}（作为扰动）到 {} 的增益").format(u, y),
         Text("|{} / {}|", "|{} / {}|").format(y, u)),
        np.geomspace(rate / 100, rate * 100, 300))


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, which fits whatever it is."""
    here = own_setting(model)
    slow = max((p.real for p in model.controller_poles), default=-1.0)
    near = max((p.real for p in model.observer_poles), default=-1.0)
    quicker = tuple(complex(p.real + min(0.0, 3.2 * slow - near), p.imag) for p in model.observer_poles)
    return fair(replace(lesson, knobs=own_knobs(model), compute=partial(compute, here), figures=partial(figures, here),
                        tasks=(Task("fast-observer", fast_observer, {"method": "poles", "observer_poles": quicker}),)))
