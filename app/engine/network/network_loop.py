"""Compute the spectrum of a delayed loop and the mean-square stability of a lossy one."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ..systems.arrays import as_checked
from ..systems.errors import EngineError
from ..systems.gates.argument_checks import SHARE, choice, count, matrix, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant

__all__ = ["delayed_loop", "mean_square_growth"]


@takes(plant=PLANT, K=matrix("m n"), M=matrix("n p"), delay=count(0, 1000), told=choice("asked", "applied"), ahead=count(0, 1000))
def delayed_loop(plant: Plant, K: np.ndarray, M: np.ndarray, delay: int, *,
                 told: Literal["asked", "applied"] = "applied",
                 ahead: int = 0) -> np.ndarray:
    """The loop of filter gain M with inputs `delay` samples late, as z⁺ = F z on z = (x, u[k−1] … u[k−delay], e).

    e = x − x̂[k|k−1], u = −K x̂[k|k] (`ahead` > 0: of the state predicted so far on). The lower left block, from
    (x, u) into e, is zero where the observer is told the applied input; F is (2n + delay m) square. Raises ShapeError,
    EngineError.
    """
    _require_packets(plant)
    A, B, C, K, M = plant.A, plant.B, plant.C, as_checked(K), as_checked(M)
    n, m = B.shape
    N = n + delay * m
    E = np.eye(n) - M @ C
    if ahead > delay:
        raise EngineError("The controller cannot predict farther than the delay, where no input asked for is "
                          "under way; predict less far.")
    u = np.zeros((m, N + n))
    step = np.linalg.matrix_power(A, ahead)
    u[:, :n], u[:, N:] = -K @ step, K @ step @ E
    for i in range(ahead):
        u[:, n + i * m:n + (i + 1) * m] = -K @ np.linalg.matrix_power(A, i) @ B
    applied = u
    if delay:
        applied = np.zeros((m, N + n))
        applied[:, N - m:N] = np.eye(m)
    F = np.zeros((N + n, N + n))
    F[:n, :n] = A
    F[:n] += B @ applied
    if delay:
        F[n:n + m] = u
        F[n + m:N, n:N - m] = np.eye((delay - 1) * m)
    F[N:, N:] = A @ E
    if told == "asked":
        F[N:] += B @ (applied - u)
    return F


@takes(plant=PLANT, K=matrix("m n"), loss=SHARE, on_loss=choice("hold", "zero"))
def mean_square_growth(plant: Plant, K: np.ndarray, loss: float, on_loss: Literal["hold", "zero"]) -> float:
    """Growth of E‖x‖² a sample under u = −K x when each input is lost with probability `loss`: below 1 it dies out.

    The spectral radius of X ↦ (1 − loss) F X Fᵀ + loss G X Gᵀ, F and G being the loop with and without the packet,
    (x, last input) where inputs are held. Raises EngineError.
    """
    _require_packets(plant)
    A, B = plant.A, plant.B
    n, m = B.shape
    if on_loss == "zero":
        F, G = A - B @ K, A
    else:
        F = np.block([[A - B @ K, np.zeros((n, m))], [-K, np.zeros((m, m))]])
        G = np.block([[A, B], [np.zeros((m, n)), np.eye(m)]])
    return float(np.abs(np.linalg.eigvals((1 - loss) * _on_symmetric(F) + loss * _on_symmetric(G))).max())


def _require_packets(plant: Plant) -> None:
    if not plant.dt or np.any(plant.D):
        raise EngineError("A loop over packets needs a sampled plant (dt > 0) without direct feedthrough D.")


def _on_symmetric(F: np.ndarray) -> np.ndarray:
    """X ↦ F X Fᵀ on the lower triangles of symmetric matrices, where a positive map has its largest eigenvalue."""
    i, j = np.tril_indices(len(F))
    straight, crossed = F[i][:, i] * F[j][:, j], F[i][:, j] * F[j][:, i]
    return np.where(i == j, straight, straight + crossed)
