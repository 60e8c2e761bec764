"""Define functional observers of bilinear plants: ẋ = A x + B u + u F x, y = C x, g = K x.

Of k inputs each multiplies the state by a matrix of its own: Σ uⱼ Fⱼ x with F = [F₁ … F_k], n×(k n). The source has one input; its
conditions hold input by input.

All equation numbers: "Synthesis of functional observers for bilinear plants", Avtometriya 53, 2017, no. 4.
"""

from __future__ import annotations

import numpy as np

from ..structure.canonise import Canonisation, canonise
from ..structure.decomposition import reachable_subspace
from ..systems.errors import EngineError, ShapeError
from ..systems.plant import as_matrix
from ..systems.pole_sets import Poles
from ..systems.records import record

__all__ = ["BilinearForm", "BilinearObserver", "BilinearPlant", "Three", "forms_of"]

Three = tuple[np.ndarray, np.ndarray, np.ndarray]


@record()
class BilinearPlant:
    """ẋ = A x + B u + Σ uⱼ Fⱼ x, y = C x with k inputs (1).

    A n×n, F = [F₁ … F_k] n×(k n), B n×k, C m×n with independent rows and m < n. Raises ShapeError where shapes disagree, EngineError
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
        for name, matrix, shape in (("A", A, (n, n)), ("B", B, (n, B.shape[1])), ("F", F, (n, B.shape[1] * n)), ("C", C, (C.shape[0], n))):
            if matrix.shape != shape:
                raise ShapeError("{name} must be {shape}×{shape2}; it is {rows}×{columns}.",
                                 name=name, shape=shape[0], shape2=shape[1], rows=matrix.shape[0],
                                 columns=matrix.shape[1])
        if C.shape[0] >= n:
            raise EngineError("There are {rows} outputs and {n} states, so nothing is left to observe; leave out outputs, or use a "
                              "plant with more states.",
                              rows=C.shape[0], n=n)
        if canonise(_even(C)).rank < C.shape[0]:
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

    @property
    def inputs(self) -> int:
        """Number of inputs k."""
        return self.B.shape[1]

    @property
    def parts(self) -> tuple[np.ndarray, ...]:
        """F₁ … F_k, each n×n."""
        return tuple(np.hsplit(self.F, self.inputs))


def _even(M: np.ndarray) -> np.ndarray:
    """M with rows and columns of like size, so that units decide nothing about its rank."""
    M = M / (np.abs(M).max(initial=0.0) or 1.0)  # no square of it overflows
    for axis in (1, 0, 1):
        size = np.linalg.norm(M, axis=axis, keepdims=True)
        M = M / np.where(size > 0, size, 1.0)
    return M


def _each(parts: tuple[np.ndarray, ...], T: np.ndarray) -> np.ndarray:
    """[F₁ T … F_k T]."""
    return np.hstack([F @ T for F in parts])


def _freeze(record: object) -> None:
    for value in vars(record).values():
        if isinstance(value, np.ndarray):
            value.setflags(write=False)


@record()
class BilinearForm:
    """An observer that can be run: ż = A z + Y y + B u + Σ uⱼ Uⱼ y + R ẏ, ĝ = G_y y + G_z z.

    A q×q, Y and R q×m, U = [U₁ … U_k] q×(k m), B q×k, G_y r×m, G_z r×q. R = 0 in the form that needs no ẏ.
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


@record()
class BilinearObserver:
    """Every matrix of the eight steps, and what came of them.

    Step 1 (4)–(9): canonisation of C and of K₁ = K C̄ᴿ, x = T₁ y + T₂ μ + T₃ η, (y, μ, η) = (V₁, V₂, V₃) x.
    Step 2: Q = V₁ [F T₂, A T₃, F T₃] (m×(2n−2m−q)) and its canonisation; `right` = V₂ [F T₂, A T₃, F T₃].
    Of k inputs every Fⱼ T₂ and every Fⱼ T₃ stand there: (k+1)(n−m) − q columns.
    Step 3 (21): `defect` = right Q̄ᴿ must vanish; `defect_size` is its 2-norm relative to those of `right` and Q̄ᴿ, all in like units.
    Step 4: `case` 1: (21) fails, there is no observer; 2: one L only; 3: a family of L.
    Step 5 (24): A_star (q×q), B_star (q×k); `controllable` says whether any poles can be had (None unless case 3).
    Steps 6, 7 (22): π (q×k) and L (q×m); None where there is none.
    Step 8: `with_derivative` (17), (13) runs μ̂; `without_derivative` (18), (19) runs χ = μ̂ − L y.
    ε = ĝ − g = K₁ K̃ᴿ w, ẇ = A_L w whatever u is. `reached` = eig A_L. `solved`: L exists, with the poles asked for
    (case 2: with its own), and they are stable; `reason` says in a sentence why, or why not. `advised`: 3m + q ≥ 2n,
    of k inputs (k+2) m + q ≥ (k+1) n, where (21) is to be expected; q is r where no row of K x follows from y and the others.
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

    @property
    def observable(self) -> bool:
        """Whether (V₂AT₂, V₁AT₂) is: that alone would place the poles if (15), (16) asked nothing of L."""
        A, C = (V @ self.plant.A @ self.T[1] for V in (self.V[1], self.V[0]))
        return reachable_subspace(A.T, C.T)[1] == self.order

    def forms(self, L: np.ndarray) -> tuple[BilinearForm, BilinearForm]:
        """(17) with (13), and (18) with (19), for any L (q×m): also for one that misses the conditions (15), (16).

        Raises ShapeError for an L of another shape.
        """
        gain, shape = as_matrix(L, "L"), (self.order, self.plant.m)
        if gain.shape != shape:
            raise ShapeError("L must be {shape}×{shape2}; it is {rows}×{columns}.",
                             shape=shape[0], shape2=shape[1], rows=gain.shape[0], columns=gain.shape[1])
        return forms_of(self.plant, self.K, self.canonical_C.summary, self.readout, self.T, self.V, gain)

    def residuals(self) -> tuple[float, float, float]:
        """Largest entries of (V₂ − L V₁) F T₂, A T₃, F T₃ (conditions (15), (16)); NaN without an L."""
        if self.L is None:
            return (np.nan, np.nan, np.nan)
        P, (_, T2, T3) = self.V[1] - self.L @ self.V[0], self.T
        A, F = self.plant.A, self.plant.parts
        sizes = [float(np.max(np.abs(P @ M), initial=0.0)) for M in (_each(F, T2), A @ T3, _each(F, T3))]
        return sizes[0], sizes[1], sizes[2]


def forms_of(plant: BilinearPlant, K: np.ndarray, summary: np.ndarray, readout: np.ndarray, T: Three, V: Three,
           L: np.ndarray) -> tuple[BilinearForm, BilinearForm]:
    """Step 8: (17) with (13), and (18) with (19)."""
    (T1, T2, _), P = T, V[1] - L @ V[0]
    A_L, direct = P @ plant.A @ T2, K @ summary
    PB, U = P @ plant.B, _each(tuple(P @ F for F in plant.parts), T1)
    return (BilinearForm(A_L, P @ plant.A @ T1, PB, U, L, direct, readout),
            BilinearForm(A_L, P @ plant.A @ (T1 + T2 @ L), PB, U, np.zeros_like(L), direct + readout @ L, readout))
