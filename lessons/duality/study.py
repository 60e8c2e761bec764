"""Compute a design of lesson 5: both gains, Riccati solutions, Gramians, one run."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from observer_lab.course.lazy import LazyMap, LazySequence, LazyValue
from observer_lab.course.lesson import Board, Check, Design, Formula, Outcome
from observer_lab.engine import Plant, Scenario, simulate
from observer_lab.engine.systems import sorted_poles
from observer_lab.plants import Window
from observer_lab.text import Text, format_number, same, text

from ..toolkit.boards import listed, stage
from ..toolkit.knobs import BY_POLES, kicks
from ..toolkit.latex import gain_words
from .dual_quantities import TINY, Setting, Twins, gap
from .gain_tiles import shown_stage
from .knobs import MODEL

DUAL_RTOL = 1e-8  # agreement asked of the two sides, relative to their size


@lru_cache(maxsize=128)
def turned(degrees: float) -> Plant:
    """The spring-damper with its sensor turned from position (0°) to velocity (90°)."""
    angle, p = np.radians(degrees), MODEL.plant
    C = np.array([[np.cos(angle), np.sin(angle)]])
    C[np.abs(C) < TINY] = 0.0
    names = "position" if degrees == 0 else "velocity" if degrees == 90 else "sensor"
    return Plant(p.A, p.B, C, p.D, 0.0, p.state_names, p.input_names, (names,), p.units[:3], p.name)


def compute(here: Setting, design: Design) -> Outcome[Twins]:
    """Both gains, both Riccati solutions, both Gramians, and one run of the plant under them."""
    plant, model = here.plant(design), here.model
    twins = Twins(here, design, plant)
    K, L, own = twins.K, twins.L_engine, twins.L
    run = simulate(Scenario(plant, K, L, x0=model.x0, xhat0=model.guess, horizon=model.horizon, dt=model.dt,
                            impulses=kicks(design, model), seed=int(design["seed"])))
    error_matrix = plant.A - own @ plant.C
    left, right = map(sorted_poles, (plant.A - plant.B @ K, error_matrix))
    metrics = LazyMap(lambda: _metrics(twins, left, right))
    gains = {"K": K, "L": L}
    return Outcome(design, LazyMap(lambda: {**gains, "K_dual": twins.K_dual}, gains), {"controller": left, "observer": right}, metrics,
                   LazySequence(lambda: _checks(metrics)), run, _boards(here, design, left, right, error_matrix),
                   shown_stage(stage(model, run, design), twins) if here.mirror else stage(model, run, design),
                   LazySequence(lambda: _formulas(K, own, twins.K_dual)), LazyValue(lambda: _live(own, metrics)), twins)


def _metrics(twins: Twins, left: np.ndarray, right: np.ndarray) -> dict[str, float]:
    own = twins.L
    return {
        "gain_gap": gap(twins.K_dual.T, own), "riccati_gap": gap(twins.S_dual, twins.P),
        "gramian_gap": max(gap(twins.energies.reach_twin, twins.energies.reach), gap(twins.energies.seen_twin, twins.energies.seen)),
        "pairing_gap": twins.pairing_gap, "mirror_gap": twins.mirror_gap,
        "L1": float(own[0, 0]), "L2": float(own[-1, 0]), "slowest_controller": float(np.max(np.real(left))),
        "slowest_observer": float(np.max(np.real(right))),
    }


def _checks(m: Mapping[str, float]) -> tuple[Check, ...]:
    sentences = (
        ("transpose", "gain_gap", text("L = K_dᵀ to rounding")),
        ("riccati", "riccati_gap", text("P of the filter = S of the transposed plant")),
        ("gramians", "gramian_gap", text("each Gramian = that of the dual plant")),
        ("pairing", "pairing_gap", text("x_d(T − t)ᵀ e(t) is constant")),
    )
    return tuple(Check(name, words, m[key] <= DUAL_RTOL, m[key]) for name, key, words in sentences)


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


def _live(L: np.ndarray, m: Mapping[str, float]) -> Text:
    numbers = f"({', '.join(format_number(v, '.4g') for v in L[:4, 0])}{', …' if L.size > 4 else ''})"
    return text("The observer's own equation gives L = {numbers}; the transposed feedback of the transposed plant differs by "
                "{gain_gap:.0e} of its size.",
                numbers=numbers, gain_gap=m["gain_gap"])


BLOCK_SETTING = Setting(
    MODEL,
    lambda design: turned(design["sensor"]),
    np.eye(2),
    np.eye(1),
    np.eye(2),
    np.eye(1),
    (0, 1),
    ("q [m]", "v [m/s]"),
    Window(-5.0, 1.5, 3.0),
    mirror=True,
)
