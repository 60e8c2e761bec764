"""Stand a gauge of the height before the deck, with its command and the run without integral action."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from observer_lab.colours import COLOURS
from observer_lab.plants.bodies.body import DARK_GREY, PLANT_COLOUR, Body, Box, ErrorMarks, Part, Pose, Vector
from observer_lab.text import Text, format_number, text

FULL_MM, HIGH = 5.0, 1.5  # height at the far end of the gauge, and its length in stage units
MARKS = 6  # one for each millimetre
MIDDLE, FRONT, FOOT = 0.0, -1.15, 0.06  # x, y and lowest z of the gauge
WIDE, COLUMN, THIN = 1.75, 0.38, 0.02  # of the plate, which fits between the springs; of a column; of a line
ALONE, OWN, BESIDE = 0.25, -0.08, 0.66  # across: a column that is alone, that of the present run beside an old one, the old one
LEAST, LIFT = 0.004, 0.03  # stage units: the least length of a column that is drawn; from a column to its number
COUNT = 3  # values after the deck's states: height, command, height without integral action, in mm


def gauge_record(z: np.ndarray, r: float, other: np.ndarray | None) -> np.ndarray:
    """The values (n_t, 3) of the gauge in mm: a height, its command, and the height of another run, which may have ended earlier."""
    known = np.zeros(1) if other is None else other
    old = np.append(known, np.full(max(len(z) - len(known), 0), known[-1]))[:len(z)]
    return np.column_stack([z, np.full(len(z), r), old])


def gauge_share(height: float, up: bool) -> float:
    """How far along the gauge a height in mm is, 0 to 1; downwards heights below rest count."""
    return min(max((height if up else -height) / FULL_MM, 0.0), 1.0)


@lru_cache(maxsize=8)
def with_height_gauge(deck: Body, states: int, up: bool, compared: bool) -> Body:
    """The deck with a gauge before it; `compared` shows the other run as a pale column beside."""
    foot, own = FOOT if up else FOOT + HIGH, OWN if compared else ALONE  # where columns begin, and where that of the present run is

    def level(height: float) -> float:
        return foot + (1 if up else -1) * HIGH * gauge_share(height, up)

    def column(across: float, height: float) -> Pose:
        top = level(height)
        return Pose((MIDDLE + across, FRONT - 0.04, (foot + top) / 2), scale=(1.0, 1.0, max(abs(top - foot), LEAST)))

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        z, r, old = map(float, x[states:states + COUNT])
        marks = {f"height mark {k}": Pose((MIDDLE - WIDE / 2 + 0.06, FRONT - 0.03, level(k if up else -k))) for k in range(MARKS)}
        return {**deck.pose(x[:states], gain), **marks, "height plate": Pose((MIDDLE, FRONT, FOOT + HIGH / 2)),
                "height": column(own, z), "target": Pose((MIDDLE, FRONT - 0.09, level(r))),
                **({"old height": column(BESIDE, old)} if compared else {})}

    def words(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        z, r, old = map(float, x[states:states + COUNT])
        lift, side, under = (LIFT, "bottom-center", "top-left") if up else (-LIFT, "top-center", "bottom-left")

        def above(height: float) -> float:
            return level(max(height, r) if up else min(height, r)) + lift
        found = [(f"z = {format_number(z, '.2f')} mm", (MIDDLE + own, FRONT - 0.1, above(z)), side),
                 (f"r = {format_number(r, '.3g')} mm", (MIDDLE - WIDE / 2 + 0.02, FRONT - 0.1, level(r) - lift), under)]
        if compared:
            found.append((f"{format_number(old, '.2f')} mm", (MIDDLE + BESIDE, FRONT - 0.1, above(old)), side))
        return ErrorMarks((), tuple(found))

    parts = (*deck.parts, Part("height plate", Box((WIDE, 0.04, HIGH + 0.08)), COLOURS["tube"]),
             *(Part(f"height mark {k}", Box((0.12, 0.03, THIN)), DARK_GREY) for k in range(MARKS)),
             Part("height", Box((COLUMN, 0.06, 1.0)), PLANT_COLOUR),
             *((Part("old height", Box((COLUMN, 0.06, 1.0)), COLOURS["muted"], opacity=0.5),) if compared else ()),
             Part("target", Box((WIDE + 0.06, 0.05, 1.2 * THIN)), DARK_GREY))
    labels: tuple[tuple[Text | str, Vector], ...] = ((text("height of the deck"), (MIDDLE + own, FRONT - 0.1, 0.0)),)
    if compared:
        labels = (*labels, (text("pale: without integral action"), (MIDDLE + BESIDE, FRONT - 0.1, 0.0)))
    return replace(deck, parts=parts, pose=pose, marks=words, labels=(*deck.labels, *labels),
                   arrows=lambda x, u, gain: deck.arrows(x[:states], u, gain), anchors=lambda x, gain: deck.anchors(x[:states], gain))
