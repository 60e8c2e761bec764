"""Compute the sensitivities of a loop at plant inputs and outputs, and where to sample them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ..systems.errors import EngineError, ShapeError, phrase
from ..systems.gates.argument_checks import array, count, gated, takes
from ..systems.gates.plant_gate import CONTROLLER, PLANT
from ..systems.plant import Plant, as_matrix
from ..systems.pole_sets import Poles, sorted_poles
from ..systems.records import record
from ..systems.spectrum import frequency_response, modal_coordinates
from ..systems.stability import is_stable

__all__ = ["Sensitivity", "sensitivity"]

BASE = 400  # points of the logarithmic sweep
AROUND = 31  # points around the frequency of each pole
EXTRA_DECADES = 2.0  # that the sweep reaches beyond the slowest and the fastest pole


@record()
class Sensitivity:
    """S(s) = C (sI − A)⁻¹ B + D from disturbances at the cuts (plant inputs, then outputs) to the signals behind them.

    With the loop u = Kc(s) y, y = P(s) u: S = (I − X)⁻¹, X = [0 Kc; P 0], of size m + p; its blocks on the diagonal are
    (I − Kc P)⁻¹ (cut at the inputs) and (I − P Kc)⁻¹ (at the outputs). `omega` (n_ω,) in rad/s begins at 0 and ends
    at ∞ (at π/dt for a sampled loop).
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    dt: float
    inputs: int
    open_poles: Poles

    @cached_property
    def poles(self) -> Poles:
        """Poles of the closed loop, sorted by (real, imag)."""
        return sorted_poles(self.A)

    @cached_property
    def stable(self) -> bool:
        """Whether the closed loop is stable by more than rounding, so that S is finite at every frequency."""
        return is_stable(self.A, dt=self.dt) and bool(np.isfinite(self.values).all())

    @cached_property
    def omega(self) -> np.ndarray:
        """A logarithmic sweep, denser around the poles of the closed and of the open loop, with 0 and ∞."""
        poles = np.concatenate([self.poles, self.open_poles])
        if self.dt:
            with np.errstate(divide="ignore"):
                poles = np.log(poles[np.abs(poles) > 1e-12]) / self.dt
        size = np.abs(poles)
        size = size[size > 1e-12 * size.max(initial=0.0)]
        low, high = (size.min(), size.max()) if size.size else (1.0, 1.0)
        sweep = np.geomspace(low / 10**EXTRA_DECADES, high * 10**EXTRA_DECADES, BASE)
        ringing = poles[poles.imag > 0]
        turn = np.tan(np.linspace(-1.55, 1.55, AROUND))
        width = np.maximum(np.abs(ringing.real), 1e-9 * np.abs(ringing))
        around = (ringing.imag[:, None] + width[:, None] * turn).ravel()
        grid = np.unique(np.concatenate([sweep, around[around > 0]]))
        top = np.pi / self.dt if self.dt else np.inf
        return np.concatenate([[0.0], grid[grid < top], [top]])

    @cached_property
    def modal(self) -> tuple[Poles, np.ndarray] | None:
        """Poles and residues (N, m+p, m+p) of S, None where the eigenvectors are ill conditioned."""
        found = modal_coordinates(self.A, self.B, self.C)
        return None if found is None else (found[0], found[1].T[:, :, None] * found[2][:, None, :])

    @gated(omega=array(infinite=True))
    def at(self, omega: np.ndarray) -> np.ndarray:
        """S at frequencies in rad/s of any shape, ∞ included: complex (…, m+p, m+p)."""
        return self._first(omega, len(self.D))

    @gated(omega=array(infinite=True), count=count())
    def corner(self, omega: np.ndarray, count: int) -> np.ndarray:
        """S of the first `count` signals alone, complex (…, count, count): of the m inputs, where many states are measured."""
        return self._first(omega, min(count, len(self.D)))

    def _first(self, omega: np.ndarray, count: int) -> np.ndarray:
        if self.modal is None:
            flat, finite = omega.ravel(), np.isfinite(omega.ravel())
            values = np.empty((flat.size, *self.D.shape), dtype=complex)
            values[~finite] = self.D
            if finite.any():
                values[finite] = frequency_response(self.A, self.B, self.C, self.D, flat[finite], dt=self.dt)
            return values.reshape(*omega.shape, *self.D.shape)[..., :count, :count]
        residues = self.modal[1][:, :count, :count].reshape(len(self.A), count * count)
        return (self._weights(omega) @ residues).reshape(*omega.shape, count, count) + self.D[:count, :count]

    @gated(i=count())
    def along(self, i: int) -> Callable[[np.ndarray], np.ndarray]:
        """S_ii alone as a function of finite frequencies (…) → complex (…), for searches that ask again and again."""
        self._known(i)
        if self.modal is None:
            return lambda omega: self.at(omega)[..., i, i]
        poles, residues, direct, dt = self.modal[0], np.ascontiguousarray(self.modal[1][:, i, i]), self.D[i, i], self.dt

        def at(omega: np.ndarray) -> np.ndarray:
            points = np.exp(1j * omega * dt) if dt else 1j * omega
            return (1 / (points[..., None] - poles)) @ residues + direct

        return at

    @gated(i=count())
    def own(self, i: int) -> np.ndarray:
        """S_ii alone on `omega`, complex (n_ω,)."""
        self._known(i)
        if self.modal is None or "values" in vars(self):
            return self.values[:, i, i]
        return self._weights(self.omega) @ self.modal[1][:, i, i] + self.D[i, i]

    def _known(self, i: int) -> None:
        if i >= len(self.D):
            raise EngineError("There is no signal number {index}; the loop has {count}.", index=i, count=len(self.D))

    def _weights(self, omega: np.ndarray) -> np.ndarray:
        """1/(λ − λ_k) at λ = jω or e^{jω dt}, zero at ∞: (…, N)."""
        poles = self.poles if self.modal is None else self.modal[0]
        points = np.exp(1j * omega * self.dt) if self.dt else 1j * np.where(np.isfinite(omega), omega, 0.0)
        return np.where(np.isfinite(omega)[..., None], 1 / (points[..., None] - poles), 0.0)

    @cached_property
    def values(self) -> np.ndarray:
        """S on `omega`."""
        return self.at(self.omega)


@takes(plant=PLANT, controller=CONTROLLER)
def sensitivity(plant: Plant, controller: Plant | object) -> Sensitivity:
    """The loop of a plant P and a controller u = Kc(s) y, sign included, as `compensator` gives it; or a gain u = F y.

    Raises ShapeError where the two do not fit, EngineError where they have different periods or the loop is ill-posed
    (I − D_k D singular).

    >>> plant = Plant([[0]], [[1]], [[1]])
    >>> bool(np.all(sensitivity(plant, compensator(plant, [[1]], [[2]])).poles.real < 0))
    True
    """
    built = controller if isinstance(controller, Plant) else _static(plant, as_matrix(controller, phrase("The controller")))
    if (built.m, built.p) != (plant.p, plant.m):
        raise ShapeError("The controller must have {p} inputs and {m} outputs, the plant's turned around; it has "
                         "{m2} and {p2}.",
                         p=plant.p, m=plant.m, m2=built.m, p2=built.p)
    if built.dt != plant.dt:
        raise EngineError("Plant and controller must both be continuous, or share one sampling period.")
    n, m, p = plant.n, plant.m, plant.p
    cross = np.block([[np.zeros((m, m)), np.asarray(built.D)], [np.asarray(plant.D), np.zeros((p, p))]])
    well = np.eye(m + p) - cross
    if np.linalg.cond(np.eye(m) - np.asarray(built.D) @ np.asarray(plant.D)) > 1e12:
        raise EngineError("The loop is ill-posed: the direct paths of plant and controller form a loop of gain "
                          "one.")
    S0 = np.linalg.inv(well)  # (u, y) = S0 (cut disturbances + [C_k x_k; C x])
    A = np.block([[plant.A, np.zeros((n, built.n))], [np.zeros((built.n, n)), built.A]])
    B = np.block([[plant.B, np.zeros((n, p))], [np.zeros((built.n, m)), built.B]])
    C = np.block([[np.zeros((m, n)), built.C], [plant.C, np.zeros((p, built.n))]])
    opened = np.concatenate([plant.poles, built.poles]) if built.n else plant.poles
    return Sensitivity(A + B @ S0 @ C, B @ S0, S0 @ C, S0, plant.dt, m, opened)


def _static(plant: Plant, gain: np.ndarray) -> Plant:
    none = np.zeros
    return Plant(none((0, 0)), none((0, gain.shape[1])), none((gain.shape[0], 0)), gain, plant.dt)
