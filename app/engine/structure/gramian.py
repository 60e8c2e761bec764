"""Compute Gramians, Hankel singular values, and balanced truncation.

Factors, never the Gramians themselves, are multiplied: a Hankel value 1e-7 of the largest would drown in the
rounding of Wc·Wo.
"""

from __future__ import annotations

from dataclasses import field
from functools import cached_property

import numpy as np
from scipy.linalg import expm, schur, solve_sylvester
from scipy.linalg.lapack import dgesdd  # pyright: ignore[reportAttributeAccessIssue]

from ..systems.arrays import frozen, symmetric
from ..systems.balance import MIN_RATE, balance, state_scale
from ..systems.errors import EngineError, phrase
from ..systems.exact_roots import MAX_STATES
from ..systems.gates.argument_checks import HORIZON, INTEGER, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.lyapunov import settled_covariances, settled_factors
from ..systems.plant import Plant
from ..systems.records import record
from ..systems.stability import is_stable, poles_within, stable_poles
from .decomposition import in_new_states
from .projection_error import projection_rounding_error

__all__ = ["Gramians", "StableSplit", "Truncation", "balanced_truncation", "gramians", "hankel_singular_values",
           "observability_gramian", "reachability_gramian", "split_stable"]

_EPS = float(np.finfo(float).eps)


@record()
class Gramians:
    """`controllability` Wc = ∫₀^∞ e^{At}BBᵀe^{Aᵀt} dt and `observability` Wo = ∫₀^∞ e^{Aᵀt}CᵀCe^{At} dt, n×n
    (sums of the powers of A when dt > 0)."""

    controllability: np.ndarray
    observability: np.ndarray


@record()
class StableSplit:
    """x = T (z_s, z_u): two plants side by side whose transfer functions add up to the plant's.

    `stable` holds D and every pole inside the stability region; `unstable` the rest, poles on its edge included.
    """

    stable: Plant
    unstable: Plant
    T: np.ndarray


@record()
class Truncation:
    """A reduced plant: x ≈ T z (n×r), z = left x (r×n), left T = I.

    `hankel`: all Hankel values of the stable part, largest first. `error_bound` = 2 Σ of those cut away and what rounding
    may add, an upper bound of ‖G − G_r‖_∞, computed when it is asked for. `kept`: how many unstable states were set aside first
    and kept untouched; they come last in z and have no Hankel value.
    """

    plant: Plant
    T: np.ndarray
    left: np.ndarray
    hankel: np.ndarray
    kept: int
    _of: tuple[Plant, Plant, float] = field(repr=False)  # the plant, its stable part, and what rounding does to a Hankel value

    @cached_property
    def error_bound(self) -> float:
        """2 Σ of the Hankel values cut away, and what rounding may add."""
        whole, stable, dust = self._of
        cut = self.hankel[self.plant.n - self.kept:]
        rounding = projection_rounding_error(whole, self.plant, self.T, self.left)
        return float(2 * cut.sum()) * (1 + _unsure(stable)) + 2 * len(cut) * dust + rounding


def _unstable_pole(plant: Plant) -> complex | None:
    poles, stable = stable_poles(plant.A, dt=plant.dt)
    excess = np.where(stable, -np.inf, np.abs(poles) if plant.dt > 0 else np.real(poles))
    return complex(poles[np.argmax(excess)]) if not stable.all() else None


def _require_stable(plant: Plant, advice: str) -> None:
    if is_stable(plant.A, dt=plant.dt):
        return
    pole = _unstable_pole(plant)
    if pole is not None:
        shown = f"{pole.real:.4g}" if pole.imag == 0 else f"{pole.real:.4g} {pole.imag:+.4g}j"
        raise EngineError("The pole at {shown} is not stable, so the integral to infinity diverges; {advice}.",
                          shown=shown, advice=advice)


@takes(plant=PLANT)
def gramians(plant: Plant) -> Gramians:
    """The Gramians of a stable plant: A Wc + Wc Aᵀ + B Bᵀ = 0 and Aᵀ Wo + Wo A + Cᵀ C = 0.

    With dt > 0: A Wc Aᵀ − Wc + B Bᵀ = 0 and Aᵀ Wo A − Wo + Cᵀ C = 0. Both n×n, symmetric, ⪰ 0 by construction.
    Raises EngineError when a pole is not stable.
    Source: Smith, "Matrix equation XA + BX = C" (1968), the doubling, here on square-root factors.

    >>> gramians(Plant([[-1]], [[1]], [[1]])).observability
    array([[0.5]])
    """
    _require_stable(plant, phrase("use observability_gramian or reachability_gramian with a finite horizon"))
    return Gramians(*map(frozen, settled_covariances(plant.A, plant.B, plant.C, plant.dt)))


@takes(plant=PLANT)
def hankel_singular_values(plant: Plant) -> np.ndarray:
    """σᵢ = √λᵢ(Wc Wo), largest first, shape (n,): how much of each state both u and y take part in.

    Square-root method: the singular values of RoᵀRc with Wc = RcRcᵀ, Wo = RoRoᵀ. Same whatever the coordinates.
    Raises EngineError when a pole is not stable; `split_stable` gives the part that has them.
    Source: Tombs and Postlethwaite, "Truncated balanced realization of a stable non-minimal system" (1987).

    >>> hankel_singular_values(Plant([[-1]], [[1]], [[1]]))
    array([0.5])
    """
    _require_stable(plant, phrase("take the Hankel values of split_stable(plant).stable"))
    Rc, Ro = settled_factors(plant.A, plant.B, plant.C, plant.dt)
    return np.linalg.svd(Ro.T @ Rc, compute_uv=False)


def _part(plant: Plant, right: np.ndarray, left: np.ndarray, D: np.ndarray | None, label: str) -> Plant:
    return in_new_states(plant, left @ plant.A @ right, left @ plant.B, plant.C @ right, D, label)


@takes(plant=PLANT)
def split_stable(plant: Plant) -> StableSplit:
    """G(s) = G_stable(s) + G_unstable(s), by an ordered Schur form and one Sylvester equation in balanced states.

    QᵀAQ = [A₁ A₁₂; 0 A₂], A₁X − XA₂ + A₁₂ = 0, T = Q [I X; 0 I]. Poles on the stability edge count as unstable, and so
    do those that rounding cannot tell from the edge.
    """
    n = plant.n
    if n == 0:
        return StableSplit(plant, plant, np.eye(0))
    own = balance(plant.A, plant.B, plant.C)
    A = own.A(plant.A)
    if is_stable(A, dt=plant.dt):
        none = _part(plant, np.zeros((n, 0)), np.zeros((0, n)), None, "unstable part")
        if n > MAX_STATES:  # of many states a triangular form would take digits
            return StableSplit(plant, none, frozen(np.eye(n)))
        S, Q = schur(A, output="real")  # type: ignore[misc]
        T, left = own.states[:, None] * Q, Q.T / own.states
        return StableSplit(_diagonal_part(plant, S, T, left, plant.D, "stable part"), none, frozen(T))
    poles, stable = stable_poles(A, dt=plant.dt)

    def inside(re: float, im: float) -> bool:
        return bool(stable[np.argmin(np.abs(poles - complex(re, im)))])

    S, Q, k = schur(A, output="real", sort=inside)  # type: ignore[misc]
    X = solve_sylvester(S[:k, :k], -S[k:, k:], -S[:k, k:]) if 0 < k < n else np.zeros((k, n - k))
    T = own.states[:, None] * (Q @ np.block([[np.eye(k), X], [np.zeros((n - k, k)), np.eye(n - k)]]))
    left = np.block([[np.eye(k), -X], [np.zeros((n - k, k)), np.eye(n - k)]]) @ Q.T / own.states
    diagonal = S[:k, :k], S[k:, k:]  # T⁻¹AT without the rounding of the product
    return StableSplit(_diagonal_part(plant, diagonal[0], T[:, :k], left[:k], plant.D, "stable part"),
                       _diagonal_part(plant, diagonal[1], T[:, k:], left[k:], None, "unstable part"), frozen(T))


def _diagonal_part(plant: Plant, A: np.ndarray, right: np.ndarray, left: np.ndarray, D: np.ndarray | None, label: str) -> Plant:
    return in_new_states(plant, A, left @ plant.B, plant.C @ right, D, label)


def _balance(plant: Plant, order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Hankel values, the r columns and rows of a balancing transformation of a stable plant, and what rounding does to a Hankel
    value."""
    Rc, Ro = settled_factors(plant.A, plant.B, plant.C, plant.dt)
    U, sigma, Vt, _ = dgesdd(Ro.T.dot(Rc))
    sign = _signs((Ro @ U).T, plant.B)
    U, Vt = U * sign, Vt * sign[:, None]
    lost = 10 * plant.n * _EPS
    if order and not sigma[order - 1] > lost * np.linalg.norm(Ro) * np.linalg.norm(Rc):
        real = int(np.count_nonzero(sigma > lost * np.linalg.norm(Ro, 2) * np.linalg.norm(Rc, 2)))
    else:  # beyond Frobenius norms, which are the larger and take no singular values
        real = order
    if order > real:
        raise EngineError("Only {real} stable states take part between u and y; ask for that many at most.",
                          real=real)
    root = np.sqrt(sigma[:order])
    dust = 40 * plant.n * _EPS * float(np.linalg.norm(np.abs(Ro).T @ np.abs(Rc)))
    return sigma, Rc @ Vt[:order].T / root, (Ro @ U[:, :order] / root).T, dust


def _signs(rows: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Signs (n,) by which the first input that clearly moves a balanced state moves it upwards: they are free, and else each
    processor's own."""
    moved = rows @ B
    clear = np.abs(moved) > 0.01 * (np.abs(rows) @ np.abs(B))
    first = np.take_along_axis(moved, clear.argmax(axis=1)[:, None], axis=1)[:, 0] if B.shape[1] else np.zeros(len(rows))
    return np.where(clear.any(axis=1) & (first < 0), -1.0, 1.0)


@takes(plant=PLANT, order=INTEGER)
def balanced_truncation(plant: Plant, order: int) -> Truncation:
    """Keep the `order` states that both u and y feel most.

    In balanced coordinates Wc = Wo = diag(σ); the states of the smallest σ are dropped, D stays, and
    ‖G − G_r‖_∞ ≤ 2 Σ_{i>r} σᵢ; equal σᵢ may be counted once if all of them are dropped.
    An unstable part is split off first, kept whole and counted in `order`.
    Raises EngineError when order is not a whole number between the unstable count and the minimal order.
    Source: Glover, "All optimal Hankel-norm approximations" (1984), theorem 9.6; Enns (1984) for the bound.

    >>> balanced_truncation(Plant(np.diag([-1, -50]), [[1], [1]], [[1, 1]]), 1).plant.n
    1
    """
    if not 0 <= order <= plant.n:
        raise EngineError("The order must be a whole number from 0 to {n}; it is {order}.", n=plant.n, order=order)
    split = split_stable(plant)
    stable = split.stable
    kept = plant.n - stable.n
    if order < kept:
        raise EngineError("{kept} unstable states must stay; ask for an order of at least {kept}.", kept=kept)
    r = order - kept
    sigma, right, left, dust = _balance(stable, r)
    T, L, k = right, left, stable.n
    if stable is not plant:
        scale = balance(plant.A, plant.B, plant.C).states
        inverse = np.linalg.inv(split.T / scale[:, None]) / scale
        T = np.hstack([split.T[:, :k] @ right, split.T[:, k:]])
        L = np.vstack([left @ inverse[:k], inverse[k:]])
    reduced = _part(plant, T, L, plant.D, f"cut to {order}")
    return Truncation(reduced, frozen(T), frozen(L), frozen(sigma), kept, (plant, stable, dust))


def _unsure(stable: Plant) -> float:
    """The share by which rounding of A may change Gramians: how far it moves a pole, beside that pole's way to the edge."""
    if not stable.n:
        return 0.0
    poles, slack = poles_within(stable.A)
    away = 1 - np.abs(poles) if stable.dt > 0 else -np.real(poles)
    return min(1.0, float((slack / np.maximum(away, 1e-300)).max()))


def _accumulate(E: np.ndarray, Q: np.ndarray, steps: int) -> np.ndarray:
    """Σ_{k<steps} Eᵏ Q Eᵏᵀ by doubling: log₂(steps) products."""
    W: np.ndarray = np.zeros_like(Q)
    power: np.ndarray = np.eye(E.shape[0])
    for bit in bin(steps)[2:]:
        W, power = W + power @ W @ power.T, power @ power
        if bit == "1":
            W, power = Q + E @ W @ E.T, E @ power
    return W


def _one_step(A: np.ndarray, Q: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """e^{Ah} and ∫₀ʰ e^{As} Q e^{Aᵀs} ds from one exponential of [A Q; 0 −Aᵀ] (Van Loan 1978), Q of the size of A, for small ‖A‖h."""
    n, most = A.shape[0], np.abs(Q).max(initial=0.0)
    size = 2.0 ** np.round(np.log2(max(np.abs(A).max(initial=0.0), MIN_RATE)) - np.log2(most)) if most > 0 else 1.0
    block: np.ndarray = expm(h * np.block([[A, Q * size], [np.zeros_like(A), -A.T]]))
    return block[:n, :n], block[:n, n:] @ block[:n, :n].T / size


@takes(plant=PLANT, horizon=HORIZON)
def reachability_gramian(plant: Plant, horizon: float) -> np.ndarray:
    """W(t) = ∫₀ᵗ e^{As}BBᵀe^{Aᵀs} ds, n×n: xᵀW⁻¹x is the least input energy that reaches x from 0 in time t.

    `horizon` in seconds; with dt > 0 the sum over the round(horizon/dt) samples. Any poles, stable or not.
    One short step by Van Loan's exponential, then doubling: no overflow on stiff plants.
    Raises EngineError for a horizon that is negative or not finite, and when growth overflows within it.
    """
    t = float(horizon)
    scale = state_scale(plant.A, plant.B)
    A, B = plant.A * scale / scale[:, None], plant.B / scale[:, None]
    with np.errstate(over="ignore", invalid="ignore"):
        if plant.dt > 0:
            W = _accumulate(A, B @ B.T, round(t / plant.dt))
        else:
            doublings = max(0, int(np.ceil(np.log2(max(np.linalg.norm(A, 2) * t, 1.0))))) if plant.n else 0
            W = _accumulate(*_one_step(A, B @ B.T, t / 2**doublings), 2**doublings)
        W = scale[:, None] * symmetric(W) * scale
    if not np.all(np.isfinite(W)):
        raise EngineError("The state grows beyond every number within {t:g} s; shorten the horizon.", t=t)
    return W


@takes(plant=PLANT, horizon=HORIZON)
def observability_gramian(plant: Plant, horizon: float) -> np.ndarray:
    """W(t) = ∫₀ᵗ e^{Aᵀs}CᵀCe^{As} ds, n×n: x(0)ᵀW x(0) is the energy that x(0) leaves in y within t.

    `horizon` in seconds; with dt > 0 the sum over the round(horizon/dt) samples. `reachability_gramian` of the dual.
    Raises EngineError for a horizon that is negative or not finite, and when growth overflows within it.
    """
    return reachability_gramian(plant.dual(), horizon)
