"""Bilinear functional observer: one number of a plant whose input multiplies the state, watched in eight steps."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from app.engine.observers import BilinearObserver
from app.lesson.figures import Figure
from app.lesson.knobs import Choice, Number, Poles, Track
from app.lesson.lesson import Board, Check, Design, Lesson, Outcome, Stage
from app.lesson.prose import read_prose
from app.plants.bilinear import PLANT, POLE, PRINTED_FORM, PRINTED_L
from app.plants.body import Body
from app.plants.model import Window
from app.text.words import Text, same

from ..toolkit.boards import listed
from ..toolkit.figures import settle_time
from ..toolkit.knobs import run_knobs
from .formulas import formulas_of
from .page import OPTIONS, pole_of, words
from .pictures import FORM_NAMES, all_figures
from .problems import PAPER, PROBLEMS, nearest_gain
from .runs import FORMS, HORIZON, PLAIN, Watch, form_index, watch
from .tasks import COMPUTED, PRINTED, ROUNDED, TASKS, TYPED, exam

OBSERVER_WINDOW, PLANT_WINDOW = Window(-60.0, 20.0, 20.0), Window(-30.0, 10.0, 12.0)
PLANT_POLES = np.sort_complex(np.linalg.eigvals(PLANT.A))
PLANT_POLES.setflags(write=False)
MOST_INPUT = 4.0
MOVING = ("sine", "square", "sweep")
SHAPED = ("step", *MOVING, "random")

KNOBS = (
    Number("step", "", Text("step of the algorithm", "算法步骤"), low=1, high=8, default=1, scale="integer",
           hint=Text("The formulas and the tab Eight steps show this step.", "公式栏和“八个步骤”标签页显示这一步。")),
    Choice("problem", "", Text("problem", "问题"), default=PAPER,
           options=tuple((p.id, p.label) for p in PROBLEMS.values()),
           hint=Text("Which gauges are lit, and which number is wanted.", "哪些表可测，要监视哪个量。")),
    Choice("input", "u", Text("input", "输入"), default="sine", options=(
        ("none", Text("none", "无")), ("sine", Text("sine", "正弦")), ("step", Text("step", "阶跃")),
        ("square", Text("square wave", "方波")), ("sweep", Text("sweep", "扫频")), ("random", Text("random", "随机")),
        ("hand", Text("your own hand", "手动"))),
        hint=Text("u pushes the plant and also multiplies its state; the paper takes sin 2t.",
                  "u 既推动对象，又乘在状态上；论文取 sin 2t。")),
    Number("amplitude", r"u_0", Text("amplitude", "幅值"), low=0.0, high=MOST_INPUT, default=1.0, step=0.05,
           when=("input", SHAPED), hint=Text("A constant u of 3 makes the plant itself unstable.", "恒定的 u = 3 会使对象本身不稳定。")),
    Number("omega", r"\omega", Text("frequency", "角频率"), "rad/s", low=0.5, high=40.0, default=2.0, scale="log",
           when=("input", MOVING), hint=Text("The sweep is cos ωt².", "扫频信号为 cos ωt²。")),
    Number("seed", r"s_0", Text("random seed", "随机种子"), low=0, high=9999, default=1, scale="integer",
           when=("input", ("random",)), hint=Text("The same seed gives the same input.", "同一种子给出同一输入。")),
    Track("hand", "u", Text("input by hand", "手动输入"), low=-MOST_INPUT, high=MOST_INPUT, when=("input", ("hand",)),
          hint=Text("Slow the clock down, press play and move this.", "调慢时钟，按下播放，再移动它。")),
    Poles("pole", "p", Text("Observer pole", "观测器极点"), "rad/s", default=(complex(POLE),), re_low=OBSERVER_WINDOW.re_low,
          re_high=OBSERVER_WINDOW.re_high, im_high=OBSERVER_WINDOW.im_high, role="estimate", when=("problem", (PAPER,)),
          hint=Text("Real, since the observer has one state; step 6 finds π for it.",
                    "观测器只有一个状态，极点必为实数；由第 6 步求出 π。")),
    Choice("gain", "L", Text("gain", "增益"), default=COMPUTED, when=("problem", (PAPER,)), options=(
        (COMPUTED, Text("computed", "计算值")), (PRINTED, Text("L as the paper prints it", "论文所印的 L")),
        (TYPED, Text("with L₄ typed", "L₄ 自行输入")), (ROUNDED, Text("step 8 in printed decimals", "第 8 步照论文的两位小数"))),
        hint=Text("What runs: our numbers, or those of the paper taken at their word.", "按我们的数运行，或完全照论文所印的数运行。")),
    Number("l4", r"L_4", same("L₄"), low=0.0, high=14.0, default=9.0, step=0.01, when=("gain", (TYPED,)),
           hint=Text("The other entries stay as computed.", "其余各元素保持计算值。")),
    Choice("form", "", Text("form of the observer", "观测器的形式"), default=PLAIN,
           options=tuple(zip(FORMS, FORM_NAMES, strict=True)),
           hint=Text("Which estimate the ghost shows; the first is (18) with (19), the second (17) with (13).",
                     "虚影显示哪个估计：第一种为 (18)、(19)，第二种为 (17)、(13)。")),
    Number("tau", r"\tau", Text("differentiator's time constant", "微分器时间常数"), "s", low=0.001, high=0.1, default=0.02,
           scale="log", hint=Text("ẏ is replaced by s/(τs + 1) y.", "用 s/(τs + 1) y 代替 ẏ。")),
    Number("chi0", r"\chi(0)", Text("first χ", "χ 的初值"), low=-30.0, high=30.0, default=0.0, step=0.5,
           hint=Text("The paper starts at 0; ĝ then starts 15.5 below g.", "论文取 0，此时 ĝ 比 g 低 15.5。")),
    Choice("line", "", Text("printed line in doubt", "可疑的一行"), default=OPTIONS[0][0], options=OPTIONS,
           hint=Text("The tab Eight steps says which pole this line leads to by itself.", "“八个步骤”标签页给出照这一行得到的极点。")),
    run_knobs(HORIZON)[1],
)


def compute(design: Design) -> Outcome:
    """The eight steps for the problem and the pole, and one run of all three forms under the chosen input."""
    problem = PROBLEMS[design["problem"]]
    paper = problem.id == PAPER
    observer = problem.observer(design["pole"][0].real) if paper else problem.solved
    L = _gain(design, observer)
    exact, plain = observer.forms(L)
    if paper and design["gain"] == ROUNDED:
        plain = PRINTED_FORM
    run = watch(problem.plant, problem.K, plain, exact, design)
    pole = PRINTED_FORM.A.item() if plain is PRINTED_FORM else pole_of(observer, L)
    metrics = _metrics(design, observer, run, pole)
    return Outcome(design, {"L": L}, {"observer": np.array([complex(pole)]), "plant": PLANT_POLES}, metrics,
                   _checks(observer, metrics), None, _boards(design, observer, pole), _stage(problem.body, design, run),
                   formulas_of(observer, L, plain, int(design["step"])), _live(design, observer, metrics), (observer, run))


def _gain(design: Design, observer: BilinearObserver) -> np.ndarray:
    """L (1×m) of the run: computed, of the paper, with L₄ typed, or of least squares where none meets (20)."""
    if observer.L is None:
        return nearest_gain(observer)
    if design["problem"] != PAPER or design["gain"] in (COMPUTED, ROUNDED):
        return observer.L
    if design["gain"] == PRINTED:
        return PRINTED_L
    typed = observer.L.copy()
    typed[0, 3] = design["l4"]
    return typed


def _metrics(design: Design, observer: BilinearObserver, run: Watch, pole: float) -> dict[str, float]:
    size = np.abs(run.errors[:, form_index(design)])
    scale = max(float(np.max(np.abs(run.law))), 1e-3)
    n, settled = len(run.t), settle_time(run.t, size)
    found = {"pole": pole, "case": float(observer.case), "defect": observer.defect_size,
             "law_gap": float(np.max(np.abs(run.errors[:, form_index(design)] - run.law))) / scale,
             "first_error": float(run.errors[0, form_index(design)]),
             "late_error": float(np.max(size[-max(n // 10, 1):])), "half_error": float(np.max(size[n // 2:])),
             "plain_half": float(np.max(np.abs(run.errors[n // 2:, 0]))),
             "late_g": float(np.max(np.abs(run.g[-max(n // 10, 1):]))),
             "settled_after": 2 * HORIZON if settled is None else settled}
    if observer.pi is not None:
        found |= {"A*": observer.A_star.item(), "B*": observer.B_star.item(), "pi": observer.pi.item()}
    return found


def _checks(o: BilinearObserver, metrics: dict[str, float]) -> tuple[Check, ...]:
    gap = metrics["law_gap"]
    return (
        Check("case1", Text("case 1: (21) fails, no L", "情形 1：(21) 不成立，没有 L"), o.case == 1, o.defect_size),
        Check("case2", Text("case 2: one L only", "情形 2：只有一个 L"), o.case == 2, float(o.canonical_Q.rank)),
        Check("case3", Text("case 3: a family of L", "情形 3：一族 L"), o.case == 3, float(len(o.canonical_Q.zero_left))),
        Check("controllable", Text("(A*, B*) controllable: any pole", "(A*, B*) 能控：极点任意"), bool(o.controllable),
              float(np.max(np.abs(o.B_star), initial=0.0))),
        Check("stable", Text("the pole in use is on the left", "现用极点在左半平面"), metrics["pole"] < 0, metrics["pole"]),
        Check("law", Text("ε follows its pole under this u", "在此 u 下 ε 服从极点的规律"), gap <= 1e-6, gap),
    )


def _boards(design: Design, o: BilinearObserver, pole: float) -> tuple[Board, Board]:
    paper = design["problem"] == PAPER
    seen = listed(np.array([complex(pole)]))
    title = (Text("observer pole  A* − B*π", "观测器极点  A* − B*π") if o.case == 3
             else Text("observer pole  (V₂ − LV₁)AT₂", "观测器极点  (V₂ − LV₁)AT₂"))
    return (
        Board("plant", Text("the plant's poles at u = 0  eig(A)", "u = 0 时对象的极点  eig(A)"), listed(PLANT_POLES),
              side="left", re_low=PLANT_WINDOW.re_low, re_high=PLANT_WINDOW.re_high, im_high=PLANT_WINDOW.im_high),
        Board("observer", title, seen if paper else (), "pole" if paper else None, fixed=() if paper or o.case == 1 else seen,
              role="estimate", side="right", re_low=OBSERVER_WINDOW.re_low, re_high=OBSERVER_WINDOW.re_high,
              im_high=OBSERVER_WINDOW.im_high,
              also=(("gain", COMPUTED),) if paper else ()),
    )


def _stage(body: Body, design: Design, run: Watch) -> Stage:
    true = np.column_stack([run.x, run.g])
    return Stage(body, run.t, true, np.column_stack([run.x, run.estimates[:, form_index(design)]]), run.u[:, None])


def _live(design: Design, o: BilinearObserver, m: dict[str, float]) -> Text:
    pole, late = words(np.array([m["pole"]]), 2), f"{m['late_error']:.1e}"
    if o.case == 1:
        return Text(f"Case 1: no L frees ε from u and x. The nearest one leaves ε at {late} when the run ends.",
                    f"情形 1：没有 L 能使 ε 与 u、x 无关。取最接近的 L，运行结束时 ε 仍达 {late}。")
    if m["pole"] >= 0:
        return Text(f"The observer's pole is {pole}: ε grows and reaches {late}.", f"观测器极点为 {pole}：ε 不断增大，达到 {late}。")
    if m["law_gap"] <= 1e-6:
        return Text(f"Case {o.case}: one state watches g, and ε dies out as e^({pole}t) under this u.",
                    f"情形 {o.case}：一个状态便能监视 g，在此 u 下 ε 按 e^({pole}t) 衰减。")
    return Text(f"The pole is {pole}, but something still drives ε: it ends at {late}.",
                f"极点为 {pole}，但仍有东西在激励 ε：末段为 {late}。")


def figures(outcome: Outcome) -> tuple[Figure, ...]:
    """g and its error under u; the eight steps; the three cases; with and without ẏ."""
    return all_figures(outcome)


LESSON = Lesson("bilinear-observer", 16, KNOBS, compute, figures, answer=2, tasks=TASKS, exam=exam,
                source="Synthesis of functional observers for bilinear plants (004), Avtometriya 53 (2017) no. 4, "
                       "equations (1)–(24) and the worked example",
                words=read_prose(Path(__file__).parent))

__all__ = ["LESSON"]
