"""Design functional observers in parametric form: estimate K x with fewer states.

ż = F z + L (y − D u) + T B u, estimate of K x: N z + M (y − D u); the control law is u = −(estimate) + v.
The source writes u = +K x: give −K for its K and N, M come out with the other sign; F, T, L do not change.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..structure.coprime import CoprimeFactors, coprime_factors
from ..systems.arrays import as_checked, frozen
from ..systems.balance import MIN_RATE, UNLIKE, Balance, balance
from ..systems.errors import EngineError, PoleError, ShapeError
from ..systems.gates.argument_checks import INTEGER, POLES, array, choice, instance, matrix, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant, as_matrix
from ..systems.pole_sets import Poles, check_poles, pole_text
from ..systems.records import record
from ..systems.stability import all_stable
from .directions import choose_directions, normalised, row_condition, seen_rows, upper_half_poles
from .perturbation import Norm, Perturbations, check_norm, criterion, every_entry

__all__ = ["FunctionalObserver", "functional_observer"]

CONDITION_RTOL = 1e-9  # the output condition counts as met below this, relative
SUM_ROUNDING = 1e-14  # what is lost in a sum, relative to its terms


@record()
class FunctionalObserver:
    """F (q×q), T (q×n), L (q×p), N (r×q), M (r×p) with T A − F T = L C and K = N T + M C, K r×n.

    ε = z − T x obeys ε̇ = F ε whatever u is, and the estimate of K x errs by N ε. `poles` (q,) are the asked
    eigenvalues of F, `directions` (q, p) the gᵢ belonging to them, W (q×q) the coordinates: F = W J W⁻¹ with J real
    block diagonal (a pole; [a −b; b a] for a pair a ± jb). `J` is the criterion for `wrong` in `norm`.
    """

    plant: Plant
    K: np.ndarray
    F: np.ndarray
    T: np.ndarray
    L: np.ndarray
    N: np.ndarray
    M: np.ndarray
    poles: Poles
    directions: np.ndarray
    W: np.ndarray
    J: float
    wrong: Perturbations
    norm: Norm

    @property
    def order(self) -> int:
        """q: number of states of the observer."""
        return self.F.shape[0]

    @property
    def TB(self) -> np.ndarray:
        """T B (q×m): how the input enters the observer (besides −L D)."""
        return self.T @ self.plant.B

    @property
    def dynamics_residual(self) -> float:
        """‖T A − F T − L C‖ / (‖T A‖ + ‖F T‖ + ‖L C‖), Frobenius norms."""
        TA, FT, LC = self.T @ self.plant.A, self.F @ self.T, self.L @ self.plant.C
        return _ratio(TA - FT - LC, TA, FT, LC)

    @property
    def output_residual(self) -> float:
        """‖K − N T − M C‖ / ‖K‖, Frobenius norms, each column in balanced states."""
        d = seen_rows(self.plant.A, self.plant.C)[1]
        return _ratio((self.K - self.N @ self.T - self.M @ self.plant.C) * d, self.K * d)

    @property
    def condition(self) -> float:
        """Condition number of [T; C] in balanced states: rows of T of unit length, an orthonormal basis for those of C.

        Large where N must be large; infinite where a row of T lies in the others or in C.
        """
        seen, d = seen_rows(self.plant.A, self.plant.C)
        return row_condition(self.T, seen, d) if len(seen) + self.order <= self.plant.n else np.inf


@takes(plant=PLANT, K=matrix(), order=INTEGER, poles=POLES, directions=array(imaginary=True), W=matrix(), free=matrix(),
       wrong=instance(Perturbations), norm=choice(1, 2, "inf"))
def functional_observer(
    plant: Plant, K: object, order: int, *, poles: Iterable[complex] | None = None, directions: Any = None,
    W: object = None, free: object = None, wrong: Perturbations | None = None, norm: Any = 2
) -> FunctionalObserver:
    """Observer of order q for K x (K r×n): tᵢ = H(sᵢ) gᵢ, lᵢ = −L(sᵢ) gᵢ, F = W J W⁻¹, T = W T′, L = W L′.

    `poles` sᵢ: q of them, closed under conjugation and stable (default: real, one to two times the plant's spectral
    radius; 0.1 … 0.3 for dt > 0). `directions` gᵢ: (q, p), conjugate for conjugate poles; left out, they are found so
    that K = N T + M C can be solved. W: q×q, regular (default I). `free` = M′ r×(q + p − rank [T; C]), in which N and M
    may still move where the rows of T and C depend on each other. `wrong`, `norm`: for J (default: every entry of A
    and C by itself, norm 2).
    Raises PoleError for poles that are wrong in number, unpaired or unstable; EngineError where the plant hides a mode
    or no such observer exists; ShapeError for shapes.
    Source: Duan, Li, Zhou (1993), (7)–(13), where u = +K x.

    >>> plant = Plant([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])
    >>> functional_observer(plant, [[1, 1]], 1, poles=[-5]).F
    array([[-5.]])
    """
    wanted = check_functional(plant, K)
    if not 1 <= int(order) <= plant.n:
        raise EngineError("The order of the observer must lie between 1 and {n}; it is {order}.",
                          n=plant.n, order=order)
    asked = check_poles(_default_poles(plant, int(order)) if poles is None else poles, int(order))
    check_stable(plant, asked)
    own = balance(plant.A, None, plant.C)
    if directions is None and W is None and free is None and unlike_units(plant, own):
        return _in_like_units(plant, wanted, own, asked, every_entry(plant) if wrong is None else wrong, check_norm(norm))
    factors = coprime_factors(plant)
    heads = upper_half_poles(asked)
    g = (choose_directions(factors, plant, wanted, heads) if directions is None
         else _given_directions(directions, asked, plant.p))
    observer = assemble(plant, wanted, factors, asked, g, W, None if free is None else as_checked(free),
                        every_entry(plant) if wrong is None else wrong, check_norm(norm))
    if not exists(observer):
        raise EngineError("With these poles no observer of order {order} gives K x (K is missed by "
                          "{output_residual:.2g}); raise the order or move the poles.",
                          order=order, output_residual=observer.output_residual)
    return observer


def _in_like_units(plant: Plant, K: np.ndarray, own: Balance, poles: Poles, wrong: Perturbations,
                   norm: Norm) -> FunctionalObserver:
    """The observer found in balanced states and outputs, told in those of the plant; J is of the plant's own units."""
    x, y = own.states, own.outputs
    like, wanted, unit, rate = like_units(plant, K, own)
    found = functional_observer(like, wanted, len(poles), poles=poles / rate)
    T, L, M, N = found.T / x, rate * found.L / y, found.M / y * unit, found.N * unit
    return FunctionalObserver(plant, K, rate * found.F, T, L, N, M, rate * found.poles,
                              np.array([normalised(g / y) for g in found.directions]), found.W,
                              criterion(T, L, M, wrong, norm=norm), wrong, norm)


def unlike_units(plant: Plant, own: Balance) -> bool:
    """Whether states, or the rate and the unit of time, are so far apart that powers of s lose digits."""
    return own.states.max() > UNLIKE * own.states.min() or not 1 / UNLIKE < (1.0 if plant.dt else own.rate) < UNLIKE


def like_units(plant: Plant, K: np.ndarray, own: Balance) -> tuple[Plant, np.ndarray, np.ndarray, float]:
    """Plant and K (r×n) in balanced states, outputs and time; K's units (r, 1); the unit of time in 1/s."""
    x, y = own.states, own.outputs
    rate = 1.0 if plant.dt else 2.0 ** np.round(np.log2(own.rate))
    like = Plant(own.A(plant.A) / rate, plant.B / x[:, None] / rate, own.C(plant.C), np.asarray(plant.D) / y[:, None], plant.dt)
    unit = 2.0 ** np.round(np.log2(np.abs(K * x).max(axis=1, keepdims=True) + MIN_RATE))
    return like, K * x / unit, unit, float(rate)


def exists(observer: FunctionalObserver) -> bool:
    """K = N T + M C holds to 1e-9 of K, or as well as numbers of the size of N T and M C can tell."""
    o, d = observer, seen_rows(observer.plant.A, observer.plant.C)[1]
    terms = np.linalg.norm(np.abs(o.N) @ np.abs(o.T * d)) + np.linalg.norm(np.abs(o.M) @ np.abs(o.plant.C * d))
    return bool(o.output_residual <= max(CONDITION_RTOL, SUM_ROUNDING * terms / np.linalg.norm(o.K * d)))


def check_functional(plant: Plant, K: object) -> np.ndarray:
    """K as a matrix r×n; ShapeError or EngineError where it cannot be."""
    wanted = as_matrix(K, "K")
    if wanted.shape[1] != plant.n:
        raise ShapeError("K must have {n} columns, one for each state; it has {columns}.",
                         n=plant.n, columns=wanted.shape[1])
    if not np.any(wanted):
        raise EngineError("K is zero, so K x is known without an observer; choose another K.")
    return wanted


def check_stable(plant: Plant, poles: Poles) -> None:
    """PoleError unless every pole is stable: Re s < 0, or |s| < 1 for dt > 0 (condition (2a))."""
    for pole in poles:
        if not all_stable(np.array([pole]), dt=plant.dt):
            raise PoleError("The observer pole {pole} is not stable, so its error would not decay; choose a "
                            "stable one.",
                            pole=pole_text(pole))


def assemble(plant: Plant, K: np.ndarray, factors: CoprimeFactors, poles: Poles, g: np.ndarray, W: object,
             free: np.ndarray | None, wrong: Perturbations, norm: Norm,
             start: tuple[np.ndarray, np.ndarray] | None = None) -> FunctionalObserver:
    """The observer for given poles (q,) and directions of the poles with Im ≥ 0 (heads, p).

    N, M by least squares, as near as can be to `start` (N for W = I; default zero), plus what `free` adds.
    """
    heads = upper_half_poles(poles)
    J, T, L = real_rows(plant, factors, heads, g)
    q = poles.size
    turn = np.eye(q) if W is None else as_matrix(W, "W")
    if turn.shape != (q, q):
        raise ShapeError("W must be {q}×{q}; it is {rows}×{columns}.",
                         q=q, rows=turn.shape[0], columns=turn.shape[1])
    if np.linalg.cond(turn) > 1e12:
        raise EngineError("W is singular, so it gives no coordinates; change a row of it.")
    N, M = _outputs(K, T, plant.C, free, start)
    back = np.linalg.inv(turn)
    T, L = turn @ T, turn @ L
    whole = [[s] if s.imag == 0 else [s, s.conjugate()] for s in heads]
    every = [row[None] if s.imag == 0 else np.array([row, row.conj()]) for s, row in zip(heads, g, strict=True)]
    return FunctionalObserver(plant, frozen(K), frozen(turn @ J @ back), frozen(T), frozen(L), frozen(N @ back), frozen(M),
                              np.concatenate(whole), np.vstack(every), turn, criterion(T, L, M, wrong, norm=norm), wrong, norm)


def real_rows(plant: Plant, factors: CoprimeFactors, heads: Poles, g: np.ndarray) -> tuple[np.ndarray, ...]:
    """J (q×q), T′ (q×n), L′ (q×p), real: tᵢ, lᵢ of a real pole, Re and Im of those of a pair, residual at rounding.

    (t, l) = (H(s) g, −L(s) g) solves tᵀA − s tᵀ − lᵀC = 0.
    """
    J, T, L = [], [], []
    for s, direction in zip(heads, g, strict=True):
        value = s if s.imag else s.real
        direction = direction if s.imag else direction.real
        H, L_s = factors.exact_at(plant.A, plant.C, value)
        t, l = H @ direction, -L_s @ direction
        J.append(np.array([[s.real, -s.imag], [s.imag, s.real]]) if s.imag else np.array([[s.real]]))
        T += [t.real, t.imag] if s.imag else [t]
        L += [l.real, l.imag] if s.imag else [l]
    q = len(T)
    block, k = np.zeros((q, q)), 0
    for part in J:
        block[k:k + len(part), k:k + len(part)] = part
        k += len(part)
    return block, np.array(T), np.array(L)


def _outputs(K: np.ndarray, T: np.ndarray, C: np.ndarray, free: np.ndarray | None,
             start: tuple[np.ndarray, np.ndarray] | None) -> tuple[np.ndarray, np.ndarray]:
    """N, M of K = N T + M C (13): the solution nearest to `start`, one step of refinement, plus `free` Z."""
    rows, length = _unit_rows(np.vstack([T, C]))
    q = len(T)
    U, s, Vt = np.linalg.svd(rows, full_matrices=True)
    rank = int(np.count_nonzero(s > 1e-13 * s[0]))
    inverse = (Vt[:rank].T / s[:rank]) @ U[:, :rank].T
    both = np.zeros((len(K), len(rows))) if start is None else np.hstack(start) * length
    for _ in range(2):
        both = both + (K - both @ rows) @ inverse
    if free is not None:
        room = len(rows) - rank
        if free.shape != (len(K), room):
            raise ShapeError("free must be {count}×{room} here; it is {rows}×{columns}.",
                             count=len(K), room=room, rows=free.shape[0], columns=free.shape[1])
        both = both + free @ U[:, rank:].T
    both = both / length
    return both[:, :q], both[:, q:]


def _unit_rows(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    length = np.linalg.norm(rows, axis=1)
    length = np.where(length > 0, length, 1.0)
    return rows / length[:, None], length


def _given_directions(directions: Any, poles: Poles, p: int) -> np.ndarray:
    try:
        g = np.array(directions, dtype=complex).reshape(poles.size, -1)
    except (TypeError, ValueError) as problem:
        raise ShapeError("There must be {poles_size} directions, one for each pole.", poles_size=poles.size) from problem
    if g.shape[1] != p or not np.isfinite(g).all():
        raise ShapeError("Every direction must hold {p} finite numbers, one for each output.", p=p)
    heads, spare = upper_half_poles(poles), list(range(poles.size))
    chosen = []
    for s in heads:
        here = next(i for i in spare if poles[i] == s)
        spare.remove(here)
        chosen.append(g[here])
        twin = next((i for i in spare if s.imag and poles[i] == s.conjugate()), None)
        if twin is not None:
            spare.remove(twin)
        mirrored = g[here] if twin is None else g[twin]
        if np.max(np.abs(mirrored - g[here].conj())) > CONDITION_RTOL * np.max(np.abs(g[here])):
            raise EngineError("Directions must be real for real poles and conjugate for conjugate poles.")
        if not np.any(g[here]):
            raise EngineError("A direction is zero, so its pole would not belong to the observer; give one that "
                              "is not zero.")
    return np.array(chosen)


def _default_poles(plant: Plant, order: int) -> np.ndarray:
    if plant.dt:
        return np.linspace(0.1, 0.3, order) if order > 1 else np.array([0.2])
    speed = float(np.max(np.abs(plant.poles))) or 1.0
    return -speed * np.linspace(1.0, 2.0, order) if order > 1 else np.array([-1.5 * speed])


def _ratio(gap: np.ndarray, *parts: np.ndarray) -> float:
    size = sum(float(np.linalg.norm(part)) for part in parts)
    return float(np.linalg.norm(gap)) / size if size else 0.0
