"""Separation: two pole boards, one loop. The spectrum of 2n poles is the union; the transient still suffers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from types import MappingProxyType

import numpy as np

from app.engine import Plant, Scenario, autonomous_error, closed_loop, simulate
from app.engine.feedback import ClosedLoop
from app.engine.simulation import separation_meter
from app.engine.systems import amplitude_response
from app.lesson.figures import Curve, Figure, FrequencyFigure, MatrixFigure, PlaneFigure, Point
from app.lesson.knobs import Number, Switch
from app.lesson.lesson import Check, Design, ExamItem, Formula, Lesson, Outcome, Task, Verdict
from app.lesson.prose import read_prose
from app.plants import MODELS, Model, platform
from app.plants.names import called
from app.text.words import Text

from ..toolkit.boards import pole_boards, stage
from ..toolkit.figures import error_figure, input_figure, state_figures
from ..toolkit.gains import gains
from ..toolkit.knobs import kicks, method_knobs, pole_knobs, run_knobs
from ..toolkit.latex import gain_words, tiny

MODEL = MODELS["deck"]
SPECTRUM_TAB = Text("Poles", "极点")
FREQUENCY_TAB = Text("Frequency", "频率")
EXACT = 1e-9  # union of spectra: agreement asked of them

@dataclass(frozen=True, eq=False)
class Setting:
    """The plant of the lesson: what really moves and what is believed of it, in a design; noise of a design.

    `ground`, `heard`: column and row of the frequency figure, with its title, axis and frequencies in Hz.
    """

    model: Model
    truth: Callable[[Design], Plant]
    belief: Callable[[Design], Plant]
    delay: Callable[[Design], float]
    noise: Callable[[Design], np.ndarray | float | None]
    ground: np.ndarray
    heard: np.ndarray
    heading: tuple[Text, Text | str]
    frequencies: np.ndarray


KNOBS = (
    *method_knobs(),
    *pole_knobs(MODEL),
    Number("stiffness_error", r"\delta_k", Text("stiffness believed wrong by", "模型刚度误差"), "%", low=-30.0, high=30.0,
           default=0.0, step=1.0, hint=Text("The observer's model has springs this much stiffer than the plant's.",
                                            "观测器模型中的弹簧比真实对象硬这么多。")),
    Number("delay", r"\tau", Text("input delay", "输入时延"), "ms", low=0.0, high=60.0, default=0.0, step=6.0,
           hint=Text("The force arrives later than the observer is told.", "力到达得比观测器所知道的晚。")),
    Switch("limited", "", Text("limit the coils", "限制线圈推力"),
           hint=Text("Clip every coil; the observer is still told the force that was asked for.",
                     "对每个线圈限幅；观测器得到的仍是指令值。")),
    Number("u_max", r"u_{\max}", Text("coil limit", "线圈限幅"), "N", low=0.2, high=4.0, default=1.0, step=0.1,
           hint=Text("The largest force that a coil can give.", "线圈能给出的最大推力。"), when=("limited", (True,))),
    Number("noise", r"\sigma_v", Text("sensor noise", "传感器噪声"), "mm/s", low=0.0, high=5.0, default=0.0, step=0.1,
           hint=Text("Standard deviation of each velocity sample; the noise itself is drawn from the seed.",
                     "每个速度采样值的标准差；噪声序列由种子决定。")),
    *run_knobs(MODEL.horizon),
)


@lru_cache(maxsize=64)
def believed(error_percent: float) -> Plant:
    """The deck as the designer believes it: every spring stiffer by the error."""
    p, factor = platform.Parameters(), 1 + error_percent / 100
    return platform.deck(replace(p, kz=p.kz * factor, kx=p.kx * factor))


DECK = Setting(
    MODEL, lambda design: MODEL.plant, lambda design: believed(design["stiffness_error"]),
    lambda design: design["delay"] / 1000,
    lambda design: None if design["noise"] == 0 else (design["noise"] / 1000) ** 2 * MODEL.dt,
    platform.deck_disturbance()[:, :1], MODEL.plant.C[:1],
    (Text("from ground height to velocity VL", "地面高度到速度 VL 的增益"), "|VL/zg| [1/s]"), np.geomspace(0.1, 30.0, 300))


def compute(here: Setting, design: Design) -> Outcome:
    """Gains on the believed plant, the 2n-pole loop on the true one, one run."""
    model, truth, belief = here.model, here.truth(design), here.belief(design)
    K, L = gains(design, belief, model)
    loop = closed_loop(truth, K, L, belief)
    limit = design["u_max"] if design["limited"] else None
    run = simulate(Scenario(
        truth, K, L, model=belief, x0=model.x0, xhat0=model.guess, horizon=model.horizon, dt=model.dt,
        u_min=None if limit is None else -limit, u_max=limit, fed="commanded", delay=here.delay(design),
        impulses=kicks(design, model), seed=int(design["seed"]), V=here.noise(design)))
    meter = separation_meter(run)
    slow, fast = float(max(loop.controller_poles.real)), float(max(loop.observer_poles.real))
    metrics = {
        "union_error": loop.union_error, "separation_meter": meter, "slowest_controller": slow,
        "slowest_observer": fast, "largest_input": float(np.max(np.abs(run.u_asked))),
        "slowest_loop": float(max(loop.poles.real)),
    }
    same_union = loop.union_error <= EXACT or loop.polynomial_error <= EXACT
    checks = (
        Check("union", Text("the 2n poles are the union of both sets", "2n 个极点正是两组极点的并集"), same_union,
              loop.union_error),
        Check("compensator", Text("the compensator itself is stable", "补偿器自身稳定"), loop.compensator_stable,
              float(max(loop.compensator_poles.real))),
    )
    return Outcome(
        design, {"K": K, "L": L},
        {"controller": loop.controller_poles, "observer": loop.observer_poles, "loop": loop.poles,
         "compensator": loop.compensator_poles},
        metrics, checks, run, pole_boards(model, design, loop.controller_poles, loop.observer_poles,
                                          belief.A - L @ belief.C),
        stage(model, run), _formulas(K, L), _live(loop, meter), loop)


def _formulas(K: np.ndarray, L: np.ndarray) -> tuple[Formula, ...]:
    return (
        Formula("loop", r"\frac{d}{dt}\begin{bmatrix} x \\ e \end{bmatrix} = \begin{bmatrix} A-BK & BK \\ 0 & A-LC "
                        r"\end{bmatrix} \begin{bmatrix} x \\ e \end{bmatrix}"),
        Formula("K", gain_words("K", K)),
        Formula("L", gain_words(r"L^{\mathsf T}", L.T)),
    )


def _live(loop: ClosedLoop, meter: float) -> Text:
    union = (Text(f"The {len(loop.poles)} poles of the loop are the union of both boards to about {tiny(loop.union_error)}.",
                  f"闭环的 {len(loop.poles)} 个极点就是两块板上极点的并集，误差约 {tiny(loop.union_error)}。")
             if loop.union_error < 1e-6 else
             Text(f"The {len(loop.poles)} poles of the loop differ from the boards by {100 * loop.union_error:.1f} %.",
                  f"闭环的 {len(loop.poles)} 个极点与两块板上的极点相差 {100 * loop.union_error:.1f} %。"))
    wall = (Text(" Separation meter: 0.", " 分离度量：0。") if meter < 1e-8 else
            Text(f" Separation meter: {meter:.2g}; the error no longer lives by itself.",
                 f" 分离度量：{meter:.2g}；误差不再独自演化。"))
    stable = (Text("", "") if loop.compensator_stable else
              Text(" The compensator by itself is unstable.", " 补偿器自身是不稳定的。"))
    return Text(union.en + wall.en + stable.en, union.zh + wall.zh + stable.zh)


def figures(here: Setting, outcome: Outcome) -> tuple[Figure, ...]:
    """Signals, error and input over time; the spectrum and the block-triangular matrix."""
    run, loop, model = outcome.run, outcome.study, here.model
    assert run is not None
    limit = outcome.design["u_max"] if outcome.design["limited"] else None
    return (*state_figures(model, run), error_figure(run, autonomous_error(run)), input_figure(run, model, limit),
            _spectrum(outcome), _blocks(loop, model.plant), _isolation(here, outcome))


def _isolation(here: Setting, outcome: Outcome) -> FrequencyFigure:
    """From a disturbance to an output: untouched, steered by the state, steered by the estimate."""
    truth = here.truth(outcome.design)
    A, B, C = truth.A, truth.B, here.heard
    K, n, loop = outcome.gains["K"], truth.n, outcome.study
    zg, w = here.ground, 2 * np.pi * here.frequencies

    def gain(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
        return np.clip(amplitude_response(a, b, c, [[0.0]], w)[:, 0, 0], 1e-12, 1e9)
    bare, state = gain(A, zg, C), gain(A - B @ K, zg, C)
    whole = gain(loop.A_xxhat, np.vstack([zg, np.zeros((n, 1))]), np.hstack([C, np.zeros((1, n))]))
    peak = 20 * np.log10(float(bare.max()) / float(whole.max()))
    return FrequencyFigure(
        "isolation", here.heading[0], here.frequencies,
        (Curve(Text("no control", "无控制"), bare, "muted"),
         Curve(Text("by the state", "状态反馈"), state, "plant", "dash"),
         Curve(Text("by the estimate", "估计反馈"), whole, "estimate")), here.heading[1], tab=FREQUENCY_TAB,
        caption=Text(f"Steering by the estimate lowers the peak by {peak:.1f} dB; the gap to the dashed line is the "
                     "observer's share.",
                     f"按估计控制使峰值降低 {peak:.1f} dB；与虚线之间的差距来自观测器。") if peak > 0 else
        Text(f"Steering by the estimate raises the peak by {-peak:.1f} dB.", f"按估计控制使峰值升高 {-peak:.1f} dB。"))


def _spectrum(outcome: Outcome) -> PlaneFigure:
    groups = (("controller", "plant", "cross"), ("observer", "estimate", "cross"), ("loop", "reference", "circle"),
              ("compensator", "force", "dot"))
    points = tuple(Point(float(p.real), float(p.imag), role, mark)  # type: ignore[arg-type]
                   for key, role, mark in groups for p in outcome.poles[key])
    low = min(-1.0, *(p.x for p in points))
    high = max(2.0, *(abs(p.y) for p in points))
    return PlaneFigure(
        "spectrum", Text("spectrum of the whole loop", "整个闭环的谱"), (), points, "Re s", "Im s",
        (1.1 * max(low, -60.0), max(3.0, 1.1 * min(60.0, max(p.x for p in points)))),
        (-1.1 * min(high, 60.0), 1.1 * min(high, 60.0)), unstable=True, tab=SPECTRUM_TAB,
        caption=Text(f"Crosses: chosen on the boards. Circles: poles of the {len(outcome.poles['loop'])}-state loop. Green dots: "
                     "the compensator's own.",
                     f"叉号：板上选定的极点。圆圈：{len(outcome.poles['loop'])} 阶闭环的极点。绿点：补偿器自身的极点。"))


def _blocks(loop: ClosedLoop, plant: Plant) -> MatrixFigure:
    n = loop.A_xe.shape[0] // 2
    names = [*(called(plant, name) for name in plant.state_names), *(f"e{i + 1}" for i in range(n))]
    corner = float(np.max(np.abs(loop.A_xe[n:, :n])))
    zero = corner < 1e-9 * float(np.max(np.abs(loop.A_xe)))
    return MatrixFigure(
        "blocks", Text("the loop in (x, e) coordinates", "(x, e) 坐标下的闭环矩阵"), loop.A_xe, tuple(names), tuple(names),
        (n,), tab=SPECTRUM_TAB,
        caption=Text("The lower left block is zero: the error drives the state, never the other way round.",
                     "左下块为零：误差驱动状态，状态从不驱动误差。") if zero else
        Text(f"The lower left block is no longer zero (largest entry {corner:.2g}): the state drives the error.",
             f"左下块不再为零（最大元素 {corner:.2g}）：状态反过来驱动误差。"))


def fast_observer(outcome: Outcome) -> Verdict:
    """The slowest observer pole at least three times as fast as the slowest controller pole."""
    m = outcome.metrics
    ratio = m["slowest_observer"] / m["slowest_controller"]
    if m["slowest_controller"] >= 0 or m["slowest_observer"] >= 0:
        return Verdict(False, Text("A pole is not in the left half plane.", "有极点不在左半平面。"))
    if ratio >= 3:
        return Verdict(True, Text(f"The slowest observer pole is {ratio:.1f} times as fast as the slowest controller pole.",
                                  f"最慢观测器极点的实部是最慢控制器极点的 {ratio:.1f} 倍。"))
    return Verdict(False, Text(f"The ratio of the slowest poles is {ratio:.1f}; it should be at least 3.",
                               f"两组最慢极点之比为 {ratio:.1f}，应不小于 3。"))


def _break_the_wall(outcome: Outcome) -> Verdict:
    meter, stable = outcome.metrics["separation_meter"], outcome.metrics["slowest_loop"] < 0
    if meter >= 0.1 and stable:
        return Verdict(True, Text(f"The meter reads {meter:.2f} and the loop is still stable.",
                                  f"度量为 {meter:.2f}，闭环仍然稳定。"))
    if not stable:
        return Verdict(False, Text("The loop has become unstable; go back a little.", "闭环已经不稳定，请退回一些。"))
    return Verdict(False, Text(f"The meter reads {meter:.2g}; bring it to 0.1.", f"度量为 {meter:.2g}，请使它达到 0.1。"))


def _unstable_compensator(outcome: Outcome) -> Verdict:
    own = float(np.max(np.real(outcome.poles["compensator"])))
    if own > 0 and outcome.metrics["slowest_loop"] < 0:
        return Verdict(True, Text(f"The compensator has a pole with real part {own:+.3g}, and the loop is stable all the same.",
                                  f"补偿器有实部为 {own:+.3g} 的极点，而闭环依然稳定。"))
    return Verdict(False, Text(f"The compensator's rightmost pole is {own:.3g}; it must cross into the right half plane "
                               "while the loop stays stable.",
                               f"补偿器最右极点为 {own:.3g}；要让它进入右半平面而闭环保持稳定。"))


def exam(seed: int) -> ExamItem:
    """A double integrator, two poles on each board: the trace of the loop's matrix is the sum of all four."""
    rng = np.random.default_rng(seed)
    c = sorted(float(v) for v in rng.choice(np.arange(2, 9), 2, replace=False))
    o = sorted(float(v) for v in rng.choice(np.arange(10, 20), 2, replace=False))
    answer = -(c[0] + c[1] + o[0] + o[1])
    return ExamItem({"c1": f"-{c[0]:g}", "c2": f"-{c[1]:g}", "o1": f"-{o[0]:g}", "o2": f"-{o[1]:g}"}, answer, 1e-6)


def _pairs(*upper: complex) -> tuple[complex, ...]:
    return tuple(pole for p in upper for pole in (p, p.conjugate()))


FAST = tuple(complex(3.2 * p.real, p.imag) for p in (-4 + 5j, -4 - 5j, -5 + 6j, -5 - 6j, -6 + 7j, -6 - 7j))
EAGER = MappingProxyType({"method": "poles", "controller_poles": _pairs(-14 + 3j, -4 + 7j, -12 + 4j),
         "observer_poles": _pairs(-18 + 5j, -8 + 9j, -3 + 11j)})
def adapt(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant."""
    from .own import adapted

    return adapted(lesson, model)


LESSON = Lesson(
    "separation", 4, KNOBS, partial(compute, DECK), partial(figures, DECK), answer=1,
    tasks=(
        Task("fast-observer", fast_observer, {"method": "poles", "observer_poles": FAST}),
        Task("break-the-wall", _break_the_wall, {"stiffness_error": 15.0}),
        Task("unstable-compensator", _unstable_compensator, EAGER),
    ),
    exam=exam, source="Tutorial (000), separation section, equations of the augmented loop",
    words=read_prose(Path(__file__).parent), adapt=adapt)
