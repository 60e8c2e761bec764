"""The platform's sampled loop, and the same by definition, one sample after another."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
from scipy import signal

from observer_lab.engine import Plant, balanced_truncation, compensator, lqe, lqr, sampled_loop
from observer_lab.engine.sampled import Hardware, MonteCarlo, SampledLoop, coil_driver, sampled_controller, simulate_trials
from observer_lab.plants.platform import model

DT = 1e-3
PLANT = model.plant()
W, V = 1e-12 * np.eye(2), 1e-10 * np.eye(4)
IDEAL = Hardware()
KICK = np.array([0, 0, 0, 0, 0, 0.015, -0.02, 0.09, -0.02, -0.02])


def _reduced() -> tuple[Plant, np.ndarray, np.ndarray, np.ndarray]:
    """Eight states with the coils as inputs, G, K and L."""
    cut = balanced_truncation(PLANT, 8).plant
    believed = Plant(cut.A, cut.B[:, :3], cut.C)
    weight = np.diag([1e5, 1e7, 1e5, 1e7])
    return (believed, cut.B[:, 3:], lqr(cut.A, cut.B[:, :3], cut.C.T @ weight @ cut.C, np.eye(3)).gain,
            lqe(cut.A, cut.B[:, 3:], cut.C, W, V).gain)


BELIEVED, GROUND, K, L = _reduced()
CONTROLLER = compensator(BELIEVED, K, L)


def loop_of(hardware: Hardware = IDEAL) -> SampledLoop:
    return sampled_loop(PLANT, sampled_controller(CONTROLLER, DT), range(3), hardware=hardware, W=W, V=V)


def finished(loop: SampledLoop, runs: int, seconds: float, seed: int, segment: int) -> tuple[MonteCarlo, list[float]]:
    yielded = list(simulate_trials(loop, runs, seconds, seed, segment=segment))
    result = yielded[-1][1]
    assert result is not None
    return result, [fraction for fraction, _ in yielded]


def exact(A: np.ndarray, B: np.ndarray, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """e^{A t} and ∫e^{As}ds B in 40 digits."""
    with mpmath.workdps(40):
        n, m = B.shape
        block = mpmath.zeros(n + m)
        for i in range(n):
            for j in range(n):
                block[i, j] = mpmath.mpf(float(A[i, j])) * mpmath.mpf(duration)
            for j in range(m):
                block[i, n + j] = mpmath.mpf(float(B[i, j])) * mpmath.mpf(duration)
        power = mpmath.expm(block, method="taylor")
        both = np.array([[float(power[i, j]) for j in range(n + m)] for i in range(n)])
    return both[:, :n], both[:, n:]


def scipys(method: str) -> tuple[np.ndarray, ...]:
    peer: Any = signal.cont2discrete((CONTROLLER.A, CONTROLLER.B, CONTROLLER.C, CONTROLLER.D), DT, method)
    return peer[:4]


def by_definition(hardware: Hardware, steps: int, seed: int | None, ground: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """States, readings and applied commands by the definition: one sample after another, commands in a queue."""
    driver, dt = coil_driver(hardware, 3), DT
    first = 0 if driver is None else driver.n
    n, N = PLANT.n, PLANT.n + first
    A, B = np.zeros((N, N)), np.zeros((N, 5))
    A[first:, first:], B[first:, 3:] = PLANT.A, PLANT.B[:, 3:]
    if driver is None:
        B[:, :3] = PLANT.B[:, :3]
    else:
        A[:first, :first], A[first:, :first], B[:first, :3] = driver.A, PLANT.B[:, :3] @ driver.C, driver.B
    whole = int(hardware.delay / dt + 1e-9)
    part = hardware.delay - whole * dt
    early, late = exact(A, B, part), exact(A, B, dt - part)
    Ac, Bc, Cc, Dc = scipys("bilinear")
    loop = loop_of(hardware)
    jumps, v = np.zeros((steps, loop.n)), np.zeros((steps, 4))
    if seed is not None:
        for_ground, for_v, for_bias = ([way.standard_normal(steps) for way in rng.spawn(wide)]
                                       for rng, wide in zip(np.random.default_rng(seed).spawn(3), (8, 4, 4), strict=True))
        jumps = np.array(for_ground + (for_bias if hardware.walk else [])).T @ loop.jump.T
        v = np.array(for_v).T @ loop.sensor.T
    z, c, bias, queue = np.zeros(N), np.zeros(CONTROLLER.n), np.zeros(4), [np.zeros(3)] * (whole + 1)
    states, readings, commands = np.empty((steps, n)), np.empty((steps, 4)), np.empty((steps, 3))
    for k in range(steps):
        m = PLANT.C @ z[first:] + bias + v[k]
        if hardware.step:
            m = hardware.step * np.round(m / hardware.step)
        u = np.clip(Cc @ c + Dc @ m, -hardware.limit, hardware.limit)
        c = Ac @ c + Bc @ m
        states[k], readings[k], commands[k] = z[first:], m, u
        queue.append(u)
        older, newer = queue[-2 - whole], queue[-1 - whole]
        z = early[0] @ z + early[1] @ np.concatenate([older, ground[k]])
        z = late[0] @ z + late[1] @ np.concatenate([newer, ground[k]])
        z += jumps[k, :N]
        bias = bias + hardware.ramp * dt + (jumps[k, loop.bias] if hardware.walk else 0.0)
        if k == 99:
            z[first:] += KICK
    return states, readings, commands
