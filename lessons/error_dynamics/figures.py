"""The figures of lesson 2: signals and force; the error with and without the force; the page of the notes."""

from __future__ import annotations

import math

import numpy as np

from app.engine.simulation import Run
from app.lesson.figures import Curve, Figure, TableFigure, TimeFigure
from app.lesson.lesson import Outcome
from app.text.words import Text, same

from ..toolkit.figures import TIME_TAB, state_figures
from .notes import notes_figures
from .study import NOTHING, Setting, Study, left_alone

ERROR_TAB = Text("Error", "误差")


def figures(here: Setting, outcome: Outcome[Study]) -> tuple[Figure, ...]:
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


def _size(outcome: Outcome[Study], run: Run, quiet: Run) -> TimeFigure:
    after = outcome.metrics["settled_after"]
    said = (Text(f"The error stays below 2 % of its peak after {after:.2f} s.", f"{after:.2f} s 之后误差一直小于峰值的 2 %。")
            if after <= run.scenario.horizon else Text("The error does not settle within this run.", "误差在本次运行中没有衰减下来。"))
    return TimeFigure("error", Text("size of the error", "误差的大小"), run.t, (
        Curve(Text("with this input", "有这个输入"), np.linalg.norm(run.e, axis=1), "error"),
        Curve(Text("without input", "没有输入"), _beside(np.linalg.norm(quiet.e, axis=1), len(run.t)), "reference", "dash", 1.6)),
        "‖e‖", log=True, tab=ERROR_TAB, window=(1e-6, 1.0), caption=said)


def _components(here: Setting, outcome: Outcome[Study], run: Run, quiet: Run) -> TimeFigure:
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


def _proof(here: Setting, outcome: Outcome[Study], run: Run, quiet: Run) -> TableFigure:
    if outcome.metrics["state_moved"] <= NOTHING:
        said = Text("no input acts, so nothing parts.", "现在没有输入，所以什么都没有分开。")
    elif left_alone(outcome.metrics):
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
