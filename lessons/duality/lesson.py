"""Duality: one problem worn twice. The observer of (A, C) is the controller of (Aᵀ, Cᵀ), read sideways."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from types import MappingProxyType

import numpy as np

from app.engine import Scenario, simulate
from app.engine.systems import sorted_poles
from app.lesson.knobs import Choice, Number, Poles, Switch
from app.lesson.lesson import Board, Check, Design, ExamItem, Formula, Lesson, Outcome
from app.lesson.prose import read_prose
from app.plants import Model, Window
from app.text.words import Text, same

from ..toolkit.boards import WEIGHTS, listed, stage
from ..toolkit.knobs import BY_POLES, BY_WEIGHTS, kicks, run_knobs
from ..toolkit.latex import gain_words
from .pictures import all_figures
from .tasks import TASKS
from .twins import MODEL, TINY, Setting, gains_of, gap, turned, twins_of

EXACT = 1e-8  # agreement asked of the two sides, relative to their size
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


def compute(here: Setting, design: Design) -> Outcome:
    """Both gains, both Riccati solutions, both Gramians, and one run of the plant under them."""
    plant, model = here.plant(design), here.model
    K, L, own, K_dual = gains_of(here, design, plant)
    twins = twins_of(here, design, plant, own, K_dual)
    run = simulate(Scenario(plant, K, L, x0=model.x0, xhat0=model.guess, horizon=model.horizon, dt=model.dt,
                            impulses=kicks(design, model), seed=int(design["seed"])))
    error_matrix = plant.A - own @ plant.C
    left, right = map(sorted_poles, (plant.A - plant.B @ K, error_matrix))
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
        return Board(name, same(title), design["poles"] if by_hand else listed(poles), "poles" if can else None, role=role,
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


def exam(seed: int) -> ExamItem:
    """Spring-damper with m = 1: a feedback for (Aᵀ, Cᵀ) with poles −a, −c is given; what is the second entry of L?"""
    rng = np.random.default_rng(seed)
    b, k = float(rng.integers(1, 9)) / 4, float(rng.integers(1, 7))
    a, c = (float(v) for v in rng.choice(np.arange(2, 9), 2, replace=False))
    first = a + c - b
    return ExamItem({"b": f"{b:g}", "k": f"{k:g}", "p1": f"-{a:g}", "p2": f"-{c:g}", "first": f"{first:g}"},
                    a * c - k - b * first, 1e-3)


def adapt(lesson: Lesson, model: Model) -> Lesson:
    """The lesson on a person's own plant."""
    from .own import adapted

    return adapted(lesson, model)


BLOCK = Setting(MODEL, lambda design: turned(design["sensor"]), np.eye(2), np.eye(1), np.eye(2), np.eye(1), (0, 1), ("q [m]", "v [m/s]"),
                Window(-5.0, 1.5, 3.0), mirror=True)
LESSON = Lesson(
    "duality", 5, KNOBS, partial(compute, BLOCK), partial(all_figures, BLOCK), answer=2, tasks=TASKS, exam=exam,
    source="Tutorial (000), duality section: L = K_dᵀ; observer notes (001), spring-damper example",
    words=read_prose(Path(__file__).parent), adapt=adapt)

__all__ = ["LESSON"]
