"""LQG on the platform beside python-control and SciPy on the same work: medians, and how many times faster.

    OMP_NUM_THREADS=1 python tests/benchmarks/bench_lqg.py
"""

from __future__ import annotations

import statistics
import time
import warnings
from collections.abc import Callable

import control
import numpy as np
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov
from scipy.signal import StateSpace, freqresp

from app.engine import lqe, lqg, lqr, noisy_loop
from app.plants import platform, platform_lqg
from app.plants.platform_channels import T_y

REPEATS = 25
P = platform.plant()
COILS, G = platform_lqg.coils(P), platform_lqg.ground(P)
W = platform_lqg.Weights()
Q, R = W.Q(P), W.R
F = np.geomspace(0.01, 100.0, 200)
UNIT = 1e-12  # python-control's lqe fails at these scales; divided by this it works


def median(job: Callable[[], object]) -> float:
    """Median milliseconds of a job, warmed up."""
    job()
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        job()
        times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)


def scipy_gains() -> tuple[np.ndarray, np.ndarray]:
    """Both Riccati equations by SciPy, scaled by hand."""
    S = solve_continuous_are(COILS.A, COILS.B, Q, R)
    E = solve_continuous_are(COILS.A.T, COILS.C.T, G @ G.T * W.beta_q, W.V / UNIT)
    return np.linalg.solve(R, COILS.B.T @ S), np.linalg.solve(W.V / UNIT, COILS.C @ E).T


def control_gains() -> tuple[np.ndarray, np.ndarray]:
    """lqr and lqe of python-control, scaled by hand."""
    K = control.lqr(COILS.A, COILS.B, Q, R, method="scipy")[0]
    L = control.lqe(COILS.A, G, COILS.C, W.W / UNIT, W.V / UNIT, method="scipy")[0]
    return np.asarray(K), np.asarray(L)


DESIGN = platform_lqg.lqg(P)
LOOP = noisy_loop(COILS, DESIGN.controller, G, W.W, V=W.V)
ROWS = LOOP.outputs(T_y[:3])
SOURCES = 2 * np.diag(LOOP.noise)


def ours_psd() -> np.ndarray:
    """Loop and densities of three channels at 200 frequencies."""
    loop = noisy_loop(COILS, DESIGN.controller, G, W.W, V=W.V)
    return loop.psd(F, loop.outputs(T_y[:3]))


def control_psd() -> np.ndarray:
    """The same by python-control's frequency response."""
    system = control.ss(LOOP.A, LOOP.B, ROWS @ LOOP.C, ROWS @ LOOP.D)
    H = system(2j * np.pi * F)
    return (np.abs(H) ** 2 * SOURCES[None, :, None]).sum(axis=1).T


def scipy_psd() -> np.ndarray:
    """The same by SciPy, one input and one output at a time."""
    total = np.zeros((len(F), 3))
    for i in range(3):
        for j in range(LOOP.B.shape[1]):
            system = StateSpace(LOOP.A, LOOP.B[:, [j]], (ROWS @ LOOP.C)[[i]], np.zeros((1, 1)))
            total[:, i] += SOURCES[j] * np.abs(freqresp(system, 2 * np.pi * F)[1]) ** 2
    return total


def main() -> None:
    """Print the table."""
    warnings.simplefilter("ignore")
    jobs = {
        "lqr and lqe, 10 states": (
            lambda: (lqr(COILS.A, COILS.B, Q, R), lqe(COILS.A, G, COILS.C, W.W, W.V)),
            {"python-control": control_gains, "SciPy": scipy_gains}),
        "3 channels, 200 frequencies": (ours_psd, {"python-control": control_psd, "SciPy": scipy_psd}),
        "variances by Lyapunov": (
            lambda: noisy_loop(COILS, DESIGN.controller, G, W.W, V=W.V).variance(),
            {"SciPy": lambda: solve_continuous_lyapunov(LOOP.A, -LOOP.B @ LOOP.noise @ LOOP.B.T)}),
        "whole design (K, L, compensator, costs)": (lambda: lqg(COILS, Q, R, W.W, W.V, G=G), {}),
    }
    for name, peer in {"python-control": control_psd, "SciPy (by polynomials)": scipy_psd}.items():
        print(f"densities: {name} differs from ours by {np.abs(peer() / ours_psd() - 1).max():.1e} relative")
    print()
    print(f"{'work':42s} {'ours [ms]':>10s}  peers")
    for name, (ours, peers) in jobs.items():
        mine = median(ours)
        beside = [f"{peer} {t:.2f} ms ({t / mine:.1f}×)" for peer, job in peers.items() for t in (median(job),)]
        print(f"{name:42s} {mine:10.3f}  {', '.join(beside)}")


if __name__ == "__main__":
    main()
