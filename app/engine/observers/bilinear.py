"""Functional observer of a bilinear plant: ẋ = A x + B u + u F x, y = C x, wanted g = K x.

All equation numbers: "Synthesis of functional observers for bilinear plants", Avtometriya 53, 2017, no. 4.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from ..design.placement import place
from ..structure.canonise import Canonisation, canonise, canonise_right
from ..structure.decomposition import reachable_subspace
from ..systems.errors import EngineError, PoleError, ShapeError
from ..systems.plant import as_matrix
from ..systems.pole_sets import Poles, check_poles, sorted_poles

__all__ = ["BilinearForm", "BilinearObserver", "BilinearPlant", "bilinear_functional_observer"]

Three = tuple[np.ndarray, np.ndarray, np.ndarray]
MET = 1e-9  # a solvability condition counts as met below this, relative to its terms


@dataclass(frozen=True, eq=False)
class BilinearPlant:
    """ẋ = A x + B u + u F x, y = C x with one input u (1).

    A, F n×n, B n×1, C m×n with independent rows and m < n. Raises ShapeError where shapes disagree, EngineError
    where rows of C depend on each other or every state is measured.

    >>> BilinearPlant(np.diag([-1, -2]), [[1], [1]], np.eye(2), [[1, 0]]).C
    array([[1., 0.]])
    """

    A: np.ndarray
    B: np.ndarray
    F: np.ndarray
    C: np.ndarray

    def __post_init__(self) -> None:
        A, F, C = (as_matrix(getattr(self, k), k) for k in "AFC")
        B = as_matrix(self.B, "B")
        n = A.shape[0]
        B = as_matrix(B.T, "B") if B.shape == (1, n) else B
        for name, matrix, shape in (("A", A, (n, n)), ("F", F, (n, n)), ("B", B, (n, 1)), ("C", C, (C.shape[0], n))):
            if matrix.shape != shape:
                raise ShapeError("{name} must be {shape}×{shape2}; it is {rows}×{columns}.",
                                 name=name, shape=shape[0], shape2=shape[1], rows=matrix.shape[0],
                                 columns=matrix.shape[1])
        if C.shape[0] >= n:
            raise EngineError("C measures {rows} values of {n} states, so nothing is left to observe; measure "
                              "fewer.",
                              rows=C.shape[0], n=n)
        if canonise(C).rank < C.shape[0]:
            raise EngineError("Rows of C depend on each other; leave out the outputs that repeat others.")
        for key, value in (("A", A), ("B", B), ("F", F), ("C", C)):
            object.__setattr__(self, key, value)

    @property
    def n(self) -> int:
        """Number of states."""
        return self.A.shape[0]

    @property
    def m(self) -> int:
        """Number of outputs."""
        return self.C.shape[0]


def _freeze(record: object) -> None:
    for value in vars(record).values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)


@dataclass(frozen=True, eq=False)
class BilinearForm:
    """An observer that can be run: ż = A z + Y y + B u + u U y + R ẏ, ĝ = G_y y + G_z z.

    A q×q, Y, U and R q×m, B q×1, G_y r×m, G_z r×q. R = 0 in the form that needs no ẏ.
    """

    A: np.ndarray
    Y: np.ndarray
    B: np.ndarray
    U: np.ndarray
    R: np.ndarray
    G_y: np.ndarray
    G_z: np.ndarray

    def __post_init__(self) -> None:
        _freeze(self)


@dataclass(frozen=True, eq=False)
class BilinearObserver:
    """Every matrix of the eight steps, and what came of them.

    Step 1 (4)–(9): canonisation of C and of K₁ = K C̄ᴿ, x = T₁ y + T₂ μ + T₃ η, (y, μ, η) = (V₁, V₂, V₃) x.
    Step 2: Q = V₁ [F T₂, A T₃, F T₃] (m×(2n−2m−q)) and its canonisation; `right` = V₂ [F T₂, A T₃, F T₃].
    Step 3 (21): `defect` = right Q̄ᴿ must vanish; `defect_size` is its 2-norm relative to that of `right`.
    Step 4: `case` 1: (21) fails, there is no observer; 2: one L only; 3: a family of L.
    Step 5 (24): A_star (q×q), B_star (q×k); `controllable` says whether any poles can be had (None unless case 3).
    Steps 6, 7 (22): π (q×k) and L (q×m); None where there is none.
    Step 8: `with_derivative` (17), (13) runs μ̂; `without_derivative` (18), (19) runs χ = μ̂ − L y.
    ε = ĝ − g = K₁ K̃ᴿ w, ẇ = A_L w whatever u is. `reached` = eig A_L. `solved`: L exists, with the poles asked for
    (case 2: with its own), and they are stable; `reason` says in a sentence why, or why not. `advised`: 3m + r ≥ 2n,
    where (21) is to be expected.
    """

    plant: BilinearPlant
    K: np.ndarray
    asked: Poles
    canonical_C: Canonisation
    K1: np.ndarray
    canonical_K1: Canonisation
    T: Three
    V: Three
    Q: np.ndarray
    canonical_Q: Canonisation
    right: np.ndarray
    defect: np.ndarray
    defect_size: float
    case: int
    A_star: np.ndarray
    B_star: np.ndarray
    controllable: bool | None
    pi: np.ndarray | None
    L: np.ndarray | None
    A_L: np.ndarray | None
    reached: Poles
    with_derivative: BilinearForm | None
    without_derivative: BilinearForm | None
    solved: bool
    reason: str
    advised: bool

    def __post_init__(self) -> None:
        _freeze(self)

    @property
    def order(self) -> int:
        """q: number of states of the observer, the rank of K₁."""
        return self.canonical_K1.rank

    @property
    def readout(self) -> np.ndarray:
        """K₁ K̃ᴿ (r×q): ε = K₁ K̃ᴿ w."""
        return self.K1 @ self.canonical_K1.unit_right

    def forms(self, L: np.ndarray) -> tuple[BilinearForm, BilinearForm]:
        """(17) with (13), and (18) with (19), for any L (q×m): also for one that misses the conditions (15), (16).

        Raises ShapeError for an L of another shape.
        """
        gain, shape = as_matrix(L, "L"), (self.order, self.plant.m)
        if gain.shape != shape:
            raise ShapeError("L must be {shape}×{shape2}; it is {rows}×{columns}.",
                             shape=shape[0], shape2=shape[1], rows=gain.shape[0], columns=gain.shape[1])
        return _forms(self.plant, self.K, self.canonical_C.summary, self.readout, self.T, self.V, gain)

    def residuals(self) -> tuple[float, float, float]:
        """Largest entries of (V₂ − L V₁) F T₂, A T₃, F T₃ (conditions (15), (16)); NaN without an L."""
        if self.L is None:
            return (np.nan, np.nan, np.nan)
        P, (_, T2, T3) = self.V[1] - self.L @ self.V[0], self.T
        A, F = self.plant.A, self.plant.F
        sizes = [float(np.max(np.abs(P @ M), initial=0.0)) for M in (F @ T2, A @ T3, F @ T3)]
        return sizes[0], sizes[1], sizes[2]


@dataclass(frozen=True, eq=False)
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
    if np.max(np.abs(K1)) <= MET * np.max(np.abs(K)):
        raise EngineError("K x can be read from y directly, so there is nothing to observe; choose another K.")
    c1 = canonise_right(K1)
    return _Coordinates(c, K1, c1, (c.summary, c.zero_right @ c1.unit_right, c.zero_right @ c1.zero_right))


def bilinear_functional_observer(
    A: object, B: object, F: object, C: object, K: object, pole: complex | Iterable[complex]
) -> BilinearObserver:
    """Observer of g = K x for ẋ = A x + B u + u F x, y = C x, whose error decays by ẇ = A_L w under every u(t).

    A, F n×n, B n×1, C m×n, K r×n. `pole`: one real pole, used for every state of the observer, or as many poles as
    K C̄ᴿ has rank. The record tells all eight steps also where no observer exists. Raises ShapeError for shapes that
    disagree, EngineError where C or K leave nothing to do, PoleError for a request that no real gain can meet.
    Source: Avtometriya 53 (2017) no. 4, equations (4)–(24); sign of the error ε = ĝ − g as there.

    >>> A, F = [[-1, 1], [0, -2]], [[0.1, 0], [0, 0]]
    >>> bilinear_functional_observer(A, [[0], [1]], F, [[1, 0]], [[0, 1]], -5).solved
    True
    """
    plant = BilinearPlant(*(as_matrix(M, k) for M, k in ((A, "A"), (B, "B"), (F, "F"), (C, "C"))))
    wanted = as_matrix(K, "K")
    if wanted.shape[1] != plant.n:
        raise ShapeError("K must have {n} columns, one for each state; it has {columns}.",
                         n=plant.n, columns=wanted.shape[1])
    if not np.any(wanted):
        raise EngineError("K is zero, so g = K x is known without an observer; choose another K.")
    at = _coordinates(plant, wanted)
    q = at.c1.rank
    asked = check_poles(pole if isinstance(pole, Iterable) else [complex(pole)] * q, q)
    V1, V2, _ = at.V
    block = np.hstack([plant.F @ at.T[1], plant.A @ at.T[2], plant.F @ at.T[2]])
    Q, right = V1 @ block, V2 @ block
    cQ = canonise(Q)
    defect = right @ cQ.zero_right
    size = _relative(defect, right, cQ.zero_right)
    case = 1 if size > MET else 2 if cQ.rank == plant.m else 3
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
    forms = (None, None) if L is None else _forms(plant, wanted, at.C.summary, at.K1 @ at.c1.unit_right, at.T, at.V, L)
    return BilinearObserver(plant, wanted, asked, at.C, at.K1, at.c1, at.T, at.V, Q, cQ, right, defect, size, case,
                            A_star, B_star, controllable, pi, L, A_L, reached, *forms, solved and stable, reason,
                            3 * plant.m + wanted.shape[0] >= 2 * plant.n)


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


def _forms(plant: BilinearPlant, K: np.ndarray, summary: np.ndarray, readout: np.ndarray, T: Three, V: Three,
           L: np.ndarray) -> tuple[BilinearForm, BilinearForm]:
    """Step 8: (17) with (13), and (18) with (19)."""
    (T1, T2, _), P = T, V[1] - L @ V[0]
    A_L, direct = P @ plant.A @ T2, K @ summary
    PB, U = P @ plant.B, P @ plant.F @ T1
    return (BilinearForm(A_L, P @ plant.A @ T1, PB, U, L, direct, readout),
            BilinearForm(A_L, P @ plant.A @ (T1 + T2 @ L), PB, U, np.zeros_like(L), direct + readout @ L, readout))
