"""What a design's data say, and what may honestly be said of it: never "rank n" alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.engine.structure import Mode

from .cases import Case, Sensed
from .criteria import Criterion
from .knowledge import Belief, Rebuilt
from .sweep import Sweep

NEAR = 0.02  # a mode nearer than this to being hidden (in typical sizes) is called nearly hidden


@dataclass(frozen=True, eq=False)
class Found:
    """All that a design leads to; `rank` is that of the whole O at the tolerance; no sweep where no knob moves a sensor."""

    case: Case
    sensed: Sensed
    rebuilt: Rebuilt
    belief: Belief
    start: np.ndarray
    criteria: tuple[Criterion, ...]
    weakest: Mode
    rank: int
    sweep: Sweep | None


def judged(found: Found) -> str:
    """hidden, near, unresolved or clear."""
    if not found.sensed.seen.observable:
        return "hidden"
    if found.weakest.distance < NEAR:
        return "near"
    return "clear" if found.belief.known == found.sensed.plant.n else "unresolved"
