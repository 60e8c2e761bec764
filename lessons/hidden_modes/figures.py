"""Figures of the lesson: what the sensor says, what it does not, margins, lights, and the plant taken apart."""

from __future__ import annotations

from functools import lru_cache
from itertools import accumulate

import numpy as np

from app.engine.simulation import Run
from app.engine.structure import Mode
from app.lesson.figures import Curve, Figure, LineFigure, MatrixFigure, PlaneFigure, Point, TableFigure
from app.lesson.lesson import Check, Outcome
from app.text.words import Text, same, symbol

from ..toolkit.figures import ERROR_TAB, TIME_TAB, input_figure
from ..toolkit.latex import pole_words
from .knobs import CASES, COMMON, RELATIVE, Case

MODES_TAB, EVERY_TAB = Text("Modes", "模态"), Text("Every gain", "任意增益")
CLEAR = 1e-3  # a distance above this share of the plant's size is well above zero
DRAWS = 50  # random gains on the maps of the tab "Every gain"
SPREAD = np.array([3.0, 3.0, 8.0, 8.0])  # their standard deviations, position entries first
YES, NO = Text("● yes", "● 是"), Text("○ no", "○ 否")


def all_figures(outcome: Outcome[Case]) -> tuple[Figure, ...]:
    """Everything on the right of the stage."""
    run, case = outcome.run, CASES[outcome.design["plant"]]
    assert run is not None
    seed = int(outcome.design["seed"])
    return (_measured(run), _centre(run, case), _error_parts(run, case), _state_parts(run, case),
            input_figure(run, case.model), margins_of(case), lights_of(outcome.checks), _decomposed(case.id),
            _every_observer(case.id, seed), _every_controller(case.id, seed))


def _measured(run: Run) -> LineFigure:
    y, late = run.y[:, 0], run.y[-max(len(run.y) // 8, 1):, 0]
    size = float(np.max(np.abs(late)))
    quiet = size < 0.02 * max(float(np.max(np.abs(y))), 1e-12)
    return LineFigure(
        "measured", Text("what the sensor says", "传感器的读数"), run.t,
        (Curve(Text("measured y", "测量值 y"), y),
         Curve(Text("predicted ŷ", "预测值 ŷ"), run.yhat[:, 0], "estimate", "dash")), "y [m]", window=(-0.2, 0.2),
        tab=TIME_TAB,
        caption=Text("The trace has gone flat: as far as the sensor can tell, all is at rest.",
                     "曲线已经变平：在传感器看来，一切静止。") if quiet else
        Text(f"In the last eighth of the run the sensor still reads up to {size:.2g} m.",
             f"在运行的最后八分之一，读数仍达 {size:.2g} m。"))


def _centre(run: Run, case: Case) -> LineFigure:
    signal = case.model.watched[-1]
    true, guess = signal.of(run.x), signal.of(run.xhat)
    end, gap = float(abs(true[-1])), float(abs(true[-1] - guess[-1]))
    return LineFigure(
        "centre", Text("the motion of both blocks together", "两滑块同步的运动"), run.t,
        (Curve(Text("true", "真实"), true), Curve(Text("estimate", "估计"), guess, "estimate", "dash")),
        "[m]", window=(-0.5, 0.5), tab=TIME_TAB,
        caption=Text(f"At the end both blocks are {end:.2g} m off their rest, the estimate is {gap:.2g} m wrong.",
                     f"末时刻两滑块共同偏离平衡位置 {end:.2g} m，估计偏差 {gap:.2g} m。"))


def _fixed(bolts: tuple[complex, ...], what: str, gain: str) -> Text:
    rate = f"{max(p.real for p in bolts):.3g}".replace("-", "−")
    return Text(f"The common part of {what} follows e^({rate} t), whatever {gain} is.",
                f"不论 {gain} 取什么，{what} 的同步部分都按 e^({rate} t) 变化。")


def _parts(name: str, what: str, title: Text, run: Run, values: np.ndarray, caption: Text) -> LineFigure:
    common, relative = (np.linalg.norm(values @ part.T, axis=1) for part in (COMMON, RELATIVE))
    return LineFigure(
        name, title, run.t,
        (Curve(Text("both blocks together", "两块同步"), common, "error"),
         Curve(Text("one against the other", "两块相对"), relative, "second", "dash")), f"‖{what}‖", log_y=True,
        window=(1e-3, 1.0), caption=caption, tab=ERROR_TAB)


def _error_parts(run: Run, case: Case) -> LineFigure:
    caption = (_fixed(case.unseen, "e", "L") if case.unseen
               else Text("L moves both parts of e.", "e 的两部分都由 L 支配。"))
    return _parts("error_parts", "e", Text("estimation error e, in two parts", "估计误差 e 的两个部分"), run, run.e, caption)


def _state_parts(run: Run, case: Case) -> LineFigure:
    if case.unmoved:
        caption = _fixed(case.unmoved, "x", "K")
    elif case.unseen:
        caption = Text("K could move both parts, but it acts on x̂: the common part of x goes where that of e goes.",
                       "K 本可支配两部分，但它依据的是 x̂：x 的同步部分只能跟着 e 的同步部分走。")
    else:
        caption = Text("K moves both parts of x.", "x 的两部分都由 K 支配。")
    return _parts("state_parts", "x", Text("plant state x, in two parts", "对象状态 x 的两个部分"), run, run.x, caption)


def _bar(mode: Mode) -> str:
    """The PBH distance as a number, its share of the plant's size as a bar over six decades; a hidden mode has none."""
    if not mode.visible:
        return "0"
    return f"{mode.distance:.3g} " + "▮" * max(1, round(6 + np.log10(mode.margin)))


def _pole(mode: Mode) -> str:
    return pole_words([complex(mode.pole.real, abs(mode.pole.imag))])


def margins_of(case: Case) -> TableFigure:
    """Every mode with its PBH distances towards y and u."""
    rows = []
    for seen, reached in zip(case.seen.modes, case.reached.modes, strict=True):
        if seen.pole.imag < -1e-9:
            continue
        fate = Text("settles", "衰减") if seen.stable else Text("departs", "发散")
        rows.append((_pole(seen), fate, _bar(seen), _bar(reached)))
    hidden = case.unseen or case.unmoved
    words = pole_words(list(hidden))
    weakest = min((m for report in (case.seen, case.reached) for m in report.modes), key=lambda m: m.margin)
    caption = (Text("No mode is hidden: every distance is well above zero.", "没有隐藏模态：各距离都明显大于零。")
               if not hidden and weakest.margin > CLEAR else
               Text(f"No mode is hidden, but the nearest is only {weakest.distance:.1g} from it.",
                    f"没有隐藏模态，但最近的离隐藏只有 {weakest.distance:.1g}。")
               if not hidden
               else Text(f"Hidden from the sensor: {words}.", f"对传感器隐藏：{words}。") if case.unseen
               else Text(f"Out of reach of the force: {words}.", f"对力不能控：{words}。"))
    return TableFigure(
        "margins", Text("PBH distance of each mode from being hidden", "各模态离“隐藏”的 PBH 距离"),
        (Text("mode", "模态"), Text("by itself", "自由运动"), Text("from y", "对 y（能观程度）"),
         Text("from u", "对 u（能控程度）")), tuple(rows), tab=MODES_TAB, caption=caption)


def lights_of(checks: tuple[Check, ...]) -> TableFigure:
    """The checks as lights."""
    lit = sum(check.holds for check in checks)
    return TableFigure(
        "lights", Text("lights", "指示灯"), (Text("statement", "性质"), Text("holds", "成立")),
        tuple((check.text, YES if check.holds else NO) for check in checks), tab=MODES_TAB,
        caption=Text(f"{lit} of {len(checks)} hold for the plant and gains shown now.",
                     f"对当前的对象和增益，{len(checks)} 项中有 {lit} 项成立。"))


@lru_cache(maxsize=8)
def _decomposed(name: str) -> MatrixFigure:
    return blocks_of(CASES[name])


def blocks_of(case: Case) -> MatrixFigure:
    """The Kalman decomposition as a heat map with its blocks."""
    d = case.decomposition
    n, m, p = d.A.shape[0], d.B.shape[1], d.C.shape[0]
    whole = np.block([[d.A, d.B], [d.C, np.zeros((p, m))]])
    edges = tuple(k for k in accumulate(d.sizes) if 0 < k < n)
    shown = d.sizes[0]
    if d.sizes[1]:
        block = Text("the force reaches it, and its column in the row of y is empty", "力能控制它，但它在 y 这一行是空的")
    elif d.sizes[2]:
        block = Text("the sensor sees it, and its row in the column of u is empty", "传感器看得见它，但它在 u 这一列是空的")
    else:
        block = same("")
    caption = (Text(f"z₁ … {symbol(f'z{shown}')} are reached and seen. The last block is the hidden motion: {block.en}.",
                    f"z₁ … {symbol(f'z{shown}')} 既可达又可见；最后一块就是隐藏的运动：{block.zh}。") if block.en
               else Text("One block: every state is reached and seen.", "只有一块：所有状态既可达又可见。"))
    return MatrixFigure("decomposed", Text("Kalman decomposition", "卡尔曼分解"), whole,
                        (*numbered("z", n), *numbered("y", p)), (*numbered("z", n), *numbered("u", m)), (*edges, n),
                        caption=caption, tab=MODES_TAB)


def numbered(letter: str, count: int) -> tuple[str, ...]:
    """y, or y1, y2, …: one name each."""
    return (letter,) if count == 1 and letter != "z" else tuple(f"{letter}{i + 1}" for i in range(count))


def random_poles(case: Case, seed: int, observer: bool) -> np.ndarray:
    """Poles of A − LC (observer) or A − BK for `DRAWS` random gains, (DRAWS, n)."""
    draws = np.random.default_rng(seed).normal(size=(DRAWS, case.model.plant.n)) * SPREAD
    plant = case.model.plant
    turned = draws[:, :, None] * plant.C if observer else plant.B * draws[:, None, :]
    return np.linalg.eigvals(plant.A - turned)


def _cloud(name: str, title: Text, poles: np.ndarray, bolts: tuple[complex, ...], gain: str) -> PlaneFigure:
    points = tuple(Point(float(p.real), float(p.imag), "second", "dot") for p in poles.ravel())
    points += tuple(Point(p.real, p.imag, "reference", "bolt") for p in bolts)
    least = float(np.min(np.max(np.real(poles), axis=1)))
    words = f"{least:.3g}".replace("-", "−")
    return PlaneFigure(
        name, title, (), points, "Re s", "Im s", (-10.0, 4.0), (-7.0, 7.0), unstable=True, tab=EVERY_TAB,
        caption=Text(f"{DRAWS} gains {gain} drawn at random. The best of them has its rightmost pole at {words}"
                     + (", on the bolt or right of it." if bolts else "."),
                     f"随机取 {DRAWS} 个增益 {gain}。其中最好的一个，最右极点的实部为 {words}"
                     + ("，不在螺栓左侧。" if bolts else "。")))


@lru_cache(maxsize=16)
def _every_observer(name: str, seed: int) -> PlaneFigure:
    case = CASES[name]
    return _cloud("every_observer", Text("eig(A − LC) for random L", "随机 L 的 eig(A − LC)"),
                  random_poles(case, seed, True), case.unseen, "L")


@lru_cache(maxsize=16)
def _every_controller(name: str, seed: int) -> PlaneFigure:
    case = CASES[name]
    return _cloud("every_controller", Text("eig(A − BK) for random K", "随机 K 的 eig(A − BK)"),
                  random_poles(case, seed, False), case.unmoved, "K")
