"""Build the loop of plant, observer and controller as matrices on z = (x, x̂), input open."""

from __future__ import annotations

import numpy as np

from ..systems.gates.argument_checks import SECONDS, matrix, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.records import record
from ..systems.recursions import step_matrices
from ..systems.sampling import discretise, require_continuous
from .scenario import Scenario

__all__ = ["Loop", "continuous_loop", "discrete_loop", "emulated_gain"]


@record()
class Loop:
    """ż = A z + Bs sat(u) + Bc u + E v with u = F z + r (or z⁺ = … for a sampled loop).

    z = (x, x̂) (N,); Bs, Bc: N×m for the clipped and for the asked input, E: N×p, F: m×N. `Bp` (N×m) is the
    way of the delayed input into plant and measurement, already in Bs where there is no delay.
    """

    A: np.ndarray
    Bs: np.ndarray
    Bc: np.ndarray
    Bp: np.ndarray
    E: np.ndarray
    F: np.ndarray

    def closed(self, free: np.ndarray) -> np.ndarray:
        """A with the inputs `free` (bool, m) fed back and the others held at their limits."""
        return self.A + self.Bc @ self.F + self.Bs[:, free] @ self.F[free]

    def forcing(self, free: np.ndarray, held: np.ndarray, r: np.ndarray, v: np.ndarray) -> np.ndarray:
        """What acts beside `closed(free)`: (…, N) from r (…, m), v (…, p) and the limits `held` (m,)."""
        return r @ self.Bc.T + np.where(free, r, held) @ self.Bs.T + v @ self.E.T


@takes(plant=PLANT, L=matrix("n p"), dt=SECONDS)
def emulated_gain(plant: Plant, L: np.ndarray, dt: float) -> np.ndarray:
    """The gain of a sampled observer emulating a continuous L: L_d = ∫₀ᵈᵗ e^{(A − L C) s} ds L, n×p.

    The innovation is held over the sample; the sampled poles are eig(e^{A dt} − L_d C), near but not equal to
    e^{λ dt} of the continuous ones. Raises EngineError for a plant that is sampled already.
    """
    require_continuous(plant)
    return step_matrices(plant.A - L @ plant.C, dt)[1] @ L


def _join(s: Scenario, plant: Plant, model: Plant, L: np.ndarray) -> Loop:
    n, N, m = plant.n, plant.n + model.n, plant.m
    A = np.zeros((N, N))
    A[:n, :n] = plant.A
    A[n:, :n] = L @ plant.C
    A[n:, n:] = model.A - L @ model.C
    into_plant = np.vstack([plant.B, L @ plant.D])
    into_observer = np.vstack([np.zeros((n, m)), model.B - L @ model.D])
    nothing = np.zeros((N, m))
    F = np.zeros((m, N))
    F[:, slice(0, n) if s.state_feedback else slice(n, N)] = -s.K
    applied = s.fed == "applied"
    Bs = (nothing if s.lag else into_plant) + (into_observer if applied else nothing)
    return Loop(A, Bs, nothing if applied else into_observer, into_plant,
                np.vstack([np.zeros((n, plant.p)), L]), F)


def continuous_loop(s: Scenario) -> Loop:
    """The loop of a scenario in continuous time."""
    return _join(s, s.plant, s.model, s.L)


def discrete_loop(s: Scenario) -> Loop:
    """The loop of a scenario whose observer and controller run every dt, as z⁺ = A z + …; plant exact at the samples.

    A continuous L is emulated (`emulated_gain`); a plant with dt > 0 brings discrete K and L and is taken as is.
    """
    return _join(s, *_systems(s))


def error_loop(s: Scenario) -> Loop:
    """The loop of a scenario without limits and delay on (x, e), e = x − x̂, for a model of the plant's order.

    ė = (Aₘ − L Cₘ) e + (A − Aₘ − L (C − Cₘ)) x + (B − Bₘ − L (D − Dₘ)) u − L v: on a true model no x and no u are in it.
    """
    plant, model, L = _systems(s)
    n, m = plant.n, plant.m
    A = np.block([[plant.A, np.zeros((n, n))], [plant.A - model.A - L @ (plant.C - model.C), model.A - L @ model.C]])
    into = np.vstack([plant.B, plant.B - model.B - L @ (np.asarray(plant.D) - np.asarray(model.D))])
    F = np.hstack([-s.K, np.zeros((m, n)) if s.state_feedback else s.K])
    return Loop(A, into, np.zeros_like(into), into, np.vstack([np.zeros((n, plant.p)), -L]), F)


def _systems(s: Scenario) -> tuple[Plant, Plant, np.ndarray]:
    """Plant, model and L in the time in which the loop runs."""
    if s.plant.dt or not s.discrete:
        return s.plant, s.model, s.L
    return discretise(s.plant, s.dt), discretise(s.model, s.dt), emulated_gain(s.model, s.L, s.dt)


def ramped(loop: Loop) -> Loop:
    """The loop with the delayed input as 2m more states (p, ṗ), so that a step sees it change linearly."""
    N, m = loop.Bp.shape
    A = np.zeros((N + 2 * m, N + 2 * m))
    A[:N, :N] = loop.A
    A[:N, N:N + m] = loop.Bp
    A[N:N + m, N + m:] = np.eye(m)

    def tall(matrix: np.ndarray) -> np.ndarray:
        return np.vstack([matrix, np.zeros((2 * m, matrix.shape[1]))])

    return Loop(A, tall(loop.Bs), tall(loop.Bc), tall(loop.Bp), tall(loop.E), np.hstack([loop.F, np.zeros((m, 2 * m))]))
