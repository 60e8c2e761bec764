"""Check source 000, tutorial on estimate feedback: its laws and its one false sentence."""

from __future__ import annotations

import numpy as np

from ..engine import Plant, Scenario, autonomous_error, closed_loop, lqe, lqr, observability, observer_gain, place, simulate
from ..plants import MODELS
from ..plants.two_mass import HIDDEN
from .record import Published

SOURCE = "000 tutorial"
DECK_MODEL = MODELS["deck"]
DOUBLE = Plant(np.array([[0, 1], [0, 0]]), np.array([[0], [1]]), np.array([[1, 0]]))
CLIPPED_START = (5.0, 0.0)  # x(0) of the clipped double integrator, believed to be at rest in 0
LIMIT = 1.0


def _deck_gains() -> tuple[np.ndarray, np.ndarray]:
    A, B, C = DECK_MODEL.plant.A, DECK_MODEL.plant.B, DECK_MODEL.plant.C
    alike = np.ones(len(A))
    return (place(A, B, DECK_MODEL.controller_poles, sizes=alike).gain, observer_gain(A, C, DECK_MODEL.observer_poles, sizes=alike).gain)


def error_under_inputs() -> float:
    """How far e differs between no input and a sine of 1 N on each coil, relative to its size."""
    _, L = _deck_gains()
    t = DECK_MODEL.dt * np.arange(round(DECK_MODEL.horizon / DECK_MODEL.dt) + 1)
    push = np.sin(5 * t)[:, None] * np.ones(DECK_MODEL.plant.m)
    still, moved = (simulate(Scenario(DECK_MODEL.plant, None, L, x0=DECK_MODEL.x0, xhat0=DECK_MODEL.guess, horizon=DECK_MODEL.horizon,
                                      dt=DECK_MODEL.dt, reference=r)) for r in (None, push))
    return float(np.abs(still.e - moved.e).max() / np.abs(still.e).max())


def union_of_spectra() -> float:
    """Largest distance between the poles of the 2n-state loop and the union of both sets, relative."""
    return closed_loop(DECK_MODEL.plant, *_deck_gains()).union_error


def lower_left_block() -> float:
    """Largest entry of the block through which x would drive e, relative to the loop matrix."""
    loop = closed_loop(DECK_MODEL.plant, *_deck_gains())
    n = DECK_MODEL.plant.n
    return float(np.abs(loop.A_xe[n:, :n]).max() / np.abs(loop.A_xe).max())


def loop_states() -> float:
    """Number of poles of the whole loop for each state of the plant."""
    return closed_loop(DECK_MODEL.plant, *_deck_gains()).poles.size / DECK_MODEL.plant.n


def dual_gain() -> float:
    """‖L − K_dᵀ‖ for the deck, K_d placed on the dual plant, relative."""
    _, L = _deck_gains()
    dual = DECK_MODEL.plant.dual()
    K = place(dual.A, dual.B, DECK_MODEL.observer_poles, sizes=np.ones(dual.n)).gain
    return float(np.abs(L - K.T).max() / np.abs(L).max())


def dual_riccati() -> float:
    """Difference of P (filter) and S (regulator of the dual plant) under the swap, relative."""
    A, B, C = DECK_MODEL.plant.A, DECK_MODEL.plant.B, DECK_MODEL.plant.C
    W, V = 0.1 * np.eye(DECK_MODEL.plant.m), 0.01 * np.eye(DECK_MODEL.plant.p)
    P, S = lqe(A, B, C, W, V).solution, lqr(A.T, C.T, B @ W @ B.T, V).solution
    return float(np.abs(P - S).max() / np.abs(P).max())


def fixed_pole() -> tuple[float, float]:
    """Whether the unseen unstable chain is called detectable, and how near its fixed pole stays for any of 20 gains."""
    case = HIDDEN["unseen-unstable"]
    plant, rng = case.model.plant, np.random.default_rng(1)
    pole = max(case.poles, key=lambda p: p.real)
    gap = max(float(np.abs(np.linalg.eigvals(plant.A - rng.normal(scale=5, size=(plant.n, plant.p)) @ plant.C)
                           - pole).min()) for _ in range(20))
    return float(observability(plant).detectable), gap


def clipped_error(fed: str) -> float:
    """Largest deviation of e from expm((A − LC)t) e(0) over 10 s: K at −2, −2, L at −6, −6, |u| ≤ 1."""
    K, L = place(DOUBLE.A, DOUBLE.B, [-2, -2]).gain, observer_gain(DOUBLE.A, DOUBLE.C, [-6, -6]).gain
    run = simulate(Scenario(DOUBLE, K, L, x0=CLIPPED_START, u_min=-LIMIT, u_max=LIMIT, fed=fed))  # type: ignore[arg-type]
    return float(np.abs(run.e - autonomous_error(run)).max())


RECORDS = (
    Published(SOURCE, "e differs between two inputs u(t) by", "ė = (A − LC)e", error_under_inputs, right="0",
              tolerance=1e-9, note="the law holds no u; deck, sine against nothing"),
    Published(SOURCE, "states of the loop for each of the plant's", "2n", loop_states, right="2"),
    Published(SOURCE, "spectrum of the loop against the union", "union", union_of_spectra, right="0",
              tolerance=1e-9),
    Published(SOURCE, "lower left block in (x, e)", "0", lower_left_block, tolerance=1e-12),
    Published(SOURCE, "L − K_dᵀ of the dual plant", "L = K_dᵀ", dual_gain, right="0", tolerance=1e-9),
    Published(SOURCE, "Riccati solutions under the swap", "", dual_riccati, "beyond", "0", tolerance=1e-9),
    Published(SOURCE, "unseen unstable mode: detectable, motion of its pole", "fixed for every L", fixed_pole,
              right="0, 0", tolerance=1e-9),
    Published(SOURCE, "saturated, observer fed sat(u): e leaves its law by", "saturation ends the cancellation of Bu",
              lambda: clipped_error("applied"), "slip", "0", tolerance=1e-9,
              note="only if the observer is fed the commanded input; fed sat(u), ė = (A − LC)e stays exact"),
    Published(SOURCE, "saturated, observer fed u: e leaves its law by", "", lambda: clipped_error("commanded"),
              "beyond", "7.7", note="x(0) = (5, 0), believed 0"),
)
