"""Knobs of the lesson: three loops, the mixing and its band, ground and sensors."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number, Poles, Switch
from app.plants import platform_siso as siso
from app.text.words import Text

from ..toolkit.knobs import run_knobs
from .loops import A_EDGE, B_EDGE, BEST, FALLING, GAIN, HORIZON, NONE, OPEN, OWN, POLES, PUBLISHED, SHAPED, WHITE
from .study import CONTROL_HIGH, CONTROL_IM, CONTROL_LOW, OBSERVER_HIGH, OBSERVER_IM, OBSERVER_LOW

MIXING = Text("Mixing and its band", "混合与频带")
WORLD = Text("Ground and sensors", "地面与传感器")
KNOBS = (
    Choice("vertical", "", Text("vertical loop", "竖直回路"), default=PUBLISHED,
           options=((PUBLISHED, Text("C_v as printed", "报告的 C_v")), (SHAPED, Text("shaped by hand", "自行整定")),
                    (OPEN, Text("open", "开环"))),
           hint=Text("What turns vertical velocity into a vertical force.", "由竖直速度产生竖直力的控制器。")),
    Number("gain_v", "k_v", Text("vertical gain", "竖直增益"), "N s/m", low=10.0, high=1e5, default=2000.0, scale="log",
           when=("vertical", (SHAPED,)), hint=Text("Newtons for each metre per second.", "每 1 m/s 对应的力。")),
    Number("lag", r"\omega_i", Text("more gain below", "低频增益提升"), "rad/s", low=0.0, high=5.0, default=0.0, step=0.1,
           when=("vertical", (SHAPED,)), hint=Text("A lag: up to 20 times the gain below this corner; 0: none.",
                                                    "滞后环节：低于此频率时增益最多提升 20 倍；0 为不用。")),
    Number("lead", "f_l", Text("phase lead at", "相位超前中心"), "Hz", low=0.0, high=100.0, default=0.0, step=1.0,
           when=("vertical", (SHAPED,)), hint=Text("A lead of a decade about this frequency; 0: none.",
                                                    "以此频率为中心、约一个十倍频的超前环节；0 为不用。")),
    Number("roll_off", "f_r", Text("roll-off above", "高频滚降"), "Hz", low=1.0, high=2000.0, default=1000.0, scale="log",
           when=("vertical", (SHAPED,)), hint=Text("The gain falls above this frequency; too low, and the phase is spent.",
                                                    "高于此频率时增益下降；过低则相位裕度被耗尽。")),
    Choice("horizontal", "", Text("horizontal loop", "水平回路"), default=PUBLISHED,
           options=((PUBLISHED, Text("C_h as printed", "报告的 C_h")), (POLES, Text("poles by A E + B F = Φ", "A E + B F = Φ 极点配置")),
                    (GAIN, Text("a pure gain", "纯增益")), (OPEN, Text("open", "开环"))),
           hint=Text("What turns horizontal velocity into the horizontal force; dragging a pole selects the second.",
                     "由水平速度产生水平力的控制器；拖动极点即选用第二项。")),
    Number("gain_h", "k_h", Text("horizontal gain", "水平增益"), "N s/m", low=10.0, high=1e5, default=2000.0, scale="log",
           when=("horizontal", (GAIN,)), hint=Text("Newtons for each metre per second.", "每 1 m/s 对应的力。")),
    Poles("control_poles", "p", Text("Roots of Φ, first four", "Φ 的前四个根"), "rad/s", default=siso.AT_WILL[0],
          re_low=CONTROL_LOW, re_high=CONTROL_HIGH, im_high=CONTROL_IM, role="plant", when=("horizontal", (POLES,)),
          hint=Text("Four of the eight poles of the horizontal loop.", "水平回路八个闭环极点中的四个。")),
    Poles("observer_poles", "q", Text("Roots of Φ, last four", "Φ 的后四个根"), "rad/s", default=siso.AT_WILL[1],
          re_low=OBSERVER_LOW, re_high=OBSERVER_HIGH, im_high=OBSERVER_IM, role="estimate", when=("horizontal", (POLES,)),
          hint=Text("The other four; E and F do not tell which is which.", "另外四个；E 与 F 并不区分前后。")),
    Switch("pitch", "", Text("close the pitch loop", "闭合俯仰回路"),
           hint=Text("A gain from the difference of the vertical sensors to the difference of the vertical coils.",
                     "由两竖直传感器之差到两竖直线圈之差的增益。")),
    Number("bandwidth", r"\Delta\omega", Text("pitch bandwidth", "俯仰带宽"), "rad/s", low=0.1, high=50.0, default=0.5,
           scale="log", when=("pitch", (True,)),
           hint=Text("Width of the band about the pitch mode in which the loop acts.", "俯仰模态附近回路起作用的频带宽度。")),
    Choice("mix", "", Text("mixing S", "混合矩阵 S"), default=NONE, group=MIXING,
           options=((NONE, Text("none", "不混合")), (OWN, Text("by hand", "手动")), (BEST, Text("least J", "J 最小"))),
           hint=Text("S = [1 b; a 1] between the last two virtual inputs and the coils.", "后两路虚拟输入与线圈之间的 S = [1 b; a 1]。")),
    Number("a", "a", Text("differential force into horizontal, a", "差模力到水平力 a"), low=-A_EDGE, high=A_EDGE, default=0.0,
           step=0.01, group=MIXING, when=("mix", (OWN,)), hint=Text("Newtons of u3 for each newton of differential force.",
                                                                  "每 1 N 差模力对应的 u3。")),
    Number("b", "b", Text("horizontal into differential force, b", "水平力到差模力 b"), low=-B_EDGE, high=B_EDGE, default=0.0,
           step=0.01, group=MIXING, when=("mix", (OWN,)), hint=Text("Newtons of differential force for each newton of v3.",
                                                                  "每 1 N 水平指令对应的差模力。")),
    Number("f_low", "f_1", Text("J from", "J 的频带下限"), "Hz", low=0.1, high=4.0, default=0.1, scale="log", group=MIXING,
           hint=Text("Lower end of the band over which J is summed.", "J 求和频带的下限。")),
    Number("f_high", "f_2", Text("J up to", "J 的频带上限"), "Hz", low=0.5, high=30.0, default=10.0, scale="log", group=MIXING,
           hint=Text("Upper end of the band over which J is summed.", "J 求和频带的上限。")),
    Choice("ground", "", Text("ground motion", "地面振动"), default=WHITE, group=WORLD,
           options=((WHITE, Text("white, 1 µm/√Hz", "白噪声，1 µm/√Hz")), (FALLING, Text("falling as 1/f²", "按 1/f² 下降"))),
           hint=Text("White as in the report's design, or falling, which meets its open-loop peaks.",
                     "报告设计所用的白噪声，或与其开环峰值相符的 1/f² 谱。")),
    Number("noise", r"\sigma_v", Text("sensor noise", "传感器噪声"), "m/s/√Hz", low=1e-12, high=1e-6, default=1e-9, scale="log",
           group=WORLD, hint=Text("One-sided amplitude density of each of the four sensors.", "每个传感器的单边幅值谱密度。")),
    *run_knobs(HORIZON),
)
