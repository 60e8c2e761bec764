"""Figures of the lesson, from an outcome and nothing else."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from app.engine import Plant, frequency_response
from app.engine.design import polynomial_roots
from app.lesson.figures import (
    FLOOR,
    Curve,
    Figure,
    FrequencyFigure,
    MapFigure,
    PlaneFigure,
    Point,
    TableFigure,
    TimeFigure,
)
from app.lesson.lesson import Outcome
from app.plants import platform_siso as siso
from app.plants.platform_channels import T_y
from app.text.words import Text, same

from .loops import A_EDGE, B_EDGE, CHANNELS, GRID_A, GRID_B, NONE, OWN, PLATFORM, PUBLISHED, channels
from .study import Study

SPECTRA_TAB, CHANNEL_TAB = Text("Spectra", "频谱"), Text("Channels", "通道")
LOOP_TAB, TIME_TAB, FORCE_TAB = Text("Controllers", "控制器"), Text("Time", "时间"), Text("Forces", "控制力")
NANO = 1e9
LOW, HIGH = 1e-9, 1e7  # nm/s/√Hz
BARE, CLOSED, SENSOR = Text("no control", "无控制"), Text("closed", "闭环"), Text("sensor noise", "传感器噪声")
VERTICAL, ROTATION, HORIZONTAL = (Text("vertical", "竖直平动"), Text("rotation", "俯仰转动"), Text("horizontal", "水平平动"))
DOWN = ((Text("down 10 dB or more", "降低 10 dB 以上"), "force"), (Text("down 3 to 10 dB", "降低 3～10 dB"), "second"),
        (Text("down less", "略有降低"), "plant"), (Text("up", "升高"), "muted"), (Text("least", "最小点"), "error"))
CONTROLLER_SWEEP = np.geomspace(1e-3, 1e3, 160)
RE_LOW, RE_HIGH, IM_HIGH = -20.0, 5.0, 20.0


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Spectra, channels, controllers, time, forces: at most three in a tab."""
    return (_spectrum(outcome, 0, "vertical", VERTICAL), _spectrum(outcome, 2, "horizontal", HORIZONTAL),
            _spectrum(outcome, 1, "rotation", ROTATION), _dominance(outcome), _map(outcome), _mixing(outcome),
            _magnitudes(outcome), _poles(outcome), _facts(outcome), _velocity(outcome, 0, "vertical", VERTICAL),
            _velocity(outcome, 2, "horizontal", HORIZONTAL), _velocity(outcome, 1, "rotation", ROTATION),
            _force_spectrum(outcome), _forces(outcome))


def _nano(density: np.ndarray) -> np.ndarray:
    return np.clip(NANO * np.sqrt(np.maximum(density, 0.0)), LOW, HIGH)


def _spectrum(outcome: Outcome[Study], i: int, name: str, title: Text) -> FrequencyFigure:
    s, gain = outcome.study.spectra, outcome.metrics[name]
    noise = np.full(len(s.f), outcome.design["noise"] ** 2 / 2)
    caption = (Text("The loop is unstable: what is drawn is no spectrum.", "闭环不稳定：所画曲线不是真正的频谱。")
               if outcome.metrics["rightmost"] >= 0 else
               Text("Peak in 0.1–10 Hz as without control.", "0.1～10 Hz 内峰值与无控制时相同。") if abs(gain) < 0.05 else
               Text(f"Peak in 0.1–10 Hz down by {gain:.1f} dB, before sensor noise.",
                    f"0.1～10 Hz 内峰值降低 {gain:.1f} dB（不计传感器噪声）。") if gain >= 0 else
               Text(f"Peak in 0.1–10 Hz up by {-gain:.1f} dB.", f"0.1～10 Hz 内峰值升高 {-gain:.1f} dB。"))
    return FrequencyFigure(f"spectrum-{name}", Text(f"{title.en} velocity", f"{title.zh}速度"), s.f,
                           (Curve(BARE, _nano(s.bare[:, i]), "muted"), Curve(CLOSED, _nano(s.closed[:, i]), "plant"),
                            Curve(SENSOR, _nano(noise), "disturbance", "dash", 1.6)), "[nm/s/√Hz]", caption=caption,
                           tab=SPECTRA_TAB, window=(1.0, 1e6))


# --- channels ----------------------------------------------------------------------------------------------------------
def _dominance(outcome: Outcome[Study]) -> FrequencyFigure:
    """Row ratios of rotation and horizontal with the mixing of the design."""
    mixed, plain = outcome.study.mixed, channels()
    G = plain.response @ mixed.S
    rows = np.abs(np.stack([G[:, 1, 2] / G[:, 1, 1], G[:, 2, 1] / G[:, 2, 2]], axis=1))
    width = np.gradient(np.log(CHANNELS))
    lost = float(width[(rows > 1).any(axis=1)].sum() / width.sum())
    curves = [Curve(Text("into rotation", "进入转动通道"), np.clip(rows[:, 0], 1e-4, 1e3), "plant"),
              Curve(Text("into horizontal", "进入水平通道"), np.clip(rows[:, 1], 1e-4, 1e3), "estimate", "dash"),
              Curve(Text("equal to the diagonal", "与对角元相等"), np.ones(len(CHANNELS)), "reference", "dot", 1.4)]
    return FrequencyFigure("dominance", Text("off the diagonal over on it, by row", "各行非对角元与对角元之比"), CHANNELS,
                           tuple(curves), Text("|off-diagonal| / |diagonal|", "|非对角元| / |对角元|"), tab=CHANNEL_TAB, window=(1e-3, 1e2),
                           caption=Text(f"Dominance is lost on {100 * lost:.0f} % of the decades from 0.1 to 10 Hz; vertical "
                                        "is decoupled exactly.",
                                        f"0.1～10 Hz（对数刻度）内有 {100 * lost:.0f} % 失去对角占优；竖直通道完全解耦。"))


def _map(outcome: Outcome[Study]) -> MapFigure:
    mixed = outcome.study.mixed
    ratio = 10 * np.log10(np.minimum(mixed.map, 1e30) / mixed.best.plain_J)
    values = np.select([ratio <= -10, ratio <= -3, ratio < 0], [0, 1, 2], 3)
    a, b = mixed.best.a, mixed.best.b
    inside = abs(a) <= A_EDGE and abs(b) <= B_EDGE
    if inside:
        values[int(np.argmin(np.abs(GRID_B - b))), int(np.argmin(np.abs(GRID_A - a)))] = 4
    share = 100 * float(np.mean(values <= 1))
    tail = Text("", "") if inside else Text(" The optimum lies outside the map.", " 最优点在图外。")
    return MapFigure("index", Text("J(a, b) against no mixing", "J(a, b) 与不混合时相比"), GRID_A, GRID_B, values, DOWN,
                     "a", "b", (float(np.clip(mixed.a, -A_EDGE, A_EDGE)), float(np.clip(mixed.b, -B_EDGE, B_EDGE))),
                     caption=Text(f"On {share:.0f} % of the map J comes down by 3 dB or more; click a point to use it.{tail.en}",
                                  f"图中 {share:.0f} % 的区域使 J 降低 3 dB 以上；点击即可选用。{tail.zh}"), tab=CHANNEL_TAB)


def _mixing(outcome: Outcome[Study]) -> TableFigure:
    mixed, best = outcome.study.mixed, outcome.study.mixed.best

    def row(name: Text, a: float, b: float, J: float) -> tuple[Text | str, ...]:
        return (name, _short(a), _short(b), f"{J / best.count:.3g}", _decibel(J / best.plain_J))
    rows = (row(Text("no mixing", "不混合"), 0.0, 0.0, best.plain_J),
            row(Text("closed form", "闭式初值"), best.start[0], best.start[1], best.start_J),
            row(Text("optimum", "最优"), best.a, best.b, best.J), row(Text("in use", "现在使用"), mixed.a, mixed.b, mixed.J))
    d = outcome.design
    worse = best.start_J > best.plain_J
    caption = (Text(f"{d['f_low']:g}–{d['f_high']:g} Hz. The closed form is worse than nothing: a resonance lies in the band.",
                    f"{d['f_low']:g}～{d['f_high']:g} Hz。闭式初值比不混合还差：频带内有共振。") if worse else
               Text(f"{d['f_low']:g}–{d['f_high']:g} Hz, mean over {best.count} frequencies.",
                    f"{d['f_low']:g}～{d['f_high']:g} Hz，{best.count} 个频率点的平均。"))
    return TableFigure("mixing", Text("mixing of the last two inputs", "后两路输入的混合"),
                       (Text("choice", "方案"), same("a"), same("b"), Text("J per frequency", "每点平均 J"), same("dB")), rows,
                       caption=caption, tab=CHANNEL_TAB)


def _short(value: float) -> str:
    return f"{value:.4g}".replace("-", "−")


def _decibel(ratio: float) -> str:
    return f"{10 * np.log10(max(ratio, 1e-30)):+.1f}".replace("-", "−")


# --- controllers -------------------------------------------------------------------------------------------------------
def _magnitudes(outcome: Outcome[Study]) -> FrequencyFigure:
    built = outcome.study.controllers
    curves = []
    for name, role, dash, plant in ((Text("vertical", "竖直"), "plant", "solid", built.vertical),
                                    (Text("horizontal", "水平"), "estimate", "dash", built.horizontal),
                                    (Text("rotation", "转动"), "force", "dot", built.rotation)):
        size = np.zeros(len(CONTROLLER_SWEEP)) if plant is None else _size(plant)  # nothing is drawn of a loop that is open
        words = name if plant is not None else Text(f"{name.en} (open)", f"{name.zh}（开环）")
        curves.append(Curve(words, np.clip(size, FLOOR, 1e8), role, dash))  # type: ignore[arg-type]
    phase = _phase(built.vertical)
    caption = (Text("The vertical channel is open.", "竖直通道开环。") if phase is None else
               Text(f"Between 0.1 and 10 Hz the vertical controller's phase strays from −180° by at most {phase:.2g}°.",
                    f"0.1～10 Hz 内，竖直控制器的相位偏离 −180° 最多 {phase:.2g}°。"))
    return FrequencyFigure("controllers", Text("size of the three controllers", "三个控制器的幅频"), CONTROLLER_SWEEP,
                           tuple(curves), "|C| [N s/m]", caption=caption, tab=LOOP_TAB, window=(1e2, 1e6))


def _size(plant: Plant) -> np.ndarray:
    return np.abs(frequency_response(plant.A, plant.B, plant.C, plant.D, 2 * np.pi * CONTROLLER_SWEEP)[:, 0, 0])


def _phase(plant: Plant | None) -> float | None:
    if plant is None:
        return None
    H = frequency_response(plant.A, plant.B, plant.C, plant.D, 2 * np.pi * CHANNELS[::4])[:, 0, 0]
    return float(np.degrees(np.abs(np.angle(-H))).max())


def _poles(outcome: Outcome[Study]) -> PlaneFigure:
    loop, own = outcome.poles["loop"], outcome.poles["controller"]
    zeros = outcome.poles["zeros of P_h"]
    points = [Point(float(p.real), float(p.imag), role, mark)  # type: ignore[arg-type]
              for group, role, mark in ((zeros, "reference", "circle"), (own, "force", "dot"), (loop, "plant", "cross"))
              for p in group if RE_LOW <= p.real <= RE_HIGH and abs(p.imag) <= IM_HIGH]
    right = outcome.metrics["rightmost"]
    drift = outcome.metrics["drift"]
    at = f"{right:.3g}".replace("-", "−")
    words = Text(f"Rightmost pole of the loop: {at} rad/s.", f"闭环最右极点：{at} rad/s。")
    if drift > 0:
        years, size = 1 / (drift * 3.156e7), f"{drift:.2g}".replace("-", "−")
        words = Text(f"{words.en} C_v adds one at +{size} rad/s: e-fold in {years:.0f} years.",
                     f"{words.zh} C_v 另有一个 +{size} rad/s：{years:.0f} 年增大到 e 倍。")
    return PlaneFigure("poles", Text("poles of the loop, near the origin", "闭环极点（原点附近）"), (), tuple(points), "Re s",
                       "Im s", (RE_LOW, RE_HIGH), (-IM_HIGH, IM_HIGH), unstable=True, tab=LOOP_TAB,
                       caption=Text(words.en + " Circles: zeros of P_h. Dots: poles of the controllers.",
                                    words.zh + " 圆圈：P_h 的零点；圆点：控制器的极点。"))


def _facts(outcome: Outcome[Study]) -> TableFigure:
    """What (26), (31) and (32) are, and what is in use."""
    cv, ch = polynomial_roots(siso.CV_DENOMINATOR), polynomial_roots(siso.CH_DENOMINATOR)
    built, design = outcome.study.controllers, outcome.design
    rows: list[tuple[Text | str, ...]] = [
        (Text("C_v printed: poles", "报告的 C_v：极点"), ", ".join(_root(p) for p in cv)),
        (Text("C_v printed: gain in band", "报告的 C_v：带内增益"), "−31 252 N s/m"),
        (Text("C_v printed: used as", "报告的 C_v：接法"), same("v = +C_v z")),
        (Text("C_h printed: rightmost pole", "报告的 C_h：最右极点"), _root(ch[np.argmax(np.real(ch))])),
        (Text("C_h printed: used as", "报告的 C_h：接法"), same("v = −C_h z")),
    ]
    for name, chosen, plant in ((Text("vertical in use", "竖直，现用"), design["vertical"], built.vertical),
                                (Text("horizontal in use", "水平，现用"), design["horizontal"], built.horizontal)):
        if plant is None:
            rows.append((name, Text("open", "开环")))
        elif chosen == PUBLISHED:
            rows.append((name, Text("as printed", "照报告")))
        else:
            worst = float(np.max(np.real(plant.poles))) if plant.n else -np.inf
            rows.append((name, Text(f"order {plant.n}, {'unstable by itself' if worst > 0 else 'stable'}",
                                    f"{plant.n} 阶，{'自身不稳定' if worst > 0 else '自身稳定'}")))
    return TableFigure("facts", Text("what the controllers are", "控制器的真面目"), (Text("fact", "项目"), Text("value", "数值")),
                       tuple(rows), tab=LOOP_TAB,
                       caption=Text("Poles in rad/s, recomputed from the printed coefficients.", "极点单位 rad/s，由报告印出的系数重算。"))


def _root(p: complex) -> str:
    return f"{p.real:+.3g}".replace("-", "−") if abs(p.imag) < 1e-12 else f"{p.real:+.3g} ± {abs(p.imag):.3g}j".replace("-", "−")


# --- time --------------------------------------------------------------------------------------------------------------
def _velocity(outcome: Outcome[Study], i: int, name: str, title: Text) -> TimeFigure:
    run = outcome.study.shaken
    row = 1e6 * (T_y[i] @ PLATFORM.C)
    now, bare = run.x @ row, run.bare @ row
    size, without = float(np.std(now)), float(np.std(bare))
    return TimeFigure(f"velocity-{name}", Text(f"{title.en} velocity", f"{title.zh}速度"), run.t,
                      (Curve(BARE, bare, "muted"), Curve(CLOSED, np.clip(now, -1e4, 1e4), "plant")), "[µm/s]", tab=TIME_TAB,
                      caption=Text(f"Root mean square {size:.2g} µm/s, without control {without:.2g} µm/s.",
                                   f"均方根 {size:.2g} µm/s，无控制时 {without:.2g} µm/s。"))


def _force_spectrum(outcome: Outcome[Study]) -> FrequencyFigure:
    s = outcome.study.spectra
    size = np.clip(1e3 * np.sqrt(np.maximum(s.forces, 0.0)), 1e-8, 1e4)
    inside = (s.f >= 0.1) & (s.f <= 10)
    names = (Text("left vertical", "左竖直"), Text("right vertical", "右竖直"), Text("horizontal", "水平"))
    curves = tuple(Curve(n, size[:, j], role, dash)  # type: ignore[arg-type]
                   for j, (n, role, dash) in enumerate(zip(names, ("plant", "estimate", "force"), ("solid", "dash", "dot"),
                                                           strict=True)))
    return FrequencyFigure("force-spectrum", Text("forces asked of the coils", "线圈出力的频谱"), s.f, curves, "[mN/√Hz]",
                           tab=FORCE_TAB, window=(1e-2, 10.0),
                           caption=Text(f"Largest between 0.1 and 10 Hz: {float(size[inside].max()):.3g} mN/√Hz.",
                                        f"0.1～10 Hz 内最大 {float(size[inside].max()):.3g} mN/√Hz。"))


def _forces(outcome: Outcome[Study]) -> TimeFigure:
    run = outcome.study.shaken
    u, largest = np.clip(1e3 * run.u, -1e7, 1e7), 1e3 * float(np.abs(run.u).max())
    names = (Text("left vertical", "左竖直"), Text("right vertical", "右竖直"), Text("horizontal", "水平"))
    curves = tuple(Curve(n, u[:, j], role, dash)  # type: ignore[arg-type]
                   for j, (n, role, dash) in enumerate(zip(names, ("plant", "estimate", "force"), ("solid", "dash", "dot"),
                                                           strict=True)))
    return TimeFigure("forces", Text("forces on the shaking ground", "地面振动下的控制力"), run.t, curves, "[mN]", tab=FORCE_TAB,
                      caption=Text(f"Largest force: {largest:.3g} mN.",
                                   f"最大控制力：{largest:.3g} mN。") if outcome.design["mix"] == NONE else
                      Text(f"Largest force: {largest:.3g} mN, after the mixing.",
                           f"最大控制力：{largest:.3g} mN（经混合后）。"))


def pick(outcome: Outcome[Study], a: float, b: float) -> Mapping[str, str | float]:
    """A click on the map of J takes its a and b."""
    return {"mix": OWN, "a": float(np.clip(a, -A_EDGE, A_EDGE)), "b": float(np.clip(b, -B_EDGE, B_EDGE))}
