"""Noise: the block, how its observer is chosen, and how strong both noises are."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number, Poles
from app.plants import MODELS
from app.text.words import Text

from ..toolkit.knobs import run_knobs

MODEL = MODELS["spring-damper"]
PLANT = MODEL.plant
HORIZON, DT = 6.0, 0.012
RE_LOW, RE_HIGH, IM_HIGH = -16.0, 2.0, 10.0
SPEED, POLES = "speed", "poles"
POSITION, VELOCITY = "position", "velocity"
KNOBS = (
    Choice("method", "", Text("observer by", "观测器由"), default=SPEED,
           options=((SPEED, Text("speed, in the Kalman pattern", "速度（卡尔曼极点的形状）")),
                    (POLES, Text("dragging poles", "拖动极点"))),
           hint=Text("One factor on the Kalman filter's poles, or two poles of your own on the right board.",
                     "把卡尔曼滤波器的极点乘以一个倍数，或在右侧板上自己放两个极点。")),
    Number("speed", r"\rho", Text("speed, times Kalman", "速度（卡尔曼的倍数）"), low=0.1, high=10.0, default=5.0, scale="log",
           when=("method", (SPEED,)), hint=Text("Both poles are ρ times those of the Kalman filter.",
                                                "两个极点都是卡尔曼滤波器极点的 ρ 倍。")),
    Poles("observer_poles", "q", Text("Observer poles", "观测器极点"), "rad/s", default=(-8 - 6j, -8 + 6j), re_low=RE_LOW,
          re_high=RE_HIGH, im_high=IM_HIGH, role="estimate", when=("method", (POLES,)),
          hint=Text("eig(A − LC): farther left is faster.", "eig(A − LC)：越靠左越快。")),
    Number("w", "W", Text("force noise W", "力噪声 W"), "N² s", low=1e-2, high=1.0, default=0.04, scale="log",
           hint=Text("Intensity of the unknown force on the block.", "作用在滑块上的未知力的强度。")),
    Number("v", "V", Text("sensor noise V", "测量噪声 V"), "m² s", low=1e-5, high=1e-2, default=4e-4, scale="log",
           hint=Text("Intensity of the noise on the measured position.", "位置测量噪声的强度。")),
    Number("error0", "e_1(0)", Text("position error at the start", "初始位置误差"), "m", low=0.0, high=1.0, default=0.3,
           step=0.05, hint=Text("Where the block really starts; the observer believes 0.", "滑块实际的起点；观测器以为是 0。")),
    Choice("watch", "", Text("judge by the error in", "评判依据"), default=VELOCITY,
           options=((POSITION, Text("position, measured", "位置误差（有测量）")),
                    (VELOCITY, Text("velocity, not measured", "速度误差（无测量）"))),
           hint=Text("Which error the curves show.", "曲线显示哪一个误差。")),
    *run_knobs(HORIZON),
)
