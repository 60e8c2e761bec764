"""Run the long comparison: Monte Carlo, filter start, other decks, one switch at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from observer_lab.course.lazy import merge_lazily, replace_keeping_cache
from observer_lab.course.lesson import Design, Job, Outcome
from observer_lab.engine import Belief
from observer_lab.engine.sampled import loop_density, mechanics_response, simulate_trials
from observer_lab.plants.platform import model
from observer_lab.text import text

from .controllers import DT, LQE, ORDER, RECURSIVE, Player, first_belief, sampled_design
from .equal_effort import equal_effort
from .friction import friction_of, isolation, noise
from .race import leaders, race
from .simulation import BAND_HZ, World, band_rms, grid, loop_of, with_resonances
from .study import TOLERANCE, Study, Trials, acts

RUN_COUNT, RUN_S, SEGMENT = 24, 32.0, 16_384
LEARNING_SAMPLES, PART_SAMPLES = 30_000, 1000  # samples that the recursive filter is followed for, and whose gains are found at once
DECKS = 60
COSTS = ("driver", "delay", "adc", "drift", "stiffness", "damping", "placement")


def try_out(outcome: Outcome[Study]) -> Iterator[tuple[float, Trials]]:
    """The ranking by runs where a limit or friction acts, then Monte-Carlo of every player, that on the stage first, learning, equal
    effort, tolerances and costs."""
    done = 0.0
    for fraction, found in _all(outcome):
        done = max(done, fraction)
        yield done, found


def _all(outcome: Outcome[Study]) -> Iterator[tuple[float, Trials]]:
    found = Trials((None,) * 5)
    match, design = outcome.study, outcome.design
    world, seed = match.world, int(design["seed"])
    if acts(design):
        for share, raced in race(world, match.five, seed, friction_of(design)):
            found = found if raced is None else replace(found, raced=raced)
            yield 0.14 * share, found
    shown_first = sorted(enumerate(match.five), key=lambda each: each[1].id != design["play"])
    for done, (i, player) in enumerate(shown_first):
        loop = loop_of(world, player)
        if not loop.stable:
            continue
        for share, result in simulate_trials(loop, RUN_COUNT, RUN_S, seed, segment=SEGMENT, together=RUN_COUNT):
            if result is not None:
                found = replace(found, noise=(*found.noise[:i], result, *found.noise[i + 1:]))
            yield 0.14 * (done + share), found
    yield 0.7, found
    if match.spectra[ORDER.index(LQE)].stable and match.spectra[ORDER.index(RECURSIVE)].stable:
        for share, apart in _learning(world, match.five, design["v"], seed):
            if apart is not None:
                found = replace(found, learning=apart)
            yield 0.7 + 0.1 * share, found
    if match.spectra[ORDER.index(LQE)].stable:
        wanted = float(match.forces[ORDER.index(LQE)].max())
        for share, equal in equal_effort(world, match.five, design["v"], design["pair"], wanted):
            if equal is not None:
                found = replace(found, equal=equal)
            yield 0.8 + 0.02 * share, found
    spread = abs(design["stiffness"]), abs(design["damping"]), abs(design["placement"])
    spread = spread if any(spread) else TOLERANCE
    decks = np.empty((DECKS, 5, 3))
    for share in _decks(world, match.five, spread, seed, decks):
        yield 0.82 + 0.08 * share, found
    found = replace(found, decks=decks, tolerance=spread)
    if most := friction_of(design):
        rubbing = np.empty((5, 3, 3))
        for i, player in enumerate(match.five):
            rubbing[i] = isolation(world, player, seed, most)
            yield 0.9, found
        found = replace(found, rubbing=rubbing)
    sizes, costs = _sizes(design), np.empty((len(COSTS), 5, 3))
    for share in _costs(match.five, sizes, world, costs):
        yield 0.9 + 0.1 * share, found
    yield 1.0, replace(found, costs=costs, sizes=sizes)


def _learning(world: World, five: tuple[Player, ...], v: float, seed: int) -> Iterator[tuple[float, np.ndarray | None]]:
    """The recursive filter from the moment it is switched on beside the same filter settled, on one seed.

    RMS over each second of the difference of the three channels' velocities, relative to the RMS of the run.
    """
    loop, design = loop_of(world, five[ORDER.index(RECURSIVE)]), sampled_design(v)
    kf, K, own, n = design.filter, design.K, loop.control, loop.n
    rounding, limit = loop.hardware.step, loop.hardware.limit
    jumps, slips = (drawn[:, :, None] for drawn in noise(loop, LEARNING_SAMPLES, seed))
    step, settled = np.hstack([loop.F[-1], loop.F_m[-1], loop.F_s[-1]]), np.hstack([loop.U[-1], loop.T[-1]])
    closed, C, Y = kf.A - kf.B @ K, kf.C, loop.Y
    belief, both = first_belief(v), np.zeros((step.shape[1], 2))  # learning beside settled: states, readings, what coils are told
    outputs, seen = loop.outputs[:3], np.empty((LEARNING_SAMPLES, 3, 2))
    w, m, told = both[:n], both[n:n + 4], both[n + 4:]
    gains = np.empty((0, kf.n, 4))
    for k in range(LEARNING_SAMPLES):
        if k % PART_SAMPLES == 0:
            schedule = kf.schedule(belief, PART_SAMPLES + 1)
            gains, belief = schedule.gains[schedule.index], Belief(belief.mean, schedule.prior[schedule.index[PART_SAMPLES]])
        np.matmul(outputs, w, out=seen[k])
        np.matmul(Y, w, out=m)
        m += slips[k]
        if rounding:
            m[:] = rounding * np.rint(m / rounding)
        believed = w[own, 0]
        xhat = believed + gains[k % PART_SAMPLES] @ (m[:, 0] - C @ believed)
        told[:, 0], told[:, 1] = -K @ xhat, settled @ both[:n + 4, 1]
        if limit < np.inf:
            np.clip(told, -limit, limit, out=told)
        w[:] = step @ both + jumps[k]
        w[own, 0] = closed @ xhat
        if k % 100 == 99:
            yield (k + 1) / LEARNING_SAMPLES, None
    second = round(1 / DT)
    squares = ((seen[:, :, 0] - seen[:, :, 1])**2).reshape(-1, second, 3).mean(axis=1), (seen[:, :, 1]**2).mean(axis=0)
    yield 1.0, np.sqrt(squares[0] / squares[1])


def _gains(world: World, five: tuple[Player, ...]) -> np.ndarray:
    """Gain in dB over the band of each player (5, 3); NaN where its loop is unstable. Nothing is kept in a cache."""
    loops = [loop_of.__wrapped__(world, player) for player in five]
    f = grid(world.parameters)
    near = f[(f >= BAND_HZ[0]) & (f <= BAND_HZ[1])]
    mechanics, rms = mechanics_response(loops[0], near), []
    for loop in loops:
        fine = with_resonances(near, loop) if loop.stable else near
        S = loop_density(loop, mechanics if fine is near else mechanics_response(loops[0], fine)) if loop.stable else None
        rms.append(np.full(3, np.nan) if S is None else band_rms(fine, S, *BAND_HZ)[:3])
    return 20 * np.log10(rms[0] / np.array(rms))


def _decks(world: World, five: tuple[Player, ...], spread: tuple[float, float, float], seed: int, found: np.ndarray) -> Iterator[float]:
    """Gains on decks whose stiffness, damping and sensor places lie anywhere within ±spread of the nominal ones."""
    rng, p = np.random.default_rng((seed, 1)), model.Parameters()
    for i in range(DECKS):
        k, c, s = rng.uniform(-1, 1, 3) * spread
        other = replace(p, kz=p.kz * (1 + k / 100), kx=p.kx * (1 + k / 100), cz=p.cz * (1 + c / 100),
                        cx=p.cx * (1 + c / 100), s=p.s + s / 1000)
        found[i] = _gains(replace(world, parameters=other), five)
        yield (i + 1) / DECKS


def _sizes(design: Design) -> tuple[float, ...]:
    """How far each switch is turned for its cost: as far as its knob, or a standard size where that is at rest."""
    standard = (30.0, 5.0, 500.0, 10.0, 10.0, 50.0, 20.0)
    present = [design["bandwidth"] if design["driver"] != "ideal" else 0.0, *(design[name] for name in COSTS[1:])]
    return tuple(float(now) if now else usual for now, usual in zip(present, standard, strict=True))


def _costs(five: tuple[Player, ...], sizes: tuple[float, ...], world: World, found: np.ndarray) -> Iterator[float]:
    """Each switch alone in an otherwise ideal world."""
    p, h = model.Parameters(), type(world.hardware)()
    ideal = World(p, h, world.sensor, world.shaped)
    base = _gains(ideal, five)
    band, delay, step, walk, k, c, s = sizes
    worlds = (
        replace(ideal, hardware=replace(h, bandwidth=band, order=world.hardware.order if np.isfinite(world.hardware.bandwidth) else 2)),
        replace(ideal, hardware=replace(h, delay=delay / 1000)), replace(ideal, hardware=replace(h, step=step * 1e-6)),
        replace(ideal, hardware=replace(h, walk=walk * 1e-6)),
        replace(ideal, parameters=replace(p, kz=p.kz * (1 + k / 100), kx=p.kx * (1 + k / 100))),
        replace(ideal, parameters=replace(p, cz=p.cz * (1 + c / 100), cx=p.cx * (1 + c / 100))),
        replace(ideal, parameters=replace(p, s=p.s + s / 1000)),
    )
    for i, other in enumerate(worlds):
        found[i] = _gains(other, five) - base
        yield (i + 1) / len(worlds)


def depends(design: Design) -> Design:
    """The design without the player on the stage, the test and the kick: no trial has them."""
    return design.with_values(play="", test="", kick=-1.0)


def shown(outcome: Outcome[Study], found: Trials) -> Outcome[Study]:
    """The outcome with what was measured."""
    study = replace_keeping_cache(outcome.study, trials=found)
    if found.raced is None:
        return replace(outcome, study=study)
    numbers = {f"{player.id}_{channel}_raced": float(found.raced.rms[i, j]) for i, player in enumerate(study.five)
               for j, channel in enumerate(("vertical", "rotation", "horizontal")) if not np.isnan(found.raced.rms[i, j])}
    return replace(outcome, study=study, words=leaders(found.raced.rms), metrics=merge_lazily(outcome.metrics, numbers))


JOB = Job(text("Monte-Carlo, tolerances, costs"), try_out, depends, shown, figure="trials", follows=True)
