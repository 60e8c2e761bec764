"""Rank the controllers by runs in which coils have their limit and guides their friction."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from observer_lab.engine.sampled import SampledLoop
from observer_lab.text import Text, listed, text

from .controllers import DT, SHORT_NAMES, Player
from .friction import GUIDES, Guides, guides, noise, rub
from .simulation import BAND_HZ, World, loop_of

RACE_RUNS, SETTLING_SAMPLES, RACED_SAMPLES = 6, 2000, 16_384  # of each controller; the samples of a run that are judged
SEEDS_APART = 1000  # from one run's seed to the next
TIED = 1.01  # times the least value: less is no lead
BINS_HZ = np.geomspace(0.5, 30.0, 26)  # edges of the bins over which the drawn density is a mean


@dataclass(frozen=True, eq=False)
class Raced:
    """What the runs gave. rms (5, 3): of each player's channels over the band in µm/s; clipped (5,): share of commands at the limit.

    density (5, n_f): of the vertical velocity in (µm/s)²/Hz at the frequencies f. NaN where a loop is unstable or a run is lost.
    """

    rms: np.ndarray
    clipped: np.ndarray
    f: np.ndarray
    density: np.ndarray


def race(world: World, five: tuple[Player, ...], seed: int, most: float) -> Iterator[tuple[float, Raced | None]]:
    """The share that is done, and at the end the result. All players meet the same ground; `most` is what a guide holds in N.

    Rounding of the converter counts as noise of q²/12, as it does in the spectra.
    """
    rms, clipped, lines = np.full((5, 3), np.nan), np.full(5, np.nan), np.full((5, len(BINS_HZ) - 1), np.nan)
    for i, player in enumerate(five):
        loop = loop_of(world, player)
        runs = []
        for k in range(RACE_RUNS if loop.stable else 0):
            runs.append(_judged(world, player, loop, seed + SEEDS_APART * k, most))
            yield (i + (k + 1) / RACE_RUNS) / len(five), None
        if runs and all(run is not None for run in runs):
            f, density, share = (np.mean([run[j] for run in runs if run is not None], axis=0) for j in range(3))
            inside = (f >= BAND_HZ[0]) & (f <= BAND_HZ[1])
            rms[i], clipped[i] = np.sqrt(density[inside].sum(axis=0) * f[1]), float(share)
            bins = np.digitize(f, BINS_HZ)
            lines[i] = [density[bins == b, 0].mean() for b in range(1, len(BINS_HZ))]
    yield 1.0, Raced(rms, clipped, np.sqrt(BINS_HZ[1:] * BINS_HZ[:-1]), lines)


def _judged(world: World, player: Player, loop: SampledLoop, seed: int, most: float) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Frequencies, densities (n_f, 3) in (µm/s)²/Hz and the share of clipped commands of one run; None where it is lost."""
    count = SETTLING_SAMPLES + RACED_SAMPLES
    jumps, v = noise(loop, count, seed)
    if loop.hardware.step:
        v = v + loop.hardware.step / np.sqrt(12) * np.random.default_rng((seed, 2)).standard_normal(v.shape)
    at = guides(world, player) if most else Guides(np.zeros((GUIDES, loop.n)), np.zeros((loop.n, GUIDES)))
    w = rub(loop, at, most, np.zeros(loop.n), jumps, v)[0][SETTLING_SAMPLES:]
    if len(w) < RACED_SAMPLES:
        return None
    from scipy.signal import periodogram  # late: it brings all of scipy.stats, 0.6 s

    f, density = periodogram(1e6 * w @ loop.outputs[:3].T, 1 / DT, window="hann", axis=0)
    asked = w @ loop.feedback.T + v[SETTLING_SAMPLES:] @ loop.T[-1].T
    return f, density, float(np.mean(np.abs(asked) > loop.hardware.limit))


def moves(world: World, player: Player, seed: int, most: float) -> float:
    """The vertical rms velocity over the band in one run in µm/s, NaN where it is lost."""
    run = _judged(world, player, loop_of(world, player), seed, most)
    if run is None:
        return float("nan")
    inside = (run[0] >= BAND_HZ[0]) & (run[0] <= BAND_HZ[1])
    return float(np.sqrt(run[1][inside, 0].sum() * run[0][1]))


def places(rms: np.ndarray) -> np.ndarray:
    """The place of each value, 1 for the least; values within TIED of each other share a place, and NaN has the last one."""
    known = np.where(np.isnan(rms), np.inf, rms)
    return np.array([1 + int(np.sum(known < one / TIED)) for one in known])


def leaders(rms: np.ndarray) -> Text:
    """Who moves least in each channel of the runs (5, 3), "none" among them."""
    first = [listed(SHORT_NAMES[i] for i in np.flatnonzero(places(rms[:, j]) == 1)) for j in range(3)]
    return text("Least motion over 0.5–3 Hz in runs with limit and friction: {short} vertically, {short2} in rotation, {short3} "
                "horizontally.", short=first[0], short2=first[1], short3=first[2])
