"""Filters of many runs at once beside the same filters run by run: `python tests/benchmarks/bench_many_filters.py`.

The deck on hardening springs, 200 runs of 100 samples. The peer is a plain loop over runs, samples and sigma points, as a
textbook or a filtering package has it. Gates: unscented ≥ 50×, extended ≥ 15×.
"""

# ruff: noqa: E402 — the thread limits must be set before numpy is imported
from __future__ import annotations

import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from app.engine import ExtendedKalmanFilter, UnscentedKalmanFilter
from app.engine.filters import Beliefs, Experiment, simulate_filters
from app.plants import nonlinear_platform

RUNS, STEPS, FEW = 200, 100, 4
PLANT = nonlinear_platform.plant()
FLOW = PLANT.flow(0.025)
Q, R = np.diag([1e-9, 1e-9, 1e-8, 1e-8, 1e-8, 1e-5]), 1e-6 * np.eye(4)
P0 = np.diag([1.5e-3, 2e-3, 9e-3, 1e-2, 1.4e-2, 7e-2])**2
NO_FORCE = np.zeros((3, 1))


def f(x: np.ndarray) -> np.ndarray:
    """One state (6,) one step on."""
    return FLOW(x[:, None], NO_FORCE)[:, 0]


def unscented(y: np.ndarray) -> np.ndarray:
    """One record, every sigma point on its own."""
    n = 6
    x, P, out = np.zeros(n), P0, []
    mean_weights, weights = np.full(2 * n + 1, 0.5 / n), np.full(2 * n + 1, 0.5 / n)
    mean_weights[0], weights[0] = 0.0, 2.0
    C = PLANT.output_slope(x[:, None], NO_FORCE)[0]

    def points(x: np.ndarray, P: np.ndarray) -> list[np.ndarray]:
        root = np.linalg.cholesky(n * P)
        return [x, *(x + root[:, i] for i in range(n)), *(x - root[:, i] for i in range(n))]

    for measured in y:
        spread = points(x, P)
        seen = [C @ point for point in spread]
        expected = sum(w * z for w, z in zip(mean_weights, seen, strict=True))
        S = sum(w * np.outer(z - expected, z - expected) for w, z in zip(weights, seen, strict=True)) + R
        across = sum(w * np.outer(p - x, z - expected) for w, p, z in zip(weights, spread, seen, strict=True))
        M = across @ np.linalg.inv(S)
        x, P = x + M @ (measured - expected), P - M @ S @ M.T
        out.append(x)
        moved = [f(point) for point in points(x, P)]
        x = sum(w * p for w, p in zip(mean_weights, moved, strict=True))
        P = sum(w * np.outer(p - x, p - x) for w, p in zip(weights, moved, strict=True)) + Q
    return np.array(out)


def extended(y: np.ndarray) -> np.ndarray:
    """One record along the slopes by hand."""
    x, P, out, one = np.zeros(6), P0, [], np.eye(6)
    C = PLANT.output_slope(x[:, None], NO_FORCE)[0]
    for measured in y:
        S = C @ P @ C.T + R
        M = P @ C.T @ np.linalg.inv(S)
        x = x + M @ (measured - C @ x)
        P = (one - M @ C) @ P @ (one - M @ C).T + M @ R @ M.T
        out.append(x)
        later, F = FLOW.expand(x[:, None], NO_FORCE)
        x, P = later[:, 0], F[0] @ P @ F[0].T + Q
    return np.array(out)


def main() -> None:
    """Print the table."""
    x0 = np.sqrt(P0) @ np.random.default_rng(0).standard_normal((6, RUNS))
    inputs = np.zeros((STEPS, 3))

    def many(filters: dict) -> list:
        return list(simulate_filters(Experiment(FLOW, PLANT.output, Q, R, x0, Beliefs.alike(np.zeros(6), P0, RUNS),
                                                inputs, filters),
                               np.random.default_rng(1)))

    def seconds(work: Callable[[], object]) -> float:
        work()
        times = []
        for _ in range(5):
            began = time.process_time()
            work()
            times.append(time.process_time() - began)
        return sorted(times)[2]

    alone = seconds(lambda: many({}))
    print(f"{'the runs alone, batched':52s} {1e3 * alone:10.1f} ms")
    for name, make, peer, gate in (("unscented", UnscentedKalmanFilter, unscented, 50), ("extended", ExtendedKalmanFilter, extended, 15)):
        filters = {name: make(FLOW, PLANT.output, Q, R)}
        samples = many(filters)
        for run in range(FEW):
            ours = np.array([s.corrections[name].beliefs.mean[:, run] for s in samples])
            theirs = peer(np.array([s.y[:, run] for s in samples]))
            assert np.abs(ours - theirs).max() < 1e-8, "the peer is another filter"
        y = np.array([s.y[:, 0] for s in samples])
        plain, batched = RUNS * seconds(lambda y=y, peer=peer: peer(y)), seconds(lambda filters=filters: many(filters)) - alone
        print(f"{name + ', run by run, ' + str(RUNS) + ' runs':52s} {1e3 * plain:10.1f} ms")
        print(f"{name + ', batched':52s} {1e3 * batched:10.1f} ms {plain / batched:8.0f}×  gate {gate}× "
              f"{'met' if plain >= gate * batched else 'MISSED'}")


if __name__ == "__main__":
    main()
