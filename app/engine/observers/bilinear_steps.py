"""Design a functional observer of a bilinear plant in eight steps, in scaled units.

All equation numbers: "Synthesis of functional observers for bilinear plants", Avtometriya 53, 2017, no. 4.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import field, replace

import numpy as np
from numpy.typing import ArrayLike

from ..design.placement import place
from ..structure.canonise import Canonisation, canonise, canonise_right, singular_values
from ..structure.decomposition import reachable_subspace
from ..systems.arrays import as_checked, frozen
from ..systems.balance import natural_scale
from ..systems.errors import EngineError, PoleError, ShapeError
from ..systems.gates.argument_checks import POLES, matrix, takes
from ..systems.plant import as_matrix
from ..systems.pole_sets import Poles, check_poles, sorted_poles
from ..systems.records import record
from .bilinear import BilinearObserver, BilinearPlant, Three, forms_of

__all__ = ["bilinear_functional_observer"]

CONDITION_RTOL = 1e-9  # a solvability condition counts as met below this, relative to its terms


@record()
class _Units:
    """Powers of two: states (n,), outputs (m,), rows of K (r,), the rate of A and the inputs (k,) that make uⱼ Fⱼ as fast."""

    states: np.ndarray
    outputs: np.ndarray
    wanted: np.ndarray
    rate: float
    input: np.ndarray

    def plant(self, p: BilinearPlant) -> BilinearPlant:
        """The plant in these units: nothing is rounded."""
        D, rate = self.states, self.rate
        return BilinearPlant(p.A * D / D[:, None] / rate, p.B * self.input / D[:, None] / rate,
                             np.hstack([F * D / D[:, None] * u / rate for F, u in zip(p.parts, self.input, strict=True)]),
                             p.C * D / self.outputs[:, None])

    def told(self, o: BilinearObserver, plant: BilinearPlant, K: np.ndarray, asked: Poles) -> BilinearObserver:
        """All eight steps of an observer found in these units, as the same eliminations give them for the plant as it is."""
        D, E, rate = self.states, self.outputs, self.rate
        of_C = _rescaled(o.canonical_C, plant.C, E, 1 / D)
        z = D[_own(o.canonical_C.right.T)[plant.m:]]
        K1 = o.K1 * self.wanted[:, None] / z
        of_K1 = _rescaled(o.canonical_K1.flipped(), K1.T, 1 / z, self.wanted).flipped()
        mu = self.wanted[_own(o.canonical_K1.left)[:o.order]]
        eta = z[_own(o.canonical_K1.right.T)[o.order:]]
        T = (o.T[0] * D[:, None] / E, o.T[1] * D[:, None] / mu, o.T[2] * D[:, None] / eta)
        V = (o.V[0] * E[:, None] / D, o.V[1] * mu[:, None] / D, o.V[2] * eta[:, None] / D)
        columns = rate * np.concatenate([*(1 / mu / u for u in self.input), 1 / eta, *(1 / eta / u for u in self.input)])
        Q, L = o.Q * E[:, None] * columns, None if o.L is None else o.L * mu[:, None] / E
        free = E[_own(o.canonical_Q.left)[o.canonical_Q.rank:]]
        forms = (None, None) if L is None else forms_of(plant, K, T[0], K1 @ of_K1.unit_right, T, V, L)
        of_Q = _rescaled(o.canonical_Q, Q, E, columns)
        right = o.right * mu[:, None] * columns
        return replace(
            o, plant=plant, K=K, asked=asked, canonical_C=of_C, K1=K1, canonical_K1=of_K1, T=T, V=V, Q=Q, canonical_Q=of_Q, right=right,
            defect=right @ of_Q.zero_right, A_star=rate * o.A_star * mu / mu[:, None], B_star=rate * o.B_star * free / mu[:, None],
            pi=None if o.pi is None else o.pi * mu[:, None] / free, L=L, A_L=None if o.A_L is None else rate * o.A_L * mu[:, None] / mu,
            reached=rate * o.reached, with_derivative=forms[0], without_derivative=forms[1])


def _own(left: np.ndarray) -> np.ndarray:
    """For each row of what elimination did on the left the row that it began as: the one that no row above has in it."""
    own: list[int] = []
    for row in left:
        own.append(next(int(k) for k in np.flatnonzero(row) if k not in own))
    return np.array(own, dtype=int)


def _rescaled(c: Canonisation, M: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> Canonisation:
    """The canonisation of M (p×q) from that of M / rows / columns, by the same pivots."""
    of_rows, of_columns = rows[_own(c.left)], columns[_own(c.right.T)]
    rho = c.rank
    right = c.right * of_columns / columns[:, None]
    return Canonisation(frozen(c.unit_left / of_columns[:rho, None] / rows), frozen(c.zero_left * of_rows[rho:, None] / rows),
                        frozen(right[:, :rho]), frozen(right[:, rho:]), frozen(singular_values(M)))


def _units(plant: BilinearPlant, K: np.ndarray) -> _Units:
    def two(size: ArrayLike) -> np.ndarray:
        sizes = np.asarray(size, dtype=float)
        return 2.0 ** np.round(np.log2(np.where(sizes > 0, sizes, 1.0)))
    D = two(natural_scale(plant.A, plant.B, plant.C))
    A, *F = (float(np.linalg.norm(M * D / D[:, None], 2)) for M in (plant.A, *plant.parts))
    rate = float(two(A if A > 0 else max(F)))
    return _Units(D, two(np.linalg.norm(plant.C * D, axis=1)), two(np.linalg.norm(K * D, axis=1)), rate,
                  two([rate / f if f > 0 else 1.0 for f in F]))


@record()
class _Coordinates:
    C: Canonisation
    K1: np.ndarray
    c1: Canonisation
    T: Three
    V: Three = field(init=False)

    def __post_init__(self) -> None:
        V, m, q = np.linalg.inv(np.hstack(self.T)), self.T[0].shape[1], self.T[1].shape[1]
        object.__setattr__(self, "V", (V[:m], V[m:m + q], V[m + q:]))


def _coordinates(plant: BilinearPlant, K: np.ndarray) -> _Coordinates:
    """Step 1: x = T₁ y + T₂ μ + T₃ η, (4)–(9)."""
    c = canonise(plant.C)
    K1 = K @ c.zero_right
    if np.max(np.abs(K1)) <= CONDITION_RTOL * np.max(np.abs(K)):
        raise EngineError("K x can be read from y directly, so there is nothing to observe; choose another K.")
    c1 = canonise_right(K1)
    return _Coordinates(c, K1, c1, (c.summary, c.zero_right @ c1.unit_right, c.zero_right @ c1.zero_right))


@takes(A=matrix(), B=matrix(), F=matrix(), C=matrix(), K=matrix(), pole=POLES)
def bilinear_functional_observer(
    A: object, B: object, F: object, C: object, K: object, pole: complex | Iterable[complex]
) -> BilinearObserver:
    """Observer of g = K x for ẋ = A x + B u + u F x, y = C x, whose error decays by ẇ = A_L w under every u(t).

    A, F n×n, B n×1, C m×n, K r×n; of k inputs B n×k and F = [F₁ … F_k] n×(k n) in Σ uⱼ Fⱼ x, and (15), (16) hold for each Fⱼ.
    `pole`: one real pole, used for every state of the observer, or as many poles as K C̄ᴿ has rank.
    The record tells all eight steps also where no observer exists. Raises ShapeError for shapes that
    disagree, EngineError where C or K leave nothing to do, PoleError for a request that no real gain can meet.
    Source: Avtometriya 53 (2017) no. 4, equations (4)–(24); sign of the error ε = ĝ − g as there.

    >>> A, F = [[-1, 1], [0, -2]], [[0.1, 0], [0, 0]]
    >>> bilinear_functional_observer(A, [[0], [1]], F, [[1, 0]], [[0, 1]], -5).solved
    True
    """
    plant = BilinearPlant(*(as_matrix(M, k) for M, k in ((A, "A"), (B, "B"), (F, "F"), (C, "C"))))
    wanted = as_checked(K)
    if wanted.shape[1] != plant.n:
        raise ShapeError("K must have {n} columns, one for each state; it has {columns}.",
                         n=plant.n, columns=wanted.shape[1])
    if not np.any(wanted):
        raise EngineError("K is zero, so g = K x is known without an observer; choose another K.")
    units = _units(plant, wanted)
    inner = _coordinates(units.plant(plant), wanted * units.states / units.wanted[:, None])
    q = inner.c1.rank
    given = np.ravel(np.array(list(pole) if isinstance(pole, Iterable) else [pole], dtype=complex))
    asked = check_poles(list(given) * q if given.size == 1 else given, q)
    found = _steps(inner, units.plant(plant), wanted * units.states / units.wanted[:, None], asked / units.rate)
    return units.told(found, plant, wanted, asked)


def _steps(at: _Coordinates, plant: BilinearPlant, wanted: np.ndarray, asked: Poles) -> BilinearObserver:
    """Steps 2 to 8 from the coordinates of step 1."""
    q = at.c1.rank
    V1, V2, _ = at.V
    block = np.hstack([*(F @ at.T[1] for F in plant.parts), plant.A @ at.T[2], *(F @ at.T[2] for F in plant.parts)])
    Q, right = V1 @ block, V2 @ block
    cQ = canonise(Q)
    defect = right @ cQ.zero_right
    size = _relative(defect, right, cQ.zero_right)
    case = 1 if size > CONDITION_RTOL else 2 if cQ.rank == plant.m else 3
    base = right @ cQ.summary
    A_star = (V2 @ plant.A @ at.T[1] - base @ V1 @ plant.A @ at.T[1]).T
    B_star = (cQ.zero_left @ V1 @ plant.A @ at.T[1]).T
    controllable = bool(reachable_subspace(A_star, B_star)[1] == q) if case == 3 else None
    pi, reason = _choose(A_star, B_star, asked, case, controllable)
    L = None if case == 1 else base if pi is None else base + pi @ cQ.zero_left
    solved = case == 2 or pi is not None
    A_L = None if L is None else (V2 - L @ V1) @ plant.A @ at.T[1]
    reached = np.zeros(0, dtype=complex) if A_L is None else sorted_poles(A_L)
    stable = bool(np.all(np.real(reached) < 0))
    if case == 2:
        reason = "One L only; " + ("its poles are stable." if stable else "its poles are not stable: no observer.")
    elif solved and not stable:
        reason = "A family of L, but with poles that are not stable the error does not decay."
    forms = (None, None) if L is None else forms_of(plant, wanted, at.C.summary, at.K1 @ at.c1.unit_right, at.T, at.V, L)
    return BilinearObserver(plant, wanted, asked, at.C, at.K1, at.c1, at.T, at.V, Q, cQ, right, defect, size, case,
                            A_star, B_star, controllable, pi, L, A_L, reached, *forms, solved and stable, reason,
                            (plant.inputs + 2) * plant.m + q >= (plant.inputs + 1) * plant.n)


def _relative(defect: np.ndarray, first: np.ndarray, second: np.ndarray) -> float:
    """‖first second‖ relative to ‖first‖‖second‖."""
    if not defect.size:
        return 0.0
    whole = float(np.linalg.norm(first, 2) * np.linalg.norm(second, 2))
    return float(np.linalg.norm(defect, 2)) / whole if whole else 0.0


def _choose(A_star: np.ndarray, B_star: np.ndarray, asked: Poles, case: int,
            controllable: bool | None) -> tuple[np.ndarray | None, str]:
    """Steps 5 and 6: π with eig(A* − B* πᵀ) as asked, or None and why."""
    if case == 1:
        return None, "Condition (21) fails: no L frees the error from u and from the states left aside."
    if case == 2:
        return None, ""
    try:
        pi = place(A_star, B_star, asked).gain.T
    except PoleError as problem:
        return None, f"A family of L, but it cannot reach these poles: {problem}"
    return pi, "A family of L: the poles can be chosen." if controllable else "A family of L: some poles stay put."
