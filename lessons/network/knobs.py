"""Knobs of the lesson: the case, what happens on the way from the sensor, and on the way to the actuator."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number
from app.text.words import Text

from ..toolkit.knobs import run_knobs
from .cases import CART, CHIP, DECK, HORIZON, KINDS, SCALAR, SLOWEST
from .study import AHEAD, APPLIED, ASKED, HOLD, ZERO

SENSOR, ACTUATOR = Text("From the sensor", "传感器一侧"), Text("To the actuator", "执行器一侧")
KNOBS = (
    Choice("case", "", Text("case", "算例"), default=SCALAR, options=tuple((name, kind.label) for name, kind in KINDS.items()),
           hint=Text("Four that run away by themselves, and the deck, which does not.", "四个会自行发散的对象，以及不会发散的平台。")),
    Number("a", "a", Text("growth per sample a", "每周期增长倍数 a"), low=1.01, high=2.0, default=1.2, step=0.01, when=("case", (SCALAR,)),
           hint=Text("x⁺ = a x + u + w: left alone, x is multiplied by a every sample.",
                     "x⁺ = a x + u + w：不加控制时，x 每个采样周期乘以 a。")),
    Number("stretch", r"h/h_0", Text("sampling period", "采样周期"), "h₀", low=0.5, high=SLOWEST, default=1.0, step=0.05,
           when=("case", (CHIP, CART, DECK)),
           hint=Text("In units of the normal one: chip 0.5 s, cart 50 ms, deck 40 ms.",
                     "以常规周期为单位：芯片 0.5 s，小车 50 ms，平台 40 ms。")),
    Number("noise", r"\sigma_v", Text("sensor noise", "测量噪声"), "σ₀", low=0.1, high=10.0, default=1.0, scale="log",
           hint=Text("Standard deviation, in units of the normal one.", "标准差，以常规值为单位。")),
    Number("loss", "p", Text("measurements lost", "测量丢包率"), low=0.0, high=0.99, default=0.3, step=0.01, group=SENSOR,
           hint=Text("Each packet is lost with this probability, whatever happened to the others.", "每个数据包以此概率独立丢失。")),
    Number("jitter", "J", Text("late by up to (samples)", "最多迟到（周期数）"), low=0, high=4, default=0, scale="integer", group=SENSOR,
           hint=Text("Each measurement comes 0 to J samples late, so they may overtake each other.",
                     "每个测量随机晚到 0 到 J 个采样周期，可能后发先至。")),
    Choice("order", "", Text("late measurements", "迟到的测量"), default="stamped", group=SENSOR, when=("jitter", (1.0, 2.0, 3.0, 4.0)),
           options=(("stamped", Text("put in place by time stamp", "按时间戳归位")), ("arrival", Text("taken for fresh", "当作刚测的"))),
           hint=Text("With time stamps the filter goes back and takes each in where it belongs.",
                     "有时间戳时，滤波器回到相应时刻再纳入该测量。")),
    Number("loss_u", "p_u", Text("inputs lost", "输入丢包率"), low=0.0, high=0.95, default=0.1, step=0.01, group=ACTUATOR,
           hint=Text("Each input packet is lost with this probability.", "每个输入数据包以此概率丢失。")),
    Choice("lost", "", Text("in place of a lost input", "输入丢失时"), default=HOLD, group=ACTUATOR,
           options=((HOLD, Text("hold the last one", "保持上一个")), (ZERO, Text("apply zero", "置零"))),
           hint=Text("What the actuator does when no packet comes.", "没有收到数据包时执行器怎么做。")),
    Number("delay", "d", Text("delay of inputs (samples)", "输入时延（周期数）"), low=0, high=4, default=0, scale="integer", group=ACTUATOR,
           hint=Text("Every input acts this many samples after it was asked for.", "每个输入在发出若干采样周期之后才起作用。")),
    Choice("told", "", Text("the observer counts with", "观测器使用的输入"), default=APPLIED, group=ACTUATOR,
           options=((ASKED, Text("the input asked for", "指令输入")), (APPLIED, Text("the input applied", "实际输入")),
                    (AHEAD, Text("the input applied, u looks ahead", "实际输入，控制器预测"))),
           hint=Text("Looking ahead: u = −K times the state predicted over the delay.", "预测：u = −K 乘以时延之后的预测状态。")),
    *run_knobs(HORIZON),
)
