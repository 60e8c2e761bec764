"""Knobs of the lesson: the pair on the stage and the order kept, rank and its units, geometry, LQG."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number
from app.text.words import Text

from .body import NOMINAL
from .regulator import OUTPUTS, PAIRS, PRESSED
from .study import MEASURES, RELATIVE
from .system import STATES, sigmas

GEOMETRY, RANK, MODEL, LQG = Text("Geometry", "几何"), Text("Rank", "秩"), Text("Model", "模型"), Text("LQG", "LQG")


def _size(name: str, symbol: str, label: Text, unit: str, low: float, high: float, hint: Text, step: float | None = None) -> Number:
    return Number(name, symbol, label, unit, low=low, high=high, default=getattr(NOMINAL, name),
                  scale="linear" if step else "log", step=step, group=GEOMETRY, hint=hint)


KNOBS = (
    Choice("pair", "", Text("pair on the stage", "场景中的一对"), default="1", group=MODEL,
           options=tuple((str(k + 1), Text(sigmas(k), sigmas(k))) for k in range(PAIRS)),
           hint=Text("Which motion is drawn, the strongest pair first.", "画出哪一种运动；从最强的一对开始。")),
    Number("order", "r", Text("states kept", "保留的状态数"), low=1, high=STATES, default=STATES, scale="integer", group=MODEL,
           hint=Text("Order of the balanced truncation. The ghost shows what that model can hold of the motion.",
                     "平衡截断的阶数。虚影是该模型所能容纳的运动。")),
    Number("clock", "T", Text("unit of time", "时间单位"), "s", low=1e-3, high=1.0, default=1.0, scale="log", group=RANK,
           hint=Text("Velocities and A are counted per this unit. The plant stays the same.", "速度与 A 按此单位计。对象不变。")),
    Number("tolerance", r"\tau", Text("tolerance", "容差"), low=1e-18, high=0.1, default=1e-9, scale="log", group=RANK,
           hint=Text("Singular values at or below it count as zero.", "不超过它的奇异值按零计。")),
    Choice("measure", "", Text("singular values", "奇异值"), default=RELATIVE, options=MEASURES, group=RANK,
           hint=Text("Measured against the largest, or taken as they are.", "以最大者为基准，或直接取其值。")),
    _size("s", "s", Text("sensors off the centre", "传感器离中心"), "m", 0.06, 0.18,
          Text("Half the distance of the two sensors.", "两传感器间距的一半。"), 0.002),
    _size("h", "h", Text("height of the centre of mass", "质心高度"), "m", 0.002, 0.06,
          Text("How far the centre of mass lies above the deck plane.", "质心高出台面的距离。"), 0.001),
    _size("a", "a", Text("springs off the centre", "弹簧离中心"), "m", 0.10, 0.21,
          Text("Half the distance of the two vertical springs.", "两竖直弹簧间距的一半。"), 0.002),
    _size("mu", r"\mu", Text("test mass", "测试质量"), "kg", 0.01, 0.5,
          Text("Mass inside each sensor.", "每个传感器内的质量。")),
    _size("kp", "k_p", Text("servo stiffness", "伺服刚度"), "N/m", 300.0, 20000.0,
          Text("Stiffness that holds each test mass.", "约束测试质量的伺服刚度。")),
    Number("v0", "V", Text("measurement noise", "测量噪声强度"), "m²/s", low=1e-12, high=1e-6, default=1e-9, scale="log", group=LQG,
           hint=Text("Intensity V of the noise on each velocity reading.", "每个速度读数的噪声强度 V。")),
    Choice("pressed", "", Text("the cost presses on", "代价所计的量"), default=OUTPUTS, options=PRESSED, group=LQG,
           hint=Text("The report's Q = α CᵀW_yC, or the same heavy weight on every balanced state.",
                     "报告的 Q = α CᵀW_yC，或对每个平衡状态取同样大的权重。")),
)
