"""Simulate a bilinear plant beside its functional observer under any input."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..systems.arrays import as_checked
from ..systems.errors import EngineError, ShapeError
from ..systems.gates.argument_checks import FUNCTION, SECONDS, instance, matrix, optional, takes
from ..systems.plant import as_matrix
from ..systems.records import record
from .bilinear import BilinearForm, BilinearPlant

__all__ = ["BilinearRun", "simulate_bilinear"]

ROOT15 = np.sqrt(15.0)
GAUSS_NODES = np.array([0.5 - ROOT15 / 10, 0.5, 0.5 + ROOT15 / 10])
STAGES = np.array([[5 / 36, 2 / 9 - ROOT15 / 15, 5 / 36 - ROOT15 / 30],
                   [5 / 36 + ROOT15 / 24, 2 / 9, 5 / 36 - ROOT15 / 24],
                   [5 / 36 + ROOT15 / 30, 2 / 9 + ROOT15 / 15, 5 / 36]])
GAUSS_WEIGHTS = np.array([5 / 18, 4 / 9, 5 / 18])
MAX_STEPS = 200_000
CHUNK_STEPS = 2048
DIVERGENCE_LIMIT = 1e12


@record()
class BilinearRun:
    """Time-first: t (n_t,), u (n_t,) or of k inputs (n_t, k), x (n_t, n), z (n_t, q), y (n_t, m), g, estimate and error (n_t, r).

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


@takes(plant=instance(BilinearPlant), form=instance(BilinearForm), K=matrix(), u=FUNCTION, x0=matrix(), z0=matrix(),
       horizon=SECONDS, dt=SECONDS, noise=optional(matrix()))
def simulate_bilinear(
    plant: BilinearPlant, form: BilinearForm, K: np.ndarray, u: Callable[[np.ndarray], Any], x0: object, z0: object,
    *, horizon: float = 1.0, dt: float = 0.002, noise: object = None
) -> BilinearRun:
    """ẋ = A x + B u + Σ uⱼ Fⱼ x beside ż = A_z z + Y y + B_z u + Σ uⱼ Uⱼ y + R ẏ, by Gauss's method of order 6 on the grid.

    `u` maps an array of times to as many numbers, of k > 1 inputs to k along one more axis. For a given u(t) the pair is linear
    in (x, z, 1), so all steps are computed at once and then chained; the method keeps every linear relation that the exact
    flow keeps, hence the decay of the error also where u jumps. x0 (n,), z0 (q,); horizon and dt in s. `noise` (n_t, m) is what the
    sensors add to C x, held over each step; ẏ in R ẏ stays the true one. Raises ShapeError for starts or noise of the wrong length,
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
    K = as_checked(K)
    if K.shape[1] != plant.n:
        raise ShapeError("K must have {n} columns, one for each state; it has {columns}.",
                         n=plant.n, columns=K.shape[1])
    if not (dt <= horizon and horizon / dt <= MAX_STEPS):
        raise EngineError("The horizon must be positive and hold between 1 and {most_steps} steps dt.",
                          most_steps=MAX_STEPS)
    t = np.arange(round(horizon / dt) + 1) * dt
    heard = _noise(noise, t.size, plant.m)
    still = x0.size + z0.size
    states = np.empty((t.size, still + 1 + heard.shape[1]))
    states[:, still], states[:, still + 1:] = 1.0, heard
    states[0, :still] = np.concatenate([x0, z0])
    for begin in range(0, t.size - 1, CHUNK_STEPS):
        steps = _steps(plant, form, _input(u, t[begin:begin + CHUNK_STEPS + 1][:-1, None] + GAUSS_NODES * dt, plant.inputs), dt,
                       bool(heard.size))
        with np.errstate(over="ignore", invalid="ignore"):
            for k, step in enumerate(steps, start=begin):
                np.dot(step, states[k], out=states[k + 1, :still])
            fine = np.abs(states[begin + 1:begin + 1 + len(steps), :still]).max(axis=1) < DIVERGENCE_LIMIT
        if not fine.all():
            count = begin + 1 + int(np.argmin(fine))
            return _record(plant, form, K, u, t[:count], states[:count], float(t[count]))
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
    inputs = _input(u, t, plant.inputs)
    return BilinearRun(t, inputs if plant.inputs > 1 else inputs[:, 0], x, z, y, g, estimate, estimate - g, diverged_at)


def _input(u: Callable[[np.ndarray], Any], t: np.ndarray, count: int) -> np.ndarray:
    """u at these times, the inputs along a last axis."""
    try:
        found = np.asarray(u(t), dtype=float)
        values = np.array(np.broadcast_to(found[..., None] if count == 1 else found, (*t.shape, count)))
    except ValueError as problem:
        if count > 1:
            raise ShapeError("u(t) must give {count} numbers, one for each input, for every time that it is given.",
                             count=count) from problem
        raise ShapeError("u(t) must give as many numbers as it is given times.") from problem
    if not np.isfinite(values).all():
        raise EngineError("The input u(t) must be a finite number at all times of the run.")
    return values


def _steps(plant: BilinearPlant, form: BilinearForm, u: np.ndarray, h: float, noisy: bool) -> np.ndarray:
    """Matrices (steps, n + q, n + q + 1 + m) of Gauss's three-stage method that lead (x, z, 1, v) to (x, z) one step later, for inputs
    at the nodes u (steps, 3, k); ẏ = C ẋ enters through R, the noise v as y does, if there is any.

    x hears neither observer nor noise, so its stages are found without them, and no rounding of theirs reaches it. z hears itself
    through a constant matrix: what its three stages make of what drives them is the same in every step.
    """
    n, q, m, nodes = plant.n, len(form.A), plant.m if noisy else 0, u.shape[:2]
    RC, parts = form.R @ plant.C, np.hsplit(form.U, plant.inputs)
    drift, heard = np.zeros((*nodes, n, n + 1)), np.zeros((*nodes, q, plant.m))
    drift[..., :n], heard[:] = plant.A, form.Y
    driven = np.zeros((*nodes, q, 1))
    for j, (F, U) in enumerate(zip(plant.parts, parts, strict=True)):
        at = u[:, :, j, None, None]
        drift += at * np.hstack([F, plant.B[:, j:j + 1]])
        heard += at * U
        driven += at * form.B[:, j:j + 1]
    k, inner = _stages(drift, h)
    pushes = heard @ (plant.C @ inner) + RC @ drift[..., :n] @ inner
    pushes[..., n:] += driven + RC @ drift[..., n:]
    way = h * np.linalg.solve((np.eye(3 * q) - h * np.kron(STAGES, form.A)).T, np.kron(GAUSS_WEIGHTS[:, None], np.eye(q))).T
    steps = np.zeros((len(u), n + q, n + q + 1 + m))
    whole = np.eye(n, n + 1) + h * (GAUSS_WEIGHTS @ k.reshape(len(u), 3, -1)).reshape(-1, n, n + 1)
    pushed = way @ pushes.reshape(-1, 3 * q, n + 1)
    for rows, part in ((slice(0, n), whole), (slice(n, None), pushed)):
        steps[:, rows, :n], steps[:, rows, n + q:n + q + 1] = part[..., :n], part[..., n:]
    steps[:, n:, n:n + q] = np.eye(q) + way @ np.tile(form.A, (3, 1))
    if noisy:
        steps[:, n:, n + q + 1:] = way @ heard.reshape(-1, 3 * q, m)
    return steps


def _stages(drift: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """The slopes of x at the three stages as maps of (x, 1), (steps, 3, n, n + 1), and x there, for ẋ = drift (x, 1)."""
    steps, _, n, _ = drift.shape
    system = (-h * STAGES[:, None, :, None] * drift[:, :, :, None, :n]).reshape(steps, 3 * n, 3 * n)
    system[:, np.arange(3 * n), np.arange(3 * n)] += 1.0
    k = np.linalg.solve(system, drift.reshape(steps, 3 * n, n + 1)).reshape(steps, 3, -1)
    return k.reshape(drift.shape), np.eye(n, n + 1) + h * (STAGES @ k).reshape(drift.shape)
