"""Error dynamics: steer a block on a spring as you like; the error of its observer does not notice."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from app.engine import Plant, Scenario, observer_gain, simulate
from app.engine.simulation import Run
from app.engine.systems import sorted_poles
from app.lesson.figures import Curve, Figure, TableFigure, TimeFigure
from app.lesson.knobs import Choice, Number, Poles, Track
from app.lesson.lesson import Board, Check, Design, Formula, Lesson, Outcome, Task
from app.lesson.prose import read_prose
from app.plants import MODELS, Model
from app.text.words import Text, same

from ..toolkit.boards import bolts, listed, stage
from ..toolkit.figures import TIME_TAB, settle_time, state_figures
from ..toolkit.knobs import kicks, run_knobs
from ..toolkit.latex import gain_words, matrix
from .notes import FIRST, LINES, NONE, PLANT, PRINTED_GAIN, notes_figures, poles_of, printed_model
from .tasks import PRINTED, QUIET, confused, double_pole, exam, first_slip, mixed_matrix

MODEL = MODELS["spring-damper"]
WINDOW = MODEL.observer_window
HORIZON, DT = 15.0, 0.03
HOLD = 20  # steps for which a random force is held
MOST_FORCE = 2.0
ROUNDING = 1e-9  # an error moved by less than this share of the state is moved by rounding alone
NOTHING = 1e-12  # a state moved by less has not been pushed at all
POLES, NUMBERS = "poles", "numbers"
ERROR_TAB = Text("Error", "误差")
PRINTED_MODEL = printed_model()

KNOBS = (
    Choice("input", "u", Text("force", "力"), default="sine", options=(
        (QUIET, Text("none", "无")), ("step", Text("step", "阶跃")), ("sine", Text("sine", "正弦")),
        ("square", Text("square wave", "方波")), ("random", Text("random", "随机")), ("hand", Text("your own hand", "手动"))),
        hint=Text("The plant and the observer get the same force.", "对象和观测器得到同一个力。")),
    Number("amplitude", r"u_0", Text("amplitude", "幅值"), "N", low=0.0, high=MOST_FORCE, default=1.0, step=0.05,
           when=("input", ("step", "sine", "square", "random")),
           hint=Text("1 N held for long stretches the spring by 1 m.", "1 N 的恒力最终把弹簧拉长 1 m。")),
    Number("frequency", "f", Text("frequency", "频率"), "Hz", low=0.02, high=1.0, default=0.15, step=0.01,
           when=("input", ("sine", "square")),
           hint=Text("The block swings most near 0.15 Hz.", "在 0.15 Hz 附近滑块摆动最大。")),
    Number("seed", r"s_0", Text("random seed", "随机种子"), low=0, high=9999, default=1, scale="integer",
           when=("input", ("random",)), hint=Text("The same seed gives the same force.", "同一种子给出同一串力。")),
    Track("hand", "u", Text("force by hand", "手动施力"), "N", low=-MOST_FORCE, high=MOST_FORCE, when=("input", ("hand",)),
          hint=Text("Press play and move this: your hand is recorded.", "按下播放，再移动它：你的手法会被记录下来。")),
    Choice("method", "L", Text("gain by", "增益由"), default=POLES, options=(
        (POLES, Text("dragging poles", "拖动极点")), (NUMBERS, Text("typing numbers", "输入数值")),
        (PRINTED, Text("the notes, as printed", "照讲义所印"))),
        hint=Text("The last choice runs matrix and gain exactly as the notes print them.",
                  "最后一项完全照讲义所印的矩阵和增益运行。")),
    Poles("observer_poles", "q", Text("Observer poles", "观测器极点"), "rad/s", default=MODEL.observer_poles,
          re_low=WINDOW.re_low, re_high=WINDOW.re_high, im_high=WINDOW.im_high, role="estimate",
          when=("method", (POLES,)), hint=Text("The eigenvalues of A − LC; the engine finds L.", "A − LC 的特征值，由引擎求出 L。")),
    Number("l1", r"l_1", same("l₁"), "1/s", low=-5.0, high=10.0, default=1.0, step=0.05, when=("method", (NUMBERS,)),
           hint=Text("How strongly y − ŷ corrects the position.", "y − ŷ 对位置估计的校正强度。")),
    Number("l2", r"l_2", same("l₂"), "1/s²", low=-10.0, high=20.0, default=0.0, step=0.05, when=("method", (NUMBERS,)),
           hint=Text("How strongly y − ŷ corrects the velocity.", "y − ŷ 对速度估计的校正强度。")),
    Number("guess_q", r"\hat q(0)", Text("guessed position", "猜测的位置"), "m", low=-2.0, high=2.0, default=0.0, step=0.05,
           hint=Text("The block really starts at 1 m.", "滑块实际从 1 m 处开始。")),
    Number("guess_v", r"\hat v(0)", Text("guessed velocity", "猜测的速度"), "m/s", low=-2.0, high=2.0, default=0.0, step=0.05,
           hint=Text("The block really starts at rest.", "滑块实际从静止开始。")),
    Choice("line", "", Text("line of the notes in doubt", "讲义中可疑的一行"), default=NONE, options=LINES,
           hint=Text("The tab Notes shows where this line leads.", "“讲义”标签页显示照这一行会得到什么。")),
    run_knobs(HORIZON)[1],
)


@dataclass(frozen=True, eq=False)
class Setting:
    """The plant of the lesson, what is believed of it and the gain in a design, the first guess, how long it runs.

    `notes`: whether the page of the notes is about this plant. `whose`: what the left board is called.
    """

    model: Model
    horizon: float
    dt: float
    belief: Callable[[Design], Plant]
    gain: Callable[[Design], np.ndarray]
    guess: Callable[[Design], tuple[float, ...]]
    parts: tuple[tuple[Text, str], ...]  # names of the first two errors, and the unit
    whose: Text
    notes: bool = False


@dataclass(frozen=True, eq=False)
class Twin:
    """The same run without any input, and the matrix that drives the error."""

    quiet: Run
    error: np.ndarray


def force(design: Design, horizon: float = HORIZON, dt: float = DT) -> np.ndarray:
    """The force over the run (n_t,) in N, held between grid points."""
    t = dt * np.arange(round(horizon / dt) + 1)
    kind, size = design["input"], design["amplitude"]
    if kind == "step":
        return np.full(len(t), size)
    if kind == "sine":
        return size * np.sin(2 * np.pi * design["frequency"] * t)
    if kind == "square":
        return np.where((t * design["frequency"]) % 1.0 < 0.5, size, -size)
    if kind == "random":
        rng = np.random.default_rng(int(design["seed"]))
        return np.repeat(rng.uniform(-size, size, len(t) // HOLD + 1), HOLD)[:len(t)]
    if kind == "hand" and design["hand"]:
        times, values = np.array(design["hand"]).T
        return np.concatenate([[0.0], values])[np.searchsorted(times, t + 1e-9 * dt, side="right")]
    return np.zeros(len(t))


def gain(design: Design) -> np.ndarray:
    """L (2×1): from the poles, typed, or as the notes print it."""
    if design["method"] == PRINTED:
        return PRINTED_GAIN
    if design["method"] == NUMBERS:
        return np.array([[design["l1"]], [design["l2"]]])
    return observer_gain(PLANT.A, PLANT.C, design["observer_poles"]).gain


BLOCK = Setting(
    MODEL, HORIZON, DT, lambda design: PRINTED_MODEL if design["method"] == PRINTED else PLANT, gain,
    lambda design: (design["guess_q"], design["guess_v"]), ((same("e₁"), "m"), (same("e₂"), "m/s")),
    Text("the block's own poles  eig(A)", "滑块自身的极点  eig(A)"), notes=True)


def compute(here: Setting, design: Design) -> Outcome:
    """One run with the chosen force and one without any, from the same start and with the same kick."""
    model, plant = here.model, here.model.plant
    L, belief = here.gain(design), here.belief(design)
    error = belief.A - L @ belief.C
    push = np.zeros((round(here.horizon / here.dt) + 1, plant.m))
    push[:, 0] = force(design, here.horizon, here.dt)
    steered = Scenario(plant, None, L, model=belief, x0=model.x0, xhat0=here.guess(design),
                       horizon=here.horizon, dt=here.dt, reference=push, impulses=kicks(design, model))
    run, quiet = simulate(steered), simulate(replace(steered, reference=None))
    poles = poles_of(error) if plant.n == 2 else sorted_poles(error)
    metrics = _metrics(run, quiet) | {"slowest_observer": float(np.max(np.real(poles)))}
    checks = (
        Check("independent", Text("the error does not depend on the input", "误差与输入无关"),
              _left_alone(metrics), metrics["error_moved"]),
        Check("observer", Text("the error dies out by itself", "误差会自行消失"), metrics["slowest_observer"] < 0,
              metrics["slowest_observer"]),
    )
    return Outcome(design, {"L": L}, {"observer": poles, "plant": plant.poles}, metrics, checks, run,
                   _boards(here, design, poles, error), stage(model, run), _formulas(here, design, L, error), _live(metrics),
                   Twin(quiet, error))


def _metrics(run: Run, quiet: Run) -> dict[str, float]:
    count = min(len(run.t), len(quiet.t))
    size = np.linalg.norm(run.e, axis=1)
    settled = settle_time(run.t, size)
    return {
        "error_moved": float(np.max(np.abs(run.e[:count] - quiet.e[:count]))),
        "state_moved": float(np.max(np.abs(run.x[:count] - quiet.x[:count]))),
        "largest": float(max(np.max(np.abs(run.x)), np.max(np.abs(run.xhat)))),
        "final_error": float(np.max(size[-max(len(size) // 10, 1):])), "largest_error": float(np.max(size)),
        "settled_after": run.scenario.horizon + run.scenario.dt if settled is None else settled}


def _boards(here: Setting, design: Design, poles: np.ndarray, error: np.ndarray) -> tuple[Board, Board]:
    window, own = here.model.observer_window, here.model.plant.poles
    shown = design["observer_poles"] if design["method"] == POLES else listed(poles)
    return (
        Board("plant", here.whose, listed(own), side="left", re_low=window.re_low, re_high=window.re_high,
              im_high=window.im_high),
        Board("observer", Text("observer poles  eig(A − LC)", "观测器极点  eig(A − LC)"), shown, "observer_poles",
              bolts(here.model.observer, window), role="estimate", side="right", re_low=window.re_low, re_high=window.re_high,
              im_high=window.im_high, also=(("method", POLES),), landscape=error),
    )


def _formulas(here: Setting, design: Design, L: np.ndarray, error: np.ndarray) -> tuple[Formula, ...]:
    gain_now = Formula("L", gain_words("L", L))
    if design["method"] != PRINTED:
        return (Formula("law", r"\dot e = (A - LC)\,e"), gain_now, Formula("error", gain_words("A - LC", error)))
    plant = here.model.plant
    leak = plant.A - L @ plant.C - error
    return (Formula("law", r"\dot e = M e + (A - LC - M)\,x"), gain_now, Formula("error", rf"M = {matrix(error)}"),
            Formula("leak", rf"A - LC - M = {matrix(leak)}"))


def _live(m: dict[str, float]) -> Text:
    if m["state_moved"] <= NOTHING:
        return Text("No input acts: plant and error are left to themselves.", "没有输入：对象和误差都各行其是。")
    moved = f"{m['state_moved']:.2g}"
    if not _left_alone(m):
        return Text(f"The input moves the state by up to {moved} and the error by up to {m['error_moved']:.2g}: the "
                    "error is not left alone.",
                    f"输入使状态最多改变 {moved}，使误差最多改变 {m['error_moved']:.2g}：误差受到了干扰。")
    return Text(f"The input moves the state by up to {moved} and the error by {m['error_moved']:.0e}: rounding, nothing "
                "else.",
                f"输入使状态最多改变 {moved}，使误差改变 {m['error_moved']:.0e}：只是舍入误差。")


def figures(here: Setting, outcome: Outcome) -> tuple[Figure, ...]:
    """Signals and force; the error with and without the force; the page of the notes."""
    run, twin = outcome.run, outcome.study
    assert run is not None
    page = notes_figures(outcome.design["line"], outcome.gains["L"]) if here.notes else ()
    return (*state_figures(here.model, run, 2), _force(here, run), _size(outcome, run, twin.quiet),
            _components(here, outcome, run, twin.quiet), _proof(here, outcome, run, twin.quiet), *page)


def _force(here: Setting, run: Run) -> TimeFigure:
    peak, unit = float(np.max(np.abs(run.u_applied))), here.model.input_unit
    calm = 0.5 * here.model.u_max if here.model.controller is not None else 1.0
    return TimeFigure("force", Text("force on the block, told to the observer", "施加的力，观测器也知道") if here.notes else
                      Text("input, told to the observer", "输入，观测器也知道"), run.t,
                      (Curve(Text("force", "力") if here.notes else Text("input", "输入"), run.u_applied[:, 0], "force"),),
                      f"u [{unit}]", tab=TIME_TAB, window=(-calm, calm),
                      caption=Text(f"Largest input: {peak:.3g} {unit}.", f"最大输入：{peak:.3g} {unit}。"))


def _beside(quiet: np.ndarray, count: int) -> np.ndarray:
    """The quiet run's curve on the time axis of the steered one: cut, or held where it ended early."""
    return quiet[:count] if len(quiet) >= count else np.concatenate([quiet, np.full(count - len(quiet), quiet[-1])])


def _size(outcome: Outcome, run: Run, quiet: Run) -> TimeFigure:
    after = outcome.metrics["settled_after"]
    said = (Text(f"The error stays below 2 % of its peak after {after:.2f} s.", f"{after:.2f} s 之后误差一直小于峰值的 2 %。")
            if after <= run.scenario.horizon else Text("The error does not settle within this run.", "误差在本次运行中没有衰减下来。"))
    return TimeFigure("error", Text("size of the error", "误差的大小"), run.t, (
        Curve(Text("with this input", "有这个输入"), np.linalg.norm(run.e, axis=1), "error"),
        Curve(Text("without input", "没有输入"), _beside(np.linalg.norm(quiet.e, axis=1), len(run.t)), "reference", "dash", 1.6)),
        "‖e‖", log=True, tab=ERROR_TAB, window=(1e-6, 1.0), caption=said)


def _components(here: Setting, outcome: Outcome, run: Run, quiet: Run) -> TimeFigure:
    m, dashes = outcome.metrics, ("solid", "dash")
    curves, units = [], []
    for (name, unit), signal, dash in zip(here.parts, here.model.watched, dashes, strict=False):
        units.append(unit)
        curves += [Curve(name, signal.of(run.e), "error", dash),  # type: ignore[arg-type]
                   Curve(Text(f"{name.en} without input", f"{name.zh}（无输入）"), _beside(signal.of(quiet.e), len(run.t)),
                         "reference", "dot", 1.4)]
    title = (Text("error in position e₁ and velocity e₂", "位置误差 e₁ 与速度误差 e₂") if here.notes else
             Text("error in two signals", "两个信号的误差"))
    calm = (-1.0, 1.0) if here.notes else None
    return TimeFigure("components", title, run.t, tuple(curves), f"e [{', '.join(units)}]", tab=ERROR_TAB, window=calm, caption=Text(
        f"Largest gap between the curves and their twins without input: {m['error_moved']:.1e}.",
        f"两组曲线与各自无输入时的曲线最大相差 {m['error_moved']:.1e}。"))


def _proof(here: Setting, outcome: Outcome, run: Run, quiet: Run) -> TableFigure:
    if outcome.metrics["state_moved"] <= NOTHING:
        said = Text("no input acts, so nothing parts.", "现在没有输入，所以什么都没有分开。")
    elif _left_alone(outcome.metrics):
        said = Text("the outputs part, the errors do not.", "输出分开了，误差没有。")
    else:
        said = Text("here the errors part as well.", "这里连误差也分开了。")
    last, signal = min(len(run.t), len(quiet.t)) - 1, here.model.watched[0]
    at = sorted({min(round(share * (round(here.horizon / here.dt))), last) for share in (0.0, 0.1, 0.2, 0.4, 0.7, 1.0)})
    q, q0, e, e0 = (signal.of(x) for x in (run.x, quiet.x, run.e, quiet.e))
    clock = 1 if here.horizon >= 5 else 1 - math.floor(math.log10(here.horizon))
    rows = tuple((f"{run.t[k]:.{clock}f}", _digits(q[k], 4), _digits(q0[k], 4), _digits(e[k], 6),
                  _digits(e0[k], 6), _order(abs(e[k] - e0[k]))) for k in at)
    name = "q" if here.notes else "y₁"
    return TableFigure("proof", Text("the proof in numbers", "用数字证明"), (
        same("t [s]"), Text(f"{name}, input", f"{name}，有输入"), Text(f"{name}, none", f"{name}，无输入"), Text("e₁, input", "e₁，有输入"),
        Text("e₁, none", "e₁，无输入"), Text("gap in e₁", "e₁ 之差")), rows, tab=ERROR_TAB, caption=Text(
            f"Two runs from one start, with this input and with none: {said.en}",
            f"同一初值的两次运行，一次有输入，一次无输入：{said.zh}"))


def _digits(value: float, places: int) -> str:
    return f"{round(float(value), places) + 0.0:.{places}f}".replace("-", "−")  # + 0.0: no minus before a zero


def _order(value: float) -> str:
    return f"{value:.0e}".replace("-", "−") if value else "0"


def _left_alone(m: Mapping[str, float]) -> bool:
    """Whether the force moves the error by rounding alone."""
    return m["error_moved"] <= ROUNDING * max(1.0, m["largest"])


def adapt(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant."""
    from .own import adapted

    return adapted(lesson, model)


LESSON = Lesson(
    "error-dynamics", 2, KNOBS, partial(compute, BLOCK), partial(figures, BLOCK), answer=1,
    tasks=(
        Task("double-pole", double_pole, {"method": POLES, "observer_poles": (-1.0, -1.0)}),
        Task("first-slip", first_slip, {"method": NUMBERS, "l1": 1.5, "l2": -0.75, "line": FIRST}),
        Task("mixed-matrix", mixed_matrix, {"method": NUMBERS, "l1": 2.5, "l2": -0.75, "line": "matrix"}),
        Task("confused", confused, {"method": PRINTED, "input": "step"}),
    ),
    exam=exam, source="Observer notes (001), equations (1)–(7) and the spring-damper example; tutorial (000)",
    words=read_prose(Path(__file__).parent), adapt=adapt)
