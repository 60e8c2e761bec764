"""What several lessons share: knobs every run has, gains by poles or by weights, and the usual figures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from app.engine import EngineError, Plant, dlqe, dlqr, lqe, lqr, observer_gain, place
from app.engine.design import StartingGain, shift_observer, shift_poles, typical_rate
from app.engine.simulation import Run
from app.lesson.figures import Curve, TimeFigure
from app.lesson.knobs import Choice, KnobError, Number, Poles
from app.lesson.lesson import Board, Design, Lesson, Stage, Task
from app.plants.model import Model, Signal, Window
from app.plants.names import called
from app.text.words import Text, same, symbol

MOST_ENTRIES = 24  # of a matrix that is written out
BY_POLES, BY_WEIGHTS = "poles", "weights"
TIME_TAB = Text("Time", "时间")
ERROR_TAB = Text("Error and input", "误差与输入")
WEIGHTS = Text("Weights", "权重")
INPUTS = MappingProxyType({"force": Text("force", "力"), "force 1": Text("force 1", "力 1"), "force 2": Text("force 2", "力 2")})


def run_knobs(horizon: float) -> tuple[Number, ...]:
    """Knobs that every run has and no slider shows: the seed of its noise and the time of a kick (−1: none)."""
    return (
        Number("seed", r"s_0", Text("noise seed", "噪声种子"), low=0, high=9999, default=1, scale="integer", hidden=True),
        Number("kick", r"t_k", Text("time of the kick", "冲击时刻"), "s", low=-1.0, high=horizon, default=-1.0,
               hidden=True),
    )


def pole_knobs(model: Model) -> tuple[Poles, Poles]:
    """The controller's and the observer's poles, inside the windows of their boards."""
    c, o = model.controller_window, model.observer_window
    when = ("method", (BY_POLES,))
    return (
        Poles("controller_poles", "p", Text("Controller poles", "控制器极点"), "rad/s", default=model.controller_poles,
              re_low=c.re_low, re_high=c.re_high, im_high=c.im_high, role="plant", when=when, hidden=not model.controller_poles,
              hint=Text("Where eig(A − BK) is to lie: farther left is faster and asks for more input.",
                        "eig(A − BK) 的位置：越靠左越快，所需的输入也越大。")),
        Poles("observer_poles", "q", Text("Observer poles", "观测器极点"), "rad/s", default=model.observer_poles,
              re_low=o.re_low, re_high=o.re_high, im_high=o.im_high, role="estimate", when=when, hidden=not model.observer_poles,
              hint=Text("Where eig(A − LC) is to lie: farther left forgets a wrong start sooner.",
                        "eig(A − LC) 的位置：越靠左，初始误差消失得越快。")),
    )


def method_knobs() -> tuple[Choice, Number, Number, Number, Number]:
    """Gains by poles or by weights: Q = α_Q CᵀC, R = α_R I for K; W = α_W B Bᵀ, V = α_V I for L."""
    weights = ("method", (BY_WEIGHTS,))

    def weight(name: str, symbol: str, en: str, zh: str, default: float, hint: Text) -> Number:
        return Number(name, symbol, Text(en, zh), low=1e-6, high=1e6, default=default, scale="log", when=weights,
                      hint=hint)
    return (
        Choice("method", "", Text("gains by", "增益由"), default=BY_POLES,
               options=((BY_POLES, Text("dragging poles", "拖动极点")), (BY_WEIGHTS, Text("Q/R weights", "Q/R 权重"))),
               hint=Text("Drag the poles yourself, or let LQR and its dual choose them from weights.",
                         "自己拖动极点，或由权重经 LQR 及其对偶给出极点。")),
        weight("q", r"\alpha_Q", "state weight α_Q", "状态权重 α_Q", 1e4,
               Text("Q = α_Q CᵀC: how much a moving plant costs.", "Q = α_Q CᵀC：对象运动的代价。")),
        weight("r", r"\alpha_R", "input weight α_R", "输入权重 α_R", 1.0,
               Text("R = α_R I: how much force costs. Only α_Q/α_R matters for K.", "R = α_R I：用力的代价。K 只取决于 α_Q/α_R。")),
        weight("w", r"\alpha_W", "process intensity α_W", "过程噪声强度 α_W", 1e2,
               Text("W = α_W I on the inputs: how far the model is to be distrusted.", "输入端的 W = α_W I：对模型的不信任程度。")),
        weight("v", r"\alpha_V", "sensor intensity α_V", "测量噪声强度 α_V", 1e-2,
               Text("V = α_V I: how far the sensors are to be distrusted. Only α_W/α_V matters for L.",
                    "V = α_V I：对传感器的不信任程度。L 只取决于 α_W/α_V。")),
    )


def by_hand(design: Design) -> bool:
    """Whether poles are chosen by hand: the method says so, or the lesson knows no other."""
    return dict(design.values).get("method", BY_POLES) == BY_POLES


def gains(design: Design, plant: Plant, model: Model | None = None) -> tuple[np.ndarray, np.ndarray]:
    """K and L of a design: by poles, or by LQR and LQE from the weights. `model` where the plant is a person's own."""
    if by_hand(design):
        return feedback(plant, design["controller_poles"], model), injection(plant, design["observer_poles"], model)
    Q, R = design["q"] * plant.C.T @ plant.C, design["r"] * np.eye(plant.m)
    W, V = design["w"] * np.eye(plant.m), design["v"] * np.eye(plant.p)
    if plant.dt:
        return dlqr(plant.A, plant.B, Q, R).gain, dlqe(plant.A, plant.B, plant.C, W, V).gain
    return lqr(plant.A, plant.B, Q, R).gain, lqe(plant.A, plant.B, plant.C, W, V).gain


def feedback(plant: Plant, poles: Sequence[complex], model: Model | None = None) -> np.ndarray:
    """K (m×n) for poles: placed, or for a person's own plant its starting gain with the poles of the board moved."""
    if model is None or model.controller is None:
        return place(plant.A, plant.B, poles).gain
    return shift_poles(plant.A, plant.B, model.controller.gain, model.controller_poles, poles)


def injection(plant: Plant, poles: Sequence[complex], model: Model | None = None) -> np.ndarray:
    """L (n×p) for poles, as `feedback`."""
    if model is None or model.observer is None:
        return observer_gain(plant.A, plant.C, poles).gain
    return shift_observer(plant.A, plant.C, model.observer.gain, model.observer_poles, poles)


def bolts(start: StartingGain | None, window: Window) -> tuple[complex, ...]:
    """The poles that no gain moves, as far as the board reaches."""
    if start is None:
        return ()
    return tuple(complex(p) for p in start.bolted
                 if window.re_low <= p.real <= window.re_high and abs(p.imag) <= window.im_high)


def sped(plant: Plant, percent: float) -> Plant:
    """The plant as it is when everything in it goes faster by so many per cent than its model says: A and B grow alike."""
    if not percent:
        return plant
    share = 1 + percent / 100
    return replace(plant, A=share * plant.A, B=share * plant.B)


def sizes(model: Model) -> np.ndarray:
    """The size (p,) of each output of a person's own plant near its start, 1 where that is nothing."""
    size = np.abs(model.plant.C) @ np.abs(np.array(model.x0))
    return np.where(size > 0, size, 1.0)


def noise_units(model: Model) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """G, W and V of unit noises for a person's own plant: intensities, or covariances of a sample where it is sampled.

    w enters where the inputs do and has the size of the natural input over a typical time, v that of the outputs near the
    start; a plant that no input reaches is shaken in every state.
    """
    plant = model.plant
    time = 1.0 if plant.dt else 1.0 / typical_rate(plant)
    V = np.diag(sizes(model) ** 2) * time
    if np.any(plant.B):
        return plant.B, model.u_max**2 * time * np.eye(plant.m), V
    return np.diag(np.abs(np.array(model.x0)) + 1e-9), (1.0 if plant.dt else 1.0 / time) * np.eye(plant.n), V


def fair(lesson: Lesson) -> Lesson:
    """The lesson with those tasks alone that fail at its start and pass at their own solution."""
    start = lesson.start()
    opened = lesson.compute(start)

    def passes(task: Task) -> bool:
        try:
            return task.check(lesson.compute(lesson.apply(start, task.solution))).solved
        except (EngineError, KnobError):
            return False
    return replace(lesson, tasks=tuple(t for t in lesson.tasks if not t.check(opened).solved and passes(t)))


def pole_boards(model: Model, design: Design, controller: np.ndarray, observer: np.ndarray,
                error_matrix: np.ndarray | None = None) -> tuple[Board, Board]:
    """The two boards of a lesson with K and L: controller on the left, observer on the right.

    Poles chosen by hand stand exactly where the hand put them; poles that weights choose can be dragged too, which
    turns the method to poles. `error_matrix` A − LC gives the landscape of |det(sI − A + LC)|⁻¹.
    """
    chosen = by_hand(design)
    take = (("method", BY_POLES),) if "method" in dict(design.values) else ()
    c, o = model.controller_window, model.observer_window

    def grip(knob: str, poles: np.ndarray) -> str | None:  # a board that shows other poles than the knob holds only mirrors
        return knob if chosen or len(design[knob]) == len(poles) else None
    return (
        Board("controller", Text("controller poles  eig(A − BK)", "控制器极点  eig(A − BK)"),
              design["controller_poles"] if chosen else listed(controller), grip("controller_poles", controller),
              bolts(model.controller, c) if chosen else (), role="plant", side="left", re_low=c.re_low, re_high=c.re_high,
              im_high=c.im_high, also=take, disc=bool(model.plant.dt)),
        Board("observer", Text("observer poles  eig(A − LC)", "观测器极点  eig(A − LC)"),
              design["observer_poles"] if chosen else listed(observer), grip("observer_poles", observer),
              bolts(model.observer, o) if chosen else (), role="estimate", side="right", re_low=o.re_low,
              re_high=o.re_high, im_high=o.im_high, also=take, disc=bool(model.plant.dt), landscape=error_matrix),
    )


def listed(poles: Iterable[complex]) -> tuple[complex, ...]:
    """Poles of an array as a board takes them."""
    return tuple(complex(p) for p in poles)


def kicks(design: Design, model: Model) -> tuple[tuple[float, tuple[float, ...]], ...]:
    """The impulse that the kick button has put into the design, if any; a sampled plant feels it at the next sample."""
    step = model.plant.dt
    at = step * np.ceil(design["kick"] / step - 1e-9) if step else design["kick"]
    return ((float(at), model.kick),) if design["kick"] >= 0 else ()


def stage(model: Model, run: Run) -> Stage:
    """The plant and its ghost along a run."""
    xhat = run.xhat if run.xhat.shape == run.x.shape else None
    return Stage(model.body, run.t, run.x, xhat, run.u_applied)


def state_figures(model: Model, run: Run, count: int = 3) -> tuple[TimeFigure, ...]:
    """The watched signals with their estimates, one figure each."""
    figures = []
    for i, signal in enumerate(model.watched[:count]):
        true, guess = signal.of(run.x), signal.of(run.xhat)
        gap = float(np.max(np.abs(true[-max(len(true) // 10, 1):] - guess[-max(len(true) // 10, 1):])))
        figures.append(TimeFigure(
            f"state{i}", signal.name, run.t,
            (Curve(Text("true", "真实"), true), Curve(Text("estimate", "估计"), guess, "estimate", "dash")),
            axis_name(signal), tab=TIME_TAB,
            caption=_agreement(gap, float(np.max(np.abs(true), initial=0.0)), signal.unit)))
    return tuple(figures)


def axis_name(signal: Signal) -> str:
    """The symbol at the end of a signal's name with its unit, or the unit alone."""
    last = signal.name.en.split()[-1]
    unit = f"[{signal.unit}]" if signal.unit else ""
    return f"{last} {unit}".strip() if len(last) <= 2 else unit


def _agreement(gap: float, size: float, unit: str) -> Text:
    """How well an estimate agrees with the truth in the last tenth of a run."""
    if gap <= 1e-3 * size:
        return Text("The estimate has caught up with the truth.", "估计已经追上真实值。")
    return Text(f"In the last tenth of the run they differ by up to {gap:.2g} {unit}.",
                f"在运行的最后十分之一，二者最多相差 {gap:.2g} {unit}。")


def error_figure(run: Run, promised: np.ndarray | None = None) -> TimeFigure:
    """The norm of the estimation error on a logarithmic axis, beside what ė = (A − LC)e promises."""
    size = np.linalg.norm(run.e, axis=1)
    curves = [Curve(Text("‖e‖", "‖e‖"), size, "error")]
    if promised is not None:
        curves.append(Curve(Text("promised by A − LC", "按 A − LC 的理论值"), np.linalg.norm(promised, axis=1), "reference",
                            "dash", 1.6))
    small = settle_time(run.t, size)
    caption = (Text(f"The error stays below 2 % of its peak after {small:.2f} s.", f"{small:.2f} s 之后误差一直小于峰值的 2 %。")
               if small is not None else Text("The error does not settle within this run.", "误差在本次运行中没有衰减下来。"))
    return TimeFigure("error", Text("estimation error", "估计误差"), run.t, tuple(curves), "‖x − x̂‖", log=True,
                      caption=caption, tab=ERROR_TAB)


def input_figure(run: Run, model: Model, limit: float | None = None) -> TimeFigure:
    """Inputs asked (dashed) and applied (solid), with the limits."""
    curves = []
    for j, name in enumerate(run.scenario.plant.input_names):
        role = ("force", "disturbance", "second")[j % 3]
        applied, asked = run.u_applied[:, j] * model.input_scale, run.u_asked[:, j] * model.input_scale
        shown = (Text("input {}", "输入 {}").format(called(model.plant, name)) if model.controller is not None else
                 INPUTS.get(name, same(symbol(name))))
        curves.append(Curve(shown, applied, role))
        if not np.array_equal(applied, asked):
            curves.append(Curve(Text(f"{shown.en} asked", f"{shown.zh} 指令"), asked, role, "dash", 1.6))
    if limit is not None:
        flat = np.full(len(run.t), limit * model.input_scale)
        curves += [Curve(Text("limit", "限幅"), sign * flat, "reference", "dot", 1.4) for sign in (1, -1)]
    peak = float(np.max(np.abs(run.u_applied))) * model.input_scale
    return TimeFigure("input", Text("input, asked and applied", "输入：指令与实际"), run.t, tuple(curves),
                      f"u [{model.input_unit}]", tab=ERROR_TAB,
                      caption=Text(f"Largest input applied: {peak:.3g} {model.input_unit}.",
                                   f"实际输入的最大值：{peak:.3g} {model.input_unit}。"))


BEYOND = Text(" What lies beyond the scale is drawn at its edge.", " 超出坐标范围的部分画在边缘。")


def within(figure: TimeFigure, edge: float) -> TimeFigure:
    """The figure with values beyond ±edge drawn at the edge, which its caption then says: a lost loop leaves every scale."""
    if all(np.all(np.abs(c.y) <= edge) for c in figure.curves):
        return figure
    return replace(figure, curves=tuple(replace(c, y=np.clip(c.y, -edge, edge)) for c in figure.curves),
                   caption=Text(figure.caption.en + BEYOND.en, figure.caption.zh + BEYOND.zh.strip()))


def settle_time(t: np.ndarray, size: np.ndarray, share: float = 0.02) -> float | None:
    """When `size` goes below a share of its peak for good; None if it does not, or only in the last twentieth of the run."""
    above = np.flatnonzero(size > share * float(np.max(size, initial=0.0)))
    if not len(above):
        return 0.0
    return None if above[-1] >= 0.95 * (len(t) - 1) else float(t[above[-1] + 1])


def number(value: float, digits: int = 3) -> str:
    """A number for a live formula: short, with a true minus sign, powers of ten only where they help."""
    if value == 0 or not np.isfinite(value):
        return "0" if value == 0 else r"\infty"
    if abs(value) >= 1e5 or abs(value) < 10 ** (-digits):
        mantissa, exponent = f"{value:.{max(digits - 2, 0)}e}".split("e")
        return rf"{mantissa} \cdot 10^{{{int(exponent)}}}"
    short = f"{value:.{digits}g}"
    return f"{value:.0f}" if "e" in short else short


def tiny(value: float) -> str:
    """The order of magnitude of a rounding error as words: 10⁻¹⁵, or 0."""
    if value == 0 or not np.isfinite(value):
        return "0" if value == 0 else "∞"
    return "10" + str(round(float(np.log10(abs(value))))).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def matrix(M: np.ndarray, digits: int = 3, changed: Sequence[tuple[int, int]] = ()) -> str:
    """A matrix as LaTeX with its present entries; `changed` ones stand out."""
    def entry(i: int, j: int) -> str:
        words = number(float(M[i, j]), digits)
        return rf"\color{{#D55E00}}{{{words}}}" if (i, j) in changed else words
    rows = r" \\ ".join(" & ".join(entry(i, j) for j in range(M.shape[1])) for i in range(M.shape[0]))
    return rf"\begin{{bmatrix}} {rows} \end{{bmatrix}}"


def gain_words(symbol: str, M: np.ndarray) -> str:
    """A gain as LaTeX: its entries, or its size where they are too many to read."""
    return rf"{symbol} = {matrix(M)}" if M.size <= MOST_ENTRIES else rf"\| {symbol} \| = {number(float(np.linalg.norm(M, 2)))}"


def pole_words(poles: Sequence[complex]) -> str:
    """Poles as words: −4 ± 5j, −2."""
    near = [(p, 1e-6 * max(1.0, abs(p))) for p in poles]  # a double pole comes back split by the root of rounding
    names = [f"{p.real:.3g}" if abs(p.imag) < tiny else f"{p.real:.3g} ± {p.imag:.3g}j" for p, tiny in near if p.imag >= -tiny]
    return ", ".join(names).replace("-", "−")


__all__ = [
    "EngineError",
    "axis_name",
    "bolts",
    "by_hand",
    "error_figure",
    "fair",
    "feedback",
    "gain_words",
    "gains",
    "injection",
    "input_figure",
    "kicks",
    "listed",
    "matrix",
    "method_knobs",
    "number",
    "pole_boards",
    "pole_knobs",
    "pole_words",
    "run_knobs",
    "settle_time",
    "sizes",
    "sped",
    "stage",
    "state_figures",
    "within",
]
