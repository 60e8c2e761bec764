"""Filters and margins against plain textbook loops and python-control: `python tests/benchmarks/bench_filters.py`.

Ten states, four sensors. Gates: Kalman with a changing gain on a par with the textbook loop (≥ 0.8×), ≥ 200× once it
has settled; an unscented step ≥ 5× one point at a time.
"""

# ruff: noqa: E402 — the thread limits must be set before numpy is imported
from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import control
import numpy as np
from stopwatch import median, row

from app.engine import (
    Belief,
    ExtendedKalmanFilter,
    KalmanFilter,
    Plant,
    SquareRootFilter,
    UnscentedKalmanFilter,
    compensator,
    loop_margins,
    lqe,
    lqr,
)
from app.plants import platform

STEPS = 10_000


def textbook(filter_: KalmanFilter, start: Belief, y: np.ndarray) -> np.ndarray:
    """Predict and update one step after another, Joseph's form, nothing saved."""
    A, C, Q, R = filter_.A, filter_.C, filter_.Q, filter_.R
    x, P, one, means = start.mean, start.covariance, np.eye(len(A)), []
    for measured in y:
        S = C @ P @ C.T + R
        M = P @ C.T @ np.linalg.inv(S)
        x = x + M @ (measured - C @ x)
        P = (one - M @ C) @ P @ (one - M @ C).T + M @ R @ M.T
        means.append(x)
        x, P = A @ x, A @ P @ A.T + Q
    return np.array(means)


def textbook_unscented(A: np.ndarray, C: np.ndarray, P: np.ndarray, y: np.ndarray) -> np.ndarray:
    """One unscented step, every sigma point on its own."""
    n = len(A)
    weight = np.full(2 * n + 1, 0.5 / n)
    weight[0] = 0.0

    def spread(mean: np.ndarray, P: np.ndarray) -> list[np.ndarray]:
        root = np.linalg.cholesky(n * P)
        return [mean] + [mean + root[:, i] for i in range(n)] + [mean - root[:, i] for i in range(n)]

    points = [A @ point for point in spread(np.zeros(n), P)]
    mean = sum(w * point for w, point in zip(weight, points, strict=True))
    P = sum(w * np.outer(p - mean, p - mean) for w, p in zip(weight, points, strict=True)) + np.eye(n)
    points = spread(mean, P)
    seen = [C @ point for point in points]
    expected = sum(w * z for w, z in zip(weight, seen, strict=True))
    S = sum(w * np.outer(z - expected, z - expected) for w, z in zip(weight, seen, strict=True)) + np.eye(len(C))
    across = sum(w * np.outer(p - mean, z - expected) for w, p, z in zip(weight, points, seen, strict=True))
    return mean + across @ np.linalg.solve(S, y - expected)


def filters() -> None:
    plant = platform.plant()
    plain, roots = (kind.from_plant(plant, 1e-12, 1e-12, dt=1e-3, G=plant.B[:, 3:]) for kind in (KalmanFilter, SquareRootFilter))
    y = 1e-6 * np.random.default_rng(0).standard_normal((STEPS, 4))
    start, settled = Belief(np.zeros(10), 1e-6 * np.eye(10)), Belief(np.zeros(10), plain.steady.solution)
    loop = median(lambda: textbook(plain, start, y))
    row("textbook loop, 10 000 steps", loop)
    row("KalmanFilter.run, gain changing", median(lambda: plain.run(start, y)), loop, 0.8)
    row("SquareRootFilter.run, gain changing", median(lambda: roots.run(start, y)), loop)
    row("KalmanFilter.run, settled", median(lambda: plain.run(settled, y)), loop, 200)


def unscented() -> None:
    A, C, y = 0.9 * np.eye(10), np.eye(4, 10), np.zeros(4)
    arguments = (lambda x, u: A @ x, lambda x, u: C @ x, np.eye(10), np.eye(4))
    start = Belief(np.zeros(10), np.eye(10))
    single = median(lambda: textbook_unscented(A, C, np.eye(10), y), 0.3)
    row("textbook unscented step, point by point", single)
    for kind, gate in ((UnscentedKalmanFilter, 5), (ExtendedKalmanFilter, None)):
        filter_ = kind(*arguments)
        row(f"{kind.__name__} step", median(lambda f=filter_: f.update(f.predict(start), y), 0.3), single, gate)


def margins() -> None:
    whole = platform.plant()
    plant = Plant(whole.A, whole.B[:, :3], whole.C)
    K = lqr(plant.A, plant.B, 1e10 * plant.C.T @ plant.C, 0.1 * np.eye(3)).gain
    L = lqe(plant.A, whole.B[:, 3:], plant.C, 1e-12 * np.eye(2), 1e-9 * np.eye(4)).gain
    built = compensator(plant, K, L)
    row("loop_margins, each input", median(lambda: loop_margins(plant, built).inputs, 0.5))
    row("loop_margins, all inputs", median(lambda: loop_margins(plant, built).all_inputs, 0.5))
    row("loop_margins, inputs and outputs at once", median(lambda: loop_margins(plant, built).both, 0.5))
    one = Plant(whole.A, whole.B[:, :1], whole.C[:1])
    K = lqr(one.A, one.B, 1e10 * one.C.T @ one.C, 0.1).gain
    built = compensator(one, K, lqe(one.A, one.B, one.C, 1e-6, 1e-9).gain)
    loop = -control.ss(built.A, built.B, built.C, 0) * control.ss(one.A, one.B, one.C, 0)
    omega = loop_margins(one, built).loop.omega[1:-1]

    def peer() -> None:
        control.disk_margins(loop, omega)
        control.stability_margins(loop)

    against = median(peer, 0.5)
    row("control.disk_margins + stability_margins, one loop", against)
    row("loop_margins, the same loop", median(lambda: loop_margins(one, built).inputs, 0.5), against)


if __name__ == "__main__":
    filters()
    unscented()
    margins()
