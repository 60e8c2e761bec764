"""Compute spectra and variances of a loop driven by white noise."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag

from ..systems.arrays import as_checked, as_covariance, frozen
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import SECONDS, SERIES, array, covariance, gated, matrix, number, optional, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.lyapunov import settled_covariance
from ..systems.noise import root, step_covariance
from ..systems.plant import Plant, as_matrix
from ..systems.pole_sets import Poles, sorted_poles
from ..systems.records import record
from ..systems.recursions import step_matrices
from ..systems.spectrum import modal_coordinates, response_at
from ..systems.stability import is_stable

__all__ = ["NoisyLoop", "noisy_loop"]


@record()
class NoisyLoop:
    """ż = A z + B d, (y, u) = C z + D d with d = (w, v) white of intensity `noise`; y without the sensors' noise v.

    A N×N, B N×(q+p), C (p+m)×N, D (p+m)×(q+p), noise (q+p)×(q+p) = diag(W, V): two-sided intensities, the covariances
    of a sample where dt > 0. z holds the plant's states and after them the controller's. Signals are rows of weights
    over (y, u): `outputs(T)` and `inputs(T)` make them.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    noise: np.ndarray
    disturbances: int
    measured: int
    dt: float = 0.0

    @cached_property
    def poles(self) -> Poles:
        """Poles of the loop, sorted by (real, imag)."""
        return sorted_poles(self.A)

    @cached_property
    def stable(self) -> bool:
        """Whether every pole is stable by more than rounding; only then are there variances."""
        return is_stable(self.A, dt=self.dt)

    @gated(T=matrix())
    def outputs(self, T: object | None = None) -> np.ndarray:
        """Rows for T y, k×(p+m); T k×p, by default I."""
        return self._rows(T, slice(0, self.measured))

    @gated(T=matrix())
    def inputs(self, T: object | None = None) -> np.ndarray:
        """Rows for T u, k×(p+m); T k×m, by default I."""
        return self._rows(T, slice(self.measured, len(self.C)))

    @gated(T=matrix())
    def watching(self, T: object) -> NoisyLoop:
        """The same loop with T x in place of y, k×n weights on the plant's states: for signals that no sensor reads."""
        T = as_matrix(T, "T")
        if T.shape[1] > len(self.A):
            raise ShapeError("T must have a column for each state of the plant; it has {columns}, and the loop "
                             "{count} states.",
                             columns=T.shape[1], count=len(self.A))
        zeros = np.zeros((len(T), len(self.A) - T.shape[1]))
        C = np.vstack([np.hstack([T, zeros]), self.C[self.measured:]])
        D = np.vstack([np.zeros((len(T), self.D.shape[1])), self.D[self.measured:]])
        return replace(self, C=C, D=D, measured=len(T))

    @gated(disturbances=number(0, 1e150), sensors=number(0, 1e150))
    def only(self, *, disturbances: float = 1.0, sensors: float = 1.0) -> NoisyLoop:
        """The same loop with the intensities of the disturbances and of the sensors' noise multiplied: 0 is without."""
        scale = np.ones(len(self.noise))
        scale[:self.disturbances], scale[self.disturbances:] = disturbances, sensors
        return replace(self, noise=self.noise * np.sqrt(np.outer(scale, scale)))

    @gated(frequency=SERIES, rows=optional(matrix()), ground=array())
    def psd(self, frequency: object, rows: object | None = None, *, ground: object | None = None) -> np.ndarray:
        """One-sided density S(f) = 2 Σ H(j2πf) N H(j2πf)ᴴ of each signal, (n_f, k), in units²/Hz.

        Its area over f from 0 is the variance (up to 1/(2 dt) where sampled). `frequency` in Hz; rows k×(p+m), by default
        all outputs. `ground`: one-sided densities of the disturbances in place of 2W, (n_f,) for all or (n_f, q).
        """
        return sum(self.parts(frequency, rows, ground=ground))  # type: ignore[return-value]

    @gated(frequency=SERIES, rows=optional(matrix()), ground=array())
    def parts(self, frequency: object, rows: object | None = None, *,
              ground: object | None = None) -> tuple[np.ndarray, np.ndarray]:
        """The density as (what the disturbances cause, what the sensors' noise causes), each (n_f, k)."""
        H = self.response(frequency, rows)
        q, two_sided = self.disturbances, 2 * (self.dt or 1.0)
        sensors = two_sided * _square(H[..., q:], self.noise[q:, q:])
        if ground is None:
            return two_sided * _square(H[..., :q], self.noise[:q, :q]), sensors
        shape = np.asarray(ground, dtype=float)
        shape = shape[:, None] if shape.ndim == 1 else shape
        if shape.shape not in ((len(H), 1), (len(H), q)) or not (np.isfinite(shape).all() and (shape >= 0).all()):
            raise ShapeError("The ground's density must be finite, not negative, and of shape ({count},) or "
                             "({count}, {q}).",
                             count=len(H), q=q)
        return np.einsum("fkj,fj->fk", np.abs(H[..., :q]) ** 2, np.broadcast_to(shape, (len(H), q))), sensors

    @gated(frequency=SERIES, rows=matrix())
    def response(self, frequency: object, rows: object | None = None) -> np.ndarray:
        """H from d = (w, v) to each signal, complex (n_f, k, q+p), `frequency` in Hz; not finite on a pole."""
        rows = self.outputs() if rows is None else self._fitting(rows)
        omega = 2 * np.pi * np.asarray(frequency, dtype=float).reshape(-1)
        points = np.exp(1j * omega * self.dt) if self.dt else 1j * omega
        C, D = rows @ self.C, rows @ self.D
        modal = None if self._modal is None else (self._modal[0], rows @ self._modal[1], self._modal[2])
        return response_at(modal, self.A, self.B, C, D, points)

    @cached_property
    def covariance(self) -> np.ndarray:
        """Σ of z, N×N: A Σ + Σ Aᵀ + B N Bᵀ = 0, or Σ = A Σ Aᵀ + B N Bᵀ. Raises EngineError for an unstable loop."""
        if not self.stable:
            raise EngineError("The loop is unstable: its variances grow without bound; stabilise it first.")
        return frozen(settled_covariance(self.A, self.B @ root(self.noise), dt=self.dt))

    @gated(rows=matrix())
    def variance(self, rows: object | None = None) -> np.ndarray:
        """Variance of each signal, (k,); ∞ where white noise passes straight through a continuous loop."""
        return np.maximum(np.diag(self.joint(rows)), 0.0)

    @gated(rows=matrix())
    def joint(self, rows: object | None = None) -> np.ndarray:
        """Covariance of the signals, k×k; ∞ on the diagonal where white noise passes straight through."""
        rows = self.outputs() if rows is None else self._fitting(rows)
        C, direct = rows @ self.C, rows @ self.D @ self.noise @ (rows @ self.D).T
        found = C @ self.covariance @ C.T
        if self.dt:
            return found + direct
        found[np.diag_indices(len(found))] += np.where(np.diag(direct) > 0, np.inf, 0.0)
        return found

    @gated(Q=matrix(), R=matrix())
    def cost(self, Q: object, R: object) -> tuple[float, float]:
        """(E xᵀQx, E uᵀRu) of the plant's state x (the first n of z) and the input: what a loop really costs.

        Q n×n, R m×m. The loop need not be the optimal one, nor the noise the one that it was designed for.
        """
        Q, R = as_matrix(Q, "Q"), as_matrix(R, "R")
        n, m = len(Q), len(self.C) - self.measured
        if Q.shape != (n, n) or n > len(self.A):
            raise ShapeError("Q must be square, with a row for each state of the plant; it is {rows}×{columns}.",
                             rows=Q.shape[0], columns=Q.shape[1])
        if R.shape != (m, m):
            raise ShapeError("R must be {m}×{m}; it is {rows}×{columns}.", m=m, rows=R.shape[0], columns=R.shape[1])
        u = self.joint(self.inputs())
        return float(np.sum(Q * self.covariance[:n, :n])), float(np.sum(R * u)) if np.isfinite(u).all() else np.inf

    @gated(dt=SECONDS)
    def sampled(self, dt: float) -> NoisyLoop:
        """The same loop seen every dt seconds: its densities are folded at 1/(2 dt), its variances stay.

        z⁺ = e^{A dt} z + jump with the exact covariance of the jump. Raises EngineError for a loop that is sampled
        already, or through which white noise passes straight.
        """
        if self.dt:
            raise EngineError("This loop is sampled already; use it as it is.")
        if np.any(self.D):
            raise EngineError("White noise passes straight through this loop; samples of it have no finite "
                              "variance.")
        N = len(self.A)
        jump = step_covariance(self.A, self.B @ self.noise @ self.B.T, dt)
        return NoisyLoop(step_matrices(self.A, dt)[0], np.eye(N), self.C, np.zeros((len(self.C), N)), jump, N,
                         self.measured, dt)

    @cached_property
    def _modal(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        return modal_coordinates(self.A, self.B, self.C)

    def _rows(self, T: object | None, part: slice) -> np.ndarray:
        width = part.stop - part.start
        T = np.eye(width) if T is None else as_matrix(T, "T")
        if T.shape[1] != width:
            raise ShapeError("T must have {width} columns, one for each signal; it has {columns}.",
                             width=width, columns=T.shape[1])
        rows = np.zeros((len(T), len(self.C)))
        rows[:, part] = T
        return rows

    def _fitting(self, rows: object) -> np.ndarray:
        rows = as_matrix(rows, "rows")
        if rows.shape[1] != len(self.C):
            raise ShapeError("Rows must have {count} columns, one for each output and input; they have {columns}.",
                             count=len(self.C), columns=rows.shape[1])
        return rows


@takes(plant=PLANT, controller=optional(PLANT), G=matrix("n q"), W=covariance("q"), V=covariance("p"))
def noisy_loop(plant: Plant, controller: Plant | None, G: object, W: object, *, V: object = 0.0) -> NoisyLoop:
    """The loop ẋ = A x + B u + G w, y = C x + D u with a controller u = Kc(s)(y + v), sign included; None: u = 0.

    G n×q, W q×q and V p×p intensities (a number is that number times I; covariances of a sample where plant and
    controller are sampled). Raises ShapeError, EngineError where the parts do not fit or the loop is ill-posed.

    >>> plant = Plant([[0]], [[1]], [[1]])
    >>> noisy_loop(plant, compensator(plant, [[1]], [[2]]), [[1]], [[1]], V=[[1]]).stable
    True
    """
    G = as_checked(G)
    n, m, p = plant.n, plant.m, plant.p
    noise = np.array(block_diag(as_covariance(W, "W", G.shape[1]), as_covariance(V, "V", p)))
    q, D = G.shape[1], np.asarray(plant.D)
    if controller is None:
        C = np.vstack([plant.C, np.zeros((m, n))])
        return NoisyLoop(plant.A, np.hstack([G, np.zeros((n, p))]), C, np.zeros((p + m, q + p)), noise, q, p, plant.dt)
    if (controller.m, controller.p) != (p, m):
        raise ShapeError("The controller must have {p} inputs and {m} outputs, the plant's turned around; it has "
                         "{m2} and {p2}.",
                         p=p, m=m, m2=controller.m, p2=controller.p)
    if controller.dt != plant.dt:
        raise EngineError("Plant and controller must both be continuous, or share one sampling period.")
    Dk = np.asarray(controller.D)
    well = np.eye(m) - Dk @ D
    if np.linalg.cond(well) > 1e12:
        raise EngineError("The loop is ill-posed: the direct paths of plant and controller form a loop of gain "
                          "one.")
    # u = E (Dk C x + Ck xk + Dk v), E = (I − Dk D)⁻¹; y = C x + D u; the controller reads y + v
    E = np.linalg.inv(well)
    u_z, u_v = E @ np.hstack([Dk @ plant.C, controller.C]), E @ Dk
    y_z, y_v = np.hstack([plant.C, np.zeros((p, controller.n))]) + D @ u_z, D @ u_v
    A = np.vstack([np.hstack([plant.A, np.zeros((n, controller.n))]) + plant.B @ u_z,
                   np.hstack([np.zeros((controller.n, n)), controller.A]) + controller.B @ y_z])
    B = np.block([[G, plant.B @ u_v], [np.zeros((controller.n, q)), controller.B @ (np.eye(p) + y_v)]])
    zero = np.zeros((p, q)), np.zeros((m, q))
    return NoisyLoop(A, B, np.vstack([y_z, u_z]), np.block([[zero[0], y_v], [zero[1], u_v]]), noise, q, p, plant.dt)


def _square(H: np.ndarray, N: np.ndarray) -> np.ndarray:
    """diag(H N Hᴴ) for each frequency, (n_f, k)."""
    if not N.size or not np.any(N):
        return np.zeros(H.shape[:2])
    if not np.any(N - np.diag(np.diag(N))):
        return np.abs(H) ** 2 @ np.diag(N)
    return np.maximum(np.einsum("fki,ij,fkj->fk", H, N, H.conj(), optimize=True).real, 0.0)
