"""Duality: the block whose sensor turns, and what a person may choose."""

from __future__ import annotations

from types import MappingProxyType

from app.lesson.knobs import Choice, Number, Poles, Switch
from app.plants import MODELS
from app.text.words import Text

from ..toolkit.boards import WEIGHTS
from ..toolkit.knobs import BY_POLES, BY_WEIGHTS, run_knobs

MODEL = MODELS["spring-damper"]
HINTS = MappingProxyType({
    "q": Text("Q = α_Q I: how dear a deviation of the state is.", "Q = α_Q I：状态偏离的代价。"),
    "r": Text("R = α_R: how dear the input is.", "R = α_R：输入的代价。"),
    "w": Text("W = α_W I: how hard unknown forces shake the plant.", "W = α_W I：未知扰动有多强。"),
    "v": Text("V = α_V: how noisy the sensor is.", "V = α_V：测量噪声有多大。"),
})


def _weight(name: str, symbol: str, en: str, zh: str, default: float, tied: bool) -> Number:
    return Number(name, symbol, Text(en, zh), low=1e-3, high=1e3, default=default, scale="log", group=WEIGHTS,
                  when=None if tied else ("mirror", (False,)), hint=HINTS[name])


KNOBS = (
    Choice("method", "", Text("gains by", "增益由"), default=BY_POLES,
           options=((BY_POLES, Text("dragging poles", "拖动极点")), (BY_WEIGHTS, Text("Q/R weights", "Q/R 权重"))),
           hint=Text("Drag one set of poles for both boards, or let the two Riccati equations choose.",
                     "两块板共用一组极点，拖动任一块；或由两个 Riccati 方程给出。")),
    Poles("poles", "p", Text("Poles of both boards", "两块板共用的极点"), "rad/s", default=MODEL.controller_poles,
          re_low=-5.0, re_high=1.5, im_high=3.0, role="plant", when=("method", (BY_POLES,)),
          hint=Text("Drag a cross on either board: both boards hold the same poles.",
                    "拖动任一块板上的叉号：两块板的极点相同。")),
    Number("sensor", r"\varphi", Text("sensor turned by", "传感器角度"), "°", low=0.0, high=90.0, default=0.0, step=1.0,
           hint=Text("y = q cos φ + v sin φ: the position at 0°, the velocity at 90°.",
                     "y = q cos φ + v sin φ：0° 测位置，90° 测速度。")),
    Number("window", "T", Text("window of the ellipses", "椭圆的时间窗"), "s", low=0.5, high=12.0, default=4.0, step=0.1,
           hint=Text("How long the input may push, and how long the output is listened to.",
                     "输入可以作用多久，输出可以听多久。")),
    _weight("q", r"\alpha_Q", "state weight α_Q", "状态权重 α_Q", 4.0, True),
    _weight("r", r"\alpha_R", "input weight α_R", "输入权重 α_R", 1.0, True),
    Switch("mirror", "", Text("mirror the weights: W = Q, V = R", "权重对偶：W = Q，V = R"), default=True,
           hint=Text("On: the filter gets the regulator's weights. Off: it has its own.",
                     "开：滤波器取与调节器相同的权重；关：各用各的。")),
    _weight("w", r"\alpha_W", "process intensity α_W", "过程噪声强度 α_W", 1.0, False),
    _weight("v", r"\alpha_V", "sensor intensity α_V", "测量噪声强度 α_V", 1.0, False),
    *run_knobs(MODEL.horizon),
)
