"""One line for each analysis: a light and the number it rests on, or the sentence why there is none."""

from __future__ import annotations

import numpy as np

from app.engine.feedback import ClosedLoop
from app.engine.structure import Mode
from app.text.words import Text

from ..toolkit.latex import pole_words, tiny
from .analyses import Margins, Noise, Refusal, Structure, Trial

Row = tuple[Text, bool | None, Text]
EXACT = 1e-6


def verdicts(found: Structure, loop: ClosedLoop, meter: float, limited: bool, noise: Noise | Refusal, trial: Trial | Refusal,
             margins: Margins | Refusal) -> tuple[Row, ...]:
    """All rows, in the order of the lessons."""
    return (*_structure(found), *_loop(loop, meter, limited), _noise(noise), _trial(trial), _margins(margins))


def _weakest(modes: tuple[Mode, ...], hidden: tuple[complex, ...]) -> Text:
    if hidden:
        words = pole_words([p for p in hidden if p.imag >= 0][:4])
        return Text(f"{len(hidden)} hidden: {words}", f"{len(hidden)} 个隐藏：{words}")
    d = min(mode.margin for mode in modes)
    return Text(f"nearest mode {d:.2g} from hidden", f"与“隐藏”的最小距离 {d:.2g}")


def _structure(found: Structure) -> tuple[Row, ...]:
    names = ((Text("observable", "能观"), Text("detectable", "可检测")), (Text("controllable", "能控"), Text("stabilizable", "可镇定")))
    rows: list[Row] = []
    for report, (strong, weak), fixed, good in ((found.seen, names[0], "unobservable", "detectable"),
                                                (found.reached, names[1], "uncontrollable", "stabilizable")):
        if isinstance(report, Refusal):
            rows += [(strong, None, report.text), (weak, None, report.text)]
            continue
        hidden = getattr(report, fixed)
        loose = [p for p, m in zip(hidden, [m for m in report.modes if not m.visible], strict=False) if not m.stable]
        rows += [(strong, not hidden, _weakest(report.modes, hidden)),
                 (weak, getattr(report, good), Text("nothing is hidden", "没有隐藏的部分") if not hidden else
                  Text("what is hidden settles", "隐藏的部分自行衰减") if not loose else
                  Text(f"{len(loose)} hidden and not settling", f"{len(loose)} 个隐藏且不衰减"))]
    d = found.decomposition
    if isinstance(d, Refusal):
        rows.append((Text("minimal", "最小实现"), None, d.text))
    else:
        n, both = sum(d.sizes), d.sizes[0]
        rows.append((Text("minimal", "最小实现"), both == n, Text(f"{both} of {n} states act from u to y",
                                                              f"{n} 个状态中有 {both} 个从 u 到 y 起作用")))
    return tuple(rows)


def _loop(loop: ClosedLoop, meter: float, limited: bool) -> tuple[Row, ...]:
    error = min(loop.union_error, loop.polynomial_error)
    held = Text(" with the limit on", "（限幅已开）") if limited else Text("", "")
    return (
        (Text("loop stable", "闭环稳定"), loop.stable, Text(f"{len(loop.poles)} poles", f"{len(loop.poles)} 个极点")),
        (Text("separation of the poles", "极点分离"), error < EXACT, Text(f"off the union by {tiny(error)}", f"与并集相差 {tiny(error)}")),
        (Text("error lives by itself", "误差独自演化"), meter < EXACT, Text(f"meter {'0' if meter < 1e-8 else f'{meter:.2g}'}{held.en}",
                                                                    f"分离度量 {'0' if meter < 1e-8 else f'{meter:.2g}'}{held.zh}")),
        (Text("compensator stable by itself", "补偿器自身稳定"), loop.compensator_stable,
         Text(f"{len(loop.compensator_poles)} poles of its own", f"自身有 {len(loop.compensator_poles)} 个极点")),
    )


def _noise(found: Noise | Refusal) -> Row:
    name = Text("observer near the Kalman filter", "观测器接近卡尔曼滤波器")
    if isinstance(found, Refusal):
        return name, None, found.text
    if isinstance(found.ours, Refusal):
        return name, None, found.ours.text

    def size(P: np.ndarray) -> float:
        return float(np.sqrt(np.mean(np.diag(P) / found.unit**2)))
    ratio = size(found.ours.total) / max(min(size(p.total) for p in found.ladder.parts), 1e-300)
    return name, ratio < 1.5, Text(f"error {ratio:.3g} times the least", f"误差为最小值的 {ratio:.3g} 倍")


def _trial(found: Trial | Refusal) -> Row:
    name = Text("Kalman filter consistent", "卡尔曼滤波器一致")
    if isinstance(found, Refusal):
        return name, None, found.text
    p = found.test.dof
    return name, abs(found.expected / p - 1) < 0.1, Text(f"NIS {found.expected:.3g} on average, {p} expected",
                                                         f"NIS 平均为 {found.expected:.3g}，应为 {p}")


def _margins(found: Margins | Refusal) -> Row:
    name = Text("robust at the inputs (α ≥ 0.5)", "输入端鲁棒（α ≥ 0.5）")
    if isinstance(found, Refusal):
        return name, None, found.text
    return name, found.together >= 0.5, Text(f"disk margin {found.together:.3g}", f"圆盘裕度 {found.together:.3g}")
