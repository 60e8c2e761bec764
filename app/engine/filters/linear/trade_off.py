"""Split an observer's error variance into process noise and sensor noise."""

from __future__ import annotations

import numpy as np

from ...design.optimal import dlqe, lqe
from ...systems.arrays import as_checked, as_covariance
from ...systems.errors import EngineError
from ...systems.gates.argument_checks import SECONDS, SERIES, count, covariance, instance, matrix, takes
from ...systems.gates.plant_gate import PLANT
from ...systems.lyapunov import settled_covariance
from ...systems.noise import root
from ...systems.plant import Plant, as_matrix
from ...systems.records import record
from ...systems.recursions import step_matrices
from ...systems.stability import is_stable

__all__ = ["ErrorParts", "Ladder", "error_parts", "growing_error", "noise_ladder"]


@record()
class ErrorParts:
    """Covariances (n×n) of the settled error of an observer: what process noise leaves and what sensor noise adds."""

    process: np.ndarray
    sensor: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """P = P_w + P_v: the noises are independent."""
        return self.process + self.sensor


@record()
class Ladder:
    """Kalman filters that believe `ratio` (k,) times the true process noise; parts[i] is what the i-th does with the truth.

    The one at ratio 1 has the least covariance of all observers: P_i − P ⪰ 0 for every i.
    """

    ratio: np.ndarray
    gains: tuple[np.ndarray, ...]
    parts: tuple[ErrorParts, ...]


@takes(plant=PLANT, L=matrix("n p"), G=matrix("n q"), W=covariance("q"), V=covariance("p"))
def error_parts(plant: Plant, L: object, G: object, W: object, V: object) -> ErrorParts:
    """F P + P Fᵀ + G W Gᵀ = 0 and F P + P Fᵀ + L V Lᵀ = 0, F = A − LC; F P Fᵀ − P + … = 0 for a plant with dt > 0.

    L n×p, G n×q, W q×q and V p×p intensities (covariances of a sample where dt > 0; a number is that number times I).
    Raises ShapeError, EngineError where the error does not settle.

    >>> parts = error_parts(Plant([[0]], [[1]], [[1]]), [[1]], [[1]], [[1]], [[1]])
    >>> parts.total
    array([[1.]])
    """
    L, G = as_checked(L), as_checked(G)
    W, V = as_covariance(W, "W", G.shape[1]), as_checked(V)
    F = plant.A - L @ plant.C
    if not is_stable(F, dt=plant.dt):
        raise EngineError("The observer's error does not settle, so its noise has no settled variance; move "
                          "its poles.")
    return ErrorParts(*(settled_covariance(F, push, dt=plant.dt) for push in (G @ root(W), L @ root(V))))


@takes(plant=PLANT, L=matrix("n p"), parts=instance(ErrorParts), V=covariance("p"), dt=SECONDS, rows=matrix("k n"),
       steps=count(1, 1_000_000))
def growing_error(plant: Plant, L: object, parts: ErrorParts, V: object, dt: float, rows: object, steps: int) -> np.ndarray:
    """Covariances (steps, k, k) of rows @ e at 0, dt, … from P(0) = 0, as a simulation with v held over a step draws them.

    `parts` as `error_parts` gives them, rows k×n, dt the step in s (the plant's own period where it is sampled; EngineError for another).
    P_j = P_h − Φʲ P_h Φᵀʲ, with P_h the limit for sensor noise of covariance V/dt held over a step.
    """
    L, V, C = as_checked(L), as_checked(V), as_checked(rows)
    F = plant.A - L @ plant.C
    if plant.dt:
        if abs(dt - plant.dt) > 1e-9 * plant.dt:
            raise EngineError("This plant is sampled every {dt:g} s; give the same dt.", dt=plant.dt)
        Phi, limit = F, parts.total
    else:
        Phi, inner = step_matrices(F, dt)
        push = inner @ L
        limit = parts.process + settled_covariance(Phi, push @ root(V / dt), dt=dt)
    far, done = np.empty((steps, *C.shape)), 1
    far[0], jump = C, Phi
    while done < steps:  # rows @ Φʲ, twice as many with each turn
        more = min(done, steps - done)
        far[done:done + more] = far[:more] @ jump
        done, jump = done + more, jump @ jump
    return C @ limit @ C.T - far @ limit @ far.swapaxes(1, 2)


@takes(plant=PLANT, G=matrix("n q"), W=covariance("q"), V=covariance("p"), ratio=SERIES)
def noise_ladder(plant: Plant, G: object, W: object, V: object, ratio: np.ndarray) -> Ladder:
    """The filters of `ratio` times W, and what each does with W and V themselves.

    Raises EngineError, RiccatiError where there is no filter.
    """
    W, design = as_matrix(W, "W"), dlqe if plant.dt else lqe
    gains = tuple(design(plant.A, G, plant.C, float(r) * W, V).gain for r in ratio)
    return Ladder(np.asarray(ratio, dtype=float), gains, tuple(error_parts(plant, L, G, W, V) for L in gains))
