"""Realise a transfer function or a small matrix of them with as few states as its poles need."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..structure.decomposition import kalman_decomposition
from ..systems.errors import EngineError, Phrase
from ..systems.fractions import Fraction, realised_by_entries
from ..systems.plant import Plant
from ..systems.spectrum import frequency_response
from .notes import note

__all__ = ["realised"]

SAME = 1e-7  # how well the smaller realisation must give the same frequency response, relative to its size


def realised(entries: Sequence[Sequence[Fraction]], dt: float) -> tuple[Plant, tuple[Phrase, ...]]:
    """The plant of a p×m matrix of fractions, and the note that says whether it is minimal.

    Raises EngineError for an improper or empty fraction, and for one without finite coefficients.
    """
    plant = realised_by_entries(entries, dt)
    if not plant.n:
        raise EngineError("The transfer function is a plain gain without states; there is nothing to observe.")
    return _least(plant)


def _least(plant: Plant) -> tuple[Plant, tuple[Phrase, ...]]:
    """The part that is reached and seen, where it gives the same frequency response; else the plant as it is."""
    try:
        found = kalman_decomposition(plant)
        small, hidden = found.minimal, plant.n - found.sizes[0]
    except EngineError:
        return plant, (note("not_minimal", after=plant.n),)
    if not hidden:
        return plant, (note("realised", after=plant.n),)
    if not small.n or not _same(plant, small):
        return plant, (note("not_minimal", after=plant.n),)
    made = Plant(small.A, small.B, small.C, small.D, plant.dt)
    return made, (note("minimal", after=made.n, gone=hidden),)


def _same(plant: Plant, small: Plant) -> bool:
    size = max(float(np.abs(plant.poles).max(initial=0.0)), 1e-300)
    grid = np.linspace(0.05, 3.0, 17) / plant.dt if plant.dt else size * np.geomspace(1e-4, 1e2, 25)
    with np.errstate(all="ignore"):
        one, two = (frequency_response(part.A, part.B, part.C, part.D, grid, dt=plant.dt) for part in (plant, small))
    return bool(np.isfinite(two).all() and np.abs(one - two).max() <= SAME * max(np.abs(one).max(), 1e-300))
