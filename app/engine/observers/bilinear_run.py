"""Run a bilinear plant beside its functional observer under any input."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..systems.errors import EngineError, ShapeError
from ..systems.plant import as_matrix
from .bilinear import BilinearForm, BilinearPlant

__all__ = ["BilinearRun", "simulate_bilinear"]

ROOT15 = np.sqrt(15.0)
NODES = np.array([0.5 - ROOT15 / 10, 0.5, 0.5 + ROOT15 / 10])
STAGES = np.array([[5 / 36, 2 / 9 - ROOT15 / 15, 5 / 36 - ROOT15 / 30],
                   [5 / 36 + ROOT15 / 24, 2 / 9, 5 / 36 - ROOT15 / 24],
                   [5 / 36 + ROOT15 / 30, 2 / 9 + ROOT15 / 15, 5 / 36]])
WEIGHTS = np.array([5 / 18, 4 / 9, 5 / 18])
MOST_STEPS = 200_000
CHUNK = 2048
DIVERGED = 1e12


@dataclass(frozen=True, eq=False)
class BilinearRun:
    """Time-first: t (n_t,), u (n_t,), x (n_t, n), z (n_t, q), y (n_t, m), g, estimate and error (n_t, r).

    error = estimate − g = ĝ − g, the sign of the source. y is what the sensors say, noise and all. `diverged_at`: where the
    run was cut off, or None.
    """

    t: np.ndarray
    u: np.ndarray
    x: np.ndarray
    z: np.ndarray
    y: np.ndarray
    g: np.ndarray
    estimate: np.ndarray
    error: np.ndarray
    diverged_at: float | None


def simulate_bilinear(
    plant: BilinearPlant, form: BilinearForm, K: np.ndarray, u: Callable[[np.ndarray], Any], x0: object, z0: object,
    *, horizon: float = 1.0, dt: float = 0.002, noise: object = None
) -> BilinearRun:
    """ẋ = A x + B u + u F x beside ż = A_z z + Y y + B_z u + u U y + R ẏ, by Gauss's method of order 6 on the grid.

    `u` maps an array of times to as many numbers. For a given u(t) the pair is linear in (x, z, 1), so all steps are
    computed at once and then chained; the method keeps every linear relation that the exact flow keeps, hence the
    decay of the error also where u jumps. x0 (n,), z0 (q,); horizon and dt in s. `noise` (n_t, m) is what the sensors add to
    C x, held over each step; ẏ in R ẏ stays the true one. Raises ShapeError for starts or noise of the wrong length,
    EngineError for a grid or an input that is not finite or has too many steps.

    >>> A, F = [[-1, 1], [0, -2]], [[0.1, 0], [0, 0]]
    >>> found = bilinear_functional_observer(A, [[0], [1]], F, [[1, 0]], [[0, 1]], -5)
    >>> run = simulate_bilinear(found.plant, found.without_derivative, found.K, np.sin, [1, 1], [0.0], horizon=3.0)
    >>> run.x.shape
    (1501, 2)
    """
    x0, z0 = (as_matrix(v, name).ravel() for v, name in ((x0, "x0"), (z0, "z0")))
    if x0.size != plant.n or z0.size != form.A.shape[0]:
        raise ShapeError("x0 must have {n} entries and z0 {rows}; they have {x0_size} and {z0_size}.",
                         n=plant.n, rows=form.A.shape[0], x0_size=x0.size, z0_size=z0.size)
    K = as_matrix(K, "K")
    if K.shape[1] != plant.n:
        raise ShapeError("K must have {n} columns, one for each state; it has {columns}.",
                         n=plant.n, columns=K.shape[1])
    if not (np.isfinite(horizon) and np.isfinite(dt) and 0 < dt <= horizon and horizon / dt <= MOST_STEPS):
        raise EngineError("The horizon must be positive and hold between 1 and {most_steps} steps dt.",
                          most_steps=MOST_STEPS)
    t = np.arange(round(horizon / dt) + 1) * dt
    heard = _noise(noise, t.size, plant.m)
    n, still = x0.size, x0.size + z0.size
    states = np.empty((t.size, still + 1 + heard.shape[1]))
    states[:, still + 1:] = heard
    states[0, :still + 1] = np.concatenate([x0, z0, [1.0]])
    constant, slope = _joint(plant, form, bool(heard.size))
    count = 1
    for begin in range(0, t.size - 1, CHUNK):
        steps = _steps(constant, slope, _input(u, t[begin:begin + CHUNK + 1][:-1, None] + NODES * dt), dt)
        steps[:, :n, n:still] = steps[:, :n, still + 1:] = 0.0  # x hears neither observer nor noise: no rounding of them may reach it
        for step in steps:
            z = step[:still + 1] @ states[count - 1]
            if not np.abs(z).max() < DIVERGED:
                return _record(plant, form, K, u, t[:count], states[:count], float(t[count]))
            states[count, :still + 1] = z
            count += 1
    return _record(plant, form, K, u, t, states, None)


def _noise(noise: object, count: int, outputs: int) -> np.ndarray:
    """The noise (count, m), of no columns where there is none."""
    if noise is None:
        return np.zeros((count, 0))
    heard = as_matrix(noise, "noise")
    if heard.shape != (count, outputs):
        raise ShapeError("noise must be {count}×{outputs}, a row for each time; it is {rows}×{columns}.",
                         count=count, outputs=outputs, rows=heard.shape[0], columns=heard.shape[1])
    return heard


def _record(plant: BilinearPlant, form: BilinearForm, K: np.ndarray, u: Callable[[np.ndarray], Any], t: np.ndarray,
            states: np.ndarray, diverged_at: float | None) -> BilinearRun:
    q = form.A.shape[0]
    x, z, heard = states[:, :plant.n], states[:, plant.n:plant.n + q], states[:, plant.n + q + 1:]
    y, g = x @ plant.C.T, x @ K.T
    y = y + heard if heard.size else y
    estimate = y @ form.G_y.T + z @ form.G_z.T
    return BilinearRun(t, _input(u, t), x, z, y, g, estimate, estimate - g, diverged_at)


def _input(u: Callable[[np.ndarray], Any], t: np.ndarray) -> np.ndarray:
    try:
        values = np.array(np.broadcast_to(np.asarray(u(t), dtype=float), t.shape))
    except ValueError as problem:
        raise ShapeError("u(t) must give as many numbers as it is given times.") from problem
    if not np.isfinite(values).all():
        raise EngineError("The input u(t) must be a finite number at all times of the run.")
    return values


def _joint(plant: BilinearPlant, form: BilinearForm, noisy: bool) -> tuple[np.ndarray, np.ndarray]:
    """d/dt (x, z, 1, v) = (constant + u slope)(x, z, 1, v); ẏ = C ẋ enters through R, the noise v as y does, if there is any."""
    n, q, m = plant.n, form.A.shape[0], plant.m if noisy else 0
    seen, one, heard = slice(n, n + q), slice(n + q, n + q + 1), slice(n + q + 1, n + q + 1 + m)
    constant, slope = np.zeros((n + q + 1 + m, n + q + 1 + m)), np.zeros((n + q + 1 + m, n + q + 1 + m))
    constant[:n, :n], slope[:n, :n], slope[:n, one] = plant.A, plant.F, plant.B
    RC = form.R @ plant.C
    constant[seen, :n], constant[seen, seen] = form.Y @ plant.C + RC @ plant.A, form.A
    slope[seen, :n], slope[seen, one] = form.U @ plant.C + RC @ plant.F, form.B + RC @ plant.B
    if noisy:
        constant[seen, heard], slope[seen, heard] = form.Y, form.U
    return constant, slope


def _steps(constant: np.ndarray, slope: np.ndarray, u: np.ndarray, h: float) -> np.ndarray:
    """Step matrices (steps, N, N) of Gauss's three-stage method for inputs at the nodes u (steps, 3)."""
    steps, N = len(u), len(constant)
    M = constant + u[:, :, None, None] * slope
    system = np.zeros((steps, 3, N, 3, N))
    for i in range(3):
        for j in range(3):
            system[:, i, :, j, :] = -h * STAGES[i, j] * M[:, i]
        system[:, i, :, i, :] += np.eye(N)
    k = np.linalg.solve(system.reshape(steps, 3 * N, 3 * N), M.reshape(steps, 3 * N, N)).reshape(steps, 3, N, N)
    return np.eye(N) + h * np.einsum("i,sijk->sjk", WEIGHTS, k)
