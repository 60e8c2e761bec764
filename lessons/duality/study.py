"""What duality computes: the plant, its transposed twin, and each quantity worked out on both sides."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import expm, schur

from app.engine import EngineError, Plant, Scenario, lqe, lqr, observer_gain, place, simulate
from app.engine.structure import reachability_gramian
from app.engine.systems import sorted_poles, state_scale, symmetric
from app.lesson.knobs import KnobError
from app.lesson.lesson import LOST, Board, Check, Design, Formula, Outcome
from app.plants import Model, Window
from app.text import Text, same, text

from ..toolkit.boards import listed, stage
from ..toolkit.knobs import BY_POLES, kicks
from ..toolkit.latex import gain_words
from .horizon import Horizon, horizon_of
from .knobs import MODEL

EXACT = 1e-8  # agreement asked of the two sides, relative to their size
FLIP = np.diag([1.0, -1.0])  # the mirror that turns velocities round
TINY = 1e-16


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
    axes: tuple[Text | str, Text | str]
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
    S: np.ndarray  # regulator Riccati of (A, B)
    horizon: Horizon  # both equations in time, over the window
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


def weights_of(here: Setting, design: Design) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Q, R of the regulator and W, V of the filter."""
    q, r = design["q"], design["r"]
    w, v = (q, r) if design["mirror"] else (design["w"], design["v"])
    return q * here.Q, r * here.R, w * here.W, v * here.V


def gains_of(here: Setting, design: Design, plant: Plant) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """K of the plant, L by the engine, L by the observer's own equation, K_d of the transposed plant."""
    A, B, C = plant.A, plant.B, plant.C
    Q, R, W, V = weights_of(here, design)
    if design["method"] == BY_POLES:
        p = design["poles"]
        return (place(A, B, p).gain, observer_gain(A, C, p).gain, observer_by_polynomial(A, C, p),
                place(A.T, C.T, p).gain)
    own = np.linalg.solve(V, C @ filter_riccati(A, C, W, V)).T
    return lqr(A, B, Q, R).gain, lqe(A, np.eye(plant.n), C, W, V).gain, own, lqr(A.T, C.T, W, V).gain


def run_pair(model: Model, plant: Plant, L: np.ndarray, K_dual: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """e(t) of the observer and x_d(T − t) of the dual loop over a window of about two of the slowest time constants.

    Raises KnobError where one of them is lost within its first step.
    """
    slowest = float(np.min(np.abs(np.linalg.eigvals(plant.A - L @ plant.C).real)))
    span = float(np.clip(2 / max(slowest, 1e-6 / model.horizon), model.horizon / 24, model.horizon / 3))
    step = span / 200
    seen = simulate(Scenario(plant, L=L, x0=model.x0, xhat0=model.guess, horizon=span, dt=step))
    dual = simulate(Scenario(plant.dual(), K_dual, x0=np.ones(plant.n), horizon=span, dt=step, state_feedback=True))
    count = min(len(seen.t), len(dual.t))
    if count < 2:
        raise KnobError(LOST)
    return seen.t[:count], seen.e[:count], dual.x[:count][::-1]


def twins_of(here: Setting, design: Design, plant: Plant, own: np.ndarray, K_dual: np.ndarray) -> Twins:
    """Each pair worked out on both sides, with L and K_d given."""
    A, B, C = plant.A, plant.B, plant.C
    Q, R, W, V = weights_of(here, design)
    regulator, twin, P = lqr(A, B, Q, R), lqr(A.T, C.T, W, V), filter_riccati(A, C, W, V)
    return Twins(
        own, K_dual, P, twin.solution,
        (float(max(regulator.poles.real)), float(max(twin.poles.real))),
        *_gramians(plant, design["window"]), regulator.solution, horizon_of(plant, (Q, R, W, V), regulator.solution, P, design["window"]),
        *run_pair(here.model, plant, own, K_dual))


@lru_cache(maxsize=128)
def _gramians(plant: Plant, T: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Reached by (A, B), heard by (Aᵀ, Bᵀ); heard by (A, C), reached by (Aᵀ, Cᵀ); 2×2 each, within T seconds."""
    A, B, C = plant.A, plant.B, plant.C
    return (reachability_gramian(plant, T), output_energy(A.T, B.T, T),
            output_energy(A, C, T), reachability_gramian(plant.dual(), T))


def gap(a: np.ndarray, b: np.ndarray) -> float:
    """max|a − b| relative to max|b|."""
    return float(np.max(np.abs(a - b)) / max(np.max(np.abs(b)), TINY))


def compute(here: Setting, design: Design) -> Outcome[Twins]:
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
        ("transpose", "gain_gap", text("L = K_dᵀ to rounding")),
        ("riccati", "riccati_gap", text("P of the filter = S of the transposed plant")),
        ("gramians", "gramian_gap", text("each Gramian = its twin's")),
        ("pairing", "pairing_gap", text("x_d(T − t)ᵀ e(t) is constant")),
    )
    return tuple(Check(name, words, m[key] <= EXACT, m[key]) for name, key, words in sentences)


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
    return text("The observer's own equation gives L = {numbers}; the feedback of the transposed plant, turned on "
                "its side, differs by {gain_gap:.0e} of its size.",
                numbers=numbers, gain_gap=m["gain_gap"])


BLOCK = Setting(MODEL, lambda design: turned(design["sensor"]), np.eye(2), np.eye(1), np.eye(2), np.eye(1), (0, 1), ("q [m]", "v [m/s]"),
                Window(-5.0, 1.5, 3.0), mirror=True)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(48)


def observer_by_polynomial(A: np.ndarray, C: np.ndarray, poles: Sequence[complex]) -> np.ndarray:
    """L (n×1) = φ(A) O⁻¹ (0 … 0 1)ᵀ with φ the polynomial of the poles asked: Ackermann's formula for one output.

    A n×n, C 1×n. Raises EngineError where O = [C; CA; …] is singular.
    """
    rows = [C]
    for _ in range(len(A) - 1):
        rows.append(rows[-1] @ A)
    try:
        last = np.linalg.solve(np.vstack(rows), np.eye(len(A))[:, -1:])
    except np.linalg.LinAlgError:
        raise EngineError("This sensor does not see every state, so the formula for L fails; turn the sensor.") from None
    phi = np.zeros_like(A)
    for coefficient in np.real(np.poly(np.asarray(poles))):
        phi = phi @ A + coefficient * np.eye(len(A))
    return phi @ last


def filter_riccati(A: np.ndarray, C: np.ndarray, W: np.ndarray, V: np.ndarray) -> np.ndarray:
    """P (n×n) of AP + PAᵀ − PCᵀV⁻¹CP + W = 0 from the filter's own Hamiltonian [−Aᵀ CᵀV⁻¹C; W A].

    The Hamiltonian's unstable invariant subspace is spanned by [I; P], in balanced states. A n×n, C p×n, W n×n ⪰ 0, V p×p > 0.
    Raises EngineError where rounding leaves no such subspace.
    Source: Laub, "A Schur method for solving algebraic Riccati equations" (1979), written for the filter.
    """
    n, scale = len(A), state_scale(A, None, C)
    A, C, W = A * scale / scale[:, None], C * scale, W / scale / scale[:, None]
    try:
        basis = schur(np.block([[-A.T, C.T @ np.linalg.solve(V, C)], [W, A]]), output="real", sort="rhp")[1][:, :n]
        P = np.linalg.solve(basis[:n].T, basis[n:].T).T
    except np.linalg.LinAlgError:
        raise EngineError("The Riccati equation is too ill-conditioned to be solved; bring the weights or the units of the "
                          "states closer.") from None
    return scale[:, None] * symmetric(P) * scale


def output_energy(A: np.ndarray, C: np.ndarray, horizon: float) -> np.ndarray:
    """E (n×n): E_ij = ∫₀ᵀ y_i(t)·y_j(t) dt, y_i the output after a start at the i-th unit state. Gauss quadrature.

    x(0)ᵀ E x(0) is the energy that the start x(0) leaves in the measurement within T seconds.
    """
    t = (NODES + 1) * horizon / 2
    y = C @ expm(t[:, None, None] * A)  # (48, p, n)
    return np.einsum("k,kpi,kpj->ij", WEIGHTS * horizon / 2, y, y)
