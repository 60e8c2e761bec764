"""Tables of the lesson: suppression, sizes, times, trials, other decks, costs."""

from __future__ import annotations

import numpy as np

from app.lesson.figures import TableFigure
from app.lesson.lesson import Outcome
from app.text.words import Text

from .players import DECOUPLED, LQE, NAMES, ORDER, SHORT
from .study import Study

SCORE_TAB, TRIAL_TAB = Text("Scores", "成绩"), Text("Trials", "批量试验")
HEADS = (Text("vertical", "竖直"), Text("rotation", "转动"), Text("horizontal", "水平"))
APART = "\N{NO-BREAK SPACE}·\N{NO-BREAK SPACE}"  # between the three numbers of one cell, which must not part at a line's end
SPLIT = Text("Cells: vertical, rotation, horizontal.", "单元格依次为：竖直、转动、水平。")


def tables(outcome: Outcome[Study]) -> tuple[TableFigure, ...]:
    """Suppression, sizes, times; then what the longer computation has found."""
    return (_suppression(outcome), _sizes(outcome), _times(outcome), _trials(outcome), _decks(outcome), _costs(outcome))


def _cells(values: np.ndarray, stable: bool, form: str = ".1f") -> Text | str:
    if not stable:
        return Text("unstable", "不稳定")
    return APART.join(f"{v:{form}}".replace("-", "−") for v in values)


def _suppression(outcome: Outcome[Study]) -> TableFigure:
    m = outcome.study
    rows = tuple((NAMES[i], *(Text("unstable", "不稳定") if not m.spectra[i].stable else
                              f"{m.peak_db[i, j]:.1f} / {m.band_db[i, j]:.1f}".replace("-", "−") for j in range(3))) for i in range(1, 5))
    best = [1 + int(np.flatnonzero(m.band_db[1:, j] >= m.band_db[1:, j].max() - 0.05)[0]) for j in range(3)]
    return TableFigure("suppression", Text("suppression in dB, 0.5–3 Hz: of the highest peak / of the area",
                                           "0.5–3 Hz 抑制（dB）：峰值 / 面积"),
                       (Text("controller", "控制器"), *HEADS), rows, tab=SCORE_TAB,
                       caption=Text(f"Best by area: {SHORT[best[0]].en} vertically, {SHORT[best[1]].en} in rotation, "
                                    f"{SHORT[best[2]].en} horizontally.",
                                    f"按面积最好者：竖直 {SHORT[best[0]].zh}，转动 {SHORT[best[1]].zh}，水平 {SHORT[best[2]].zh}。"))


def _sizes(outcome: Outcome[Study]) -> TableFigure:
    m = outcome.study
    rows = tuple((NAMES[i], *(Text("unstable", "不稳定") if not m.spectra[i].stable else f"{m.rms[i, j]:.3g}" for j in range(3)),
                  "–" if not m.spectra[i].stable else f"{1e3 * m.forces[i].max():.3g}") for i in range(5))
    return TableFigure("sizes", Text("RMS velocity in µm/s from 0.1 Hz up, RMS command in mN",
                                     "速度均方根（µm/s，0.1 Hz 以上）与指令均方根（mN）"),
                       (Text("controller", "控制器"), *HEADS, Text("coil", "线圈")), rows, tab=SCORE_TAB,
                       caption=Text("Here what a controller adds above the resonances counts too.",
                                    "这里也计入控制器在共振以上添加的噪声。"))


def _times(outcome: Outcome[Study]) -> TableFigure:
    m = outcome.study
    rows = []
    for i in range(5):
        measured = m.measures[i]
        if measured is None:
            rows.append((SHORT[i], Text("unstable", "不稳定"), "–", "–", "–"))
            continue
        times = APART.join(">12" if part.recovery is None else f"{part.recovery:.2g}" for part in measured)
        over = APART.join(f"{100 * part.overshoot:.0f}" for part in measured)
        rows.append((SHORT[i], times, over, f"{1e3 * measured[0].peak:.3g}", f"{1e6 * measured[0].energy:.4g}"))
    return TableFigure("times", Text("the test in time", "时域指标"),
                       (Text("controller", "控制器"), Text("recovery [s]", "恢复时间 [s]"), Text("overshoot [%]", "超调 [%]"),
                        Text("peak u [mN]", "u 峰值 [mN]"), Text("energy [mN² s]", "能量 [mN² s]")), tuple(rows), tab=SCORE_TAB,
                       caption=Text(SPLIT.en + " Overshoot: largest swing to the other side, over the first.",
                                    SPLIT.zh + "超调：反向最大摆幅与正向之比。"))


NOT_YET = Text("Not computed yet: press the button under the knobs.", "尚未计算：请按旋钮下方的按钮。")


def _trials(outcome: Outcome[Study]) -> TableFigure:
    m = outcome.study
    rows = []
    for i in range(5):
        tried = None if m.trials is None else m.trials.noise[i]
        if tried is None:
            rows.append((SHORT[i], _cells(m.rms[i], m.spectra[i].stable, ".3g"), "–", "–"))
            continue
        keep = ~tried.diverged
        rms = 1e6 * np.sqrt(np.mean(tried.rms[keep, :3] ** 2, axis=0)) if keep.any() else np.zeros(3)
        rows.append((SHORT[i], _cells(m.rms[i], True, ".3g"), _cells(rms, bool(keep.any()), ".3g"),
                     f"{100 * float(tried.clipped.mean()):.2g}"))
    done = m.trials is not None and any(one is not None for one in m.trials.noise)
    said = (Text(f"24 runs of 32 s each, with clipping and rounding as they are. {SPLIT.en}",
                 f"每个控制器 24 次、每次 32 s，限幅与量化按实际处理。{SPLIT.zh}") if done else NOT_YET)
    return TableFigure("trials", Text("RMS velocity in µm/s: predicted, and from Monte-Carlo", "速度均方根（µm/s）：预测与蒙特卡罗"),
                       (Text("controller", "控制器"), Text("predicted", "预测"), Text("Monte-Carlo", "蒙特卡罗"),
                        Text("clipped [%]", "限幅 [%]")), tuple(rows), tab=TRIAL_TAB, caption=said)


def _decks(outcome: Outcome[Study]) -> TableFigure:
    m = outcome.study
    decks = None if m.trials is None else m.trials.decks
    rows = []
    for i in range(1, 5):
        if decks is None:
            rows.append((SHORT[i], "–", "–", "–"))
            continue
        good = ~np.isnan(decks[:, i, 0])
        if not good.any():
            rows.append((SHORT[i], *(Text("unstable", "不稳定"),) * 3))
            continue
        low, high = np.quantile(decks[good, i], (0.05, 0.95), axis=0)
        lost = "" if good.all() else f" ({np.sum(~good)} ✕)"
        rows.append((SHORT[i], *(f"{a:.1f} … {b:.1f}{lost}".replace("-", "−") for a, b in zip(low, high, strict=True))))
    if decks is None or m.trials is None:
        said = NOT_YET
    else:
        k, c, s = m.trials.tolerance
        said = Text(f"60 decks, stiffness ±{k:.3g} %, damping ±{c:.3g} %, sensors ±{s:.3g} mm: nine in ten lie between. ✕: unstable.",
                    f"60 个平台，刚度 ±{k:.3g} %、阻尼 ±{c:.3g} %、传感器 ±{s:.3g} mm：九成落在其间。✕：不稳定。")
    return TableFigure("decks", Text("suppression in dB, 0.5–3 Hz, on decks that are not quite the model",
                                     "平台与模型不符时 0.5–3 Hz 的抑制（dB）"),
                       (Text("controller", "控制器"), *HEADS), tuple(rows), tab=TRIAL_TAB, caption=said)


SWITCHES = (
    (Text("driver", "驱动"), "Hz"), (Text("delay", "时延"), "ms"), (Text("converter", "量化"), "µm/s"),
    (Text("drift", "漂移"), "µm/s/√s"), (Text("stiffness", "刚度"), "%"), (Text("damping", "阻尼"), "%"),
    (Text("placement", "安装"), "mm"),
)


def _costs(outcome: Outcome[Study]) -> TableFigure:
    shown, trials = (1, ORDER.index(LQE), ORDER.index(DECOUPLED)), outcome.study.trials
    if trials is None or trials.costs is None:
        rows: tuple[tuple[Text | str, ...], ...] = tuple((name, "–", "–", "–") for name, _ in SWITCHES)
        said = NOT_YET
    else:
        rows = tuple(
            (Text(f"{name.en} {size:.3g} {unit}", f"{name.zh} {size:.3g} {unit}"),
             *(_cells(np.round(cost[k], 1) + 0.0, not np.isnan(cost[k, 0]), "+.1f") for k in shown))
            for (name, unit), size, cost in zip(SWITCHES, trials.sizes, trials.costs, strict=True))
        said = Text("Change of the suppression in dB by one switch alone: vertical, rotation, horizontal. A knob at rest counts "
                    "with a usual size.",
                    "单独打开一个因素时抑制量的变化（dB）：竖直、转动、水平。未设置的旋钮取常用值。")
    return TableFigure("costs", Text("what each switch costs", "各因素的代价"),
                       (Text("switch", "因素"), *(SHORT[k] for k in shown)), rows, tab=TRIAL_TAB, caption=said)
