"""Engine against its peers, medians in one process: `python tests/benchmarks/bench_engine.py [seconds per row] [--short]`.

Peers and gates: linear ≥ 30×, saturated ≥ 30×, 1000 saturated starts ≥ 1000× one by one, response ≥ 20×.
"""

# ruff: noqa: E402 — the thread limits must be set before numpy is imported
from __future__ import annotations

import os
import sys

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

import statistics
import time
import warnings
from collections.abc import Callable
from functools import partial

import control
import numpy as np
from scipy import signal
from scipy.integrate import solve_ivp
from scipy.linalg import expm, solve_continuous_are
from stopwatch import median as patient_median
from stopwatch import row

from app.engine import Plant, Scenario, frequency_response, simulate
from app.engine.simulation import simulate_recovery, simulate_starts

PATIENCE = float(sys.argv[1]) if len(sys.argv) > 1 else 2.0
median = partial(patient_median, patience=PATIENCE)


def rig() -> tuple[Plant, np.ndarray, np.ndarray]:
    """Five light modes, three inputs, four velocity outputs, LQR and Kalman gains: a 20-state loop."""
    rng = np.random.default_rng(0)
    frequency = 2 * np.pi * np.array([0.9, 1.2, 1.5, 6.0, 8.0])
    A = np.block([[np.zeros((5, 5)), np.eye(5)], [-np.diag(frequency**2), -np.diag(0.02 * frequency)]])
    B = np.vstack([np.zeros((5, 3)), rng.standard_normal((5, 3))])
    C = np.hstack([np.zeros((4, 5)), rng.standard_normal((4, 5))])
    K = B.T @ solve_continuous_are(A, B, 30 * C.T @ C, np.eye(3))
    L = (C @ solve_continuous_are(A.T, C.T, 30 * B @ B.T, np.eye(4))).T
    return Plant(A, B, C), K, L


def slope_of(s: Scenario) -> Callable[[float, np.ndarray], np.ndarray]:
    """The clipped loop as an ordinary differential equation."""
    A, B, C, n = s.plant.A, s.plant.B, s.plant.C, s.plant.n

    def slope(_t: float, z: np.ndarray) -> np.ndarray:
        u = np.clip(-s.K @ z[n:], s.u_min, s.u_max)
        return np.concatenate([A @ z[:n] + B @ u, A @ z[n:] + B @ u + s.L @ (C @ (z[:n] - z[n:]))])

    return slope


def linear(plant: Plant, K: np.ndarray, L: np.ndarray) -> None:
    """The 20-state loop over 10 s, at 1 kHz with a random held reference, and at 1000 points without."""
    n, t = plant.n, np.arange(10_001) / 1000
    r = np.random.default_rng(1).standard_normal((10_001, 3))
    s = Scenario(plant, K, L, x0=np.ones(n), horizon=10, dt=1e-3, reference=r)
    A = np.block([[plant.A, -plant.B @ K], [L @ plant.C, plant.A - L @ plant.C - plant.B @ K]])
    B, z0 = np.vstack([plant.B, plant.B]), np.concatenate([np.ones(n), np.zeros(n)])
    sys_ = control.ss(A, B, np.eye(2 * n), np.zeros((2 * n, 3)))
    Ad, Bd, Cd, Dd, _ = signal.cont2discrete((A, B, np.eye(2 * n), np.zeros((2 * n, 3))), 1e-3)
    ours = median(lambda: simulate(s), least=20)
    row("linear, 20 states, 10 s at 1 kHz: simulate", ours)
    row("  control.forced_response", peer := median(lambda: control.forced_response(sys_, t, r.T, z0)))
    row("  … ours against it", ours, peer, 30)
    row("  scipy.signal.lsim", peer := median(lambda: signal.lsim((A, B, np.eye(2 * n), 0 * B), r, t, z0)))
    row("  … ours against it", ours, peer, 30)
    row("  scipy.signal.dlsim", peer := median(lambda: signal.dlsim((Ad, Bd, Cd, Dd, 1e-3), r, t, z0)))
    row("  … ours against it", ours, peer)
    short = Scenario(plant, K, L, x0=np.ones(n), horizon=10, dt=0.01)
    row("linear, 20 states, 1001 points (budget 3 ms)", median(lambda: simulate(short), least=20))
    free = simulate(Scenario(plant, K, L, x0=np.ones(n), horizon=10, dt=1e-3))
    print(f"  error at the end against expm: {np.abs(free.x[-1] - (expm(A * 10) @ z0)[:n]).max():.1e}")


def saturated(plant: Plant, K: np.ndarray, L: np.ndarray) -> None:
    """The same loop behind limits of ±40 (a tenth of what it asks for at first), one run and a thousand."""
    n, t = plant.n, np.arange(10_001) / 1000
    s = Scenario(plant, K, L, x0=np.ones(n), horizon=10, dt=1e-3, u_min=-40, u_max=40)
    slope, z0 = slope_of(s), np.concatenate([np.ones(n), np.zeros(n)])
    nonlinear = control.nlsys(lambda t, z, u, p: slope(t, z), None, inputs=1, states=2 * n, outputs=2 * n)
    ours = median(lambda: simulate(s), least=3)
    row("saturated, 20 states, 10 s at 1 kHz: simulate", ours)
    loose = median(lambda: control.input_output_response(nonlinear, t, 0 * t, z0))
    row("  control.input_output_response (its own tolerance)", loose)
    row("  … ours against it", ours, loose, 30)
    row("  scipy solve_ivp, rtol 1e-9", peer := median(lambda: solve_ivp(slope, (0, 10), z0, "DOP853", t, rtol=1e-9,
                                                                         atol=1e-10)))
    row("  … ours against it", ours, peer)
    tight = solve_ivp(slope, (0, 10), z0, "DOP853", t, rtol=1e-12, atol=1e-13, max_step=2e-3).y.T
    run, other = simulate(s), control.input_output_response(nonlinear, t, 0 * t, z0).states.T
    print(f"  largest error against rtol 1e-12: ours {np.abs(np.hstack([run.x, run.xhat]) - tight).max():.1e}, "
          f"input_output_response {np.abs(other - tight).max():.1e}")
    if "--short" in sys.argv:
        return
    starts = np.random.default_rng(2).uniform(-1, 1, (1000, 2 * n))
    batch = median(lambda: [None for _ in simulate_starts(s, starts)], patience=0.0)
    row("1000 saturated starts together", batch)
    row("  … against input_output_response one by one", batch, 1000 * loose, 1000)
    small = Scenario(Plant([[0, 1], [1, 0]], [[0], [1]], [[1, 0]]), [[5.0, 4.0]], [[12.0], [37.0]], x0=[0.4, 0],
                     horizon=6, u_min=-1, u_max=1)
    row("saturated, 4 states, 601 points (budget 15 ms)", median(lambda: simulate(small), least=20))
    gaps: list[float] = []

    def whole_map() -> None:
        last = time.perf_counter()
        for _ in simulate_recovery(small, 0, np.linspace(-1.5, 1.5, 41), 0, np.linspace(-1, 1, 41)):
            gaps.append(time.perf_counter() - last)
            last = time.perf_counter()

    row("recovery map 41 × 41, 601 points", median(whole_map))
    print(f"  slices: median {statistics.median(gaps) * 1e3:.1f} ms, longest {max(gaps) * 1e3:.1f} ms")


def response(plant: Plant) -> None:
    """A 1000-point response of 10 states."""
    omega = np.logspace(-1, 3, 1000)
    sys_ = control.ss(plant.A, plant.B, plant.C, plant.D)
    ours = median(lambda: frequency_response(plant.A, plant.B, plant.C, plant.D, omega), least=20)
    row("response at 1000 frequencies, 4×3", ours)
    row("  control", peer := median(lambda: sys_(1j * omega)))
    row("  … ours against it", ours, peer, 20)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    the_plant, the_K, the_L = rig()
    linear(the_plant, the_K, the_L)
    saturated(the_plant, the_K, the_L)
    response(the_plant)
