"""Decide how a limited run ends: at rest for certain, past all return for certain, or open."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import matrix_balance, solve_continuous_lyapunov

from observer_lab.engine import Scenario, simulate
from observer_lab.engine.simulation import Run

from ..toolkit.loop_rates import rate

LONGEST = 60.0  # horizons for which an open run is followed at most
FAR = 1e3  # of its largest size so far: a run that gets there is lost
AT_REST = 1e-9  # of its largest size so far: a run that gets there recovers
MAP_HORIZONS = 20.0  # at most, for the runs of a map
SETTLED = 7.0  # time constants of the slowest pole after which what decays is at rest
COARSER = 4  # the run after its horizon has steps so many times longer; it is exact at every step


@dataclass(frozen=True)
class Ending:
    """Whether a run comes to rest, and until when in s it was followed; `unstable`: its loop has a pole beyond the edge."""

    home: bool
    decided: bool
    until: float
    unstable: bool


@dataclass(frozen=True, eq=False)
class Proofs:
    """What proves that a state z = (x, x̂), or x alone, comes to rest or does not.

    At rest: V(z) = zᵀPz falls along the linear loop, and on V ≤ `level` no input reaches its limit. Lost: along the left
    eigenvector q of an eigenvalue λ to the right, d|q·x|/dt ≥ Re λ |q·x| − Σ |q·b| u_max, which cannot change sign beyond `edge`.
    """

    P: np.ndarray | None
    level: float
    modes: np.ndarray
    edge: np.ndarray
    unstable: bool
    gain: np.ndarray
    limit: np.ndarray

    def rests(self, z: np.ndarray) -> bool:
        """Whether no limit acts any more and the loop decays."""
        return self.P is not None and bool(z @ self.P @ z < self.level)

    def free(self, z: np.ndarray) -> bool:
        """Whether no input is at its limit: a small limit can hold a state close to rest for ever."""
        return bool(np.all(np.abs(self.gain @ z) <= self.limit))

    def lost(self, x: np.ndarray) -> bool:
        """Whether no input within the limits can bring x back."""
        return bool(np.any(np.abs(self.modes @ x) > self.edge * (1 + 1e-9) + 1e-12 * float(np.abs(x).max())))


def proofs_of(s: Scenario) -> Proofs:
    """The proofs of a scenario without disturbance. s is continuous."""
    A, B, C, n = s.plant.A, s.plant.B, s.plant.C, s.plant.n
    K, L = s.K, s.L
    if s.state_feedback:
        M, gain = A - B @ K, K
    else:
        M = np.block([[A, -B @ K], [L @ C, A - B @ K - L @ C]])
        gain = np.hstack([np.zeros((len(K), n)), K])
    limit = np.minimum(-s.u_min, s.u_max)
    unstable, P, level = rate(M, 0.0) >= 0, None, 0.0
    if not unstable:
        balanced, (scale, _) = matrix_balance(M, permute=False, separate=True)
        Q = solve_continuous_lyapunov(balanced.T, -np.eye(len(M)))
        if np.all(np.isfinite(Q)) and float(np.linalg.eigvalsh((Q + Q.T) / 2).min()) > 0:
            P = Q / np.outer(scale, scale)
            reach = np.einsum("ij,ij->i", gain * scale, np.linalg.solve(Q, (gain * scale).T).T)
            level = float(np.min(np.divide(limit**2, reach, out=np.full(len(limit), np.inf), where=reach > 0)))
    values, left = np.linalg.eig(A.T)
    right = np.real(values) > 1e-9 * max(float(np.abs(values).max()), 1e-300)
    modes = left.T[right]
    return Proofs(P, level, modes, np.abs(modes @ B) @ limit / np.real(values[right]), unstable, gain, limit)


def ending_of(run: Run) -> Ending:
    """How a run ends, followed beyond its horizon while that is open. Raises nothing."""
    s, proofs = run.scenario, proofs_of(run.scenario)
    size, until = float(np.abs(run.x).max()), float(run.t[-1])
    x, estimate, early = run.x[-1], run.xhat[-1], run.diverged_at is not None and not s.state_feedback
    while True:
        z = x if s.state_feedback else np.concatenate([x, estimate])
        home = proofs.rests(z) or (float(np.abs(z).max()) <= AT_REST * size and proofs.free(z))
        lost = proofs.lost(x) or early or float(np.abs(x).max()) > FAR * size
        if home or lost or until >= LONGEST * s.horizon:
            still = proofs.unstable and (float(np.abs(x).max()) > AT_REST * size or not proofs.free(z))
            return Ending(home and not lost, home or lost or still, until, proofs.unstable)
        dt = COARSER * s.dt
        longer = simulate(replace(s, x0=x, xhat0=x if s.state_feedback else estimate, impulses=(), dt=dt,
                                  horizon=dt * round(max(until, s.horizon) / dt)))
        x, estimate, early = longer.x[-1], longer.xhat[-1], longer.diverged_at is not None and not s.state_feedback
        until += max(float(longer.t[-1]), 0.1 * s.horizon)


def map_span(horizon: float, A: np.ndarray, B: np.ndarray, C: np.ndarray, K: np.ndarray, L: np.ndarray) -> float:
    """How long every start of a map is run: its horizon, and then until the slowest pole has settled, in whole horizons."""
    slowest = min(-rate(M, 0.0) for M in (A - B @ K, A - L @ C))
    return horizon * min(np.ceil(1 + SETTLED / max(slowest * horizon, 1e-9)), MAP_HORIZONS)
