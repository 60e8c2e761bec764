"""Showdown: which controller isolates best, by which yardstick, and what real life does to each."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from app.engine.sampled import ResponseMeasures
from app.lesson.knobs import Choice, Number, Switch
from app.lesson.lesson import Check, Design, Formula, Job, Lesson, Outcome, Stage
from app.lesson.prose import read_prose
from app.plants import platform
from app.plants.body import with_longer_arrows
from app.text.words import Text

from ..toolkit.knobs import run_knobs
from ..toolkit.latex import number
from .pictures import SHORT, all_figures
from .players import DT, LQE, NAMES, OPEN, ORDER, OWN, PUBLISHED, RECURSIVE, Player, players
from .tasks import TASKS, exam
from .trials import Trials, carry, try_out
from .world import (
    BAND,
    RUN,
    Analysis,
    Response,
    World,
    analyse,
    band_rms,
    grid,
    measures,
    respond,
    shake,
    without_hardware,
    world_of,
)

GAIN = 1000.0  # times that the stage exaggerates motion: 20 µm are drawn as 0.15
FORCE_ARROWS = 20.0  # times that coil forces are drawn larger: tens of millinewtons here
BODY = replace(with_longer_arrows(platform.body(), FORCE_ARROWS, 3), gain=GAIN, caption=Text(
    "Solid: with the controller chosen. Ghost: the same platform without control. Green: coil forces",
    "实体：由所选控制器控制。虚影：同一平台无控制。绿色：线圈的力"))
WORK = (0.1, 10.0)  # Hz: the report's working band
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


@dataclass(frozen=True, eq=False)
class Match:
    """Everything about one design: five players in one world. `found` is what the longer computation measured."""

    world: World
    five: tuple[Player, ...]
    f: np.ndarray
    spectra: tuple[Analysis, ...]
    responses: tuple[Response | None, ...]
    measures: tuple[tuple[ResponseMeasures, ...] | None, ...]
    peak_db: np.ndarray
    band_db: np.ndarray
    rms: np.ndarray
    forces: np.ndarray
    run: tuple[np.ndarray, np.ndarray, np.ndarray]
    ghost: np.ndarray
    trials: Trials | None = field(default=None)


def compute(design: Design) -> Outcome:
    """All five players in the design's world: spectra by transfer function, the test without noise, one noisy run."""
    world, step = world_of(design), design["test"] == "step"
    five = players(design["v"], design["pair"])
    f = grid(world.parameters)
    spectra = tuple(analyse(world, player) for player in five)
    responses = tuple(respond(world, player, step) for player in five)
    reference = responses[0]
    assert reference is not None  # the deck alone is stable
    seed, kick = int(design["seed"]), design["kick"]
    chosen = five[ORDER.index(design["play"])]
    run = shake(world, chosen, seed, step, kick)
    ghost = run if chosen.id == OPEN else shake(without_hardware(world), five[0], seed, step, kick)
    base = spectra[0].density
    inside = (f >= BAND[0]) & (f <= BAND[1])
    peak_db, band_db, rms, forces = (np.zeros((5, 3)) for _ in range(4))
    for i, analysis in enumerate(spectra):
        if analysis.stable:
            S = analysis.density
            whole = band_rms(f, S, 0.0, np.inf)
            rms[i], forces[i] = whole[:3], whole[5:]
            peak_db[i] = 10 * np.log10(base[inside, :3].max(axis=0) / S[inside, :3].max(axis=0))
            band_db[i] = 20 * np.log10(band_rms(f, base, *BAND)[:3] / band_rms(f, S, *BAND)[:3])
    match = Match(world, five, f, spectra, responses, tuple(None if r is None else measures(r, reference) for r in responses),
                  peak_db, band_db, rms, forces, run, ghost[1])
    metrics = _metrics(match)
    return Outcome(design, {}, {}, metrics, _checks(match, metrics), None, (),
                   Stage(BODY, run[0], run[1], ghost[1], run[2]), _formulas(design, match), _live(design, match), match)


def _metrics(m: Match) -> dict[str, float]:
    found: dict[str, float] = {}
    for i, player in enumerate(m.five):
        found[f"{player.id}_stable"] = float(m.spectra[i].stable)
        for j, channel in enumerate(("vertical", "rotation", "horizontal")):
            found[f"{player.id}_{channel}_band_db"] = float(m.band_db[i, j])
            found[f"{player.id}_{channel}_peak_db"] = float(m.peak_db[i, j])
            found[f"{player.id}_{channel}_rms"] = float(m.rms[i, j])
        found[f"{player.id}_worst_db"] = float(m.band_db[i].min())
        found[f"{player.id}_force_rms"] = float(m.forces[i].max())
        measured = m.measures[i]
        if measured is not None:
            found[f"{player.id}_peak_force"] = measured[0].peak
            found[f"{player.id}_energy"] = measured[0].energy
    lqe, recursive = m.spectra[ORDER.index(LQE)], m.spectra[ORDER.index(RECURSIVE)]
    if lqe.stable and recursive.stable:
        work = (m.f >= WORK[0]) & (m.f <= WORK[1])
        found["filters_apart_db"] = float(np.abs(10 * np.log10(recursive.density[work, :3] / lqe.density[work, :3])).max())
    return found


def _checks(m: Match, metrics: dict[str, float]) -> tuple[Check, ...]:
    apart, worst = metrics.get("filters_apart_db", 99.0), metrics[f"{LQE}_worst_db"]
    unstable = [player.name for player, s in zip(m.five, m.spectra, strict=True) if not s.stable]
    return (
        Check("coincide", Text("steady and recursive LQG within 0.5 dB, 0.1–10 Hz", "稳态与递推 LQG 在 0.1–10 Hz 内相差不到 0.5 dB"),
              apart < 0.5, apart),
        Check("twenty", Text("the full LQG gains 20 dB or more in every channel, 0.5–3 Hz", "完整 LQG 在 0.5–3 Hz 内各通道都不低于 20 dB"),
              worst >= 20, worst),
        Check("stable", Text("every loop is stable", "所有回路都稳定"), not unstable, float(len(unstable))),
    )


def _formulas(design: Design, m: Match) -> tuple[Formula, ...]:
    i = ORDER.index(design["play"])
    values = r",\ ".join(number(float(v)) for v in m.band_db[i])
    return (
        Formula("loop", r"u = K(z)\,(y + v),\quad S_y = |(I - PK)^{-1}G|^2 S_w + |(I-PK)^{-1}PK|^2 S_v"),
        Formula("gain", rf"10\lg\frac{{\int S_{{\mathrm{{open}}}}}}{{\int S}} = ({values})\ \mathrm{{dB}}",
                Text("Vertical, rotation, horizontal, 0.5–3 Hz: the controller on the stage.",
                     "竖直、转动、水平，0.5–3 Hz：场景中的控制器。")),
    )


def _live(design: Design, m: Match) -> Text:
    unstable = [name for name, s in zip(SHORT, m.spectra, strict=True) if not s.stable]
    if unstable:
        return Text(f"Unstable in this world: {', '.join(n.en for n in unstable)}.",
                    f"在此条件下不稳定：{'、'.join(n.zh for n in unstable)}。")
    best = [_best(m.rms[1:, j]) for j in range(3)]
    return Text(f"Least RMS velocity: {SHORT[best[0]].en} vertically, {SHORT[best[1]].en} in rotation, "
                f"{SHORT[best[2]].en} horizontally.",
                f"速度均方根最小者：竖直 {SHORT[best[0]].zh}，转动 {SHORT[best[1]].zh}，水平 {SHORT[best[2]].zh}。")


def _best(rms: np.ndarray) -> int:
    """The player with the least value; within 1 % the first in order counts, for they tie."""
    return 1 + int(np.flatnonzero(rms <= 1.01 * rms.min())[0])


LESSON = Lesson(
    "showdown", 13, KNOBS, compute, all_figures, answer=1, tasks=TASKS, exam=exam,
    source="Platform report (003), chapters 2.3, 5.3 and 6, figures 3–25; limits of section 6.2",
    words=read_prose(Path(__file__).parent),
    job=Job(Text("Monte-Carlo, tolerances, costs", "蒙特卡罗、容差与代价"), try_out), carry=carry)

__all__ = ["LESSON"]
