"""Simulate Coulomb friction at the three guides of the deck.

Three guides: at the left and the right vertical spring and at the horizontal one. The force is held over a sample (Moreau's stepping):
|f| ≤ F, and either the sliding at the end of the sample is zero or f = −F sign(sliding).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from observer_lab.course.lesson import Design
from observer_lab.engine import sampled_loop
from observer_lab.engine.kernels import Actuators, Rubbing, as_kernel_array, compiled_kernel, friction_steps
from observer_lab.engine.sampled import SampledLoop, trial_draws

from .controllers import DT, Player
from .simulation import BAND_HZ, GROUND_STEP_M, RUN_SAMPLES, TOUCH_JUMP, TOUCH_SAMPLE, World, ground_filter, loop_of, plant_of

MAX_SWEEPS, FORCE_RTOL = 60, 1e-13  # of the forces that the guides share: most, and when they are found, as a share of F
RUN_STATE_LIMIT = 1e12  # a run that gets here is over
GUIDES = 3
SETTLING_SAMPLES, JUDGED_SAMPLES = 1000, 8192  # samples before a run is judged, and judged


@dataclass(frozen=True, eq=False)
class Guides:
    """rows (3×N): the sliding of each guide, deck less ground; push (N×3): what a force on the deck there does over a sample."""

    rows: np.ndarray
    push: np.ndarray


@lru_cache(maxsize=32)
def guides(world: World, player: Player) -> Guides:
    """The guides of a loop on shaped ground, which has a velocity (white displacement has none)."""
    loop, plant, p = loop_of(world, player), plant_of(world.parameters)[0], world.parameters
    share = p.a / p.b  # a force at the spring by those of the two coils about it
    force = np.column_stack([plant.B[:, :2] @ [(1 + share) / 2, (1 - share) / 2], plant.B[:, :2] @ [(1 - share) / 2, (1 + share) / 2],
                             plant.B[:, 2]])
    rows = np.zeros((GUIDES, loop.n))
    rows[:, loop.x.start + 5:loop.x.start + 8] = [[0, 1, -p.a], [0, 1, p.a], [1, 0, p.h]]
    shaping = ground_filter()
    rows[:, loop.x.stop:loop.mechanics.stop] -= (shaping.C @ shaping.A)[[0, 0, 1]]
    pushed = sampled_loop(plant, player.controller, range(3), hardware=world.hardware, shaping=shaping, disturbances=force)
    return Guides(rows, pushed.Gamma)


def held(sliding: list[float], G: list[list[float]], most: float, f: list[float]) -> list[float]:
    """The forces f (3) with |f| ≤ most that bring sliding + G f to zero where they can, from a first guess."""
    for _ in range(MAX_SWEEPS):
        moved = 0.0
        for i in range(GUIDES):
            row = G[i]
            new = f[i] - (sliding[i] + row[0] * f[0] + row[1] * f[1] + row[2] * f[2]) / row[i]
            new = most if new > most else -most if new < -most else new
            moved = max(moved, abs(new - f[i]))
            f[i] = new
        if moved <= FORCE_RTOL * most:
            break
    return f


def rub(loop: SampledLoop, at: Guides, most: float, start: np.ndarray, jumps: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """States w (n_t, N) of the loop and the forces (n_t, 3) in N that led to them, ended early where the run leaves every bound."""
    limit, G, f = loop.hardware.limit, (at.rows @ at.push).tolist(), [0.0] * GUIDES
    w, forces = np.zeros((len(v), loop.n)), np.zeros((len(v), GUIDES))
    w[0], closed, quick = start, loop.closed(), compiled_kernel(friction_steps) if most else None
    F, F_m, F_s, Y, U, T = loop.F[-1], loop.F_m[-1], loop.F_s[-1], loop.Y, loop.U[-1], loop.T[-1]
    if quick is not None:
        last = _rubbed(quick, loop, at, most, w, forces, jumps, v)
        return w[:last], forces[:last]
    driven = jumps + v @ loop.noise_in.T
    for k in range(len(v) - 1):
        if np.isinf(limit):
            after = closed @ w[k] + driven[k]
        else:
            m = Y @ w[k] + v[k]
            after = F @ w[k] + F_m @ m + F_s @ np.clip(U @ w[k] + T @ m, -limit, limit) + jumps[k]
        if most:
            f = held((at.rows @ after).tolist(), G, most, f)
            after = after + at.push @ f
        if not np.abs(after).max() < RUN_STATE_LIMIT:
            return w[:k + 1], forces[:k + 1]
        w[k + 1], forces[k + 1] = after, f
    return w, forces


def _rubbed(quick: Callable[..., int], loop: SampledLoop, at: Guides, most: float, w: np.ndarray, forces: np.ndarray, jumps: np.ndarray,
            v: np.ndarray) -> int:
    """`rub` by its kernel, from w[0] on; the samples that it fills."""
    clips = bool(np.isfinite(loop.hardware.limit))
    step = loop.F[-1] + loop.F_m[-1] @ loop.Y if clips else loop.closed()
    driven = jumps + v @ (loop.F_m[-1] if clips else loop.noise_in).T
    asked, direct = (loop.feedback, v @ loop.T[-1].T) if clips else (np.empty((0, loop.n)), np.empty((len(v), 0)))
    return quick(
        w,
        forces,
        as_kernel_array(step.T),
        as_kernel_array(driven),
        Actuators(*map(as_kernel_array, (asked, direct, loop.F_s[-1])), loop.hardware.limit),
        Rubbing(*map(as_kernel_array, (at.rows, at.push, at.rows @ at.push)), float(most), MAX_SWEEPS, FORCE_RTOL * most),
        RUN_STATE_LIMIT,
    )


def noise(loop: SampledLoop, steps: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """What the ground does to w over each sample (n_t, N), and what the sensors add (n_t, p): the draws of `simulate_trial`."""
    from_ground, from_sensors, from_bias = trial_draws(loop, steps, seed)
    return np.hstack([from_ground, from_bias]) @ loop.jump.T, from_sensors @ loop.sensor.T


def friction_of(design: Design) -> float:
    """The most that a guide holds, in N; none on white ground."""
    return 1e-3 * design["friction"] if design["ground"] == "shaped" else 0.0


@lru_cache(maxsize=8)
def rubbed(world: World, player: Player, seed: int, step: bool, kick: float, most: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The run on the stage with guides that rub with up to `most` N each; rounding is left out, as it is in `shake`."""
    loop = loop_of(world, player)
    jumps, v = noise(loop, RUN_SAMPLES, seed)
    start = np.zeros(loop.n)
    if step:
        jumps[TOUCH_SAMPLE:] += loop.Gamma @ GROUND_STEP_M
    for at in ([] if step else [TOUCH_SAMPLE]) + ([min(round(kick / DT), RUN_SAMPLES - 1)] if kick >= 0 else []):
        (jumps[at - 1] if at else start)[loop.x] += TOUCH_JUMP
    w = rub(loop, guides(world, player), most, start, jumps, v)[0]
    limit = loop.hardware.limit
    u = np.clip(w @ loop.feedback.T + v[:len(w)] @ loop.T[-1].T, -limit, limit)
    last = np.minimum(np.arange(RUN_SAMPLES), len(w) - 1)
    return DT * np.arange(RUN_SAMPLES)[::4], np.clip(w[last][:, loop.x], -1.0, 1.0)[::4], np.clip(u[last], -100.0, 100.0)[::4]


def isolation(world: World, player: Player, seed: int, most: float) -> np.ndarray:
    """A run with nothing but ground and sensors (3, 3): RMS over the band in µm/s without friction and with it, and how often each guide
    sticks; NaN where the loop is unstable."""
    loop, at = loop_of(world, player), guides(world, player)
    if not loop.stable:
        return np.full((3, 3), np.nan)
    jumps, v = noise(loop, SETTLING_SAMPLES + JUDGED_SAMPLES, seed)
    runs = [rub(loop, at, size, np.zeros(loop.n), jumps, v) for size in (0.0, most)]
    f = np.fft.rfftfreq(JUDGED_SAMPLES, DT)
    inside = (f >= BAND_HZ[0]) & (f <= BAND_HZ[1])
    sizes = []
    for w, _ in runs:
        line = np.fft.rfft(w[SETTLING_SAMPLES:] @ loop.outputs[:3].T, axis=0)[inside] if len(w) == len(v) else np.full((1, 3), np.nan)
        sizes.append(1e6 * np.sqrt(2 * np.sum(np.abs(line) ** 2, axis=0)) / JUDGED_SAMPLES)
    return np.array([*sizes, np.mean(np.abs(runs[1][1][SETTLING_SAMPLES:]) < most * (1 - 1e-9), axis=0)])
