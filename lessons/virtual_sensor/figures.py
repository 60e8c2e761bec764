"""The figures of lesson 1: core, case and power; errors and what the observer hears; the poles as trust grows."""

from __future__ import annotations

import numpy as np

from app.engine.simulation import Run
from app.lesson.figures import Curve, Figure, PlaneFigure, Point, TimeFigure
from app.lesson.lesson import Outcome
from app.text.words import Text

from ..toolkit.figures import TIME_TAB
from .knobs import HORIZON
from .study import Study

ERROR_TAB = Text("Error", "误差")
TRUST_TAB = Text("Trust", "信任")
TRUE, COPY, OBSERVER = Text("true", "真实"), Text("open-loop copy", "开环副本"), Text("observer", "观测器")


def _at_most(value: float) -> Text:
    return (Text(f"at most {value:.2g} K", f"不超过 {value:.2g} K") if value >= 1e-3 else
            Text("less than 0.001 K", "小于 0.001 K"))


def figures(outcome: Outcome[Study]) -> tuple[Figure, ...]:
    """Core, case and power over time; the errors and what the observer hears; the poles as trust grows."""
    run, seen = outcome.run, outcome.study
    assert run is not None
    return (_core(outcome, run, seen.copy), _case(outcome, run, seen.copy), _power(run), _errors(outcome, run, seen.copy),
            _innovation(outcome, run), _locus(outcome, seen))


def _core(outcome: Outcome[Study], run: Run, copy: Run) -> TimeFigure:
    m = outcome.metrics
    known = (Text(f"The observer knows the core within 1 K after {m['known_after']:.2f} s; ",
                  f"{m['known_after']:.2f} s 之后，观测器对内核的误差小于 1 K；") if m["known_after"] <= HORIZON else
             Text("The observer does not know the core within 1 K; ", "观测器对内核的误差没有降到 1 K 以内；"))
    off = f"{m['copy_core_error']:.2g}"
    return TimeFigure("core", Text("core temperature (nobody can measure it)", "内核温度（无法测量）"), run.t, (
        Curve(TRUE, run.x[:, 0]), Curve(COPY, copy.xhat[:len(run.t), 0], "second", "dot"),
        Curve(OBSERVER, run.xhat[:, 0], "estimate", "dash")), "T₁ [K]", tab=TIME_TAB, window=(0.0, 50.0),
        caption=Text(f"{known.en}the copy is off by up to {off} K at the end.",
                     f"{known.zh}开环副本在末段最多差 {off} K。"))


def _case(outcome: Outcome[Study], run: Run, copy: Run) -> TimeFigure:
    gap = _at_most(outcome.metrics["case_error"])
    reading = (Curve(Text("sensor", "传感器读数"), run.y[:, 0], "muted", "solid", 1.0),) if outcome.design["noise"] else ()
    return TimeFigure("case", Text("case temperature (the sensor sits here)", "外壳温度（传感器在此）"), run.t, (
        *reading, Curve(TRUE, run.x[:, 1]), Curve(COPY, copy.xhat[:len(run.t), 1], "second", "dot"),
        Curve(OBSERVER, run.xhat[:, 1], "estimate", "dash")), "T₂ [K]", tab=TIME_TAB, window=(0.0, 25.0),
        caption=Text(f"In the last tenth of the run the observer's case is off by {gap.en}.",
                     f"最后十分之一时间里，观测器的外壳温度误差{gap.zh}。"))


def _power(run: Run) -> TimeFigure:
    peak = float(np.max(run.u_applied))
    return TimeFigure("power", Text("computing power, known to all three", "计算功率，三者都知道"), run.t,
                      (Curve(Text("power", "功率"), run.u_applied[:, 0], "force"),), "P [W]", tab=TIME_TAB,
                      window=(0.0, 20.0), caption=Text(f"Bursts of {peak:g} W; a quarter of it in between.",
                                                       f"每次突发 {peak:g} W，间歇时为其四分之一。"))


def _errors(outcome: Outcome[Study], run: Run, copy: Run) -> TimeFigure:
    ours, theirs = outcome.metrics["slowest_observer"], outcome.metrics["slowest_copy"]
    return TimeFigure("error", Text("size of the core error", "内核温度误差的大小"), run.t, (
        Curve(COPY, np.abs(copy.e[:len(run.t), 0]), "second", "dot"), Curve(OBSERVER, np.abs(run.e[:, 0]), "error")),
        "|e₁| [K]", log=True, tab=ERROR_TAB, window=(1e-4, 100.0), caption=Text(
            f"Slowest modes: copy {_rate(theirs)}, observer {_rate(ours)} per second.",
            f"最慢的模态：副本 {_rate(theirs)}，观测器 {_rate(ours)}（每秒）。"))


def _rate(value: float) -> str:
    return f"{value:+.3g}".replace("-", "−")


def _innovation(outcome: Outcome[Study], run: Run) -> TimeFigure:
    heard = (run.y - run.yhat)[:, 0]
    tail = _at_most(float(np.max(np.abs(heard[-max(len(heard) // 10, 1):]))))
    return TimeFigure("innovation", Text("what the observer hears: y − ŷ", "观测器听到的：y − ŷ"), run.t,
                      (Curve(Text("y − ŷ", "y − ŷ"), heard, "error"),), "y − ŷ [K]", tab=ERROR_TAB, window=(-10.0, 20.0),
                      caption=Text(f"Sensor minus prediction, {tail.en} in the last tenth of the run; L carries it "
                                   "into both states.",
                                   f"读数减预测，最后十分之一时间内{tail.zh}；L 把它送进两个状态。"))


def _locus(outcome: Outcome[Study], seen: Study) -> PlaneFigure:
    path = Text("path of a pole", "极点的轨迹")
    curves = tuple(Curve(path, branch.imag, "muted", width=1.6, x=branch.real) for branch in seen.poles.T)
    points = (*(Point(float(p.real), float(p.imag), "second", "circle") for p in outcome.poles["copy"]),
              *(Point(float(p.real), float(p.imag), "estimate") for p in outcome.poles["observer"]))
    least = outcome.metrics["least_trust"]
    need = (Text(f"This chip needs θ above {least:.3f}.", f"这块芯片要求 θ 大于 {least:.3f}。") if least > 0 else
            Text("This chip forgives θ = 0, slowly.", "这块芯片允许 θ = 0，只是忘得慢。"))
    return PlaneFigure("locus", Text("poles of A − θL₁C as trust grows", "A − θL₁C 的极点随 θ 的轨迹"), curves, points,
                       "Re s", "Im s", (-5.0, 1.0), (-2.2, 2.2), unstable=True, tab=TRUST_TAB, caption=Text(
                           f"Circles: θ = 0, the copy. Crosses: θ = {outcome.design['trust']:g} now. {need.en}",
                           f"圆圈：θ = 0，即开环副本。叉号：现在的 θ = {outcome.design['trust']:g}。{need.zh}"))
