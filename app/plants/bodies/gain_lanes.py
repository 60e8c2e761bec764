"""Lay two lanes of gains before a body: the gains that a loop tolerates, and the true gain as a ball."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import log2

from ...colours import COLOURS, rgb
from ...text import Text, same, text
from .body import DARK_GREY, METAL, PLANT_COLOUR, Arrow, Ball, Body, Box, Part, Pose, Vector

LEAST_GAIN, MOST_GAIN = 0.25, 6.0  # at the ends of a lane
OCTAVE, ONE_AT = 0.88, -0.25  # stage units for twice the gain, and where a gain of one is
TICKS = ((same("¼"), 0.25), (same("½"), 0.5), (text("input gain 1 (model)"), 1.0), (same("2"), 2.0), (same("4"), 4.0))
NEAR, FAR, WIDE, BEHIND = -0.88, -0.42, 0.38, 0.4  # y of both lanes, their width, and how far the body moves back
FLOOR, LANE = 0.1, 0.26  # stage units: top of the trough, thickness of a lane
THINNEST = 0.014  # stage units of a lane that tolerates next to nothing
BALL, SUNK = 0.13, 0.03
NAMES_AT = ONE_AT - 1.6 * OCTAVE  # where lanes are named: left of the gains that one half ends
HOLDS, FALLS = rgb(COLOURS["force"]), rgb(COLOURS["alarm"])


def gain_place(gain: float) -> float:
    """Where a gain is along a lane, in stage units; beyond the ends it stands there."""
    return ONE_AT + OCTAVE * log2(min(max(gain, LEAST_GAIN), MOST_GAIN))


def _lane(y: float, low: float, high: float) -> Pose:
    left, right = gain_place(low), gain_place(high)
    return Pose(((left + right) / 2, y, FLOOR + LANE / 2), scale=(max(right - left, THINNEST), 1.0, 1.0))


def moved_back(place: Vector, by: float = BEHIND, up: float = 0.0) -> Vector:
    """Where a point of the body is once something lies before it."""
    return place[0], place[1] + by, place[2] + up


def with_gain_lanes(body: Body, states: int, names: tuple[Text, Text]) -> Body:
    """The body behind two lanes. After its states come the limits of the near lane, those of the far one, and the true gain.

    The ball is green where the near lane carries it, else it lies in the trough and is red. `names` are those of the lanes.
    """
    middle, long = (gain_place(LEAST_GAIN) + gain_place(MOST_GAIN)) / 2, gain_place(MOST_GAIN) - gain_place(LEAST_GAIN)
    trough = Pose((middle, (NEAR + FAR) / 2, FLOOR / 2))
    marks = {f"gain mark {k}": Pose((gain_place(gain), (NEAR + FAR) / 2, FLOOR)) for k, (_, gain) in enumerate(TICKS)}

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        low, high, far_low, far_high, true = map(float, x[states:states + 5])
        held = low < true < high
        up = FLOOR + (LANE + BALL if held else BALL - SUNK)
        behind = {name: replace(each, position=moved_back(each.position)) for name, each in body.pose(x[:states], gain).items()}
        return {**behind, "trough": trough, **marks, "near lane": _lane(NEAR, low, high),
                "far lane": _lane(FAR, far_low, far_high),
                "true gain": Pose((gain_place(true), NEAR, up), colour=HOLDS if held else FALLS)}

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return tuple(replace(arrow, tail=moved_back(arrow.tail), head=moved_back(arrow.head)) for arrow in body.arrows(x[:states], u, gain))

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return tuple(map(moved_back, body.anchors(x[:states], gain)))

    parts = (*body.parts, Part("trough", Box((long + 0.3, FAR - NEAR + WIDE + 0.16, FLOOR)), DARK_GREY),
             *(Part(name, Box((0.03, FAR - NEAR + WIDE, 0.03)), METAL) for name in marks),
             Part("near lane", Box((1.0, WIDE, LANE)), PLANT_COLOUR),
             Part("far lane", Box((1.0, WIDE, LANE)), METAL),
             Part("true gain", Ball(BALL), COLOURS["force"]))
    at = NEAR - WIDE / 2 - 0.12
    said = tuple((word, (gain_place(gain), at, 0.0)) for word, gain in TICKS)
    lanes = ((names[0], (NAMES_AT, NEAR - WIDE / 2, 2.2 * FLOOR)), (names[1], (NAMES_AT, FAR, 3.6 * FLOOR)))
    before = tuple((name, moved_back(place)) for name, place in body.labels)
    return replace(body, parts=parts, pose=pose, arrows=arrows, anchors=anchors, labels=(*before, *said, *lanes))
