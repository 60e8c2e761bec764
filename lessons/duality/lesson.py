"""Duality: one problem worn twice. The observer of (A, C) is the controller of (Aᵀ, Cᵀ), read sideways."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from types import MappingProxyType

import numpy as np

from app.engine import Plant, Scenario, lqe, lqr, observer_gain, place, reachability_gramian, simulate
from app.figures import Curve, Figure, PlaneFigure, TableFigure, TimeFigure, nice
from app.knobs import Choice, Number, Poles, Switch
from app.lesson import Board, Check, Design, ExamItem, Formula, Lesson, Outcome, Task, Verdict
from app.plants import MODELS, Model, Window
from app.prose import read_prose
from app.words import Text, same

from ..toolkit import (
    BY_POLES,
    BY_WEIGHTS,
    WEIGHTS,
    error_figure,
    gain_words,
    input_figure,
    kicks,
    on_board,
    pole_words,
    run_knobs,
    stage,
    state_figures,
)
from .proofs import filter_riccati, observer_by_polynomial, output_energy

MODEL = MODELS["spring-damper"]
TWINS_TAB, ELLIPSES_TAB = Text("Twins", "孪生"), Text("Ellipses", "椭圆")
EXACT = 1e-8  # agreement asked of the two sides, relative to their size
TINY = 1e-16
MOST_ROWS = 12  # of a table
LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
CIRCLE = np.linspace(0.0, 2 * np.pi, 121)
FLIP = np.diag([1.0, -1.0])  # the mirror that turns velocities round


HINTS = MappingProxyType({
    "q": Text("Q = α_Q I: how dear a deviation of the state is.", "Q = α_Q I：状态偏离的代价。"),
    "r": Text("R = α_R: how dear the input is.", "R = α_R：输入的代价。"),
    "w": Text("W = α_W I: how hard unknown forces shake the plant.", "W = α_W I：未知扰动有多强。"),
    "v": Text("V = α_V: how noisy the sensor is.", "V = α_V：传感器噪声有多大。"),
})


def _weight(name: str, symbol: str, en: str, zh: str, default: float, tied: bool) -> Number:
    return Number(name, symbol, Text(en, zh), low=1e-3, high=1e3, default=default, scale="log", group=WEIGHTS,
                  when=None if tied else ("mirror", (False,)), hint=HINTS[name])


KNOBS = (
    Choice("method", "", Text("gains by", "增益由"), default=BY_POLES,
           options=((BY_POLES, Text("dragging poles", "拖动极点")), (BY_WEIGHTS, Text("Q/R weights", "Q/R 权重"))),
           hint=Text("Drag one set of poles for both boards, or let the two Riccati equations choose.",
                     "两块板共用一组极点，拖动任一块；或由两个 Riccati 方程给出。")),
    Poles("poles", "p", Text("Poles of both boards", "两块板共用的极点"), "rad/s", default=MODEL.controller_poles,
          re_low=-5.0, re_high=1.5, im_high=3.0, role="plant", when=("method", (BY_POLES,)),
          hint=Text("Drag a cross on either board: both boards hold the same poles.",
                    "拖动任一块板上的叉号：两块板的极点相同。")),
    Number("sensor", r"\varphi", Text("sensor turned by", "传感器角度"), "°", low=0.0, high=90.0, default=0.0, step=1.0,
           hint=Text("y = q cos φ + v sin φ: the position at 0°, the velocity at 90°.",
                     "y = q cos φ + v sin φ：0° 测位置，90° 测速度。")),
    Number("window", "T", Text("window of the ellipses", "椭圆的时间窗"), "s", low=0.5, high=12.0, default=4.0, step=0.1,
           hint=Text("How long the input may push, and how long the output is listened to.",
                     "输入可以作用多久，输出可以听多久。")),
    _weight("q", r"\alpha_Q", "state weight α_Q", "状态权重 α_Q", 4.0, True),
    _weight("r", r"\alpha_R", "input weight α_R", "输入权重 α_R", 1.0, True),
    Switch("mirror", "", Text("mirror the weights: W = Q, V = R", "权重对偶：W = Q，V = R"), default=True,
           hint=Text("On: the filter gets the regulator's weights. Off: it has its own.",
                     "开：滤波器取与调节器相同的权重；关：各用各的。")),
    _weight("w", r"\alpha_W", "process intensity α_W", "过程噪声强度 α_W", 1.0, False),
    _weight("v", r"\alpha_V", "sensor intensity α_V", "测量噪声强度 α_V", 1.0, False),
    *run_knobs(MODEL.horizon),
)


@dataclass(frozen=True, eq=False)
class Setting:
    """The plant of the lesson in a design, and what its weights and pictures are measured in.

    Q, R, W, V: the matrices that the four weights multiply. `pair`: two states that the ellipses show, with their axes.
    `window`: of both boards. `mirror`: whether velocities can be turned round.
    """

    model: Model
    plant: Callable[[Design], Plant]
    Q: np.ndarray
    R: np.ndarray
    W: np.ndarray
    V: np.ndarray
    pair: tuple[int, int]
    axes: tuple[str, str]
    window: Window
    mirror: bool = False


@dataclass(frozen=True, eq=False)
class Twins:
    """Both sides of each pair: the observer's own formula beside the controller of the transposed plant."""

    L: np.ndarray  # n×p, by the observer's own equation
    K_dual: np.ndarray  # p×n, feedback placed for (Aᵀ, Cᵀ)
    P: np.ndarray  # filter Riccati, own Hamiltonian
    S_dual: np.ndarray  # regulator Riccati of (Aᵀ, Cᵀ) with Q = W, R = V
    slowest: tuple[float, float]  # largest real part of the LQR's and of the LQE's poles
    reach: np.ndarray  # Gramian of (A, B) and the output energies of its dual
    reach_twin: np.ndarray
    seen: np.ndarray  # output energies of (A, C) and the Gramian of its dual
    seen_twin: np.ndarray
    t: np.ndarray  # the pairing, over the window of its own
    e: np.ndarray
    z: np.ndarray  # state of the dual loop, time reversed

    @property
    def pairing(self) -> np.ndarray:
        """x_d(T − t)ᵀ e(t), shape (n_t,): constant."""
        return np.sum(self.e * self.z, axis=1)


@lru_cache(maxsize=128)
def turned(degrees: float) -> Plant:
    """The spring-damper with its sensor turned from position (0°) to velocity (90°)."""
    angle, p = np.radians(degrees), MODEL.plant
    C = np.array([[np.cos(angle), np.sin(angle)]])
    C[np.abs(C) < TINY] = 0.0
    names = "position" if degrees == 0 else "velocity" if degrees == 90 else "sensor"
    return Plant(p.A, p.B, C, p.D, 0.0, p.state_names, p.input_names, (names,), p.units[:3], p.name)


def _weights(here: Setting, design: Design) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    q, r = design["q"], design["r"]
    w, v = (q, r) if design["mirror"] else (design["w"], design["v"])
    return q * here.Q, r * here.R, w * here.W, v * here.V


def _gains(here: Setting, design: Design, plant: Plant) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """K of the plant, L by the engine, L by the observer's own equation, K_d of the transposed plant."""
    A, B, C = plant.A, plant.B, plant.C
    Q, R, W, V = _weights(here, design)
    if design["method"] == BY_POLES:
        p = design["poles"]
        return (place(A, B, p).gain, observer_gain(A, C, p).gain, observer_by_polynomial(A, C, p),
                place(A.T, C.T, p).gain)
    own = np.linalg.solve(V, C @ filter_riccati(A, C, W, V)).T
    return lqr(A, B, Q, R).gain, lqe(A, np.eye(plant.n), C, W, V).gain, own, lqr(A.T, C.T, W, V).gain


def _pair(model: Model, plant: Plant, L: np.ndarray, K_dual: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """e(t) of the observer and x_d(T − t) of the dual loop over a window of about two of the slowest time constants."""
    slowest = float(np.min(np.abs(np.linalg.eigvals(plant.A - L @ plant.C).real)))
    span = float(np.clip(2 / max(slowest, 1e-6 / model.horizon), model.horizon / 24, model.horizon / 3))
    step = span / 200
    seen = simulate(Scenario(plant, L=L, x0=model.x0, xhat0=model.guess, horizon=span, dt=step))
    dual = simulate(Scenario(plant.dual(), K_dual, x0=np.ones(plant.n), horizon=span, dt=step, state_feedback=True))
    count = min(len(seen.t), len(dual.t))
    return seen.t[:count], seen.e[:count], dual.x[:count][::-1]


def _twins(here: Setting, design: Design, plant: Plant, own: np.ndarray, K_dual: np.ndarray) -> Twins:
    A, B, C = plant.A, plant.B, plant.C
    Q, R, W, V = _weights(here, design)
    regulator, twin = lqr(A, B, Q, R), lqr(A.T, C.T, W, V)
    return Twins(
        own, K_dual, filter_riccati(A, C, W, V), twin.solution,
        (float(max(regulator.poles.real)), float(max(twin.poles.real))),
        *_gramians(plant, design["window"]), *_pair(here.model, plant, own, K_dual))


@lru_cache(maxsize=128)
def _gramians(plant: Plant, T: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Reached by (A, B), heard by (Aᵀ, Bᵀ); heard by (A, C), reached by (Aᵀ, Cᵀ); 2×2 each, within T seconds."""
    A, B, C = plant.A, plant.B, plant.C
    return (reachability_gramian(plant, T), output_energy(A.T, B.T, T),
            output_energy(A, C, T), reachability_gramian(plant.dual(), T))


def gap(a: np.ndarray, b: np.ndarray) -> float:
    """max|a − b| relative to max|b|."""
    return float(np.max(np.abs(a - b)) / max(np.max(np.abs(b)), TINY))


def compute(here: Setting, design: Design) -> Outcome:
    """Both gains, both Riccati solutions, both Gramians, and one run of the plant under them."""
    plant, model = here.plant(design), here.model
    K, L, own, K_dual = _gains(here, design, plant)
    twins = _twins(here, design, plant, own, K_dual)
    run = simulate(Scenario(plant, K, L, x0=model.x0, xhat0=model.guess, horizon=model.horizon, dt=model.dt,
                            impulses=kicks(design, model), seed=int(design["seed"])))
    error_matrix = plant.A - own @ plant.C
    left, right = (np.sort_complex(np.linalg.eigvals(M).astype(complex)) for M in (plant.A - plant.B @ K, error_matrix))
    size = float(np.max(np.linalg.norm(twins.e, axis=1) * np.linalg.norm(twins.z, axis=1)))
    metrics = {
        "gain_gap": gap(K_dual.T, own), "riccati_gap": gap(twins.S_dual, twins.P),
        "gramian_gap": max(gap(twins.reach_twin, twins.reach), gap(twins.seen_twin, twins.seen)),
        "pairing_gap": float(np.ptp(twins.pairing)) / max(size, TINY),
        "mirror_gap": gap(FLIP @ twins.reach @ FLIP, twins.seen) if here.mirror else 1.0,
        "L1": float(own[0, 0]), "L2": float(own[-1, 0]), "slowest_controller": float(np.max(np.real(left))),
        "slowest_observer": float(np.max(np.real(right))),
    }
    return Outcome(design, {"K": K, "L": L, "K_dual": K_dual}, {"controller": left, "observer": right}, metrics,
                   _checks(metrics), run, _boards(here, design, left, right, error_matrix), stage(model, run),
                   _formulas(K, own, K_dual), _live(own, metrics), twins)


def _checks(m: dict[str, float]) -> tuple[Check, ...]:
    sentences = (
        ("transpose", "gain_gap", Text("L = K_dᵀ to rounding", "L = K_dᵀ，仅差舍入误差")),
        ("riccati", "riccati_gap", Text("P of the filter = S of the transposed plant", "滤波器的 P = 转置对象的 S")),
        ("gramians", "gramian_gap", Text("each Gramian = its twin's", "两个 Gram 矩阵与各自的孪生相等")),
        ("pairing", "pairing_gap", Text("x_d(T − t)ᵀ e(t) is constant", "x_d(T − t)ᵀ e(t) 为常数")),
    )
    return tuple(Check(name, text, m[key] <= EXACT, m[key]) for name, key, text in sentences)


def _boards(here: Setting, design: Design, left: np.ndarray, right: np.ndarray, error_matrix: np.ndarray) -> tuple[Board, Board]:
    can, also = "poles" in dict(design.values), (("method", BY_POLES),)
    by_hand, window = design["method"] == BY_POLES, here.window

    def board(name: str, title: str, poles: np.ndarray, role: str, side: str) -> Board:
        return Board(name, same(title), design["poles"] if by_hand else on_board(poles, window), "poles" if can else None, role=role,
                     side=side, re_low=window.re_low, re_high=window.re_high, im_high=window.im_high, also=also if can else (),
                     landscape=error_matrix if side == "right" else None)
    return (board("controller", "(A, B, K)   eig(A − BK)", left, "plant", "left"),
            board("observer", "(Aᵀ, Cᵀ, Lᵀ)   eig(Aᵀ − CᵀLᵀ)", right, "estimate", "right"))


def _formulas(K: np.ndarray, L: np.ndarray, K_dual: np.ndarray) -> tuple[Formula, ...]:
    return (
        Formula("twin", r"(A-LC)^{\mathsf T} = A^{\mathsf T} - C^{\mathsf T} L^{\mathsf T}"),
        Formula("K", gain_words("K", K)),
        Formula("L", rf"{gain_words('L', L)},\quad {gain_words('K_d', K_dual)}"),
    )


def _live(L: np.ndarray, m: dict[str, float]) -> Text:
    numbers = f"({', '.join(f'{v:.4g}' for v in L[:4, 0])}{', …' if L.size > 4 else ''})".replace("-", "−")
    return Text(f"The observer's own equation gives L = {numbers}; the feedback of the transposed plant, turned on its "
                f"side, differs by {m['gain_gap']:.0e} of its size.",
                f"由观测器自己的方程得 L = {numbers}；转置对象的反馈增益转置后与它的相对差为 {m['gain_gap']:.0e}。")


def figures(here: Setting, outcome: Outcome) -> tuple[Figure, ...]:
    """The run; gains, Riccati solutions and the pairing beside their twins; both ellipses."""
    run, twins = outcome.run, outcome.extra
    assert run is not None
    return (*state_figures(here.model, run, 2), error_figure(run), input_figure(run, here.model), _gain_table(outcome, twins),
            _riccati_table(here, outcome, twins), _pairing(twins, outcome.metrics["pairing_gap"]),
            *_ellipses(here, outcome.design["window"], twins, outcome.metrics["mirror_gap"]))


def _entry(value: float) -> str:
    return f"{value:.6g}".replace("-", "−")


def _gain_table(outcome: Outcome, twins: Twins) -> TableFigure:
    wide = twins.L.shape[1] > 1
    names = (f"L{i + 1},{j + 1}" if wide else "L" + str(i + 1).translate(LOWERED) for i, j in np.ndindex(twins.L.shape))
    rows = tuple((name, _entry(float(a)), _entry(float(b)), f"{abs(a - b):.0e}") for name, a, b in zip(
        names, twins.L.ravel(), twins.K_dual.T.ravel(), strict=True))[:MOST_ROWS]
    left, right = (pole_words(outcome.poles[side].tolist()) for side in ("controller", "observer"))
    return TableFigure(
        "gains", Text("one gain, found twice", "同一个增益，两种求法"),
        (same(""), Text("L, own equation", "L：自己的方程"), Text("K_dᵀ of (Aᵀ, Cᵀ)", "(Aᵀ, Cᵀ) 的 K_dᵀ"),
         Text("difference", "差")), rows, tab=TWINS_TAB,
        caption=Text(f"Left board: {left}. Right board: {right}.", f"左板：{left}。右板：{right}。"))


def _riccati_table(here: Setting, outcome: Outcome, twins: Twins) -> TableFigure:
    rows = [(f"P{i + 1}{j + 1}", _entry(float(twins.P[i, j])), _entry(float(twins.S_dual[i, j])),
             f"{abs(twins.P[i, j] - twins.S_dual[i, j]):.0e}") for i, j in np.ndindex(twins.P.shape) if i <= j][:MOST_ROWS]
    Q, R, W, V = _weights(here, outcome.design)
    slow = twins.slowest
    return TableFigure(
        "riccati", Text("one Riccati equation, read twice", "同一个 Riccati 方程，两种读法"),
        (same(""), Text("P of LQE (W, V)", "LQE (W, V) 的 P"), Text("S of LQR on (Aᵀ, Cᵀ)", "(Aᵀ, Cᵀ) 上 LQR 的 S"),
         Text("difference", "差")), tuple(rows), tab=TWINS_TAB,
        caption=Text(f"Q₁₁ = {Q[0, 0]:.3g}, R₁₁ = {R[0, 0]:.3g}: slowest LQR pole {_entry(slow[0])}. "
                     f"W₁₁ = {W[0, 0]:.3g}, V₁₁ = {V[0, 0]:.3g}: slowest LQE pole {_entry(slow[1])}.",
                     f"Q₁₁ = {Q[0, 0]:.3g}，R₁₁ = {R[0, 0]:.3g}：LQR 最慢极点的实部 {_entry(slow[0])}。"
                     f"W₁₁ = {W[0, 0]:.3g}，V₁₁ = {V[0, 0]:.3g}：LQE 最慢极点的实部 {_entry(slow[1])}。"))


def _pairing(twins: Twins, relative: float) -> TimeFigure:
    value = f"{twins.pairing[0]:.4g}".replace("-", "−")
    return TimeFigure(
        "pairing", Text("observer forward, dual backward", "观测器向前，对偶回路向后"), twins.t,
        (Curve(Text("‖e(t)‖", "‖e(t)‖"), np.linalg.norm(twins.e, axis=1), "error"),
         Curve(Text("‖x_d(T − t)‖", "‖x_d(T − t)‖"), np.linalg.norm(twins.z, axis=1), "second", "dash"),
         Curve(Text("x_d(T − t)ᵀ e(t)", "x_d(T − t)ᵀ e(t)"), twins.pairing, "reference", "solid", 2.6)),
        "", window=(-0.5, 1.5), tab=TWINS_TAB,
        caption=Text(f"The product stays at {value} to {relative:.0e} of the size of its factors.",
                     f"乘积恒为 {value}，相对其因子的变化为 {relative:.0e}。"))


def _ellipse(W: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
    """x and y of W^{1/2} times the unit circle, and the half axes, long and short."""
    values, axes = np.linalg.eigh(W)
    half = np.sqrt(np.maximum(values, 0.0))
    x, y = (axes * half) @ np.array([np.cos(CIRCLE), np.sin(CIRCLE)])
    return x, y, float(half[-1]), float(half[0])


def _plane(name: str, title: Text, caption: Text, own: np.ndarray, twin: np.ndarray, legend: tuple[Text, Text],
           half: float, axes: tuple[str, str]) -> PlaneFigure:
    (x, y, *_), (xt, yt, *_) = _ellipse(own), _ellipse(twin)
    return PlaneFigure(
        name, title, (Curve(legend[0], y, "plant", "solid", 3.4, x), Curve(legend[1], yt, "estimate", "dash", 1.8, xt)),
        (), *axes, (-half, half), (-half, half), equal=True, tab=ELLIPSES_TAB, caption=caption)


def _ellipses(here: Setting, window: float, twins: Twins, mirror: float) -> tuple[PlaneFigure, PlaneFigure]:
    at = np.ix_(here.pair, here.pair)
    reach, seen = _ellipse(twins.reach[at]), _ellipse(twins.seen[at])
    half = 1.15 * nice(max(reach[2], seen[2]))
    mirrored = (Text(" It is the mirror image of the upper one.", " 它正是上图的镜像。") if mirror < 1e-6 else same(""))
    return (
        _plane("reach", Text("states reached with unit energy", "单位能量所能到达的状态"),
               Text(f"Within {window:.3g} s: {reach[2]:.3g} along the easy direction, {reach[3]:.3g} along the hard one.",
                    f"在 {window:.3g} s 之内：容易的方向达 {reach[2]:.3g}，困难的方向只达 {reach[3]:.3g}。"),
               twins.reach[at], twins.reach_twin[at],
               (Text("reached by (A, B)", "(A, B) 可达"), Text("seen by (Aᵀ, Bᵀ)", "(Aᵀ, Bᵀ) 能观")), half, here.axes),
        _plane("seen", Text("how loudly a start is heard", "初始状态在输出中的响度"),
               Text(f"A unit start leaves an output of norm {seen[2]:.3g} along the long axis and {seen[3]:.3g} along the "
                    f"short one, within {window:.3g} s.{mirrored.en}",
                    f"单位初态沿长轴在 {window:.3g} s 之内留下范数 {seen[2]:.3g} 的输出，沿短轴只有 {seen[3]:.3g}。{mirrored.zh}"),
               twins.seen[at], twins.seen_twin[at],
               (Text("seen by (A, C)", "(A, C) 能观"), Text("reached by (Aᵀ, Cᵀ)", "(Aᵀ, Cᵀ) 可达")), half, here.axes),
    )


def _published(outcome: Outcome) -> Verdict:
    L, sensor = (outcome.metrics["L1"], outcome.metrics["L2"]), outcome.design["sensor"]
    shown = f"({L[0]:.3f}, {L[1]:.3f})".replace("-", "−")
    if sensor != 0:
        return Verdict(False, Text(f"The sensor is turned by {sensor:g}°; measure the position (0°).",
                                   f"传感器转了 {sensor:g}°；请测量位置（0°）。"))
    if max(abs(L[0] - 1.5), abs(L[1] + 0.75)) <= 0.05:
        return Verdict(True, Text(f"L = {shown}, and the feedback of (Aᵀ, Cᵀ) holds the same two numbers.",
                                  f"L = {shown}，(Aᵀ, Cᵀ) 的反馈增益正是同样两个数。"))
    return Verdict(False, Text(f"L = {shown}; it should be (1.5, −0.75) within 0.05.",
                               f"L = {shown}；应为 (1.5, −0.75)，允差 0.05。"))


def _ratio(outcome: Outcome) -> Verdict:
    d = outcome.design
    if d["method"] != BY_WEIGHTS or d["mirror"]:
        return Verdict(False, Text("Choose gains by weights and switch the mirror off.", "请把“增益由”改为“Q/R 权重”，并关闭“权重对偶”。"))
    scale, ratio = d["w"] / d["q"], (d["w"] / d["v"]) / (d["q"] / d["r"])
    if max(scale, 1 / scale) < 10:
        return Verdict(False, Text(f"α_W is {scale:.3g} times α_Q; make it at least ten times larger or smaller.",
                                   f"α_W 是 α_Q 的 {scale:.3g} 倍；请使它不小于 10 倍或不大于 1/10。"))
    if abs(ratio - 1) > 0.02:
        return Verdict(False, Text(f"L has changed: α_W/α_V is {ratio:.3g} times α_Q/α_R; it should be the same.",
                                   f"L 变了：α_W/α_V 是 α_Q/α_R 的 {ratio:.3g} 倍，二者应当相等。"))
    return Verdict(True, Text(f"P is {scale:.3g} times as large, yet L is what mirrored weights give.",
                              f"P 变为 {scale:.3g} 倍，L 却与权重对偶时相同。"))


def _mirror_image(outcome: Outcome) -> Verdict:
    m = outcome.metrics["mirror_gap"]
    if m <= 0.02:
        return Verdict(True, Text(f"The ellipses are mirror images to {100 * m:.1g} %: the sensor sits where the force acts.",
                                  f"两个椭圆互为镜像，相差 {100 * m:.1g} %：传感器与力同位。"))
    return Verdict(False, Text(f"Mirrored at the q axis, the ellipses still differ by {100 * m:.0f} %; bring it to 2 %.",
                               f"以 q 轴为镜，两个椭圆仍相差 {100 * m:.0f} %，请降到 2 % 以内。"))


def exam(seed: int) -> ExamItem:
    """Spring-damper with m = 1: a feedback for (Aᵀ, Cᵀ) with poles −a, −c is given; what is the second entry of L?"""
    rng = np.random.default_rng(seed)
    b, k = float(rng.integers(1, 9)) / 4, float(rng.integers(1, 7))
    a, c = (float(v) for v in rng.choice(np.arange(2, 9), 2, replace=False))
    first = a + c - b
    return ExamItem({"b": f"{b:g}", "k": f"{k:g}", "p1": f"-{a:g}", "p2": f"-{c:g}", "first": f"{first:g}"},
                    a * c - k - b * first, 1e-3)


def adapt(model: Model) -> Lesson:
    """The lesson on a person's own plant."""
    from .own import adapted  # which builds on this module

    return adapted(model)


BLOCK = Setting(MODEL, lambda design: turned(design["sensor"]), np.eye(2), np.eye(1), np.eye(2), np.eye(1), (0, 1), ("q [m]", "v [m/s]"),
                Window(-5.0, 1.5, 3.0), mirror=True)
LESSON = Lesson(
    "duality", 5, KNOBS, partial(compute, BLOCK), partial(figures, BLOCK), answer=2,
    tasks=(
        Task("published", _published, {"method": BY_POLES, "poles": (-1 + 0j, -1 + 0j), "sensor": 0.0}),
        Task("ratio", _ratio, {"method": BY_WEIGHTS, "mirror": False, "w": 40.0, "v": 10.0}),
        Task("mirror", _mirror_image, {"sensor": 90.0}),
    ),
    exam=exam, source="Tutorial (000), duality section: L = K_dᵀ; observer notes (001), spring-damper example",
    words=read_prose(Path(__file__).parent), adapt=adapt)

__all__ = ["LESSON"]
