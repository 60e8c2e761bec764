"""Compute growth rates of an error and of a whole loop, a late input counted."""

from __future__ import annotations

import numpy as np

from observer_lab.engine.simulation import Run, Scenario

CHEBYSHEV_POINTS = 12  # of the history of a late loop
EDGE = 1e-9  # of the largest pole: nearer to the edge is on it


def observer_rate(run: Run) -> float:
    """The rightmost eigenvalue of A − LC of the model, ln |z| where it is sampled; 0 where it lies on the edge."""
    s = run.scenario
    model = s.plant if s.model is None else s.model
    return rate(model.A if s.L is None else model.A - s.L @ model.C, model.dt)


def loop_rate(run: Run) -> float:
    """The rightmost pole of plant and observer together, −∞ where there is no loop. A late sampled one is judged without its delay."""
    s = run.scenario
    plant = s.plant
    if s.K is None or s.L is None:
        return -np.inf
    now, late = _loop(s)
    return late_rate(now, late, s.delay) if s.delay and not plant.dt else rate(now + late, plant.dt)


def _loop(s: Scenario) -> tuple[np.ndarray, np.ndarray]:
    """ż = M z + M₁ z(t − τ) of z = (x, x̂): the plant's input is late, the observer's copy of it is not."""
    plant, model = s.plant, s.plant if s.model is None else s.model
    K, L, corner = s.K, s.L, np.zeros((model.n, plant.n))
    now = np.block([[plant.A, corner.T], [L @ plant.C, model.A - model.B @ K - L @ model.C + L @ model.D @ K]])
    late = np.block([[0 * plant.A, -plant.B @ K], [corner, -L @ plant.D @ K]])
    return now, late


def late_rate(now: np.ndarray, late: np.ndarray, delay: float) -> float:
    """The rightmost root of det(sI − M − M₁ e^{−sτ}) by collocation of the history at Chebyshev points.

    The interpolant of z over [t − τ, t] moves by its own slope, its value at t by the equation. Breda, Maset, Vermiglio, 2005.
    """
    n, N = len(now), CHEBYSHEV_POINTS
    x = np.cos(np.pi * np.arange(N + 1) / N)
    c = np.r_[2, np.ones(N - 1), 2] * (-1.0) ** np.arange(N + 1)
    gap = x[:, None] - x + np.eye(N + 1)
    D = np.outer(c, 1 / c) / gap
    D -= np.diag(D.sum(axis=1))
    M = np.kron(2 / delay * D, np.eye(n))
    M[:n] = 0
    M[:n, :n], M[:n, -n:] = now, late
    return rate(M, 0.0)


def rate(A: np.ndarray, dt: float) -> float:
    """The rightmost eigenvalue, ln |z| where it is sampled; 0 within rounding of the edge."""
    poles = np.linalg.eigvals(A)
    if dt:
        found = float(np.log(max(np.max(np.abs(poles)), 1e-300)))
        return 0.0 if abs(found) < EDGE else found
    found = float(np.max(np.real(poles)))
    return 0.0 if abs(found) < EDGE * max(float(np.max(np.abs(poles))), 1e-300) else found
