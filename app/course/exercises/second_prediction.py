"""Define the second prediction of a lesson, asked once a surprising knob is moved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..design import Design


@dataclass(frozen=True)
class SecondPrediction:
    """What one of the `knobs` does is to be predicted, once one of them is moved; words stand under `## again`.

    `answer` is the index of the right option, `trial` the values of the knobs at which the run shows it. Until a person chooses
    or skips, the `figures` (by id) that would answer are veiled, with `numbers` the equations too; everything else stays.
    """

    knobs: tuple[str, ...]
    answer: int
    trial: Mapping[str, Any]
    figures: tuple[str, ...]
    numbers: bool = False

    def touched(self, start: Design, design: Design) -> bool:
        """Whether one of its knobs stands elsewhere than at the start."""
        return any(design[name] != start[name] for name in self.knobs)
