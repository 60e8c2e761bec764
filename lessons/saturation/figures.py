"""The figures of lesson 7: angle and position, error and force, and the map of starts."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from app.lesson.figures import Curve, Figure, MapFigure
from app.lesson.lesson import Outcome
from app.text.words import Text

from ..toolkit.figures import error_figure, input_figure, state_figures, within
from .knobs import MODEL
from .study import EXACT, GRID, UNKNOWN, Starts, Study, amount

APPLIED_FORCE, ASKED_FORCE, LIMIT = Text("applied", "实际力"), Text("asked for", "指令力"), Text("limit", "限幅")
EDGES = MappingProxyType({"state0": 49.0, "state1": 1.95, "error": 90.0, "input": 24.5})  # values beyond are drawn at the edge
CATEGORIES = (
    (Text("comes home", "能恢复"), "plant"),
    (Text("does not", "不能恢复"), "disturbance"),
    (Text("no controller could", "任何控制器都不能"), "muted"),
)


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Angle and position, error and force, and the map of starts."""
    story, design, metrics = outcome.study, outcome.design, outcome.metrics
    angle, position = state_figures(MODEL, story.shown, 2)
    known = Curve(Text("had x been known", "若 x 已知"), MODEL.watched[0].of(story.known), "reference", "dot", 1.6)
    angle = replace(angle, curves=(*angle.curves, known), caption=_angle_words(outcome), window=(-20.0, 20.0))
    error = replace(error_figure(story.shown, story.promised), caption=_error_words(outcome), window=(1e-6, 10.0))
    force = replace(input_figure(story.shown, MODEL, design["u_max"]), window=(-10.0, 10.0), caption=Text(
        f"Largest force asked for: {amount(metrics['largest_asked'])} N; the motor gives at most {design['u_max']:.3g} N.",
        f"最大指令力：{amount(metrics['largest_asked'])} N；电机最多给出 {design['u_max']:.3g} N。"))
    asked = (ASKED_FORCE,) if len(force.curves) == 4 else ()
    names = (APPLIED_FORCE, *asked, LIMIT, LIMIT)
    force = replace(force, curves=tuple(replace(c, name=name) for c, name in zip(force.curves, names, strict=True)))
    lines = (angle, replace(position, window=(-0.5, 0.5), caption=_position_words(outcome)), error, force)
    return (*(within(figure, EDGES[figure.id]) for figure in lines),
            starts_figure(story.starts, metrics["ceiling"], design["angle0"], design["error0"], design["kick"] >= 0))


def _angle_words(outcome: Outcome[Study]) -> Text:
    stopped, ideal = outcome.study.stopped, bool(outcome.metrics["known_comes_home"])
    end = (Text(f"Fallen after {stopped:.2f} s; the run stops there and the curves are held.",
                f"{stopped:.2f} s 后倒下；运行到此为止，曲线保持不变。") if stopped is not None else
           Text("Caught.", "已扶住。") if outcome.metrics["comes_home"] else Text("Not caught yet.", "尚未扶住。"))
    known = (Text(" With x known, the same start comes home.", " 若 x 已知，同一初态能恢复。") if ideal else
             Text(" Even with x known, this start is lost.", " 即使 x 已知，这一初态也不能恢复。"))
    return Text(end.en + known.en, end.zh + known.zh)


def _position_words(outcome: Outcome[Study]) -> Text:
    gap = float(np.max(np.abs(outcome.run.e[:, 0]))) if outcome.run is not None else 0.0
    return Text(f"The position is measured. Largest error of its estimate: {amount(gap)} m.",
                f"位置是直接测量的，其估计误差最大为 {amount(gap)} m。")


def _error_words(outcome: Outcome[Study]) -> Text:
    meter = outcome.metrics["separation_meter"]
    if meter < EXACT:
        return Text("The error keeps its promise, clipped or not.", "无论是否限幅，误差都与理论值一致。")
    return Text(f"The error leaves its promise; separation meter {amount(meter)}.", f"误差偏离理论值；分离度量 {amount(meter)}。")


def starts_figure(starts: Starts | None, limit: float, angle: float, error: float, kicked: bool) -> MapFigure:
    """The map with the present start marked; what is not known for this design stays blank."""
    values = np.full((len(GRID), len(GRID)), UNKNOWN) if starts is None else starts.values
    return MapFigure("starts", Text("starts that come home", "能恢复的初态"), GRID, GRID, values, CATEGORIES,
                     "θ(0) [°]", "θ(0) − θ̂(0) [°]", (angle, error), _caption(starts, limit, kicked),
                     Text("Map", "地图"))


def _caption(starts: Starts | None, limit: float, kicked: bool) -> Text:
    if starts is None:
        return Text("Not computed for this design yet: press the button under the knobs.",
                    "当前设计尚未计算：请按旋钮下方的按钮。")
    share, part = 100 * starts.home, 100 * starts.done
    text = (Text(f"{share:.1f} % of these starts come home.", f"图中 {share:.1f} % 的初态能恢复。") if starts.done == 1 else
            Text(f"{part:.0f} % of the map is known; blank starts have not been run.",
                 f"已算出 {part:.0f} %；空白处的初态尚未运行。"))
    edge = (Text(f" Beyond {limit:.1f}° no controller could.", f" 超过 {limit:.1f}° 任何控制器都无能为力。")
            if limit < GRID[-1] else Text("", ""))
    kick = Text(" The map is drawn without the kick.", " 地图不含冲击。") if kicked else Text("", "")
    click = Text(" The circle runs now; click another start.", " 圆圈是正在运行的初态；点击别处即可运行。")
    return Text(text.en + edge.en + click.en + kick.en, text.zh + edge.zh + click.zh + kick.zh)
