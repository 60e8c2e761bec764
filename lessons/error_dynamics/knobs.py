"""The knobs of lesson 2, on a block on a spring."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number, Poles, Track
from app.plants import MODELS
from app.text.words import Text, same

from ..toolkit.knobs import run_knobs
from .notes import LINES, NONE

MODEL = MODELS["spring-damper"]
WINDOW = MODEL.observer_window
HORIZON, DT = 15.0, 0.03
MOST_FORCE = 2.0
POLES, NUMBERS = "poles", "numbers"
PRINTED, QUIET = "printed", "none"
KNOBS = (
    Choice("input", "u", Text("force", "力"), default="sine", options=(
        (QUIET, Text("none", "无")), ("step", Text("step", "阶跃")), ("sine", Text("sine", "正弦")),
        ("square", Text("square wave", "方波")), ("random", Text("random", "随机")), ("hand", Text("your own hand", "手动"))),
        hint=Text("The plant and the observer get the same force.", "对象和观测器得到同一个力。")),
    Number("amplitude", r"u_0", Text("amplitude", "幅值"), "N", low=0.0, high=MOST_FORCE, default=1.0, step=0.05,
           when=("input", ("step", "sine", "square", "random")),
           hint=Text("1 N held for long stretches the spring by 1 m.", "1 N 的恒力最终把弹簧拉长 1 m。")),
    Number("frequency", "f", Text("frequency", "频率"), "Hz", low=0.02, high=1.0, default=0.15, step=0.01,
           when=("input", ("sine", "square")),
           hint=Text("The block swings most near 0.15 Hz.", "在 0.15 Hz 附近滑块摆动最大。")),
    Number("seed", r"s_0", Text("random seed", "随机种子"), low=0, high=9999, default=1, scale="integer",
           when=("input", ("random",)), hint=Text("The same seed gives the same force.", "同一种子给出同一串力。")),
    Track("hand", "u", Text("force by hand", "手动施力"), "N", low=-MOST_FORCE, high=MOST_FORCE, when=("input", ("hand",)),
          hint=Text("Press play and move this: your hand is recorded.", "按下播放，再移动它：你的手法会被记录下来。")),
    Choice("method", "L", Text("gain by", "增益由"), default=POLES, options=(
        (POLES, Text("dragging poles", "拖动极点")), (NUMBERS, Text("typing numbers", "输入数值")),
        (PRINTED, Text("the notes, as printed", "照讲义所印"))),
        hint=Text("The last choice runs matrix and gain exactly as the notes print them.",
                  "最后一项完全照讲义所印的矩阵和增益运行。")),
    Poles("observer_poles", "q", Text("Observer poles", "观测器极点"), "rad/s", default=MODEL.observer_poles,
          re_low=WINDOW.re_low, re_high=WINDOW.re_high, im_high=WINDOW.im_high, role="estimate",
          when=("method", (POLES,)), hint=Text("The eigenvalues of A − LC; the engine finds L.", "A − LC 的特征值，由引擎求出 L。")),
    Number("l1", r"l_1", same("l₁"), "1/s", low=-5.0, high=10.0, default=1.0, step=0.05, when=("method", (NUMBERS,)),
           hint=Text("How strongly y − ŷ corrects the position.", "y − ŷ 对位置估计的校正强度。")),
    Number("l2", r"l_2", same("l₂"), "1/s²", low=-10.0, high=20.0, default=0.0, step=0.05, when=("method", (NUMBERS,)),
           hint=Text("How strongly y − ŷ corrects the velocity.", "y − ŷ 对速度估计的校正强度。")),
    Number("guess_q", r"\hat q(0)", Text("guessed position", "猜测的位置"), "m", low=-2.0, high=2.0, default=0.0, step=0.05,
           hint=Text("The block really starts at 1 m.", "滑块实际从 1 m 处开始。")),
    Number("guess_v", r"\hat v(0)", Text("guessed velocity", "猜测的速度"), "m/s", low=-2.0, high=2.0, default=0.0, step=0.05,
           hint=Text("The block really starts at rest.", "滑块实际从静止开始。")),
    Choice("line", "", Text("line of the notes in doubt", "讲义中可疑的一行"), default=NONE, options=LINES,
           hint=Text("The tab Notes shows where this line leads.", "“讲义”标签页显示照这一行会得到什么。")),
    run_knobs(HORIZON)[1],
)
