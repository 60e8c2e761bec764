"""Knobs of the sandbox: gains, limit, noise and tolerance, in the plant's own measures."""

from __future__ import annotations

from app.lesson.knobs import Choice, Knob, Number, Switch
from app.plants import Model
from app.text.words import Text

from ..toolkit.knobs import method_knobs, pole_knobs, run_knobs

COMMANDED, APPLIED = "commanded", "applied"


def knobs(model: Model) -> tuple[Knob, ...]:
    """Gains, limit, noise and tolerance, in the plant's own measures."""
    return (
        *method_knobs(),
        *pole_knobs(model),
        Switch("limited", "", Text("limit the inputs", "输入限幅"),
               hint=Text("Clip every input at the limit below.", "每个输入都按下面的限幅截断。")),
        Number("u_max", r"u_{\max}", Text("limit", "限幅"), model.input_unit, low=0.02 * model.u_max, high=20 * model.u_max,
               default=model.u_max, scale="log", when=("limited", (True,)),
               hint=Text("The largest input that is given, either way.", "两个方向上所能给出的最大输入。")),
        Choice("fed", "", Text("the observer is told", "送给观测器的是"), default=COMMANDED,
               options=((COMMANDED, Text("the commanded input", "指令输入")), (APPLIED, Text("the applied input", "实际输入"))),
               when=("limited", (True,)),
               hint=Text("What the controller asked for, or what was really given.", "控制器所要的，或实际给出的。")),
        Switch("noisy", "", Text("noise in the run", "运行中加入噪声"), hint=Text("Draw both noises in the run that is shown.",
                                                                        "在所示的运行中加入过程噪声和测量噪声。")),
        Number("sensor", r"\sigma", Text("sensor noise, share of the outputs", "测量噪声（占初始输出的比例）"), low=1e-3,
               high=1.0, default=0.01, scale="log",
               hint=Text("Beside a process noise of a tenth of the natural input.", "过程噪声固定为自然输入的十分之一。")),
        Number("belief", r"b", Text("believed / true process noise", "过程噪声：设定值 / 真值"),
               low=1e-3, high=1e3, default=1.0, scale="log",
               hint=Text("What the Kalman filter of the tab Noise believes; below 1 it trusts its model too much.",
                         "“噪声”标签页中卡尔曼滤波器的设定值；小于 1 时过于相信模型。")),
        Number("tolerance", r"\tau", Text("tolerance of the rank", "秩的容差"), low=1e-16, high=1.0, default=1e-12, scale="log",
               hint=Text("Singular values at or below τ times the largest count as zero.", "奇异值不超过最大值的 τ 倍者按零计。")),
        *run_knobs(model.horizon),
    )
