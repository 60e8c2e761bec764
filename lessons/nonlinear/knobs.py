"""Knobs of the lesson: the case, its laws and noise, the filters and their sigma points, a line of the report."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number, Switch
from app.text.words import Text

from ..toolkit.knobs import run_knobs
from .cases import EKF, FALL, KF, PENDULUM, PLATFORM, UKF
from .report import LINES, NONE

HORIZON = 30.0  # s, of the longest record
KNOBS = (
    Choice("case", "", Text("case", "对象"), default=FALL,
           options=((PLATFORM, Text("platform, hardening springs", "隔振平台（硬化弹簧）")),
                    (PENDULUM, Text("pole in the fog", "雾中的倒立摆")),
                    (FALL, Text("falling body, radar", "下落体与雷达"))),
           hint=Text("The last one is the classic of Athans, Wishner and Bertolini, and of Julier and Uhlmann.",
                     "最后一个是 Athans 等人与 Julier、Uhlmann 的经典算例。")),
    Choice("filter", "", Text("the ghost is the", "虚影显示"), default=EKF,
           options=((KF, Text("KF, expanded once", "KF（只线性化一次）")),
                    (EKF, Text("EKF, expanded at every estimate", "EKF（在每个估计处线性化）")),
                    (UKF, Text("UKF, sigma points", "UKF（sigma 点）"))),
           hint=Text("Whose estimate and 3σ are drawn, and who steers where somebody steers.",
                     "显示谁的估计与 3σ；需要控制时，也由它提供估计。")),
    Number("hardening", r"\gamma", Text("hardening γ", "硬化系数 γ"), low=0.0, high=1.0, default=0.3, step=0.05, when=("case", (PLATFORM,)),
           hint=Text("A spring stretched by 5 mm is 1 + γ times as stiff.", "弹簧伸长 5 mm 时，刚度为 1 + γ 倍。")),
    Number("weakening", r"\nu", Text("weakening of the coils ν", "线圈减弱系数 ν"), low=0.0, high=1.0, default=0.2, step=0.05,
           when=("case", (PLATFORM,)), hint=Text("The force falls by e^(−ν) for every 5 mm of gap.", "间隙每增大 5 mm，出力乘以 e^(−ν)。")),
    Number("force", "F", Text("known force", "已知力"), "N", low=0.0, high=4.0, default=1.0, step=0.1, when=("case", (PLATFORM,)),
           hint=Text("Amplitude at 0.16 Hz, and every filter is told.", "0.16 Hz 的幅值，各滤波器都知道。")),
    Number("size", r"\sigma_0", Text("unknown start, times", "初始不确定度倍数"), low=0.2, high=2.0, default=1.0, step=0.05,
           hint=Text("Standard deviation of the start, and the filters know it: 1 is 2 mm, 5.7° or that of the papers.",
                     "初始状态的标准差，滤波器知道它：取 1 时为 2 mm、5.7° 或论文的取值。")),
    Number("wind", "q", Text("process noise Q, times", "过程噪声 Q 的倍数"), low=0.1, high=10.0, default=1.0, scale="log",
           when=("case", (PLATFORM, PENDULUM)), hint=Text("True and believed alike; the falling body has none.",
                                                         "真值与设定值相同；下落体没有过程噪声。")),
    Number("sensor", "r", Text("sensor noise σ, times", "测量噪声 σ 的倍数"), low=0.1, high=10.0, default=1.0, scale="log",
           hint=Text("True and believed alike. Better sensors make the bends matter more.",
                     "真值与设定值相同。传感器越准，非线性越要紧。")),
    Switch("steer", "", Text("LQR on the estimate", "用估计作 LQR 反馈"), default=False, when=("case", (PLATFORM,)),
           hint=Text("The deck is steered by the ghost's estimate; the pole always is.", "用虚影的估计控制平台；倒立摆始终如此。")),
    Number("alpha", r"\alpha", Text("UKF spread α", "UKF 的 α"), low=0.1, high=1.0, default=1.0, step=0.05,
           hint=Text("How far out the sigma points lie: √(α²(n + κ)) standard deviations.", "sigma 点离中心 √(α²(n + κ)) 个标准差。")),
    Number("beta", r"\beta", Text("UKF weight β", "UKF 的 β"), low=0.0, high=4.0, default=2.0, step=0.1,
           hint=Text("Added to the middle point's weight in covariances; 2 for a Gaussian.", "加在中心点的协方差权重上；高斯分布取 2。")),
    Number("kappa", r"\kappa", Text("UKF spread κ", "UKF 的 κ"), low=-1.0, high=3.0, default=0.0, step=0.1,
           hint=Text("Moves the points like α; 3 − n matches one fourth moment.", "与 α 一样移动各点；取 3 − n 可匹配一个四阶矩。")),
    Switch("redraw", "", Text("sigma points drawn anew", "重抽 sigma 点"), default=True,
           hint=Text("Off: Algorithm 3 of the report as printed.", "关：按报告印出的算法 3。")),
    Choice("line", "", Text("line of the report in doubt", "报告中可疑的一行"), default=NONE, options=LINES,
           hint=Text("The tab Algorithm 3 says what the engine finds.", "“算法 3”标签页给出计算结果。")),
    *run_knobs(HORIZON),
)
