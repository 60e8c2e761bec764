"""Error dynamics on a person's own plant: the same two runs, in its own measures; the notes stay with their block."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from app.engine.design import typical_rate
from app.lesson.knobs import Choice, Knob, Number, Poles, Track
from app.lesson.lesson import Lesson
from app.plants import Model
from app.plants.names import called
from app.text.words import Text

from ..toolkit.gains import injection
from ..toolkit.knobs import run_knobs
from .figures import figures
from .knobs import KNOBS, POLES
from .study import Setting, compute


def own_knobs(model: Model) -> tuple[Knob, ...]:
    """Input, observer poles and first guess in the plant's own measures."""
    window, pace, size = model.observer_window, typical_rate(model.plant) / (2 * np.pi), model.u_max
    name = model.plant.input_names[0]
    return (
        Choice("input", "u", Text("input {}", "输入 {}").format(called(model.plant, name)), default="sine",
               options=KNOBS[0].options,  # type: ignore[attr-defined]
               hint=Text("The plant and the observer get the same input.", "对象和观测器得到同一个输入。")),
        Number("amplitude", r"u_0", Text("amplitude", "幅值"), model.input_unit, low=0.0, high=5 * size, default=size,
               when=("input", ("step", "sine", "square", "random")),
               hint=Text("How strong the input is.", "输入有多强。")),
        Number("frequency", "f", Text("frequency", "频率"), "Hz", low=pace / 30, high=pace * 30, default=pace / 2, scale="log",
               when=("input", ("sine", "square")), hint=Text("How quickly the input turns round.", "输入往复的快慢。")),
        Number("seed", r"s_0", Text("random seed", "随机种子"), low=0, high=9999, default=1, scale="integer",
               when=("input", ("random",)), hint=Text("The same seed gives the same input.", "同一种子给出同一串输入。")),
        Track("hand", "u", Text("input by hand", "手动输入"), model.input_unit, low=-2 * size, high=2 * size,
              when=("input", ("hand",)), hint=Text("Press play and move this: your hand is recorded.",
                                                   "按下播放，再移动它：你的手法会被记录下来。")),
        Choice("method", "L", Text("gain by", "增益由"), default=POLES, options=((POLES, Text("dragging poles", "拖动极点")),),
               hidden=True),
        Poles("observer_poles", "q", Text("Observer poles", "观测器极点"), "rad/s", default=model.observer_poles,
              re_low=window.re_low, re_high=window.re_high, im_high=window.im_high, role="estimate",
              hidden=not model.observer_poles,
              hint=Text("Eigenvalues of A − LC that can be moved; the engine finds L.", "A − LC 可移动的特征值，由引擎求出 L。")),
        Number("guess", r"\gamma", Text("first guess, share of the true start", "初始猜测占真实初态的比例"), low=-1.0, high=2.0,
               default=0.0,
               step=0.05, hint=Text("0: the observer starts at rest; 1: exactly where the plant is.",
                                    "0：观测器从零开始；1：与对象初态完全相同。")),
        run_knobs(model.horizon)[1],
    )


def adapted(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant, which fits whatever it is; the notes stay with their own."""
    plant = model.plant
    parts = tuple((Text(f"e: {s.name.en}", f"e：{s.name.zh}"), s.unit) for s in model.watched[:2])
    here = Setting(
        model, model.horizon, model.dt, lambda design: plant, lambda design: injection(plant, design["observer_poles"], model),
        lambda design: tuple(design["guess"] * v for v in model.x0), parts, Text("the plant's own poles  eig(A)", "对象自身的极点  eig(A)"))
    return replace(lesson, knobs=own_knobs(model), compute=partial(compute, here), figures=partial(figures, here), tasks=())
