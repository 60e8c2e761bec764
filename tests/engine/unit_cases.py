"""Random plants with all that the laws of units ask of them, in the plant's own units and in others."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from observer_lab.engine import Plant
from observer_lab.engine.systems import discretise


@dataclass(frozen=True, eq=False)
class Units:
    """Diagonals of X (n,), U (m,), Y (p,), E (q,) and τ; of a plant in its own units they are ones."""

    X: np.ndarray
    U: np.ndarray
    Y: np.ndarray
    E: np.ndarray
    tau: float = 1.0


@dataclass(frozen=True, eq=False)
class Case:
    """A plant, the entry G of its noise, weights, intensities, and poles to ask for."""

    plant: Plant
    G: np.ndarray
    Q: np.ndarray
    R: np.ndarray
    W: np.ndarray
    V: np.ndarray
    slow: np.ndarray  # n poles of a controller
    quick: np.ndarray  # n poles of an observer
    horizon: float

    def to(self, z: Units) -> Case:
        """The same in other units."""
        p, rate = self.plant, 1.0 if self.plant.dt else z.tau
        plant = Plant(rate * p.A * z.X / z.X[:, None], rate * p.B * z.U / z.X[:, None], p.C * z.X / z.Y[:, None],
                      np.asarray(p.D) * z.U / z.Y[:, None], p.dt / z.tau)
        return replace(self, plant=plant, G=rate * self.G * z.E / z.X[:, None], Q=self.Q * np.outer(z.X, z.X),
                       R=self.R * np.outer(z.U, z.U), W=self.W / np.outer(z.E, z.E) / rate, V=self.V / np.outer(z.Y, z.Y) / rate,
                       slow=self.slow * rate, quick=self.quick * rate, horizon=self.horizon / z.tau)


def ones(case: Case) -> Units:
    """The plant's own units."""
    p = case.plant
    return Units(np.ones(p.n), np.ones(p.m), np.ones(p.p), np.ones(case.G.shape[1]))


def random_units(case: Case, rng: np.random.Generator, decades: float = 6.0) -> Units:
    """Units up to 10^±decades away, each by itself."""
    def draw(k: int) -> np.ndarray:
        return 10 ** rng.uniform(-decades, decades, k)
    p = case.plant
    tau = 1.0 if p.dt else float(10 ** rng.uniform(-3, 3))
    return Units(draw(p.n), draw(p.m), draw(p.p), draw(case.G.shape[1]), tau)


def _poles(rng: np.random.Generator, n: int, low: float, high: float) -> np.ndarray:
    pairs = int(rng.integers(0, n // 2 + 1))
    size = 10 ** rng.uniform(np.log10(low), np.log10(high), pairs)
    angle = rng.uniform(0.1, 1.3, pairs)
    upper = -size * np.cos(angle) + 1j * size * np.sin(angle)
    real = -10 ** rng.uniform(np.log10(low), np.log10(high), n - 2 * pairs)
    return np.concatenate([real, upper, upper.conj()]).astype(complex)


def _blocks(poles: np.ndarray) -> np.ndarray:
    M = np.diag(poles.real)
    upper = np.flatnonzero(poles.imag > 0)
    for i, j in zip(upper, upper + len(upper), strict=True):
        M[i, j], M[j, i] = poles[i].imag, -poles[i].imag
    return M


def random_case(rng: np.random.Generator, sampled: bool = False) -> Case:
    """A plant of 2 … 10 states: modes in turned coordinates, a cascade, coupled oscillators, or modes side by side."""
    n = int(rng.integers(2, 11))
    m, p, q = (int(rng.integers(1, min(n, 3) + 1)) for _ in range(3))
    kind = rng.integers(4)
    poles = _poles(rng, n, 0.3, 10.0)
    if rng.random() < 0.3:
        real = np.flatnonzero(poles.imag == 0)
        poles[real[:1]] *= -0.3
    A = _blocks(poles)
    if kind == 0:  # turned
        T = np.linalg.qr(rng.standard_normal((n, n)))[0] * 10 ** rng.uniform(-0.3, 0.3, n)
        A = np.linalg.solve(T, A @ T)
    elif kind == 1:  # a cascade: each part drives the next
        A = A + np.where(np.eye(n, k=-1) > 0, rng.uniform(0.5, 2, (n, n)), 0) * (np.abs(A) == 0)
    elif kind == 2:  # coupled
        A = A + 0.3 * rng.standard_normal((n, n)) * (rng.random((n, n)) < 0.4)
    B, C, G = rng.standard_normal((n, m)), rng.standard_normal((p, n)), rng.standard_normal((n, q))
    if kind == 1:
        B, C, G = B * (np.arange(n)[:, None] < 2), C * (np.arange(n) >= n - 2), G * (np.arange(n)[:, None] < 2)
        B[0], C[:, -1], G[0] = 1 + np.abs(B[0]), 1 + np.abs(C[:, -1]), 1 + np.abs(G[0])
    D = rng.standard_normal((p, m)) if rng.random() < 0.2 else np.zeros((p, m))
    slow, quick = _poles(rng, n, 1.0, 4.0), _poles(rng, n, 3.0, 12.0)
    dt = 0.0
    if sampled:
        dt = 0.1
        plant = discretise(Plant(A, B, C, D), dt)
        A, B = plant.A, plant.B
        slow, quick = np.exp(slow * dt), np.exp(quick * dt)
    Q, R = np.diag(rng.uniform(0.5, 2, n)), np.diag(rng.uniform(0.5, 2, m))
    W, V = np.diag(rng.uniform(0.5, 2, q)), np.diag(rng.uniform(0.5, 2, p))
    return Case(Plant(A, B, C, D, dt), G, Q, R, W, V, slow, quick, 3.0)
