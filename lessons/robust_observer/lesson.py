"""Robust observer: u = K x estimated directly by one or two states, and what it forgives when the model is wrong."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.engine import simulate_functional
from app.engine.observers import FunctionalObserver, FunctionalRun, error_index, perturbed_loop
from app.lesson.figures import Figure
from app.lesson.knobs import Choice, Number, Poles, Switch
from app.lesson.lesson import Board, Check, Design, ExamItem, Formula, Job, Lesson, Outcome, Stage
from app.lesson.prose import read_prose
from app.plants import Model
from app.plants.duan import push
from app.text.words import Text, same

from ..toolkit.boards import listed
from ..toolkit.latex import matrix, number, pole_words
from .loops import (
    CASES,
    DT,
    HORIZON,
    MOST,
    NORMS,
    ONE,
    TWO,
    errors,
    gains_over_frequency,
    observer_of,
    shown,
    start_of,
    vertices_of,
)
from .paper import COLUMNS, LINES, REMARKS
from .pictures import all_figures
from .search import Search, carry, search
from .tasks import TASKS

RE_LOW, RE_HIGH, IM_HIGH = -12.0, 1.0, 6.0  # of the observer's board
LOOP_LOW, LOOP_HIGH, LOOP_IM = -20.0, 4.0, 8.0  # of the loop's
MET = 1e-9
SLIPS = Text("Find the slips", "找出印刷错误")
ERRORS = Text("The plant is not the model", "对象与模型不符")
SEARCH = Text("Criterion and region", "指标与区域")


def _delta(name: str, symbol: str, example: str, en: str, zh: str, high: float, default: float) -> Number:
    return Number(name, symbol, Text(en, zh), low=-high, high=high, default=default, step=high / 50, group=ERRORS,
                  when=("example", (example,)),
                  hint=Text("How far the true plant is from the model the observer was designed for; 0: no error.",
                            "真实对象与设计观测器所用模型的偏差；0 表示没有偏差。"))


def _weight(name: str, symbol: str, what: str) -> Number:
    return Number(name, symbol, Text(f"weight of {what}", f"{what} 的权重"), low=0.0, high=3.0, default=1.0, step=0.1,
                  group=SEARCH, hint=Text(f"How much {what} counts in J; all ones in the paper.",
                                          f"{what} 在 J 中的分量；论文中都取 1。"))


def weight_knobs() -> tuple[Number, ...]:
    """The weights of the three sums in J."""
    return _weight("alpha", r"\alpha", "‖TAᵢ‖"), _weight("beta", r"\beta", "‖LCᵢ‖"), _weight("gamma", r"\gamma", "‖MCᵢ‖")


KNOBS = (
    Choice("example", "", Text("example", "算例"), default=ONE,
           options=((ONE, Text("Example 1: two states", "例 1：两个状态")), (TWO, Text("Example 2: three states", "例 2：三个状态"))),
           hint=Text("The two plants of the paper, each with its gain K.", "论文中的两个对象，各带一个反馈增益 K。")),
    Poles("pole", "s", Text("Observer pole", "观测器极点"), "rad/s", default=(-5 + 0j,), re_low=RE_LOW, re_high=RE_HIGH,
          im_high=IM_HIGH, role="estimate", when=("example", (ONE,)),
          hint=Text("Drag s along its axis and watch J.", "沿实轴拖动 s，观察 J。")),
    Poles("pair", r"s_1, s_2", Text("Observer poles", "观测器极点"), "rad/s", default=(-4 + 0j, -2.5 + 0j), re_low=RE_LOW,
          re_high=RE_HIGH, im_high=IM_HIGH, role="estimate", when=("example", (TWO,)),
          hint=Text("Drag s₁ and s₂; they must differ, and may be a pair.", "拖动 s₁ 与 s₂；二者不能相等，也可成共轭对。")),
    _delta("a1", r"\delta_a^1", ONE, "δ of a₂₁", "a₂₁ 的摄动 δ", 0.5, 0.1),
    _delta("a2", r"\delta_a^2", ONE, "δ of a₂₂", "a₂₂ 的摄动 δ", 0.5, -0.4),
    _delta("c", r"\delta_c", ONE, "δ of the sensor", "传感器的摄动 δ", 0.1, 0.05),
    _delta("b1", r"\delta_a^1", TWO, "δ of a₁", "a₁ 的摄动 δ", 0.5, 0.01),
    _delta("b2", r"\delta_a^2", TWO, "δ of a₂", "a₂ 的摄动 δ", 0.5, 0.05),
    _delta("d", r"\delta_c", TWO, "δ of the sensor", "传感器的摄动 δ", 0.1, 0.03),
    Number("w12", r"w_{12}", Text("coordinates W = [1 w; 0 1]", "坐标 W = [1 w; 0 1]"), low=-2.0, high=2.0, default=1.2,
           step=0.1, when=("example", (TWO,)),
           hint=Text("The observer's coordinates: F = W diag(s₁, s₂) W⁻¹.", "观测器的坐标：F = W diag(s₁, s₂) W⁻¹。")),
    Switch("carried", "", Text("carry z(0) along with W", "z(0) 随 W 变换"), when=("example", (TWO,)),
           hint=Text("On: z(0) becomes W z(0). Off: the same numbers whatever W is, as in the paper.",
                     "打开：z(0) 换成 W z(0)。关闭：不论 W 取什么都用同样的数，如论文所做。")),
    Choice("norm", "", Text("norm in J", "J 中的范数"), default="2", group=SEARCH, when=("example", (TWO,)),
           options=tuple((name, same("∞" if name == "inf" else name)) for name in NORMS),
           hint=Text("Column sum, spectral or row sum norm; in Example 1 all three agree.",
                     "列和范数、谱范数或行和范数；在例 1 中三者相同。")),
    *weight_knobs(),
    Number("region_low", "a", Text("region for RLO, left end", "RLO 区域左端"), "rad/s", low=-12.0, high=-4.0, default=-10.0,
           step=0.5, group=SEARCH, hint=Text("RLO keeps every pole right of this.", "RLO 使所有极点都在此线右侧。")),
    Number("region_high", "b", Text("region for RLO, right end", "RLO 区域右端"), "rad/s", low=-3.5, high=-0.2, default=-0.5,
           step=0.1, group=SEARCH, hint=Text("RLO keeps every pole left of this.", "RLO 使所有极点都在此线左侧。")),
    Choice("remark", "", Text("remark 3 should read", "注 3 应为"), default="printed", group=SLIPS, when=("example", (TWO,)),
           options=tuple((name, same(words)) for name, words in REMARKS.items()),
           hint=Text("Five matrices that are to meet the observer conditions again; Λ is any regular matrix.",
                     "变换后应仍满足观测器条件的五个矩阵；Λ 为任意可逆矩阵。")),
    Choice("line", "", Text("line of example 2 with a wrong size", "例 2 中尺寸有误的一行"), default="TA", group=SLIPS,
           when=("example", (TWO,)), options=tuple((name, same(words)) for name, words in LINES.items()),
           hint=Text("The table sets the printed size beside the size of the product.", "表中列出印刷尺寸与实际乘积的尺寸。")),
    Choice("columns", "", Text("columns of the free M′", "自由参数阵 M′ 的列数"), default="np", group=SLIPS,
           when=("example", (TWO,)), options=tuple((name, same(words)) for name, words in COLUMNS.items()),
           hint=Text("In the paper's letters: n states, m outputs, p observer states, r* the rank of [T; C].",
                     "用论文的记号：n 个状态、m 个输出、p 个观测器状态，r* 为 [T; C] 的秩。")),
)


@dataclass(frozen=True, eq=False)
class Story:
    """The observer, its run on the model and on the true plant, |v → e_u| (n_f,) now and at the worst vertex."""

    observer: FunctionalObserver
    model: FunctionalRun
    true: FunctionalRun
    now: np.ndarray
    worst: np.ndarray
    search: Search | None = None


def compute(design: Design) -> Outcome:
    """The observer in house sign, one run on the model and one on the true plant, the worst of eight vertices."""
    case = CASES[design["example"]]
    example, observer, (dA, dC) = case.example, observer_of(design), errors(design)
    z0 = start_of(design)
    model = simulate_functional(observer, push, x0=example.x0, z0=z0, horizon=HORIZON, dt=DT)
    true = shown(simulate_functional(observer, push, x0=example.x0, z0=z0, horizon=HORIZON, dt=DT, dA=dA, dC=dC))
    gains, peak = gains_over_frequency(observer, ((dA, dC), *vertices_of(design)))
    story = Story(observer, model, true, gains[0], gains[1:].max(axis=0))
    loop = perturbed_loop(observer, dA=dA, dB=None, dC=dC)
    late = true.t > 0.75 * HORIZON
    metrics = {
        "J": observer.J, "error_index": min(error_index(observer), 1e9), "order": float(observer.order),
        "dynamics_residual": observer.dynamics_residual, "output_residual": observer.output_residual,
        "slowest_loop": float(np.max(np.real(loop.poles))), "worst_gain": peak,
        "error_start": float(true.e_u[0, 0]), "late_error": float(min(np.abs(true.e_u[late]).max(), MOST)),
        "largest_N": float(np.abs(observer.N).max()), "coordinate_gap": _coordinate_gap(design, model),
    }
    kept = max(metrics["dynamics_residual"], metrics["output_residual"])
    checks = (
        Check("conditions", Text("T A − F T = L C and K = N T + M C", "T A − F T = L C 且 K = N T + M C"), kept < MET, kept),
        Check("stable", Text("the loop with the true plant is stable", "真实对象的闭环稳定"), metrics["slowest_loop"] < 0,
              metrics["slowest_loop"]),
    )
    o = observer
    return Outcome(design, {"F": o.F, "T": o.T, "L": o.L, "N": o.N, "M": o.M, "K": o.K},
                   {"observer": np.array(design[case.poles]), "loop": loop.poles}, metrics, checks, None,
                   _boards(design, case.poles, loop.poles), _stage(case.body, true), _formulas(o, design),
                   _live(design, metrics), story)


def _coordinate_gap(design: Design, model: FunctionalRun) -> float:
    """How far e_u on the model is from that of W = I started at the published z(0)."""
    if design["example"] == ONE:
        return 0.0
    example = CASES[TWO].example
    plain = simulate_functional(observer_of(design, np.eye(2)), push, x0=example.x0, z0=example.z0, horizon=HORIZON,
                                dt=DT)
    return float(np.abs(plain.e_u - model.e_u).max())


def _boards(design: Design, knob: str, loop: np.ndarray) -> tuple[Board, Board]:
    return (
        Board("loop", Text("poles of the loop with the true plant", "真实对象闭环的极点"),
              listed(loop),
              role="plant", side="left", re_low=LOOP_LOW, re_high=LOOP_HIGH, im_high=LOOP_IM),
        Board("observer", Text("observer poles  eig F", "观测器极点  eig F"), design[knob], knob, role="estimate",
              side="right", re_low=RE_LOW, re_high=RE_HIGH, im_high=IM_HIGH),
    )


def _stage(body: object, run: FunctionalRun) -> Stage:
    given, wanted = run.u, run.u - run.e_u
    states = np.clip(np.hstack([run.x, run.z]), -MOST, MOST)
    true, ghost = (np.hstack([states, np.clip(u, -MOST, MOST)]) for u in (wanted, given))
    return Stage(body, run.t, true, ghost, np.clip(given, -MOST, MOST))  # type: ignore[arg-type]


def _formulas(o: FunctionalObserver, design: Design) -> tuple[Formula, ...]:
    sign = Text("The paper prints u = +K x. Here u = −K x̂: its K, N and M change sign; F, T and L do not.",
                "论文印的是 u = +Kx，这里用 u = −K x̂：K、N、M 变号，F、T、L 不变。")
    law = (r"F = s,\; T = [1 \;\; s],\; L = -s^2-4s-3" if design["example"] == ONE else
           r"F = W\,\mathrm{diag}(s_1, s_2)\,W^{-1}")
    return (
        Formula("law", law),
        Formula("J", rf"J = \textstyle\sum_i \alpha\|TA_i\| + \beta\|LC_i\| + \gamma\|MC_i\| = {number(o.J, 4)}"),
        Formula("F", rf"F = {matrix(o.F)}, \quad L = {matrix(o.L)}"),
        Formula("T", rf"T = {matrix(o.T)}"),
        Formula("house", rf"u = -(Nz + My) + v: \; N = {matrix(o.N)}, \; M = {number(float(o.M[0, 0]))}"),
        Formula("paper", rf"u = +(Nz + My) + v: \; N = {matrix(-o.N)}, \; M = {number(float(-o.M[0, 0]))}", sign),
    )


def _live(design: Design, metrics: dict[str, float]) -> Text:
    poles = pole_words([complex(p.real, abs(p.imag)) for p in design[CASES[design["example"]].poles]][:2])
    start = Text(f"Observer at {poles}: J = {metrics['J']:.3g}.", f"观测器极点 {poles}：J = {metrics['J']:.3g}。")
    if metrics["slowest_loop"] >= 0:
        end = Text(" With the true plant the loop is unstable.", " 对真实对象，闭环不稳定。")
    else:
        end = Text(f" On the true plant û misses the wanted input by up to {metrics['late_error']:.2g} at the end.",
                   f" 对真实对象，末段 û 与期望输入相差最多 {metrics['late_error']:.2g}。")
    return Text(start.en + end.en, start.zh + end.zh)


def figures(outcome: Outcome) -> tuple[Figure, ...]:
    """Errors and inputs over time, J and its map, the worst case, the paper's numbers and lines."""
    return all_figures(outcome)


def exam(seed: int) -> ExamItem:
    """J of example 1 at an integer s with integer weights: 2α|s| + β|s² + 4s + 3| + γ|50 + 30s|."""
    rng = np.random.default_rng(seed)
    s, a, b, c = -int(rng.integers(2, 10)), int(rng.integers(1, 5)), int(rng.integers(1, 5)), int(rng.integers(1, 5))
    answer = 2 * a * abs(s) + b * abs(s * s + 4 * s + 3) + c * abs(50 + 30 * s)
    return ExamItem({"s": str(s), "a": str(a), "b": str(b), "c": str(c)}, float(answer), 1e-6)


def adapt(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant."""
    from .own import adapted

    return adapted(lesson, model)


LESSON = Lesson("robust-observer", 15, KNOBS, compute, figures, answer=1, tasks=TASKS, exam=exam,
                source="Duan, Li, Zhou (002): robust Luenberger observer design, 1993; there u = +K x",
                words=read_prose(Path(__file__).parent), kick=False,
                job=Job(Text("Run algorithm RLO", "运行算法 RLO"), search), carry=carry, adapt=adapt)
