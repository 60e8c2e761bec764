"""Figures of the lesson: channels, sensors, inputs, the test in time, the run on the stage."""

from __future__ import annotations

import numpy as np

from app.engine.sampled import ResponseMeasures
from app.lesson.figures import FLOOR, Curve, Dash, Figure, FrequencyFigure, TimeFigure
from app.lesson.lesson import Outcome
from app.text.words import Text, same

from .players import NAMES, ORDER, SHORT, gain_gap
from .scores import tables
from .study import Study

CHANNEL_TAB, SENSOR_TAB, INPUT_TAB = Text("Channels", "通道"), Text("Sensors", "传感器"), Text("Inputs", "输入")
TIME_TAB, RUN_TAB = Text("Test", "时域试验"), Text("Stage", "场景运行")
CHANNELS = (("vertical", Text("vertical", "竖直平动"), "µm/s"), ("rotation", Text("rotation, (VL − VR)/2", "转动，(VL − VR)/2"), "µm/s"),
            ("horizontal", Text("horizontal", "水平平动"), "µm/s"))
LOOKS: tuple[tuple[str, Dash], ...] = (
    ("muted", "solid"), ("disturbance", "solid"), ("plant", "solid"), ("reference", "dash"), ("error", "dash"),
)


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Everything on the right of the stage."""
    return (*(_channel(outcome, j) for j in range(3)), *(_sensor(outcome, j) for j in range(3)), _input(outcome, 0),
            _input(outcome, 2), _gain(outcome), *(_test(outcome, j) for j in range(3)), _stage_velocity(outcome),
            _stage_force(outcome), *tables(outcome))


def _curves(outcome: Outcome[Study], column: int, scale: float = 1.0, skip_open: bool = False) -> list[Curve]:
    """A density of every player; an unstable one lies below the axis."""
    m = outcome.study
    return [Curve(NAMES[i], np.maximum(scale * m.spectra[i].density[:, column], FLOOR), role, dash, _width(outcome, i))
            for i, (role, dash) in enumerate(LOOKS) if not (skip_open and i == 0)]


def _width(outcome: Outcome[Study], i: int) -> float:
    return 2.6 if ORDER[i] == outcome.design["play"] else 1.6


def _measured(outcome: Outcome[Study], column: int, scale: float = 1.0) -> list[Curve]:
    """The Monte-Carlo of the controller on the stage with its band of two standard errors, on the figure's frequencies."""
    m, i = outcome.study, ORDER.index(outcome.design["play"])
    if m.trials is None or m.trials.noise[i] is None:
        return []
    tried = m.trials.noise[i]
    low, high = tried.band()
    keep = tried.frequency > 1.5 * tried.frequency[1]

    def on_grid(values: np.ndarray) -> np.ndarray:
        return np.exp(np.interp(np.log(m.f), np.log(tried.frequency[keep]), np.log(np.maximum(scale * values[keep, column], FLOOR))))

    return [Curve(Text("Monte-Carlo", "蒙特卡罗"), on_grid(tried.density), "estimate", "dot", 1.6),
            Curve(Text("band", "置信带"), on_grid(low), "estimate", "dot", 0.8),
            Curve(Text("upper edge", "上沿"), on_grid(high), "estimate", "dot", 0.8)]


def _noise(m: Study, share: float) -> Curve:
    level = 2 * m.world.sensor * share * 1e12
    return Curve(Text("sensor noise", "测量噪声"), np.full(len(m.f), max(level, FLOOR)), "second", "dot", 1.6)


def _window(curves: list[Curve]) -> tuple[float, float]:
    top = max(float(c.y.max()) for c in curves)
    return (top * 1e-7, top)


def _each(m: Study, values: list[str]) -> tuple[str, str]:
    """The value of every controller in both languages; an unstable one has none."""
    said = [(n.en, n.zh, v, v) if s.stable else (n.en, n.zh, "unstable", "不稳定")
            for n, v, s in zip(SHORT[1:], values[1:], m.spectra[1:], strict=True)]
    return ", ".join(f"{en} {v}" for en, _, v, _ in said), "，".join(f"{zh} {v}" for _, zh, _, v in said)


def _channel(outcome: Outcome[Study], j: int) -> FrequencyFigure:
    m = outcome.study
    key, name, _ = CHANNELS[j]
    curves = [*_curves(outcome, j), _noise(m, 0.5), *_measured(outcome, j, 1e12)]
    said, sagt = _each(m, [f"{db:.1f}" for db in m.band_db[:, j]])
    return FrequencyFigure(f"channel_{key}", Text(f"velocity: {name.en}", f"速度：{name.zh}"), m.f, tuple(curves), "[(µm/s)²/Hz]",
                           Text(f"Suppression over 0.5–3 Hz in dB: {said}.", f"0.5–3 Hz 内的抑制（dB）：{sagt}。"), CHANNEL_TAB,
                           _window(curves))


def _sensor(outcome: Outcome[Study], j: int) -> FrequencyFigure:
    m = outcome.study
    column, key, name = ((2, "left_h", Text("left horizontal, HL", "左水平 HL")), (3, "left_v", Text("left vertical, VL", "左竖直 VL")),
                         (4, "right_v", Text("right vertical, VR", "右竖直 VR")))[j]
    curves = [*_curves(outcome, column), _noise(m, 1.0)]
    i = ORDER.index(outcome.design["play"])
    if not m.spectra[i].stable:
        said = Text("The controller on the stage does not hold this loop.", "场景中的控制器不能使回路稳定。")
    else:
        before, now = (float(m.spectra[k].density[:, column].max()) for k in (0, i))
        gain = 10 * np.log10(before / now)
        en, zh = ("lower", "低") if gain >= 0 else ("higher", "高")
        said = (Text("On the stage is the platform without control.", "场景中是无控制的平台。") if i == 0 else
                Text(f"{NAMES[i].en}: the highest point is {abs(gain):.1f} dB {en} than without control.",
                     f"{NAMES[i].zh}：最高点比无控制时{zh} {abs(gain):.1f} dB。"))
    return FrequencyFigure(f"sensor_{key}", Text(f"true velocity at {name.en}", f"真实速度：{name.zh}"), m.f, tuple(curves),
                           "[(µm/s)²/Hz]", said, SENSOR_TAB, _window(curves))


def _input(outcome: Outcome[Study], j: int) -> FrequencyFigure:
    m = outcome.study
    name = (Text("left vertical coil u1", "左竖直线圈 u1"), same(""), Text("horizontal coil u3", "水平线圈 u3"))[j]
    curves = [*_curves(outcome, 5 + j, 1e6, True), *_measured(outcome, 5 + j, 1e6)]
    said, sagt = _each(m, [f"{1e3 * v:.3g}" for v in m.forces[:, j]])
    return FrequencyFigure(f"input_{j}", Text(f"command: {name.en}", f"指令：{name.zh}"), m.f, tuple(curves), "[mN²/Hz]",
                           Text(f"RMS in mN: {said}.", f"均方根（mN）：{sagt}。"), INPUT_TAB, _window(curves))


def _gain(outcome: Outcome[Study]) -> TimeFigure:
    t, away = gain_gap(outcome.design["v"])
    m = outcome.study
    apart = outcome.metrics.get("filters_apart_db")
    en = f"It has {100 * away[-1]:.2g} % to go after 20 s."
    zh = f"20 s 后还差 {100 * away[-1]:.2g} %。"
    if apart is not None:
        en += f" Settled, its loop differs from the steady LQE's by at most {apart:.2f} dB."
        zh += f" 稳定之后，其回路与稳态 LQE 的谱最多相差 {apart:.2f} dB。"
    if m.trials is not None and m.trials.learning is not None:
        first, last = (" / ".join(f"{100 * v:.2g}" for v in m.trials.learning[k]) for k in (0, -1))
        count = len(m.trials.learning)
        en += f" On one seed (vertical/rotation/horizontal) the runs are {first} % apart in second 1, {last} % in second {count}."
        zh += f" 同一随机种子下（竖直/转动/水平），两次运行在第 1 秒相差 {first} %，第 {count} 秒相差 {last} %。"
    return TimeFigure("gain", Text("recursive gain on its way to the Riccati gain", "递推增益趋向 Riccati 增益"), t,
                      (Curve(Text("distance", "距离"), np.maximum(away, FLOOR), "estimate"),), "‖M − M∞‖ / ‖M∞‖", True, Text(en, zh),
                      INPUT_TAB, (1e-4, 10.0))


def _test(outcome: Outcome[Study], j: int) -> TimeFigure:
    m = outcome.study
    key, name, unit = CHANNELS[j]
    t = m.responses[0].t
    seen = t <= 6.0
    curves = [Curve(NAMES[i], np.zeros(int(seen.sum())) if r is None else np.interp(t[seen], r.t, r.velocity[:, j]), role, dash,
                    _width(outcome, i))
              for i, ((role, dash), r) in enumerate(zip(LOOKS, m.responses, strict=True))]
    high = float(np.abs(m.responses[0].velocity[:, j]).max())
    parts = [_recovery(measured, j) for measured in m.measures[1:]]
    en = ", ".join(f"{n.en} {p.en}" for n, p in zip(SHORT[1:], parts, strict=True))
    zh = "，".join(f"{n.zh} {p.zh}" for n, p in zip(SHORT[1:], parts, strict=True))
    return TimeFigure(f"test_{key}", Text(f"velocity after the test: {name.en}", f"试验后的速度：{name.zh}"), t[seen],
                      tuple(curves), f"v [{unit}]", caption=Text(f"Recovered, to 5 % of the peak without control: {en}.",
                                                                  f"恢复到无控制峰值 5 % 以内：{zh}。"),
                      tab=TIME_TAB, window=(-high, high))


def _recovery(measured: tuple[ResponseMeasures, ...] | None, j: int) -> Text:
    if measured is None:
        return Text("unstable", "不稳定")
    after = measured[j].recovery
    return Text("not in 12 s", "12 s 内未恢复") if after is None else same(f"{after:.2g} s")


RUNAWAY = Text("This loop is unstable: its run is held where it leaves every bound.", "该回路不稳定：运行在越出界限处停住。")


def _held(outcome: Outcome[Study]) -> bool:
    return outcome.study.spectra[ORDER.index(outcome.design["play"])].stable


def _stage_velocity(outcome: Outcome[Study]) -> TimeFigure:
    m = outcome.study
    t, x, _ = m.run
    v, ghost = (np.clip(1e6 * states[:, 6], -2e3, 2e3) for states in (x, m.ghost))
    late = t > 1.0
    sizes = float(np.std(v[late])), float(np.std(ghost[late]))
    return TimeFigure("stage_velocity", Text("vertical velocity of the run on the stage", "场景中运行的竖直速度"), t,
                      (Curve(Text("with the controller", "有控制"), v),
                       Curve(Text("without control", "无控制"), ghost, "estimate", "dash", 1.6)), "v [µm/s]",
                      caption=RUNAWAY if not _held(outcome) else
                      Text(f"Test at 0.4 s. After 1 s: {sizes[0]:.3g} µm/s RMS, {sizes[1]:.3g} µm/s without control.",
                                   f"0.4 s 时施加试验。1 s 之后均方根 {sizes[0]:.3g} µm/s，无控制时 {sizes[1]:.3g} µm/s。"),
                      tab=RUN_TAB, window=(-500.0, 500.0))


def _stage_force(outcome: Outcome[Study]) -> TimeFigure:
    t, _, u = outcome.study.run
    peak = 1e3 * float(np.abs(u).max())
    return TimeFigure("stage_force", Text("coil commands of this run", "这次运行的线圈指令"), t,
                      (Curve(Text("left vertical u1", "左竖直 u1"), 1e3 * u[:, 0], "force", "solid", 1.6),
                       Curve(Text("horizontal u3", "水平 u3"), 1e3 * u[:, 2], "disturbance", "solid", 1.0)), "u [mN]",
                      caption=RUNAWAY if not _held(outcome) else Text(f"Largest command {peak:.3g} mN.", f"最大指令 {peak:.3g} mN。"),
                      tab=RUN_TAB,
                      window=(-20.0, 20.0))
