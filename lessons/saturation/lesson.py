"""Saturation: what the observer is told while the force is clipped, and which starts still come home."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from app.engine import Scenario, autonomous_error
from app.engine.simulation import Run, separation_meter
from app.lesson.figures import Curve, Figure
from app.lesson.knobs import Choice, KnobError, Number
from app.lesson.lesson import Check, Design, ExamItem, Formula, Job, Lesson, Outcome, Task, Verdict
from app.lesson.prose import read_prose
from app.plants import MODELS, Model
from app.text.words import Text

from ..toolkit.boards import pole_boards, stage
from ..toolkit.figures import error_figure, input_figure, state_figures, within
from ..toolkit.gains import gains
from ..toolkit.knobs import kicks, pole_knobs, run_knobs
from ..toolkit.latex import matrix
from .runs import comes_home, march, until, whole
from .starts import (
    GRID,
    HORIZON,
    Starts,
    ceiling,
    map_scenario,
    nearest,
    start_state,
    starts_figure,
    survey,
)

MODEL = MODELS["cart-pendulum"]
PLANT = MODEL.plant
DT = 0.02
COMMANDED, APPLIED = "commanded", "applied"
APPLIED_FORCE, ASKED_FORCE, LIMIT = Text("applied", "实际力"), Text("asked for", "指令力"), Text("limit", "限幅")
EXACT = 1e-9  # of the error's peak: how well ė = (A − LC)e must hold to count as exact
EDGES = MappingProxyType({"state0": 49.0, "state1": 1.95, "error": 90.0, "input": 24.5})  # values beyond are drawn at the edge

KNOBS = (
    Choice("fed", "", Text("the observer is told", "送给观测器的是"), default=COMMANDED,
           options=((COMMANDED, Text("the commanded force", "指令力")), (APPLIED, Text("the applied force", "实际力"))),
           hint=Text("What the controller asked for, or what the motor really gave.", "控制器要的力，或电机真正给出的力。")),
    Number("u_max", r"u_{\max}", Text("force limit", "力的限幅"), "N", low=1.0, high=10.0, default=4.0, step=0.1,
           hint=Text("The motor gives at most this much, either way.", "电机在两个方向上最多给出这么大的力。")),
    Number("angle0", r"\theta(0)", Text("true angle at the start", "初始真实角度"), "°", low=-20.0, high=20.0, default=6.0,
           step=0.5, hint=Text("Where the pole really leans when the run begins; the cart is at rest.",
                               "运行开始时摆杆的真实倾角；小车静止。")),
    Number("error0", r"e_\theta(0)", Text("error of its estimate", "角度的初始估计误差"), "°", low=-20.0, high=20.0,
           default=4.0, step=0.5, hint=Text("The observer believes θ(0) minus this error.", "观测器认为角度是 θ(0) 减去这一误差。")),
    *(replace(knob, when=None) for knob in pole_knobs(MODEL)),
    *run_knobs(HORIZON),
)


@dataclass(frozen=True, eq=False)
class Story:
    """One run as it is drawn: `shown` has every instant of the horizon, held once the pole has fallen.

    `promised` is what ė = (A − LC)e says (n_t, n), `known` the states had x been known (n_t, n), `starts` the map.
    """

    shown: Run
    promised: np.ndarray
    known: np.ndarray
    stopped: float | None
    starts: Starts | None


def depends(design: Design) -> tuple[Any, ...]:
    """The design values on which the map depends; the start is not among them."""
    return tuple(design[name] for name in ("fed", "u_max", "controller_poles", "observer_poles"))


def scenario_of(design: Design, K: np.ndarray, L: np.ndarray, state_feedback: bool = False) -> Scenario:
    """The clipped loop from the design's own start."""
    x0, xhat0 = start_state(design["angle0"], design["error0"])
    return Scenario(PLANT, K, L, x0=x0, xhat0=xhat0, horizon=HORIZON, dt=DT, u_min=-design["u_max"],
                    u_max=design["u_max"], fed=design["fed"], state_feedback=state_feedback,
                    impulses=kicks(design, MODEL), seed=int(design["seed"]))


def compute(design: Design) -> Outcome:
    """One clipped run, the same start with a known state, and what the error was promised."""
    K, L = gains(design, PLANT)
    run = march(scenario_of(design, K, L))
    shown, stopped = whole(run)
    ideal = march(scenario_of(design, K, L, state_feedback=True))
    known, _ = whole(ideal)
    seen = until(run, stopped)
    A, B, C = PLANT.A, PLANT.B, PLANT.C
    inside = A - L @ C if design["fed"] == APPLIED else A - B @ K - L @ C
    poles = {"controller": np.linalg.eigvals(A - B @ K), "observer": np.linalg.eigvals(A - L @ C),
             "clipped": np.linalg.eigvals(inside)}
    meter = separation_meter(seen)
    metrics = {
        "separation_meter": meter, "comes_home": float(comes_home(run)), "known_comes_home": float(comes_home(ideal)),
        "stopped_at": HORIZON if stopped is None else stopped, "clipped_rate": float(np.max(np.real(poles["clipped"]))),
        "clipped_for": DT * float(np.sum(np.abs(seen.u_asked) > design["u_max"] * (1 + 1e-9))),
        "largest_asked": float(np.max(np.abs(seen.u_asked))), "ceiling": ceiling(PLANT, design["u_max"]),
    }
    story = Story(shown, autonomous_error(shown), known.x, stopped, None)
    checks = (
        Check("autonomous", Text("the error lives by itself, ė = (A − LC)e", "误差独自演化，ė = (A − LC)e"), meter < EXACT, meter),
        Check("windup", Text("the compensator is stable while the force is clipped", "力被限幅时补偿器自身稳定"),
              metrics["clipped_rate"] < 0, metrics["clipped_rate"]),
        Check("home", Text("this start comes home", "这一初态能恢复"), comes_home(run), float(np.linalg.norm(run.x[-1]))),
    )
    boards = pole_boards(MODEL, design, poles["controller"], poles["observer"])
    return Outcome(design, {"K": K, "L": L}, poles, metrics, checks, seen, boards, stage(MODEL, shown),
                   _formulas(design, K, L, metrics), _live(design, metrics, stopped), story)


def amount(value: float) -> str:
    """A number for a sentence; what has left every scale is only said to be large."""
    return "> 1000" if value > 1000 else f"{value:.3g}" if value > 1e-9 else "0"


def _formulas(design: Design, K: np.ndarray, L: np.ndarray, metrics: Mapping[str, float]) -> tuple[Formula, ...]:
    told = design["fed"] == APPLIED
    rate = metrics["clipped_rate"]
    return (
        Formula("error", r"\dot e = (A-LC)\,e" if told else r"\dot e = (A-LC)\,e + B\,(\mathrm{sat}\,u - u)"),
        Formula("clipped", r"\dot{\hat x} = (A-LC)\,\hat x \pm B\,u_{\max} + L\,y" if told else
                r"\dot{\hat x} = (A-BK-LC)\,\hat x + L\,y",
                Text(f"The compensator while the force is clipped: rightmost eigenvalue {rate:.3g}.",
                     f"力被限幅时的补偿器：最右特征值 {rate:.3g}。")),
        Formula("K", rf"K = {matrix(K)}"),
        Formula("L", rf"L^{{\mathsf T}} = {matrix(L.T)}"),
    )


def _live(design: Design, metrics: Mapping[str, float], stopped: float | None) -> Text:
    meter, clipped = metrics["separation_meter"], metrics["clipped_for"]
    home = bool(metrics["comes_home"])
    end = (Text("The pole comes home.", "摆杆恢复直立。") if home else
           Text("The pole does not come home.", "摆杆没有恢复。") if stopped is None else
           Text(f"The pole falls: past 45° at {stopped:.2f} s.", f"摆杆倒下：{stopped:.2f} s 时越过 45°。"))
    limit = Text(f" The force is clipped for {clipped:.2f} s.", f" 力被限幅共 {clipped:.2f} s。")
    wall = (Text(" The error obeys A − LC all the same.", " 误差依然服从 A − LC。") if meter < EXACT else
            Text(f" Separation meter {amount(meter)}: what the motor did not give drives the error.",
                 f" 分离度量 {amount(meter)}：电机没有给出的那部分力在驱动误差。"))
    return Text(end.en + limit.en + wall.en, end.zh + limit.zh + wall.zh)


def figures(outcome: Outcome) -> tuple[Figure, ...]:
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


def _angle_words(outcome: Outcome) -> Text:
    stopped, ideal = outcome.study.stopped, bool(outcome.metrics["known_comes_home"])
    end = (Text(f"Fallen after {stopped:.2f} s; the run stops there and the curves are held.",
                f"{stopped:.2f} s 后倒下；运行到此为止，曲线保持不变。") if stopped is not None else
           Text("Caught.", "已扶住。") if outcome.metrics["comes_home"] else Text("Not caught yet.", "尚未扶住。"))
    known = (Text(" With x known, the same start comes home.", " 若 x 已知，同一初态能恢复。") if ideal else
             Text(" Even with x known, this start is lost.", " 即使 x 已知，这一初态也不能恢复。"))
    return Text(end.en + known.en, end.zh + known.zh)


def _position_words(outcome: Outcome) -> Text:
    gap = float(np.max(np.abs(outcome.run.e[:, 0]))) if outcome.run is not None else 0.0
    return Text(f"The position is measured. Largest error of its estimate: {amount(gap)} m.",
                f"位置是直接测量的，其估计误差最大为 {amount(gap)} m。")


def _error_words(outcome: Outcome) -> Text:
    meter = outcome.metrics["separation_meter"]
    if meter < EXACT:
        return Text("The error keeps its promise, clipped or not.", "无论是否限幅，误差都与理论值一致。")
    return Text(f"The error leaves its promise; separation meter {amount(meter)}.", f"误差偏离理论值；分离度量 {amount(meter)}。")


# --- the map -------------------------------------------------------------------------------------------------------
def find_starts(outcome: Outcome) -> Iterator[tuple[float, Outcome]]:
    """The job: the map of the design's gains, limit and feed, pass by pass."""
    if max(_slowest(outcome, name) for name in ("controller", "observer")) >= 0:
        raise KnobError(Text("A pole is not in the left half plane, so no start comes home; drag it to the left first.",
                             "有极点不在左半平面，没有初态能恢复；请先把它拖到左边。"))
    scenario = map_scenario(scenario_of(outcome.design, outcome.gains["K"], outcome.gains["L"]))
    for fraction, starts in survey(scenario, depends(outcome.design), outcome.study.starts):
        if starts is not outcome.study.starts and starts.done > 0:
            outcome = _with(outcome, starts)
        yield fraction, outcome


def _slowest(outcome: Outcome, name: str) -> float:
    return float(np.max(np.real(outcome.poles[name])))


def _with(outcome: Outcome, starts: Starts) -> Outcome:
    return replace(outcome, study=replace(outcome.study, starts=starts),
                   metrics={**outcome.metrics, "map_done": starts.done, "map_home": starts.home})


def carry(before: Outcome, after: Outcome) -> Outcome:
    """The map goes over to the next design if only the start has changed, and if it knows more."""
    old, new = before.study.starts, after.study.starts
    if old is None or old.key != depends(after.design) or (new is not None and new.done >= old.done):
        return after
    return _with(after, old)


def pick(outcome: Outcome, x: float, y: float) -> Mapping[str, Any]:
    """A click on the map: the start of the nearest cell, without a kick, so that it runs as the map says."""
    if not (np.isfinite(x) and np.isfinite(y)):
        raise KnobError(Text("That click is not on the map.", "点击不在地图之内。"))
    return {"angle0": float(GRID[nearest(x)]), "error0": float(GRID[nearest(y)]), "kick": -1.0}


# --- tasks ---------------------------------------------------------------------------------------------------------
def _false_sentence(outcome: Outcome) -> Verdict:
    meter, clipped = outcome.metrics["separation_meter"], outcome.metrics["clipped_for"]
    if clipped < 0.1:
        return Verdict(False, Text(f"The force is clipped for only {clipped:.2f} s; a counterexample needs at least 0.1 s.",
                                   f"力只被限幅 {clipped:.2f} s；反例至少需要 0.1 s。"))
    if meter >= EXACT:
        return Verdict(False, Text(f"Clipped for {clipped:.2f} s, but the meter reads {amount(meter)}; it must be below 1e-9.",
                                   f"限幅 {clipped:.2f} s，但分离度量为 {amount(meter)}；应小于 1e-9。"))
    return Verdict(True, Text(f"Clipped for {clipped:.2f} s and the meter reads {meter:.0e}: the sentence is false as it stands.",
                              f"限幅 {clipped:.2f} s，分离度量仅 {meter:.0e}：那句话按原样不成立。"))


def _lost_by_belief(outcome: Outcome) -> Verdict:
    m = outcome.metrics
    if m["separation_meter"] >= EXACT:
        return Verdict(False, Text(f"The error does not obey A − LC: the meter reads {amount(m['separation_meter'])}.",
                                   f"误差并不服从 A − LC：分离度量为 {amount(m['separation_meter'])}。"))
    if not m["known_comes_home"]:
        return Verdict(False, Text("This start is lost even with x known; lean the pole less.",
                                   "即使 x 已知，这一初态也不能恢复；请减小倾角。"))
    if m["comes_home"]:
        return Verdict(False, Text("This start comes home; make the first belief worse.", "这一初态能恢复；让最初的判断更差些。"))
    return Verdict(True, Text(f"The meter reads {m['separation_meter']:.0e}, x known would save the pole, the estimate does not.",
                              f"分离度量 {m['separation_meter']:.0e}；若 x 已知则能恢复，用估计却不能。"))


def _better_observer(outcome: Outcome) -> Verdict:
    d, m = outcome.design, outcome.metrics
    asked = LESSON.apply(LESSON.start(), {"angle0": 4.0, "error0": 8.0})
    if any(d[name] != asked[name] for name in ("angle0", "error0", "controller_poles", "kick")) or d["u_max"] > 4.0:
        return Verdict(False, Text(f"Angle 4°, error 8°, at most 4 N, no kick, the lesson's controller: you have {d['angle0']:g}°, "
                                   f"{d['error0']:g}°, {d['u_max']:g} N.",
                                   f"要求：角度 4°、误差 8°、限幅不超过 4 N、无冲击、控制器极点不变；现在是 {d['angle0']:g}°、"
                                   f"{d['error0']:g}°、{d['u_max']:g} N。"))
    if not m["comes_home"]:
        slowest = _slowest(outcome, "observer")
        return Verdict(False, Text(f"The pole is lost after {m['stopped_at']:.2f} s; the observer's slowest pole is at "
                                   f"{slowest:.3g}.",
                                   f"摆杆在 {m['stopped_at']:.2f} s 倒下；观测器最慢极点在 {slowest:.3g}。"))
    return Verdict(True, Text(f"It comes home with {d['u_max']:g} N; only the observer has changed.",
                              f"限幅 {d['u_max']:g} N 时恢复成功；改变的只有观测器。"))


def exam(seed: int) -> ExamItem:
    """Double integrator, observer poles both −p, told u but given less by d: e₂ settles at −2d/p (e = x − x̂)."""
    rng = np.random.default_rng(seed)
    p, limit, excess = int(rng.integers(2, 9)), int(rng.integers(1, 5)), int(rng.integers(1, 7))
    return ExamItem({"p": str(p), "asked": str(limit + excess), "given": str(limit)}, -2.0 * excess / p, 6e-3)


FAST = (-16 + 0j, -15 + 0j, -14 + 0j, -13 + 0j)
def adapt(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant."""
    from .own import adapted

    return adapted(lesson, model)


LESSON = Lesson(
    "saturation", 7, KNOBS, compute, figures, answer=1,
    tasks=(
        Task("false-sentence", _false_sentence, {"fed": APPLIED}),
        Task("lost-by-belief", _lost_by_belief, {"fed": APPLIED, "angle0": 8.0, "error0": 12.0}),
        Task("better-observer", _better_observer,
             {"fed": APPLIED, "angle0": 4.0, "error0": 8.0, "u_max": 4.0, "observer_poles": FAST}),
    ),
    exam=exam, source="Tutorial (000), section on the limits of the separation principle",
    words=read_prose(Path(__file__).parent),
    job=Job(Text("Map the starts that come home", "计算能恢复的初态地图"), find_starts), pick=pick, carry=carry, adapt=adapt)
