"""Stack the three parts of the criterion J as slabs on a body, with their names and the value of J."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import accumulate

from ...colours import COLOURS
from ...text import format_number
from .body import DARK_GREY, STEEL, Box, ErrorMarks, Part, Pose, Vector

SLABS = (("T", COLOURS["muted"]), ("L", COLOURS["second"]), ("M", COLOURS["force"]))  # lowest first: each names the matrix of its size
HALF, FOOT, DEEP, PLATE_Y = 0.17, 0.05, 0.3, 0.2  # half the width of a slab, height of the foot, depth of a slab, y of the plate behind
LEAST, NAMED = 0.004, 0.09  # stage units: the least height of a slab that is drawn; from which height on a slab has its name
SIZE = 1.5  # the highest tower
BESIDE, ABOVE, HIDDEN = 0.06, 0.05, -9.0  # from a slab to its name, from the tower to the value; out of sight


class CriterionTower:
    """A tower of the height `SIZE` where J is `full`, on a base of the height `on`; a higher J fills it in the same shares."""

    def __init__(self, across: float, on: float, full: float) -> None:
        self._across, self._on, self._full = across, on, full

    def parts(self) -> tuple[Part, ...]:
        """The foot, the plate behind, a line at each tenth and the slabs."""
        return (Part("J foot", Box((2.6 * HALF, 1.4 * DEEP, FOOT)), STEEL), Part("J plate", Box((2.4 * HALF, 0.05, SIZE)), COLOURS["tube"]),
                *(Part(f"J line {k}", Box((2.4 * HALF, 0.02, 0.012)), DARK_GREY) for k in range(1, 5)),
                *(Part(f"J {name}", Box((2 * HALF, DEEP, 1.0)), colour) for name, colour in SLABS))

    def fixed(self) -> dict[str, Pose]:
        """The poses of foot, plate and lines."""
        foot = self._on + FOOT
        return {"J foot": Pose((self._across, 0.0, self._on + FOOT / 2)), "J plate": Pose((self._across, PLATE_Y, foot + SIZE / 2)),
                **{f"J line {k}": Pose((self._across, PLATE_Y - 0.03, foot + SIZE * k / 4)) for k in range(1, 5)}}

    def _heights(self, sizes: Sequence[float]) -> list[float]:
        times = SIZE / max(self._full, sum(sizes))
        return [times * size for size in sizes]

    def moving(self, sizes: Sequence[float]) -> Mapping[str, Pose]:
        """The slabs for the three parts of J."""
        heights = self._heights(sizes)
        feet = accumulate(heights, initial=self._on + FOOT)
        return {f"J {name}": Pose((self._across, 0.0, foot + high / 2 if high >= LEAST else HIDDEN), scale=(1.0, 1.0, max(high, LEAST)))
                for (name, _), foot, high in zip(SLABS, feet, heights, strict=False)}

    def words(self, sizes: Sequence[float]) -> ErrorMarks:
        """The value of J on top, the names of the slabs that are high enough beside them."""
        heights = self._heights(sizes)
        feet = list(accumulate(heights, initial=self._on + FOOT))

        def beside(foot: float, high: float) -> Vector:
            return (self._across + 1.2 * HALF + BESIDE, 0.0, foot + high / 2 if high >= NAMED else HIDDEN)

        return ErrorMarks((), ((f"J = {format_number(sum(sizes), '.3g')}", (self._across, 0.0, feet[-1] + ABOVE), "bottom-center"),
                               *((name, beside(foot, high), "center-left")
                                 for (name, _), foot, high in zip(SLABS, feet, heights, strict=False))))
