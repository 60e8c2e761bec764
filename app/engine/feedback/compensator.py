"""Build the compensator from y to u and the loop that it closes."""

from __future__ import annotations

from dataclasses import field
from functools import cached_property

import numpy as np

from ..systems.arrays import frozen
from ..systems.balance import balance
from ..systems.errors import ShapeError
from ..systems.gates.argument_checks import matrix, optional, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant, as_matrix
from ..systems.pole_sets import Poles, match_poles, sorted_poles
from ..systems.records import record
from ..systems.stability import is_stable

__all__ = ["ClosedLoop", "TransferFunction", "closed_loop", "compensator", "to_tf"]


@record()
class TransferFunction:
    """H(s) = num[i][j](s) / den(s) from input j to output i; coefficients from the highest power down.

    num has shape (p, m, n+1), den (n+1,), monic.
    """

    num: np.ndarray
    den: np.ndarray
    dt: float = 0.0

    def __call__(self, s: complex) -> np.ndarray:
        """H(s), p×m."""
        powers = complex(s) ** np.arange(self.den.size - 1, -1, -1)
        return (self.num @ powers) / (self.den @ powers)


@record()
class ClosedLoop:
    """Plant, observer and feedback of the estimate as one system of 2n states.

    A_xxhat drives (x, x̂), A_xe = T A_xxhat T⁻¹ drives (x, e), e = x − x̂, T = [[I, 0], [I, −I]] = T⁻¹. Where the model
    is the plant, A_xe = [[A − BK, BK], [0, A − LC]] and separation holds.
    poles: eig(A_xxhat). controller_poles, observer_poles: eig(A − BK), eig(A − LC) of the model, what the designer
    believes. union_error: largest matched distance between poles and that union, relative to the largest pole, all three
    as double precision finds them: never (much) below the true one, but multiple poles scatter by rounding (like ε^(1/k)), so
    for them read polynomial_error: the two characteristic polynomials compared around the spectrum, relative. Both errors, and
    what the compensator is by itself, are computed when they are asked for.
    """

    A_xxhat: np.ndarray
    A_xe: np.ndarray
    T: np.ndarray
    poles: Poles
    controller_poles: Poles
    observer_poles: Poles
    compensator: Plant
    stable: bool
    _boards: tuple[np.ndarray, np.ndarray] = field(repr=False)  # A − BK and A − LC

    @cached_property
    def union_error(self) -> float:
        """Largest distance between matched poles of the loop and of the union, relative to the largest pole."""
        distance = match_poles(np.concatenate([self.controller_poles, self.observer_poles]), self.poles)[1]
        return distance / self._largest if self._largest > 0 else distance

    @cached_property
    def polynomial_error(self) -> float:
        """max |det(sI − loop) / (det(sI − A + BK) det(sI − A + LC)) − 1| on a circle around the spectrum."""
        return _polynomial_error(self.A_xxhat, self._boards, self._largest)

    @cached_property
    def compensator_poles(self) -> Poles:
        """Poles of the compensator by itself (n,)."""
        return _spectrum(self.compensator.A)

    @cached_property
    def compensator_stable(self) -> bool:
        """Whether the compensator is stable by itself."""
        return is_stable(self.compensator.A, dt=self.compensator.dt)

    @property
    def _largest(self) -> float:
        return float(np.abs(np.concatenate([self.controller_poles, self.observer_poles])).max(initial=0.0))


@takes(plant=PLANT, K=matrix(), L=matrix())
def compensator(plant: Plant, K: object, L: object) -> Plant:
    """The compensator from y to u: x̂̇ = (A − BK − LC + LDK) x̂ + L y, u = −K x̂.

    K is m×n, L n×p. The plant's period travels along. Raises ShapeError where the gains do not fit the plant.

    >>> compensator(Plant([[0]], [[1]], [[1]]), [[1]], [[2]]).A
    array([[-3.]])
    """
    K, L = _gains(plant, K, L)
    A = plant.A - plant.B @ K - L @ plant.C + L @ plant.D @ K
    names = tuple(f"{name}_hat" for name in plant.state_names)
    title = f"compensator of {plant.name}".strip()
    return Plant(A, L, -K, np.zeros((plant.m, plant.p)), plant.dt, names, plant.output_names, plant.input_names, name=title)


@takes(plant=PLANT, K=matrix(), L=matrix(), model=optional(PLANT))
def closed_loop(plant: Plant, K: object, L: object, *, model: Plant | None = None) -> ClosedLoop:
    """The 2n-state loop of a plant and the compensator built on `model` (None: on the plant itself).

    ẋ = A x − B K x̂ and x̂̇ = L C x + (Aₘ − BₘK − LCₘ + L(Dₘ − D)K) x̂, with m for the model. Raises ShapeError where
    the gains do not fit, or the model has other numbers of states, inputs, outputs or another period than the plant.

    >>> np.round(closed_loop(Plant([[0]], [[1]], [[1]]), [[1]], [[2]]).poles.real, 6)
    array([-2., -1.])
    """
    K, L = _gains(plant, K, L)
    believed = plant if model is None else _same_shape(plant, model)
    n = plant.n
    BK, LC = plant.B @ K, L @ plant.C
    regulated, observed = believed.A - believed.B @ K, believed.A - L @ believed.C
    observer = regulated - L @ believed.C + L @ (_through(believed) - _through(plant)) @ K
    A_xxhat = np.block([[plant.A, -BK], [LC, observer]])
    A_xe = np.block([[plant.A - BK, BK], _error_rows(plant, believed, K, L)])
    identity, zero = np.eye(n), np.zeros((n, n))
    judged = (regulated, observed) if model is None else (A_xe,)  # of the plant itself A_xe is block triangular
    return ClosedLoop(
        A_xxhat=frozen(A_xxhat),
        A_xe=frozen(A_xe),
        T=frozen(np.block([[identity, zero], [identity, -identity]])),
        poles=_spectrum(A_xxhat),
        controller_poles=_spectrum(regulated),
        observer_poles=_spectrum(observed),
        compensator=compensator(believed, K, L),
        stable=all(is_stable(part, dt=plant.dt) for part in judged),
        _boards=(frozen(regulated), frozen(observed)),
    )


@takes(plant=PLANT)
def to_tf(plant: Plant) -> TransferFunction:
    """Transfer function H(s) = C(sI − A)⁻¹B + D of a plant or a compensator, as polynomials.

    Leading coefficients that vanish by structure (the relative degree, read from the Markov parameters D, CB, CAB, …)
    are exact zeros. Polynomials of high degree are ill-conditioned: above some ten states trust the state space.

    >>> to_tf(Plant([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]])).den
    array([1., 3., 2.])
    """
    from scipy.signal import ss2tf  # late: it brings all of scipy.stats, 0.6 s

    num = np.empty((plant.p, plant.m, plant.n + 1))
    den, own = np.ones(1), balance(plant.A, plant.B, plant.C, _through(plant))
    for j in range(plant.m):
        columns, den = ss2tf(own.A(plant.A), own.B(plant.B), own.C(plant.C), own.D(_through(plant)), input=j)
        num[:, j, :] = columns * own.outputs[:, None] / own.inputs[j]
    num[_leading_zeros(plant)] = 0.0
    return TransferFunction(frozen(num), frozen(np.atleast_1d(den)), plant.dt)


def _leading_zeros(plant: Plant) -> np.ndarray:
    """Mask (p, m, n+1) of the leading numerator coefficients that vanish with their Markov parameters."""
    vanishing = np.ones((plant.p, plant.m), dtype=bool)
    mask = np.zeros((plant.p, plant.m, plant.n + 1), dtype=bool)
    markov, bound, column = _through(plant), np.abs(_through(plant)), plant.B
    size = np.abs(plant.B)
    for k in range(plant.n):
        vanishing &= np.abs(markov) <= 1e-14 * bound
        mask[:, :, k] = vanishing
        markov, bound = plant.C @ column, np.abs(plant.C) @ size
        column, size = plant.A @ column, np.abs(plant.A) @ size
    return mask


def _through(plant: Plant) -> np.ndarray:
    """D, which is an array in every finished plant."""
    return np.asarray(plant.D)


def _gains(plant: Plant, K: object, L: object) -> tuple[np.ndarray, np.ndarray]:
    K, L = as_matrix(K, "K"), as_matrix(L, "L")
    if K.shape != (plant.m, plant.n):
        raise ShapeError("K must be {m}×{n}, inputs by states; it is {rows}×{columns}.",
                         m=plant.m, n=plant.n, rows=K.shape[0], columns=K.shape[1])
    if L.shape != (plant.n, plant.p):
        raise ShapeError("L must be {n}×{p}, states by outputs; it is {rows}×{columns}.",
                         n=plant.n, p=plant.p, rows=L.shape[0], columns=L.shape[1])
    return K, L


def _same_shape(plant: Plant, model: Plant) -> Plant:
    if (model.n, model.m, model.p, model.dt) != (plant.n, plant.m, plant.p, plant.dt):
        raise ShapeError("The model must have as many states, inputs and outputs as the plant, and the same "
                         "period dt.")
    return model


def _error_rows(plant: Plant, model: Plant, K: np.ndarray, L: np.ndarray) -> list[np.ndarray]:
    """ė = (ΔA − ΔB K − L ΔC + L ΔD K) x + (Aₘ − LCₘ + ΔB K − L ΔD K) e, with Δ = plant − model: zero if they agree."""
    through_input = (plant.B - model.B - L @ (_through(plant) - _through(model))) @ K
    from_state = plant.A - model.A - L @ (plant.C - model.C) - through_input
    return [from_state, model.A - L @ model.C + through_input]


def _spectrum(A: np.ndarray) -> Poles:
    return frozen(sorted_poles(A))


def _polynomial_error(whole: np.ndarray, parts: tuple[np.ndarray, np.ndarray], largest: float) -> float:
    """max |det(sI − whole)/∏ det(sI − part) − 1| on a circle of twice the largest pole."""
    radius = 2 * largest if largest > 0 else 1.0
    s = radius * np.exp(1j * np.pi * (np.arange(8) + 0.5) / 8)

    def value(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.linalg.slogdet(s[:, None, None] * np.eye(matrix.shape[0]) - matrix)

    sign, log = value(whole)
    for part in parts:
        part_sign, part_log = value(part)
        sign, log = sign / part_sign, log - part_log
    with np.errstate(over="ignore"):
        return float(np.abs(sign * np.exp(np.minimum(log, 700.0)) - 1).max())
