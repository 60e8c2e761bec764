"""Retune each controller to the same coil effort as the full LQG."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from observer_lab.engine import Plant
from observer_lab.engine.sampled import SampledController, loop_density, mechanics_response, sampled_controller

from .controllers import CONTROLLER_NAMES, DT, LQE, ORDER, RECURSIVE, SISO, Player, decoupled, full, sampled_design, siso_pair
from .simulation import BAND_HZ, World, band_rms, grid, loop_of, with_resonances

DIAL_FACTOR, MAX_DIAL_STEPS = 4.0, 11  # of the search for two dials on both sides: factor, and most of them (four million times)
EFFORT_RTOL, MAX_TRIES = 1e-3, 40  # of the effort met, and within so many trials between the two


@dataclass(frozen=True, eq=False)
class Equal:
    """Four controllers at the effort `wanted` (N RMS of the coil that is told most).

    dials (4,): how many times bolder each became, NaN where none meets the effort; forces (4,) in N, rms (4, 3) in µm/s and
    band_db (4, 3) as the tables of the scores have them.
    """

    wanted: float
    dials: np.ndarray
    forces: np.ndarray
    rms: np.ndarray
    band_db: np.ndarray


def retuned(id: str, dial: float, v: float, pair: str) -> SampledController:
    """A controller `dial` times as bold: of the SISO loops the gain, of the LQGs one over the noise that they believe in."""
    if id == SISO:
        own = siso_pair(pair)
        return sampled_controller(Plant(own.A, own.B, dial * own.C, dial * np.asarray(own.D)), DT)
    if id == RECURSIVE:
        return sampled_controller(sampled_design.__wrapped__(v / dial).controller, DT)
    return sampled_controller(full(v / dial) if id == LQE else decoupled(v / dial), DT)


def met(effort: Callable[[float], float], wanted: float) -> float:
    """The dial nearest to 1 on its side at which an effort that grows with the dial is the one wanted; NaN where there is none."""
    at, found = 1.0, effort(1.0)
    if abs(found / wanted - 1) < EFFORT_RTOL:
        return at
    bolder, before = found < wanted, (at, found)
    for _ in range(MAX_DIAL_STEPS):
        before, at = (at, found), at * DIAL_FACTOR if bolder else at / DIAL_FACTOR
        found = effort(at)
        if bolder == (found >= wanted):
            break
    else:
        return np.nan
    low, high = sorted([before, (at, found)])
    for _ in range(MAX_TRIES):
        share = np.log(wanted / low[1]) / np.log(high[1] / low[1]) if np.isfinite(high[1]) else 0.5
        at = low[0] * (high[0] / low[0]) ** float(np.clip(share, 0.05, 0.95))
        found = effort(at)
        if abs(found / wanted - 1) < EFFORT_RTOL:
            return at
        low, high = ((at, found), high) if found < wanted else (low, (at, found))
    return np.nan


def equal_effort(world: World, five: tuple[Player, ...], v: float, pair: str, wanted: float) -> Iterator[tuple[float, Equal | None]]:
    """What each controller does at the effort wanted: the share that is done, and all of it at the end."""
    f = grid(world.parameters)
    bare = loop_of.__wrapped__(world, five[0])
    mechanics = mechanics_response(bare, f)

    def density(id: str, dial: float) -> tuple[np.ndarray, np.ndarray] | None:
        loop = loop_of.__wrapped__(world, Player(id, CONTROLLER_NAMES[ORDER.index(id)], retuned(id, dial, v, pair)))
        if not loop.stable:
            return None
        fine = with_resonances(f, loop)
        return fine, loop_density(loop, mechanics if fine is f else mechanics_response(bare, fine))

    def effort(id: str, dial: float) -> float:
        found = density(id, dial)
        return np.inf if found is None else float(band_rms(found[0], found[1][:, 5:], 0.0, np.inf).max())

    base = band_rms(f, loop_density(bare, mechanics)[:, :3], *BAND_HZ)
    found = Equal(wanted, *(np.full(shape, np.nan) for shape in ((4,), (4,), (4, 3), (4, 3))))
    for i, id in enumerate(ORDER[1:]):
        dial = met(lambda at, id=id: effort(id, at), wanted)
        spectrum = density(id, dial) if np.isfinite(dial) else None
        if spectrum is not None:
            fine, S = spectrum
            found.dials[i], found.forces[i] = dial, band_rms(fine, S[:, 5:], 0.0, np.inf).max()
            found.rms[i] = 1e6 * band_rms(fine, S[:, :3], 0.0, np.inf)
            found.band_db[i] = 20 * np.log10(base / band_rms(fine, S[:, :3], *BAND_HZ))
        yield (i + 1) / 4, found if i == 3 else None
