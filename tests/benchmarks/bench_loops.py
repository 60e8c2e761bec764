"""Loops beside python-control and SciPy: linear, clipped, a thousand clipped, maps of starts, sampled hardware."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import control
import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm, solve_continuous_are
from stopwatch import Row, median

from observer_lab.engine import Plant, Scenario, balanced_truncation, sampled_loop, simulate, simulate_trial
from observer_lab.engine.sampled import Hardware, sampled_controller
from observer_lab.engine.simulation import simulate_recovery, simulate_starts
from observer_lab.plants.platform import model
from observer_lab.plants.platform.lqg_weights import Weights, lqg

CLIPPED = "nearly half prepares the twelve ways of clipping that are met, a quarter is the march"
TIMES = np.arange(10_001) / 1000


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


def linear(plant: Plant, K: np.ndarray, L: np.ndarray) -> Row:
    """The 20-state loop over 10 s at 1 kHz with a random reference; the error at the end of a run without, against e^{At}."""
    n = plant.n
    r = np.random.default_rng(1).standard_normal((10_001, 3))
    A = np.block([[plant.A, -plant.B @ K], [L @ plant.C, plant.A - L @ plant.C - plant.B @ K]])
    B, z0 = np.vstack([plant.B, plant.B]), np.concatenate([np.ones(n), np.zeros(n)])
    system = control.ss(A, B, np.eye(2 * n), np.zeros((2 * n, 3)))
    ours = median(lambda: simulate(Scenario(plant, K, L, x0=np.ones(n), horizon=10, dt=1e-3, reference=r)))
    theirs = median(lambda: control.forced_response(system, TIMES, r.T, z0))
    true = (expm(10 * A) @ z0)[:n]
    errors = (np.abs(x - true).max() for x in (simulate(Scenario(plant, K, L, x0=np.ones(n), horizon=10, dt=1e-3)).x[-1],
                                               control.forced_response(system, TIMES, 0 * r.T, z0).outputs[:n, -1]))
    return Row("linear loop, 20 states, 10 s at 1 kHz", ours, "forced_response", theirs, 30, said=_errors(*errors),
               limit="half is the scan and a third the outputs, which write more than the cache holds")


def clipped(plant: Plant, K: np.ndarray, L: np.ndarray) -> Iterator[Row]:
    """The same loop behind limits of ±40, a tenth of what it asks for at first; one run, and a thousand starts."""
    n = plant.n
    s = Scenario(plant, K, L, x0=np.ones(n), horizon=10, dt=1e-3, u_min=-40, u_max=40)
    slope, z0 = slope_of(s), np.concatenate([np.ones(n), np.zeros(n)])
    nonlinear = control.nlsys(lambda t, z, u, p: slope(t, z), None, inputs=1, states=2 * n, outputs=2 * n)

    def loose() -> np.ndarray:
        return np.asarray(control.input_output_response(nonlinear, TIMES, 0 * TIMES, z0).states).T

    def exact() -> np.ndarray:
        return solve_ivp(slope, (0, 10), z0, "DOP853", TIMES, rtol=1e-9, atol=1e-10).y.T

    true = solve_ivp(slope, (0, 10), z0, "DOP853", TIMES, rtol=1e-12, atol=1e-13, max_step=2e-3).y.T
    run = simulate(s)
    error = [np.abs(states - true).max() for states in (np.hstack([run.x, run.xhat]), loose(), exact())]
    ours, by_default, by_solver = median(lambda: simulate(s)), median(loose, 0, 1), median(exact, 0, 1)
    yield Row("clipped loop, the same", ours, "input_output_response", by_default, 50, said=_errors(*error[:2]), limit=CLIPPED)
    yield Row("  … at comparable accuracy", ours, "solve_ivp 1e-9", by_solver, 50, said=_errors(error[0], error[2]), limit=CLIPPED)
    starts = np.random.default_rng(2).uniform(-1, 1, (1000, 2 * n))

    def batch() -> None:
        for _ in simulate_starts(s, starts):
            pass

    began = time.perf_counter()
    together = median(batch, 0, 1)
    said = f"{time.perf_counter() - began:.2g} s by the wall, the cores sharing"
    yield Row("1000 clipped runs", together, "input_output_response, one by one", 1000 * by_default, 500, said=said,
              limit="ten million steps of one product of 24×32 numbers each and a look at the limits, about 0.1 µs")


def maps() -> Iterator[Row]:
    """Which starts of a falling plant come home, 41 × 41 of them over 601 steps."""
    s = Scenario(Plant([[0, 1], [1, 0]], [[0], [1]], [[1, 0]]), [[5.0, 4.0]], [[12.0], [37.0]], x0=[0.4, 0], horizon=6,
                 u_min=-1, u_max=1)
    x, e = np.linspace(-1.5, 1.5, 41), np.linspace(-1, 1, 41)

    def whole() -> None:
        list(simulate_recovery(s, 0, x, 0, e))

    ours = median(whole, wall=True)
    one = median(lambda: simulate(s))
    yield Row("map of starts that come home, 41 × 41", ours, "our own runs, one by one", 1681 * one, bound=0.1,
              said=f"processor {1e3 * median(whole):.0f} ms, the cores sharing; ours by the wall")


def sampled() -> Iterator[Row]:
    """The platform's sampled loop over 20 s at 1 kHz, linear and clipped, beside its definition in NumPy, sample by sample."""
    plant, steps = model.plant(), 20_000
    built = lqg(balanced_truncation(plant, 8).plant, Weights(v0=1e-10)).controller
    for words, hardware in (("linear", Hardware()), ("clipped", Hardware(limit=0.02))):
        s = sampled_loop(plant, sampled_controller(built, 1e-3), range(3), hardware=hardware, W=1e-12 * np.eye(2), V=1e-10 * np.eye(4))
        rng = np.random.default_rng(1)
        jumps, v = rng.standard_normal((steps, s.jump.shape[1])) @ s.jump.T, rng.standard_normal((steps, 4)) @ s.sensor.T

        def by_hand(s=s, jumps=jumps, v=v) -> None:
            w = np.zeros(s.n)
            for k in range(steps):
                m = s.Y @ w + v[k]
                u = np.clip(s.U[0] @ w + s.T[0] @ m, -s.hardware.limit, s.hardware.limit)
                w = s.F[0] @ w + s.F_m[0] @ m + s.F_s[0] @ u + jumps[k]

        yield Row(f"sampled platform, 20 s at 1 kHz, {words}", median(lambda s=s: simulate_trial(s, steps, seed=1)),
                  "NumPy, sample by sample", median(by_hand, 0, 1))


def _errors(ours: float, theirs: float) -> str:
    return f"error {ours:.1e}, peer {theirs:.1e}"


def rows() -> Iterator[Row]:
    """All rows about loops."""
    rigged = rig()
    yield linear(*rigged)
    yield from clipped(*rigged)
    yield from maps()
    yield from sampled()
