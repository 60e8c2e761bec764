"""The sampled platform loop beside python-control and scipy: one run, and a thousand.

    python tests/benchmarks/bench_platform.py

20 s at 1 kHz, plant of ten states, controller of eight, ground and sensor noise. Prints medians of wall-clock time and
ratios. The peers run the same loop on the same noise; a thousand of their runs are scaled from a few.
"""

from __future__ import annotations

import os

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import control
import numpy as np
from scipy import signal
from scipy.integrate import solve_ivp

sys.path.insert(0, str(Path(__file__).parents[2]))

from app.engine import balanced_truncation, sampled_loop, simulate_trial
from app.engine.sampled import Hardware, SampledLoop, sampled_controller, simulate_trials
from app.plants import platform
from app.plants.platform_lqg import Weights, lqg

STEPS, DT, RUNS = 20_000, 1e-3, 1000
REPEATS, PART = 7, 0.02  # a peer that takes long is run over this part of the record and scaled
LIMIT = 0.02  # N


def loop(hardware: Hardware) -> SampledLoop:
    plant = platform.plant()
    built = lqg(balanced_truncation(plant, 8).plant, Weights(v0=1e-10)).controller
    return sampled_loop(plant, sampled_controller(built, DT), range(3), hardware=hardware, W=1e-12 * np.eye(2), V=1e-10 * np.eye(4))


def median(work: Callable[[], Any], repeats: int = REPEATS) -> float:
    work()
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return 1e3 * float(np.median(times))


def peers(s: SampledLoop) -> dict[str, tuple[Callable[[], Any], float]]:
    """Name → (work, what part of the record it covers): the closed discrete loop driven by its own noise."""
    rng = np.random.default_rng(1)
    push = rng.standard_normal((STEPS, s.jump.shape[1])) @ s.jump.T + rng.standard_normal((STEPS, 4)) @ (s.noise_in @ s.sensor).T
    F, C, N = s.closed(), s.outputs, s.n
    B, D = np.eye(N), np.zeros((len(C), N))
    system = control.ss(F, B, C, D, DT)
    inputs: Any = push.T
    t = DT * np.arange(STEPS)
    short = max(int(PART * STEPS), 2)

    def by_hand() -> np.ndarray:
        x, y = np.zeros(N), np.empty((STEPS, len(C)))
        for k in range(STEPS):
            y[k] = C @ x
            x = F @ x + push[k]
        return y

    def held() -> np.ndarray:
        """solve_ivp over each sample with what the computer holds, the noise added at the samples."""
        x = np.zeros(N)
        A, part = platform.plant().A, s.mechanics
        for k in range(short):
            u = s.feedback @ x
            drive = platform.plant().B[:, :3] @ u
            solved = solve_ivp(lambda _, z, d=drive: A @ z + d, (0.0, DT), x[part], rtol=1e-9, atol=1e-12)
            after = F @ x + push[k]
            after[part] = solved.y[:, -1] + push[k, part]
            x = after
        return x

    return {
        "control.forced_response": (lambda: control.forced_response(system, t, inputs), 1.0),
        "scipy.signal.dlsim": (lambda: signal.dlsim((F, B, C, D, DT), push), 1.0),
        "NumPy, one sample after another": (by_hand, 1.0),
        "scipy solve_ivp from sample to sample": (held, short / STEPS),
    }


def plain_clipped(s: SampledLoop) -> None:
    """The clipped loop by the definition, one sample after another."""
    rng = np.random.default_rng(1)
    jumps, v = rng.standard_normal((STEPS, s.jump.shape[1])) @ s.jump.T, rng.standard_normal((STEPS, 4)) @ s.sensor.T
    w = np.zeros(s.n)
    for k in range(STEPS):
        m = s.Y @ w + v[k]
        u = np.clip(s.U[0] @ w + s.T[0] @ m, -s.hardware.limit, s.hardware.limit)
        w = s.F[0] @ w + s.F_m[0] @ m + s.F_s[0] @ u + jumps[k]


def thousand(s: SampledLoop) -> float:
    began = time.perf_counter()
    for _ in simulate_trials(s, RUNS, STEPS * DT, 1, segment=8192):
        pass
    return time.perf_counter() - began


def main() -> None:
    linear, clipped = loop(Hardware()), loop(Hardware(limit=LIMIT))
    rounded = loop(Hardware(step=1e-6))
    one = median(lambda: simulate_trial(linear, STEPS, seed=1))
    print("| one run of 20 s at 1 kHz | median [ms] | ratio |\n|---|---|---|")
    print(f"| simulate_trial, linear, noise drawn | {one:.1f} | 1 |", flush=True)
    slow = {}
    for name, (work, part) in peers(linear).items():
        slow[name] = median(work, 3) / part
        print(f"| {name}{'' if part == 1 else ', scaled from 2 %'} | {slow[name]:.1f} | {slow[name] / one:.1f} |", flush=True)
    bent = median(lambda: simulate_trial(clipped, STEPS, seed=1), 3)
    plain = median(lambda: plain_clipped(clipped), 3)
    print(f"| simulate_trial, clipped at {LIMIT:g} N | {bent:.1f} | |\n| simulate_trial, rounded to 1 µm/s | "
          f"{median(lambda: simulate_trial(rounded, STEPS, seed=1), 3):.1f} | |")
    print(f"| NumPy by the definition, clipped | {plain:.1f} | {plain / bent:.1f} to clipped |", flush=True)
    print("\n| 1000 runs with their Welch spectra | [s] | ratio |\n|---|---|---|")
    many = thousand(linear)
    print(f"| simulate_trials, linear | {many:.1f} | 1 |\n| simulate_trials, clipped and rounded | "
          f"{thousand(loop(Hardware(limit=LIMIT, step=1e-6))):.1f} | |", flush=True)
    for name, each in slow.items():
        print(f"| {name}, 1000 times one run, no spectra | {each:.0f} | {each / many:.1f} |")


if __name__ == "__main__":
    main()
