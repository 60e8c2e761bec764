"""Knobs of the lesson: the step shown, the problem, the input, the pole and the gain, the form that runs."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number, Poles, Track
from app.plants.bilinear import POLE
from app.text.words import Text, same

from ..toolkit.knobs import run_knobs
from .page import OPTIONS
from .problems import COMPUTED, PAPER, PRINTED, PROBLEMS, ROUNDED, TYPED
from .study import FORM_NAMES, FORMS, HORIZON, OBSERVER_WINDOW, PLAIN

MOST_INPUT = 4.0
MOVING = ("sine", "square", "sweep")
SHAPED = ("step", *MOVING, "random")
KNOBS = (
    Number("step", "", Text("step of the algorithm", "算法步骤"), low=1, high=8, default=1, scale="integer",
           hint=Text("The formulas and the tab Eight steps show this step.", "公式栏和“八个步骤”标签页显示这一步。")),
    Choice("problem", "", Text("problem", "问题"), default=PAPER,
           options=tuple((p.id, p.label) for p in PROBLEMS.values()),
           hint=Text("Which gauges are lit, and which number is wanted.", "哪些表可测，要监视哪个量。")),
    Choice("input", "u", Text("input", "输入"), default="sine", options=(
        ("none", Text("none", "无")), ("sine", Text("sine", "正弦")), ("step", Text("step", "阶跃")),
        ("square", Text("square wave", "方波")), ("sweep", Text("sweep", "扫频")), ("random", Text("random", "随机")),
        ("hand", Text("your own hand", "手动"))),
        hint=Text("u pushes the plant and also multiplies its state; the paper takes sin 2t.",
                  "u 既推动对象，又乘在状态上；论文取 sin 2t。")),
    Number("amplitude", r"u_0", Text("amplitude", "幅值"), low=0.0, high=MOST_INPUT, default=1.0, step=0.05,
           when=("input", SHAPED), hint=Text("A constant u of 3 makes the plant itself unstable.", "恒定的 u = 3 会使对象本身不稳定。")),
    Number("omega", r"\omega", Text("frequency", "角频率"), "rad/s", low=0.5, high=40.0, default=2.0, scale="log",
           when=("input", MOVING), hint=Text("The sweep is cos ωt².", "扫频信号为 cos ωt²。")),
    Number("seed", r"s_0", Text("random seed", "随机种子"), low=0, high=9999, default=1, scale="integer",
           when=("input", ("random",)), hint=Text("The same seed gives the same input.", "同一种子给出同一输入。")),
    Track("hand", "u", Text("input by hand", "手动输入"), low=-MOST_INPUT, high=MOST_INPUT, when=("input", ("hand",)),
          hint=Text("Slow the clock down, press play and move this.", "调慢时钟，按下播放，再移动它。")),
    Poles("pole", "p", Text("Observer pole", "观测器极点"), "rad/s", default=(complex(POLE),), re_low=OBSERVER_WINDOW.re_low,
          re_high=OBSERVER_WINDOW.re_high, im_high=OBSERVER_WINDOW.im_high, role="estimate", when=("problem", (PAPER,)),
          hint=Text("Real, since the observer has one state; step 6 finds π for it.",
                    "观测器只有一个状态，极点必为实数；由第 6 步求出 π。")),
    Choice("gain", "L", Text("gain", "增益"), default=COMPUTED, when=("problem", (PAPER,)), options=(
        (COMPUTED, Text("computed", "计算值")), (PRINTED, Text("L as the paper prints it", "论文所印的 L")),
        (TYPED, Text("with L₄ typed", "L₄ 自行输入")), (ROUNDED, Text("step 8 in printed decimals", "第 8 步照论文的两位小数"))),
        hint=Text("What runs: our numbers, or those of the paper taken at their word.", "按我们的数运行，或完全照论文所印的数运行。")),
    Number("l4", r"L_4", same("L₄"), low=0.0, high=14.0, default=9.0, step=0.01, when=("gain", (TYPED,)),
           hint=Text("The other entries stay as computed.", "其余各元素保持计算值。")),
    Choice("form", "", Text("form of the observer", "观测器的形式"), default=PLAIN,
           options=tuple(zip(FORMS, FORM_NAMES, strict=True)),
           hint=Text("Which estimate the ghost shows; the first is (18) with (19), the second (17) with (13).",
                     "虚影显示哪个估计：第一种为 (18)、(19)，第二种为 (17)、(13)。")),
    Number("tau", r"\tau", Text("differentiator's time constant", "微分器时间常数"), "s", low=0.001, high=0.1, default=0.02,
           scale="log", hint=Text("ẏ is replaced by s/(τs + 1) y.", "用 s/(τs + 1) y 代替 ẏ。")),
    Number("chi0", r"\chi(0)", Text("first χ", "χ 的初值"), low=-30.0, high=30.0, default=0.0, step=0.5,
           hint=Text("The paper starts at 0; ĝ then starts 15.5 below g.", "论文取 0，此时 ĝ 比 g 低 15.5。")),
    Choice("line", "", Text("printed line in doubt", "可疑的一行"), default=OPTIONS[0][0], options=OPTIONS,
           hint=Text("The tab Eight steps says which pole this line leads to by itself.", "“八个步骤”标签页给出照这一行得到的极点。")),
    run_knobs(HORIZON)[1],
)
