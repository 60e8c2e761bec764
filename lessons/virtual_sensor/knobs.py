"""The knobs of lesson 1, on a chip that cools and on one that runs away."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number, Poles
from app.plants import MODELS, chip
from app.text.words import Text

from ..toolkit.knobs import run_knobs

TAME, RUNAWAY, HORIZON = chip.MODEL.id, chip.RUNAWAY.id, chip.MODEL.horizon
WINDOW = MODELS[TAME].observer_window
DT = MODELS[TAME].dt
MOST_TRUST = 2.0
KNOBS = (
    Choice("plant", "", Text("chip", "芯片"), default=TAME, options=(
        (TAME, Text("cools by itself", "能自行冷却")), (RUNAWAY, Text("runs away", "会热失控"))),
        hint=Text("Leakage current that grows with temperature can make the chip heat itself without end.",
                  "漏电流随温度增大，可使芯片无休止地自我加热。")),
    Number("trust", r"\theta", Text("trust in the sensor θ", "对传感器的信任 θ"), low=0.0, high=MOST_TRUST, default=1.0,
           step=0.01, hint=Text("The gain is θ times the one for the poles below; θ = 0 is the open-loop copy.",
                                "实际增益是下面极点所对应增益的 θ 倍；θ = 0 就是开环副本。")),
    Poles("observer_poles", "q", Text("Observer poles at θ = 1", "θ = 1 时的观测器极点"), "rad/s",
          default=MODELS[TAME].observer_poles, re_low=WINDOW.re_low, re_high=WINDOW.re_high, im_high=WINDOW.im_high,
          role="estimate", hint=Text("The error dies as fast as the rightmost of these; far left asks for a large gain.",
                                     "误差消失的快慢由最右边的极点决定；越靠左，需要的增益越大。")),
    Number("guess_core", r"\hat T_1(0)", Text("first guess of the core", "内核温度初始猜测"), "K", low=-40.0, high=80.0,
           default=0.0, step=1.0, hint=Text("Above ambient. The core really starts at 45 K, or 12 K if it runs away.",
                                            "相对环境温度。内核实际从 45 K 开始；热失控的芯片从 12 K 开始。")),
    Number("guess_case", r"\hat T_2(0)", Text("first guess of the case", "外壳温度初始猜测"), "K", low=-40.0, high=80.0,
           default=0.0, step=1.0, hint=Text("Above ambient. The case really starts at 20 K, or 6 K if it runs away.",
                                            "相对环境温度。外壳实际从 20 K 开始；热失控的芯片从 6 K 开始。")),
    Number("air_error", r"\delta_R", Text("case-to-air resistance wrong by", "外壳到空气的热阻误差"), "%", low=-50.0,
           high=50.0, default=0.0, step=1.0,
           hint=Text("What both models believe of the fan: positive, they think it cools worse than it does.",
                     "两个模型对风扇的看法：为正时，以为散热比实际差。")),
    Number("power", "P", Text("computing power", "计算功率"), "W", low=0.0, high=40.0, default=10.0, step=1.0,
           hint=Text("Work for 3 s, then a quarter of it for 3 s. Chip, copy and observer are all told.",
                     "满功率 3 s，再以四分之一功率 3 s。芯片、副本和观测器都知道它。")),
    Number("noise", r"\sigma", Text("sensor noise", "传感器噪声"), "K", low=0.0, high=2.0, default=0.0, step=0.05,
           hint=Text("Standard deviation of each reading, one every 30 ms.", "每 30 ms 一次读数，这是单次读数的标准差。")),
    *run_knobs(HORIZON),
)
