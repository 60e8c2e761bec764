"""Design observers that an unknown input cannot disturb, and test whether they exist."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..design.placement import observer_gain
from ..systems.arrays import as_checked, frozen, is_definite, solve_scaled, symmetric
from ..systems.balance import UNLIKE, balance, without_dust
from ..systems.errors import EngineError, Phrase, PoleError, ShapeError, phrase
from ..systems.gates.argument_checks import POLES, gated, matrix, optional, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant, as_matrix
from ..systems.pole_sets import Poles, pole_text, sorted_poles
from ..systems.records import record
from ..systems.zeros import invariant_zeros

__all__ = ["Decoupling", "UnknownInputObserver", "decoupling", "unknown_input_observer"]

RANK_RTOL = 1e-9  # singular values below this, of columns of length one, count as zero

NO_REASON = Phrase("")


@record()
class Decoupling:
    """Whether an observer can ignore the unknown input d of ẋ = A x + B u + E d, y = C x + D u.

    rank_CE, rank_E: the first condition is that they are equal. Then H (n×p) solves (I − H C) E = 0, T = I − H C,
    A1 = T A, and `zeros` are the invariant zeros of (A, E, C), which are the modes of A1 that C does not see; the
    second condition is that all of them are stable: `unstable` is empty. H, T, A1 and zeros are None where the first
    condition fails. `reason` says in one sentence why no observer exists, empty if one does.
    """

    rank_CE: int
    rank_E: int
    H: np.ndarray | None
    T: np.ndarray | None
    A1: np.ndarray | None
    zeros: Poles | None
    unstable: Poles
    reason: Phrase

    @property
    def exists(self) -> bool:
        """Whether there is an observer of the whole state whose error d does not disturb."""
        return not self.reason


@record()
class UnknownInputObserver:
    """ż = F z + T B u + K (y − D u), x̂ = z + H (y − D u) with e = x − x̂, ė = F e whatever d does (x⁺, e⁺ if sampled).

    F, T n×n; K, H n×p; K = K1 + F H. poles: eig(F), sorted by (real, imag), of which `fixed` are the invariant zeros
    of (A, E, C) that no gain moves. `plant` has inputs (u, y) and output x̂.
    """

    F: np.ndarray
    T: np.ndarray
    K: np.ndarray
    H: np.ndarray
    K1: np.ndarray
    poles: Poles
    fixed: Poles
    conditions: Decoupling
    plant: Plant

    @gated(plant=PLANT, E=matrix("n d"))
    def residuals(self, plant: Plant, E: object) -> tuple[float, float, float]:
        """How far the three conditions are missed, relative to their terms: T + H C = I, T E = 0, T A = F T + K C.

        They are what ε = T x − z, ε̇ = F ε + (T A − F T − K C) x + T E d asks for.
        """
        E = _unknown(plant, E)
        x = balance(plant.A, E, plant.C).states
        terms = ((self.T, self.H @ plant.C, -np.eye(plant.n)), (E, -self.H @ plant.C @ E),
                 (self.T @ plant.A, -self.F @ self.T, -self.K @ plant.C))
        terms = tuple(tuple(t / x[:, None] * (1.0 if i == 1 else x) for t in group) for i, group in enumerate(terms))
        first, second, third = (float(np.linalg.norm(sum(t)) / max(max(np.linalg.norm(x) for x in t), 1e-300))
                                for t in terms)
        return first, second, third


@takes(plant=PLANT, E=matrix("n d"), weight=optional(matrix("p p")))
def decoupling(plant: Plant, E: object, *, weight: object | None = None) -> Decoupling:
    """The two conditions for ignoring an unknown input that enters through E (n×q).

    They are rank(C E) = rank(E), and no invariant zero of (A, E, C), s with rank [sI − A, −E; C, 0] < n + rank(E), in
    the closed right half plane (on or outside the unit circle for a sampled plant). H = E ((C E)ᵀ V⁻¹ C E)⁻¹ (C E)ᵀ V⁻¹
    with V = `weight` (p×p > 0; default I, of balanced outputs where the units given are far apart): with the
    covariance of the sensor noise, what is left of y after H tells
    nothing about the noise that H lets in. Raises ShapeError, EngineError. Chen and Patton (1999), theorem 3.1.
    """
    E, V = _unknown(plant, E), np.eye(plant.p) if weight is None else as_checked(weight)
    if np.abs(V - V.T).max() > RANK_RTOL * np.abs(V).max() or not is_definite(symmetric(V)):
        raise EngineError("The weight must be symmetric and positive definite, as the covariance of noise on "
                          "every sensor is.")
    own = balance(plant.A, E, plant.C)
    A, C, E = own.A(plant.A), own.C(plant.C), _range(own.B(E))
    q = E.shape[1]
    size = np.linalg.norm(C, axis=1, keepdims=True)
    rank = int(np.count_nonzero(np.linalg.svd(C / np.where(size > 0, size, 1.0) @ E, compute_uv=False) > RANK_RTOL))
    if rank < q:
        return Decoupling(rank, q, None, None, None, None, np.empty(0, dtype=complex),
                          phrase("rank(CE) = {rank} is less than rank(E) = {q}: the unknown input does not act directly on dy/dt. "
                                 "Measure nearer to where it enters.", rank=rank, q=q))
    CE = C @ E
    V = symmetric(V) / own.outputs / own.outputs[:, None]
    if weight is None and own.outputs.max() > UNLIKE * own.outputs.min():
        V = np.eye(plant.p)  # no output is surer than another: in like units
    weighted = solve_scaled(V, CE).T
    H = E @ np.linalg.solve(weighted @ CE, weighted)
    T = np.eye(plant.n) - H @ C
    zeros = invariant_zeros(A, E, C)
    bad = _unstable(zeros, A, plant.dt)
    H, T = H * own.states[:, None] / own.outputs, T * own.states[:, None] / own.states
    A1 = T @ plant.A
    reason = NO_REASON if not len(bad) else phrase(
        "(A, E, C) has an invariant zero at {zero}, which is not stable. The unknown input can move the state without any effect on "
        "the outputs; add a sensor.", zero=pole_text(bad[-1]))
    return Decoupling(rank, q, frozen(H), frozen(T), frozen(A1), zeros, bad, reason)


@takes(plant=PLANT, E=matrix("n d"), poles=POLES)
def unknown_input_observer(plant: Plant, E: object, poles: Iterable[complex]) -> UnknownInputObserver:
    """The observer whose error an unknown input through E (n×q) does not disturb, with eig(F) = poles and fixed ones.

    F = A − H C A − K1 C, T = I − H C, K = K1 + F H; `poles` are those that can be chosen: n less the number of
    invariant zeros of (A, E, C), which stay. Raises EngineError where a condition of `decoupling` fails, PoleError for
    another number of poles. Chen and Patton (1999), section 3.2.

    >>> plant = Plant(np.diag([-1, -2]), np.ones((2, 1)), np.eye(2))
    >>> unknown_input_observer(plant, [[1], [0]], [-3, -4]).T @ [[1], [0]]
    array([[0.],
           [0.]])
    """
    known = decoupling(plant, E)
    if not known.exists or known.H is None or known.T is None or known.A1 is None or known.zeros is None:
        raise EngineError(known.reason)
    wanted, free = list(poles), plant.n - len(known.zeros)
    if len(wanted) != free:
        raise PoleError("Give {free} poles: this observer has {n}, and {count} stay at the invariant zeros of (A, "
                        "E, C); you gave {count2}.",
                        free=free, n=plant.n, count=len(known.zeros), count2=len(wanted))
    own = balance(plant.A, _unknown(plant, E), plant.C)
    A1, C = own.A(without_dust(known.A1, own.states)), own.C(plant.C)
    rows = _range(C)
    K1 = observer_gain(A1, rows.T @ C, [*wanted, *known.zeros]).gain @ rows.T
    K1 = K1 * own.states[:, None] / own.outputs
    F = known.A1 - K1 @ plant.C
    K = K1 + F @ known.H
    D = np.asarray(plant.D)
    system = Plant(F, np.hstack([known.T @ plant.B - K @ D, K]), np.eye(plant.n), np.hstack([-known.H @ D, known.H]),
                   plant.dt, plant.state_names, (*plant.input_names, *plant.output_names))
    return UnknownInputObserver(frozen(F), known.T, frozen(K), known.H, frozen(K1),
                                sorted_poles(F), known.zeros, known, system)


def _unknown(plant: Plant, E: object) -> np.ndarray:
    E = as_matrix(E, "E")
    if E.shape[0] != plant.n:
        raise ShapeError("E must have {n} rows, one for each state; it has {rows}.", n=plant.n, rows=E.shape[0])
    if not np.any(E):
        raise EngineError("E is zero: there is no unknown input to ignore.")
    return E


def _range(M: np.ndarray) -> np.ndarray:
    """Orthonormal columns that span the range of M."""
    size = np.linalg.norm(M, axis=0)
    U, s, _ = np.linalg.svd(M / np.where(size > 0, size, 1.0), full_matrices=False)
    return U[:, s > RANK_RTOL]


def _unstable(zeros: Poles, A: np.ndarray, dt: float) -> Poles:
    if dt:
        return zeros[np.abs(zeros) >= 1 - RANK_RTOL]
    return zeros[zeros.real >= -RANK_RTOL * float(np.linalg.norm(A, 2))]
