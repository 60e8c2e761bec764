"""Knobs of the lesson: who is on the stage, noise believed and true, the test, and what real life adds."""

from __future__ import annotations

from app.lesson.knobs import Choice, Number, Switch
from app.text.words import Text

from ..toolkit.knobs import run_knobs
from .players import DT, LQE, NAMES, ORDER, OWN, PUBLISHED
from .world import RUN

REAL = Text("Real life", "实际因素")


def _error(name: str, symbol: str, label: Text, unit: str, high: float, hint: Text) -> Number:
    return Number(name, symbol, label, unit, low=-high, high=high, default=0.0, hint=hint, group=REAL)


KNOBS = (
    Choice("play", "", Text("on the stage", "场景中的控制器"), default=LQE,
           options=tuple(zip(ORDER, NAMES, strict=True)),
           hint=Text("The solid deck is under this controller, the ghost under none; both feel the same ground.",
                     "实体平台由它控制，虚影无控制；二者的地面扰动相同。")),
    Number("v", "V", Text("believed noise V", "设定的噪声 V"), "(m/s)² s", low=1e-18, high=1e-7,
           default=1e-10, scale="log", hint=Text("The intensity V in the design of all three LQGs.", "三个 LQG 设计时所用的强度 V。")),
    Number("sensor", "V_0", Text("true noise V₀", "真实的噪声 V₀"), "(m/s)² s", low=1e-18, high=1e-7, default=1e-10,
           scale="log", hint=Text("What the sensors really add. No controller is told.", "传感器实际的噪声强度；任何控制器都不知道。")),
    Choice("pair", "", Text("SISO loops", "SISO 回路"), default=OWN,
           options=((OWN, Text("ours, made for 1 kHz", "自行设计，适合 1 kHz")), (PUBLISHED, Text("the report's", "报告给出的"))),
           hint=Text("C_v and C_h; the pitch loop stays open in both.", "C_v 与 C_h；两种情形俯仰回路都开环。")),
    Choice("ground", "", Text("ground motion", "地面运动"), default="white",
           options=(("white", Text("white, σ_w² = 10⁻¹² m² s", "白噪声，σ_w² = 10⁻¹² m² s")),
                    ("shaped", Text("falling as 1/f²", "按 1/f² 衰减"))),
           hint=Text("White displacement as in the report's design, or a density like that of real ground.",
                     "报告设计时所用的白位移，或接近真实地面的谱。")),
    Choice("test", "", Text("test", "时域试验"), default="touch",
           options=(("touch", Text("a touch of the deck", "轻触平台")), ("step", Text("a step of the ground", "地面阶跃"))),
           hint=Text("A touch changes the velocities at once; the step moves the ground 20 µm up and aside.",
                     "轻触使速度突变；阶跃使地面向上并横向移动 20 µm。")),
    Switch("limited", "", Text("coils have a limit", "线圈有限幅"), default=False, group=REAL,
           hint=Text("Clip what each coil can give.", "限制每个线圈的出力。")),
    Number("limit", r"u_{\max}", Text("coil limit", "线圈限幅"), "N", low=1e-3, high=1.0, default=0.05, scale="log",
           when=("limited", (True,)), group=REAL, hint=Text("Most that a coil gives, either way.", "线圈在两个方向上的最大力。")),
    Choice("driver", "", Text("coil drivers", "线圈驱动器"), default="ideal", group=REAL,
           options=(("ideal", Text("ideal", "理想")), ("first", Text("first-order lag", "一阶滞后")),
                    ("second", Text("second-order lag", "二阶滞后"))),
           hint=Text("How the force follows the command.", "力跟随指令的方式。")),
    Number("bandwidth", "f_b", Text("driver bandwidth", "驱动带宽"), "Hz", low=1.0, high=1000.0, default=100.0, scale="log",
           when=("driver", ("first", "second")), group=REAL, hint=Text("The driver is 3 dB down there.", "驱动器在此频率下降 3 dB。")),
    Number("delay", r"\tau", Text("computing delay", "计算时延"), "ms", low=0.0, high=10.0, default=0.0, step=0.1, group=REAL,
           hint=Text("From reading the sensors to giving the command; fractions of a sample count.",
                     "从读取传感器到给出指令的时间，可为采样周期的非整数倍。")),
    Number("adc", "q", Text("converter step", "ADC 量化步长"), "µm/s", low=0.0, high=1000.0, default=0.0, step=5.0, group=REAL,
           hint=Text("Readings are rounded to whole steps; the spectra count it as noise of q²/12.",
                     "读数按整步取整；频谱中按 q²/12 的噪声计。")),
    Number("drift", r"\sigma_b", Text("bias drift", "零偏漂移"), "µm/s/√s", low=0.0, high=20.0, default=0.0, step=0.1, group=REAL,
           hint=Text("The zero of every sensor walks at random; this far in one second.", "每个传感器的零点随机游走，一秒内约走这么远。")),
    _error("stiffness", r"\varepsilon_k", Text("stiffness error", "刚度误差"), "%", 30.0,
           Text("The true springs are stiffer by this much than the designer believes.", "真实弹簧比设计者所认为的硬这么多。")),
    _error("damping", r"\varepsilon_c", Text("damping error", "阻尼误差"), "%", 90.0,
           Text("The true dashpots differ by this much.", "真实阻尼与设计值的偏差。")),
    _error("placement", r"\varepsilon_s", Text("sensor placement error", "传感器安装误差"), "mm", 60.0,
           Text("The sensors stand this much farther from the middle.", "传感器比设计位置离中心远这么多。")),
    *run_knobs(RUN * DT - DT),
)
