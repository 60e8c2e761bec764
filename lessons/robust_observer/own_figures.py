"""Figures of the lesson on a person's own plant."""

from __future__ import annotations

import numpy as np

from app.engine.observers import FunctionalObserver, criterion
from app.lesson.figures import Curve, Figure, LineFigure, PlaneFigure, Point, TableFigure, over_frequency
from app.lesson.lesson import Design, Outcome
from app.text.words import Text

from ..toolkit.latex import pole_words
from .figures import J_TAB, NONE, TIME_TAB
from .own_job import inside
from .own_loop import Run, Story

LOOP_TAB = Text("Loop", "闭环")
CHOSEN, RLO, MODEL = Text("true plant", "真实对象"), Text("true plant, RLO", "真实对象，RLO"), Text("model", "模型")


def all_figures(outcome: Outcome[Story]) -> tuple[Figure, ...]:
    """Time, criterion, loop: at most three in a tab."""
    story = outcome.study
    return (_error(outcome, story), _signal(story), _compared(outcome, story), _attempts(story), _gain(story),
            _plane(outcome.design, story))


def _error(outcome: Outcome[Story], story: Story) -> LineFigure:
    late, size = outcome.metrics["late_error"], outcome.metrics["late_wanted"]
    ideal = story.model.late(story.model.e)
    curves = [Curve(CHOSEN, story.true.e, "error"), Curve(MODEL, story.model.e, "reference", "dash", 1.6)]
    said = Text(f"In the last quarter up to {late:.2g} on the true plant, {ideal:.2g} on the model; wanted: up to {size:.2g}.",
                f"最后四分之一时间内，对真实对象最多 {late:.2g}，对模型最多 {ideal:.2g}；待估计的量最大 {size:.2g}。")
    if story.found_run is not None:
        curves.append(Curve(RLO, story.found_run.e, "force", "dot"))
    return LineFigure("e_u", Text(f"error of the estimate: {story.name.en}", f"估计误差：{story.name.zh}"), story.true.t, tuple(curves),
                      f"e [{story.unit}]", caption=said, tab=TIME_TAB)


def _signal(story: Story) -> LineFigure:
    run, sign = story.true, -1.0 if story.fed else 1.0
    push = run.v if story.fed else 0.0
    title = Text("input wanted and given", "期望输入与实际给出的输入") if story.fed else Text("state and its estimate", "状态及其估计")
    names = ((Text("wanted, −Kx + v", "期望的 −Kx + v"), Text("given", "实际给出的")) if story.fed
             else (Text("true", "真实"), Text("estimate", "估计")))
    wanted, given = sign * run.wanted + push, sign * (run.wanted - run.e) + push
    return LineFigure("signal", title, run.t, (Curve(names[0], wanted, "plant"), Curve(names[1], given, "estimate", "dash"),
                                               Curve(Text("v", "v"), run.v, "muted", "dot", 1.4)), f"[{story.unit}]", tab=TIME_TAB,
                      caption=Text(f"Largest difference: {np.abs(run.e).max():.3g}.", f"最大相差 {np.abs(run.e).max():.3g}。"))


# --- criterion -----------------------------------------------------------------------------------------------------
def _parts(o: FunctionalObserver) -> tuple[str, ...]:
    """The three sums of J."""
    w, nothing = o.wrong, np.zeros
    T, L, M = nothing(o.T.shape), nothing(o.L.shape), nothing(o.M.shape)
    return tuple(f"{criterion(*rows, w, norm=o.norm):.4g}" for rows in ((o.T, L, M), (T, o.L, M), (T, L, o.M)))


def _compared(outcome: Outcome[Story], story: Story) -> TableFigure:
    """The chosen observer beside that of RLO."""
    def column(o: FunctionalObserver, run: Run) -> tuple[Text | str, ...]:
        within = Text("yes", "是") if inside(o.poles, outcome.design) else Text("no", "否")
        return (str(o.order), pole_words(list(o.poles)), within, f"{o.J:.5g}", *_parts(o), f"{o.condition:.3g}", f"{o.output_residual:.1e}",
                f"{run.late(run.e):.3g}",
                f"{run.poles.real.max():.3g}".replace("-", "−"))
    ours = column(story.observer, story.true)
    found = story.found
    theirs = (column(found.observer, story.found_run) if found is not None and story.found_run is not None
              else (NONE,) * len(ours))
    names = (Text("order", "阶数"), Text("poles", "极点"), Text("in the region", "在区域内"), Text("J", "J"),
             Text("α Σ‖TAᵢ‖", "α Σ‖TAᵢ‖"), Text("β Σ‖LCᵢ‖", "β Σ‖LCᵢ‖"),
             Text("γ Σ‖MCᵢ‖", "γ Σ‖MCᵢ‖"), Text("condition of [T; C]", "[T; C] 的条件数"), Text("K missed by", "K 的误差"),
             Text("error at the end", "末段误差"),
             Text("slowest pole of the loop", "闭环最慢的极点"))
    if found is None:
        said = Text("RLO has not run yet: press the button “Run algorithm RLO”.", "RLO 尚未运行：请按“运行算法 RLO”。")
    elif found.observer.order != story.observer.order:
        said = Text("The orders differ; J of observers of different order is to be compared with care.",
                    "两者阶数不同；不同阶数的观测器之间，J 只宜谨慎比较。")
    else:
        ratio = story.observer.J / max(found.value, 1e-300)
        said = Text(f"The chosen J is {ratio:.3g} times that of RLO.", f"所选观测器的 J 是 RLO 的 {ratio:.3g} 倍。")
    return TableFigure("compared", Text("chosen and RLO", "所选观测器与 RLO"), (Text("", ""), Text("chosen", "所选"), Text("RLO", "RLO")),
                       tuple(zip(names, ours, theirs, strict=True)), caption=said, tab=J_TAB)


def _attempts(story: Story) -> TableFigure:
    """What RLO tried on its way."""
    rows: tuple[tuple[Text | str, ...], ...] = ((NONE, NONE, NONE, NONE),)
    if story.found is not None:
        rows = tuple((str(a.order), "✓" if a.feasible else "✗", f"{a.gap:.2g}", f"{a.J:.5g}" if np.isfinite(a.J) else NONE)
                     for a in story.found.attempts)
    said = (Text("Algorithm RLO raises the order until the conditions can be met; it has not run yet.",
                 "算法 RLO 逐阶提高，直到条件能满足；尚未运行。") if story.found is None else
            Text("Share of K that is missed at best: where it is not zero the order is raised.",
                 "达不到的 K 的相对误差：不为零时阶数加一。"))
    return TableFigure("attempts", Text("algorithm RLO inside the region", "区域内的算法 RLO"),
                       (Text("order", "阶数"), Text("exists", "存在"), Text("K missed by", "K 的误差"), Text("least J", "最小 J")), rows,
                       caption=said, tab=J_TAB)


# --- loop ----------------------------------------------------------------------------------------------------------
def _gain(story: Story) -> LineFigure:
    run = story.true
    top = max(float(run.gain.max()), 1e-300)
    floor = 1e-8 * top
    curves = [Curve(CHOSEN, np.maximum(run.gain, floor), "error")]
    if story.found_run is not None:
        curves.append(Curve(RLO, np.maximum(story.found_run.gain, floor), "force", "dot"))
    k = int(np.argmax(run.gain))
    said = (Text("The loop is unstable, so the gain has no meaning over time.", "闭环不稳定，该增益没有时域意义。")
            if run.poles.real.max() >= 0 else
            Text(f"Largest {run.gain[k]:.3g}, near {run.f[k]:.3g} Hz; on the model it would be zero.",
                 f"最大 {run.gain[k]:.3g}，在 {run.f[k]:.3g} Hz 附近；对模型则为零。"))
    return over_frequency("gain", Text("from v to the error of the estimate", "由 v 到估计误差的增益"), run.f, tuple(curves), "|e/v|",
                          caption=said, tab=LOOP_TAB)


def _plane(design: Design, story: Story) -> PlaneFigure:
    w = story.window
    low, high = 1.6 * w.re_low, max(w.re_high, 0.3 * -w.re_low)
    tall = 1.2 * w.im_high
    points = [Point(float(np.clip(p.real, low, high)), float(np.clip(p.imag, -tall, tall)), role, mark)  # type: ignore[arg-type]
              for poles, role, mark in ((story.true.poles, "plant", "dot"), (story.observer.poles, "estimate", "cross")) for p in poles]
    if story.found is not None:
        points += [Point(float(np.clip(p.real, low, high)), float(np.clip(p.imag, -tall, tall)), "force", "circle")
                   for p in story.found.observer.poles]
    a, b, c = (design[name] for name in ("region_low", "region_high", "region_tall"))
    lines = (Curve(Text("region of RLO", "RLO 区域"), np.array([-c, -c, c, c, -c]), "reference", "dot", 1.6, np.array([a, b, b, a, a])),)
    outside = int(np.count_nonzero((story.true.poles.real < low) | (np.abs(story.true.poles.imag) > tall)))
    return PlaneFigure("plane", Text("poles of the loop and of the observer", "闭环与观测器的极点"), lines, tuple(points), "Re s", "Im s",
                       (low, high), (-tall, tall), unstable=True, tab=LOOP_TAB,
                       caption=Text(f"Dots: loop with the true plant, {outside} of them on the edge. Crosses: observer. Circles: RLO.",
                                    f"圆点：真实对象的闭环，其中 {outside} 个画在边缘。叉号：观测器。圆圈：RLO。"))
