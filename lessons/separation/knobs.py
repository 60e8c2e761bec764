"""The knobs of lesson 4, on the platform's deck."""

from __future__ import annotations

from app.lesson.knobs import Number, Switch
from app.plants import MODELS
from app.text.words import Text

from ..toolkit.knobs import method_knobs, pole_knobs, run_knobs

MODEL = MODELS["deck"]
KNOBS = (
    *method_knobs(),
    *pole_knobs(MODEL),
    Number("stiffness_error", r"\delta_k", Text("stiffness believed wrong by", "模型刚度误差"), "%", low=-30.0, high=30.0,
           default=0.0, step=1.0, hint=Text("The observer's model has springs this much stiffer than the plant's.",
                                            "观测器模型中的弹簧比真实对象硬这么多。")),
    Number("delay", r"\tau", Text("input delay", "输入时延"), "ms", low=0.0, high=60.0, default=0.0, step=6.0,
           hint=Text("The force arrives later than the observer is told.", "力到达得比观测器所知道的晚。")),
    Switch("limited", "", Text("limit the coils", "限制线圈推力"),
           hint=Text("Clip every coil; the observer is still told the force that was asked for.",
                     "对每个线圈限幅；观测器得到的仍是指令值。")),
    Number("u_max", r"u_{\max}", Text("coil limit", "线圈限幅"), "N", low=0.2, high=4.0, default=1.0, step=0.1,
           hint=Text("The largest force that a coil can give.", "线圈能给出的最大推力。"), when=("limited", (True,))),
    Number("noise", r"\sigma_v", Text("sensor noise", "传感器噪声"), "mm/s", low=0.0, high=5.0, default=0.0, step=0.1,
           hint=Text("Standard deviation of each velocity sample; the noise itself is drawn from the seed.",
                     "每个速度采样值的标准差；噪声序列由种子决定。")),
    *run_knobs(MODEL.horizon),
)
