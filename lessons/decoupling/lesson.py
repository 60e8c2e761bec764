"""Decoupling: three channels of the platform, a mixing, three simple loops; the report's pair as printed and our own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from app.engine.design import polynomial_roots
from app.lesson.figures import Figure
from app.lesson.knobs import Choice, Number, Poles, Switch
from app.lesson.lesson import Board, Check, Design, ExamItem, Formula, Lesson, Outcome, Stage
from app.lesson.prose import read_prose
from app.plants import platform_siso as siso
from app.plants.body import with_longer_arrows
from app.plants.platform_channels import HORIZONTAL
from app.text.words import Text

from ..toolkit.knobs import run_knobs
from ..toolkit.latex import number
from .loops import (
    A_EDGE,
    B_EDGE,
    BEST,
    FALLING,
    GAIN,
    HORIZON,
    MODEL,
    NONE,
    OPEN,
    OWN,
    POLES,
    PUBLISHED,
    SHAPED,
    WHITE,
    Controllers,
    Mixed,
    Shaken,
    Spectra,
    close,
    controllers,
    mixed,
    rightmost,
    shaken,
    spectra,
    suppression,
)
from .pictures import all_figures
from .tasks import TASKS

MIXING = Text("Mixing and its band", "混合与频带")
WORLD = Text("Ground and sensors", "地面与传感器")
CONTROL_LOW, CONTROL_HIGH, CONTROL_IM = -40.0, 5.0, 25.0
OBSERVER_LOW, OBSERVER_HIGH, OBSERVER_IM = -80.0, 5.0, 60.0
FORCE_ARROWS = 100.0  # times that coil forces are drawn larger: millinewtons here

BODY = replace(with_longer_arrows(MODEL.body, FORCE_ARROWS, 3), gain=4000.0, caption=Text(  # micrometres here
    "Solid: with control. Ghost: the same platform without control. Green: coil forces. Orange: the ground's motion",
    "实体：有控制。虚影：同一平台无控制。绿色：线圈的力。橙色：地面运动"))

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


@dataclass(frozen=True, eq=False)
class Story:
    """Mixing, controllers, spectra and the run of a design."""

    mixed: Mixed
    controllers: Controllers
    spectra: Spectra
    shaken: Shaken


def compute(design: Design) -> Outcome:
    """The mixing, the controllers y → u, the closed loop with its spectra, and one run on a shaking ground."""
    mix = mixed(design)
    built = controllers(design, mix.S)
    loop = close(built.whole, design["noise"])
    right, drift = rightmost(loop, built.whole)
    without = right
    if design["pitch"]:
        apart = siso.from_channels(built.vertical, None, built.horizontal, mixing=mix.S)
        without = rightmost(close(apart), apart)[0]
    seen, run = spectra(loop, design), shaken(loop, design)
    down = suppression(seen)
    metrics = {
        "vertical": float(down[0]), "rotation": float(down[1]), "horizontal": float(down[2]), "rightmost": right,
        "drift": max(drift, -1.0), "rightmost_pitch_open": without, "J": min(mix.J, 1e9), "J_plain": mix.best.plain_J,
        "J_best": mix.best.J, "a": mix.a, "b": mix.b, "a_best": mix.best.a, "b_best": mix.best.b,
        "placement_residual": built.placed.residual if built.placed else 0.0,
    }
    worst = max(right, drift)
    checks = (Check("stable", Text("every pole of the loop lies on the left", "闭环极点全部位于左半平面"), worst < 0, worst),
              Check("claim", Text("closing pitch leaves the loop stable", "闭合俯仰回路后仍稳定"), right < 0 or without >= 0, right))
    zeros = polynomial_roots(siso.rigid_polynomials(HORIZONTAL, mix.S)[0])
    own = built.whole.poles if built.whole.n else np.zeros(0, dtype=complex)
    return Outcome(design, {"S": mix.S}, {"loop": loop.poles, "controller": own, "zeros of P_h": zeros}, metrics, checks, None,
                   _boards(design, zeros), Stage(BODY, run.t, run.x, run.bare, np.hstack([run.u, run.ground])),
                   _formulas(mix, built), _live(metrics), Story(mix, built, seen, run))


def _boards(design: Design, zeros: np.ndarray) -> tuple[Board, Board]:
    drawn = tuple(complex(z) for z in zeros if abs(z) > 1e-9)
    also = (("horizontal", POLES),)
    return (
        Board("control", Text("horizontal: first roots of Φ", "水平：Φ 的前四个根"), design["control_poles"],
              "control_poles", zeros=drawn, role="plant", side="left", re_low=CONTROL_LOW, re_high=CONTROL_HIGH,
              im_high=CONTROL_IM, also=also),
        Board("observer", Text("horizontal: last roots of Φ", "水平：Φ 的后四个根"), design["observer_poles"],
              "observer_poles", zeros=drawn, role="estimate", side="right", re_low=OBSERVER_LOW, re_high=OBSERVER_HIGH,
              im_high=OBSERVER_IM, also=also),
    )


def _formulas(mix: Mixed, built: Controllers) -> tuple[Formula, ...]:
    out = [
        Formula("law", r"u = T_u\, S \,\mathrm{diag}(C_v, C_\theta, C_h)\, T_y\, y"),
        Formula("mixing", rf"S_{{23}} = \begin{{bmatrix}} 1 & {number(mix.b)} \\ {number(mix.a)} & 1 \end{{bmatrix}}, \quad "
                          rf"\det = {number(1 - mix.a * mix.b)}"),
        Formula("index", rf"J = \sum_\omega \frac{{|G'_{{23}}|^2}}{{|G'_{{22}}|^2}} + \frac{{|G'_{{32}}|^2}}{{|G'_{{33}}|^2}} = "
                         rf"{number(mix.J)}"),
    ]
    p = built.placed
    solved = rf", \quad E: {_column(p.E)}, \; F: {_column(p.F)}" if p else ""
    out.append(Formula("E", rf"A E + B F = \Phi{solved}", Text(
        "Coefficients from the highest power of s down, in rad/s; the controller is −F/E.",
        "系数按 s 的降幂排列，单位 rad/s；控制器为 −F/E。")))
    return tuple(out)


def _column(p: np.ndarray) -> str:
    """Coefficients as a column, two digits where they are large."""
    def entry(c: float) -> str:
        mantissa, exponent = f"{c:.1e}".split("e")
        return f"{c:.3g}" if 1e-3 <= abs(c) < 999.5 or c == 0 else rf"{mantissa} \cdot 10^{{{int(exponent)}}}"
    rows = r" \\ ".join(entry(float(c)) for c in p)
    return rf"\begin{{bmatrix}} {rows} \end{{bmatrix}}"


def _live(m: Mapping[str, float]) -> Text:
    right, drift = (f"{v:+.3g}".replace("-", "−") for v in (m["rightmost"], m["drift"]))
    if m["rightmost"] >= 0:
        if m["rightmost_pitch_open"] < 0:
            return Text(f"Closing pitch has made the loop unstable: rightmost pole {right} rad/s.",
                        f"闭合俯仰回路使系统失稳：最右极点 {right} rad/s。")
        return Text(f"The loop is unstable: rightmost pole {right} rad/s.",
                    f"闭环不稳定：最右极点 {right} rad/s。")
    words = [f"{0.0 - round(v):+.0f} dB".replace("-", "−") for v in (m["vertical"], m["horizontal"], m["rotation"])]
    tail = Text(f" C_v keeps a pole at {drift} rad/s.", f" C_v 有极点 {drift} rad/s。") if m["drift"] > 0 else Text("", "")
    return Text(f"Peaks against no control: vertical {words[0]}, horizontal {words[1]}, rotation {words[2]}.{tail.en}",
                f"峰值与无控制相比：竖直 {words[0]}，水平 {words[1]}，转动 {words[2]}。{tail.zh}")


def figures(outcome: Outcome) -> tuple[Figure, ...]:
    """Spectra, channels and mixing, controllers and poles, velocities, forces."""
    return all_figures(outcome)


def pick(outcome: Outcome, a: float, b: float) -> Mapping[str, Any]:
    """A click on the map of J takes its a and b."""
    return {"mix": OWN, "a": float(np.clip(a, -A_EDGE, A_EDGE)), "b": float(np.clip(b, -B_EDGE, B_EDGE))}


def exam(seed: int) -> ExamItem:
    """A = s − a, B = k, Φ = (s + c)²: E = s + a + 2c and F = (c + a)²/k."""
    rng = np.random.default_rng(seed)
    a, c, k = int(rng.integers(1, 6)), int(rng.integers(2, 9)), int(rng.integers(2, 6))
    return ExamItem({"a": str(a), "c": str(c), "k": str(k)}, (c + a) ** 2 / k, 1e-3 * (c + a) ** 2 / k)


LESSON = Lesson("decoupling", 11, KNOBS, compute, figures, answer=2, tasks=TASKS, exam=exam,
                source="Platform report (003), chapter 2: equations (2)–(38), figures 3–6; section 5.3.3",
                words=read_prose(Path(__file__).parent), pick=pick)
