"""Simulate and record a run, in one piece, or in two with a kick between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from observer_lab.engine import BilinearPlant, simulate_bilinear
from observer_lab.engine.observers import BilinearForm, BilinearRun

from .input_signals import Signal, columns


@dataclass(frozen=True, eq=False)
class Record:
    """t, u (n_t,) or of k inputs (n_t, k), x (n_t, n), g (n_t, …), estimates and errors ε = ĝ − g (n_t, 3, …) in the order of FORMS.

    heard (n_t, 3, …) is the part of the errors that the sensors' noise made. law (n_t, …): ε of the chosen form as its own
    equation has it from the start, or from the kick. fed (n_t, 2): the first row of L ẏ, true and as the differentiator gives it.
    """

    t: np.ndarray
    u: np.ndarray
    x: np.ndarray
    g: np.ndarray
    estimates: np.ndarray
    errors: np.ndarray
    heard: np.ndarray
    law: np.ndarray
    fed: np.ndarray


@dataclass(frozen=True, eq=False)
class Setting:
    """A plant beside the joined forms, rows K x of g for each, u(t), x(0) and z(0), the jump of a kick and its grid point, the grid."""

    plant: BilinearPlant
    form: BilinearForm
    rows: np.ndarray
    u: Signal
    x0: np.ndarray
    z0: np.ndarray
    jump: np.ndarray
    at: int | None
    last: int
    dt: float

    def pieces(self, noise: np.ndarray | None) -> list[BilinearRun]:
        """The run, cut where x jumps; a kick moves x, and through ẏ the exact form, never χ."""
        leap = self.form.R @ self.plant.C @ self.jump
        if self.at is None:
            return [self._piece(self.x0, self.z0, 0, self.last, noise)]
        if self.at == 0:
            return [self._piece(self.x0 + self.jump, self.z0 + leap, 0, self.last, noise)]
        before = self._piece(self.x0, self.z0, 0, self.at, noise)
        if before.diverged_at is not None:
            return [before]
        return [before, self._piece(before.x[-1] + self.jump, before.z[-1] + leap, self.at, self.last, noise)]

    def _piece(self, x: np.ndarray, z: np.ndarray, begin: int, end: int, noise: np.ndarray | None) -> BilinearRun:
        return simulate_bilinear(self.plant, self.form, self.rows, lambda t: self.u(t + begin * self.dt), x, z,
                                 horizon=(end - begin) * self.dt, dt=self.dt, noise=None if noise is None else noise[begin:end + 1])


def kicked_at(kick: float, dt: float, last: int) -> int | None:
    """The grid point of a kick, None where there is none."""
    return min(int(kick / dt + 1e-9), last - 1) if kick >= 0 else None


def whole(name: str, of: list[BilinearRun]) -> np.ndarray:
    """One signal of all pieces; the sample at the kick is the one just after it."""
    return end_to_end([getattr(p, name) for p in of])


def end_to_end(parts: list[np.ndarray]) -> np.ndarray:
    """Pieces that share a sample with the next one."""
    return np.concatenate([*(p[:-1] for p in parts[:-1]), parts[-1]])


def fed_of(plant: BilinearPlant, L: np.ndarray, pieces: list[BilinearRun], d: int, tau: float) -> np.ndarray:
    """L ẏ (n_t, 2) for one row L (m,), true and as the differentiator gives it, whose state is number d."""
    x, u, y, z = (whole(name, pieces) for name in ("x", "u", "y", "z"))
    rate = x @ plant.A.T + columns(u) @ plant.B.T
    for each, F in zip(columns(u).T, plant.parts, strict=True):
        rate += each[:, None] * (x @ F.T)
    return np.column_stack([rate @ plant.C.T @ L, (y @ L - z[:, d]) / tau])
