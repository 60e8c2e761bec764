"""Knobs of the lesson: the fault, the diagnosis, the loop."""

from __future__ import annotations

from app.lesson.knobs import Choice, Knob, Number
from app.text.words import Text

from ..toolkit.knobs import run_knobs
from .bank import HORIZON, PLACE_NAMES, PLACES
from .diagnosis import ENERGY, MEAN
from .runs import BIAS, BLIND, DRIFT, NONE, OPEN, STUCK, SWITCH

FAULT, TEST, LOOP = Text("Fault", "故障"), Text("Diagnosis", "诊断"), Text("Loop", "回路")
SENSOR_PLACES, COIL_PLACES = PLACES[:4], PLACES[4:]
KNOBS: tuple[Knob, ...] = (
    Choice("place", "", Text("what fails", "故障部件"), default="HL", group=FAULT,
           options=((NONE, Text("nothing", "无")), *((p, PLACE_NAMES[i]) for i, p in enumerate(PLACES))),
           hint=Text("The bank does not know it.", "诊断器并不知道。")),
    Choice("kind", "", Text("how it lies", "故障类型"), default=BIAS, when=("place", SENSOR_PLACES), group=FAULT,
           options=((BIAS, Text("bias", "恒定偏差")), (DRIFT, Text("drift", "漂移")), (STUCK, Text("stuck", "卡死"))),
           hint=Text("A constant added, a growing error, or a reading frozen at its last value.",
                     "加一个常数、误差不断增长，或读数停在最后的值。")),
    Number("bias", "b", Text("bias", "偏差"), "mm/s", low=0.5, high=20.0, default=3.0, scale="log",
           when=("kind", (BIAS,)), group=FAULT, hint=Text("The noise of a reading is 1 mm/s.", "读数噪声的标准差为 1 mm/s。")),
    Number("drift", "c", Text("drift", "漂移速率"), "mm/s²", low=0.5, high=10.0, default=4.0, scale="log",
           when=("kind", (DRIFT,)), group=FAULT, hint=Text("How fast the error grows.", "误差增长的速率。")),
    Number("loss", r"\eta", Text("force lost", "失效比例"), "%", low=5.0, high=100.0, default=60.0, step=1.0,
           when=("place", COIL_PLACES), group=FAULT,
           hint=Text("How much of what is asked the coil does not deliver.", "线圈未能输出的指令比例。")),
    Number("at", "t_f", Text("fails at", "故障时刻"), "s", low=1.0, high=10.0, default=4.0, step=0.1,
           when=("place", PLACES), group=FAULT, hint=Text("When the fault sets in.", "故障开始的时间。")),
    Choice("statistic", "T", Text("statistic", "统计量"), default=ENERGY, group=TEST,
           options=((ENERGY, Text("sum of squares", "平方和")), (MEAN, Text("square of the mean", "均值的平方"))),
           hint=Text("Squares see every shape; the mean sees lasting errors sooner and sines hardly at all.",
                     "平方和对任何形状有效；均值对持久误差更灵敏，对正弦几乎无效。")),
    Number("window", "N", Text("window", "窗口"), low=1, high=150, default=25, scale="integer", group=TEST,
           hint=Text("Samples of 0.02 s that are judged together.", "一起判断的采样数，每个 0.02 s。")),
    Number("rate", r"\alpha", Text("false-alarm rate", "误报率"), low=1e-6, high=0.1, default=1e-3, scale="log", group=TEST,
           hint=Text("Of one window of one healthy member; the threshold follows from it.",
                     "健康时一个成员一个窗口的误报概率，阈值由它算出。")),
    Choice("loop", "", Text("the loop", "回路"), default=BLIND, group=LOOP,
           options=((OPEN, Text("open", "开环")), (BLIND, Text("closed, nobody acts", "闭环，无人处理")),
                    (SWITCH, Text("closed, acts on the verdict", "闭环，按判决切换"))),
           hint=Text("Acting: leave the accused sensor out, or stop using the accused coil.",
                     "切换：去掉被指认的传感器，或停用被指认的线圈。")),
    Number("force", "F", Text("known force", "已知力"), "N", low=0.0, high=4.0, default=1.0, step=0.1, group=LOOP,
           hint=Text("A sine on all three coils; the bank is told.", "三个线圈上的正弦力，诊断器知道它。")),
    Number("tone", "f", Text("its frequency", "其频率"), "Hz", low=0.2, high=5.0, default=0.5, scale="log", group=LOOP,
           hint=Text("The deck's own modes lie at 1.0, 1.2 and 1.5 Hz.", "平台自身的模态在 1.0、1.2 和 1.5 Hz。")),
    Number("stiffer", r"\delta", Text("springs stiffer than the model", "弹簧比模型硬"), "%", low=-20.0, high=20.0, default=0.0, step=0.5,
           group=LOOP, hint=Text("The bank keeps believing its model.", "诊断器仍相信原来的模型。")),
    *run_knobs(HORIZON),
)
