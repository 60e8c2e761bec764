"""Test observability and controllability, mode by mode and as distances."""

from __future__ import annotations

from dataclasses import field
from functools import cached_property

import numpy as np

from ..systems.arrays import frozen
from ..systems.balance import state_scale
from ..systems.errors import EngineError
from ..systems.exact_roots import MAX_STATES, exact_poles
from ..systems.gates.argument_checks import number, takes
from ..systems.gates.plant_gate import DRIVEN, SEEN
from ..systems.plant import Plant
from ..systems.pole_sets import match_poles, sorted_poles
from ..systems.records import record
from ..systems.stability import poles_within, stable_poles
from .decomposition import balanced_staircase, clearly_reached

__all__ = ["Controllability", "Mode", "Observability", "controllability", "controllability_matrix", "observability", "observability_matrix"]


POLE_ROUNDING_RTOL = 1e-12  # of the largest pole: what rounding may move another by before it is asked what A has in truth


@record(eq=True)
class Mode:
    """One eigenvalue of A, and how far it is from being hidden.

    `distance` = σ_min [A − λI; C], the 2-norm of the smallest change of (A, C) that hides λ (Eising 1984);
    `margin` = distance / max(‖A‖₂, ‖C‖₂), a number without unit. For controllability read (Aᵀ, Bᵀ) for
    (A, C). Both belong to the eigenvalue: copies of a repeated pole share them. `visible` belongs to the copy:
    of two poles at −1 of which one leaves a trace, one is visible and one is not. `stable` means Re λ < 0,
    or |λ| < 1 when dt > 0, by more than rounding.
    """

    pole: complex
    margin: float
    distance: float
    visible: bool
    stable: bool


@record()
class _Seen:
    """A pair (A, C), and A in coordinates whose first `rank` states are seen; of controllability the dual."""

    A: np.ndarray
    C: np.ndarray
    dt: float
    turned: np.ndarray
    rank: int

    @cached_property
    def labelled(self) -> tuple[np.ndarray, np.ndarray]:
        """Every pole (n,), and which of them leave a trace: the diagonal block that a pole comes from says so, which counts repeated
        poles right."""
        r = self.rank
        poles = np.concatenate([sorted_poles(self.turned[:r, :r]), sorted_poles(self.turned[r:, r:])])
        order = np.lexsort((np.imag(poles), np.real(poles)))
        return frozen(poles[order]), frozen(order < r)


@record()
class _Report:
    rank: int
    _seen: _Seen = field(repr=False)

    @cached_property
    def matrix(self) -> np.ndarray:
        """The matrix of the powers of A; raises EngineError where one overflows."""
        return frozen(_powers(self._seen.A, self._seen.C))

    @cached_property
    def singular_values(self) -> np.ndarray:
        """Those of `matrix` (n,)."""
        return frozen(np.linalg.svd(self.matrix, compute_uv=False))

    @cached_property
    def modes(self) -> tuple[Mode, ...]:
        """Every pole with its distances, sorted by (real, imag)."""
        return _modes(self._seen)

    def matrix_rank(self, rtol: float | None = None) -> int:
        """Singular values of the matrix above rtol·σ₁ (default max(shape)·eps): the naive rank, for comparison."""
        bound = max(self.matrix.shape) * np.finfo(float).eps if rtol is None else rtol
        return int(np.count_nonzero(self.singular_values > bound * self.singular_values[:1]))

    @property
    def _hidden(self) -> tuple[complex, ...]:
        if self.rank == len(self._seen.A):
            return ()
        poles, visible = self._seen.labelled
        return tuple(complex(pole) for pole in poles[~visible])

    @property
    def _hidden_are_stable(self) -> bool:
        return not self._hidden or all(mode.stable for mode in self.modes if not mode.visible)

    @property
    def weakest(self) -> Mode | None:
        """The mode with the smallest margin; None for a plant without states."""
        return min(self.modes, key=lambda mode: mode.margin, default=None)


@record()
class Observability(_Report):
    """Does y determine x? `matrix` = O = [C; CA; …; CAⁿ⁻¹] (pn×n) with its `singular_values` (n,);
    `rank` = n less the dimension of the hidden subspace, by the staircase and not by rank(O);
    `modes` sorted by (real, imag), each with its distance to being hidden."""

    @property
    def unobservable(self) -> tuple[complex, ...]:
        """Poles that leave no trace in y, repeated as often as they are hidden."""
        return self._hidden

    @property
    def observable(self) -> bool:
        """Every mode leaves a trace."""
        return not self._hidden

    @property
    def detectable(self) -> bool:
        """Every hidden mode is stable: some L makes A − LC stable."""
        return self._hidden_are_stable


@record()
class Controllability(_Report):
    """Does u move x anywhere? `matrix` = [B, AB, …, Aⁿ⁻¹B] (n×nm) with its `singular_values` (n,);
    `rank` = dimension of the reachable subspace, by the staircase; `modes` as in Observability,
    where `visible` reads "reached by u"."""

    @cached_property
    def matrix(self) -> np.ndarray:
        """[B, AB, …, Aⁿ⁻¹B] (n×nm); raises EngineError where a power of A overflows."""
        return frozen(_powers(self._seen.A, self._seen.C).T)

    @property
    def uncontrollable(self) -> tuple[complex, ...]:
        """Poles that no input moves, repeated as often as they are fixed."""
        return self._hidden

    @property
    def controllable(self) -> bool:
        """Every mode is reached."""
        return not self._hidden

    @property
    def stabilizable(self) -> bool:
        """Every mode out of reach is stable: some K makes A − BK stable."""
        return self._hidden_are_stable


def _distances(A: np.ndarray, C: np.ndarray, poles: np.ndarray) -> np.ndarray:
    n, stack = A.shape[0], np.empty((poles.size, A.shape[0] + C.shape[0], A.shape[0]), dtype=complex)
    stack[:, :n] = A - poles[:, None, None] * np.eye(n)
    stack[:, n:] = C
    return np.linalg.svd(stack, compute_uv=False)[:, -1] if poles.size else np.zeros(0)


def _seen(A: np.ndarray, C: np.ndarray, dt: float, rtol: float | None) -> _Seen:
    if clearly_reached(A.T, C.T, rtol):
        return _Seen(A, C, dt, A, len(A))
    scale, Q, rank = balanced_staircase(A.T, C.T, rtol)
    return _Seen(A, C, dt, Q.T @ (A * scale[:, None] / scale) @ Q, rank)


def _modes(seen: _Seen) -> tuple[Mode, ...]:
    A, C, (poles, visible) = seen.A, seen.C, seen.labelled
    own, judged = stable_poles(A, dt=seen.dt)
    stable = judged[match_poles(poles, own)[0]]
    size = max((float(np.linalg.norm(M, 2)) for M in (A, C) if M.size), default=0.0)
    distances = _distances(A, C, _sure(A, poles))
    return tuple(
        Mode(complex(poles[i]), float(distances[i] / size) if size else 0.0, float(distances[i]), bool(visible[i]),
             bool(stable[i]))
        for i in range(len(poles))
    )


def _sure(A: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """The poles at which distances are taken: those of A itself, in truth where copies of a multiple one are scattered."""
    own, slack = poles_within(A)
    if len(own) <= MAX_STATES and slack.max(initial=0.0) > POLE_ROUNDING_RTOL * np.abs(own).max(initial=0.0):
        own = exact_poles(A, np.zeros((len(A), 0)), np.zeros((0, len(A))), own, state_scale(A)).values
    return own[match_poles(poles, own)[0]]


def _powers(A: np.ndarray, C: np.ndarray) -> np.ndarray:
    rows = [C]
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(A.shape[0] - 1):
            rows.append(rows[-1] @ A)
    stacked = np.vstack(rows)
    if not np.all(np.isfinite(stacked)):
        raise EngineError("The powers of A overflow; choose a unit of time in which the poles are nearer to 1.")
    return stacked


@takes(plant=SEEN)
def observability_matrix(plant: Plant) -> np.ndarray:
    """O = [C; CA; …; CAⁿ⁻¹] (pn×n) alone, without a look at any pole; raises EngineError when a power of A overflows.

    >>> observability_matrix(Plant(np.diag([-1, -2]), np.ones((2, 1)), [[1, 0]]))
    array([[ 1.,  0.],
           [-1.,  0.]])
    """
    return frozen(_powers(plant.A, plant.C))


@takes(plant=DRIVEN)
def controllability_matrix(plant: Plant) -> np.ndarray:
    """[B, AB, …, Aⁿ⁻¹B] (n×nm) alone, without a look at any pole; raises EngineError when a power of A overflows.

    >>> controllability_matrix(Plant(np.diag([-1, -2]), np.ones((2, 1)), np.eye(2)))
    array([[ 1., -1.],
           [ 1., -2.]])
    """
    return frozen(_powers(plant.A.T, plant.B.T).T)


@takes(plant=SEEN, rtol=number())
def observability(plant: Plant, *, rtol: float | None = None) -> Observability:
    """Whether, and how nearly not, the output determines the state.

    O = [C; CA; …; CAⁿ⁻¹] (pn×n); pole λ is hidden when [A − λI; C] loses rank. Hidden means: found so by the
    staircase at relative tolerance rtol (default 1e-10). Distances say how near the others are.
    Modes with their distances, O and its values are computed when they are asked for. Raises EngineError for rtol outside [0, 1).
    Source: Popov, Belevitch, Hautus (the PBH test).

    >>> observability(Plant(np.diag([-1, -2]), np.ones((2, 1)), [[1, 0]])).rank
    1
    """
    found = _seen(plant.A, plant.C, plant.dt, rtol)
    return Observability(found.rank, found)


@takes(plant=DRIVEN, rtol=number())
def controllability(plant: Plant, *, rtol: float | None = None) -> Controllability:
    """Whether, and how nearly not, the input reaches every state: `observability` of (Aᵀ, Bᵀ).

    matrix = [B, AB, …, Aⁿ⁻¹B] (n×nm); pole λ is out of reach when [A − λI, B] loses rank.
    Raises EngineError for rtol outside [0, 1).

    >>> controllability(Plant(np.diag([-1, -2]), [[1], [0]], np.eye(2))).rank
    1
    """
    found = _seen(plant.A.T, plant.B.T, plant.dt, rtol)
    return Controllability(found.rank, found)
