"""Draw a run's disturbances: the noise of its seed, and its impulses."""

from __future__ import annotations

import numpy as np

from ..systems.errors import EngineError
from ..systems.noise import process_noise, root
from ..systems.records import record
from ..systems.recursions import step_matrices
from .loop import Loop
from .scenario import Scenario

__all__ = ["Disturbances", "disturbances"]

Kicks = dict[int, list[tuple[float, np.ndarray]]]


@record()
class Disturbances:
    """Start and disturbances of z = (x, x̂).

    z0 (N,) with impulses at t = 0 in it; w (n_t, q) means over the steps; v (n_t, p) held over the steps;
    jumps (n_t − 1, N) of z at the ends of the steps, or None; kicks: step → (time into it, jump) between grid points.
    """

    z0: np.ndarray
    w: np.ndarray
    v: np.ndarray
    jumps: np.ndarray | None
    kicks: Kicks


def disturbances(s: Scenario, loop: Loop) -> Disturbances:
    """Draw the noise and place the impulses of a scenario with this loop."""
    for_w, for_v = np.random.default_rng(s.seed).spawn(2)
    v = np.zeros((s.n_t, s.plant.p))
    if s.V is not None:
        v = for_v.standard_normal(v.shape) @ root(s.V if s.plant.dt else s.V / s.dt).T
    w, jumps = _process(s, loop, for_w)
    z0, jumps, kicks = _impulses(s, len(loop.A), jumps)
    return Disturbances(z0, w, v, jumps, kicks)


def _process(s: Scenario, loop: Loop, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray | None]:
    """w and the jumps it makes. Observer and controller answer within the step only in a continuous loop."""
    if s.W is None or s.G is None:
        return np.zeros((s.n_t, 0 if s.G is None else s.G.shape[1])), None
    n, N, q = s.plant.n, len(loop.A), s.G.shape[1]
    if s.plant.dt:
        w = rng.standard_normal((s.n_t, q)) @ root(s.W).T
        jumps = w @ s.G.T
    elif s.discrete:
        w, jumps = process_noise(s.plant.A, s.G, s.W, s.dt, s.n_t, rng)
    else:
        enter = np.vstack([s.G, np.zeros((N - n, q))])
        w, jumps = process_noise(loop.closed(np.ones(s.plant.m, dtype=bool)), enter, s.W, s.dt, s.n_t, rng)
    wide = np.zeros((s.n_t - 1, N))
    wide[:, :jumps.shape[1]] = jumps[:-1]
    return w, wide


def _impulses(s: Scenario, N: int, jumps: np.ndarray | None) -> tuple[np.ndarray, np.ndarray | None, Kicks]:
    """Impulses on the grid join the start or the jumps, those between grid points become kicks.

    A sampled loop feels a kick at the next sample as e^{A (h − τ)} dx, whatever the held input.
    """
    z0, kicks, n = np.concatenate([s.x0, s.xhat0]), {}, s.plant.n
    for time, dx in sorted(s.impulses, key=lambda impulse: impulse[0]):
        steps = time / s.dt
        k = round(steps)
        if steps > s.n_t - 1 + 1e-9:
            continue
        dz = np.zeros(N)
        dz[:n] = dx
        if abs(steps - k) > 1e-9:
            k = int(steps)
            if s.plant.dt:
                raise EngineError("A sampled plant has no time between samples: give impulses at multiples of dt.")
            if not s.discrete:
                kicks.setdefault(k, []).append((time - k * s.dt, dz))
                continue
            k += 1
            dz[:n] = step_matrices(s.plant.A, k * s.dt - time)[0] @ dz[:n]
        if k == 0:
            z0 = z0 + dz
        else:
            jumps = np.zeros((s.n_t - 1, N)) if jumps is None else jumps
            jumps[k - 1] += dz
    return z0, jumps, kicks
