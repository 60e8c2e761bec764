"""Lay two lanes of gains before a body: the gains that a loop tolerates, and the true gain as a ball."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import log2

from ...colours import COLOURS, rgb
from ...text import Text, format_number, same, text
from .body import DARK_GREY, METAL, PLANT_COLOUR, Arrow, Ball, Body, Box, ErrorMarks, Part, Pose, Rod, Vector, pose_between

LEAST_GAIN, MOST_GAIN, MOST_WRITTEN = 0.25, 6.0, 100.0  # at the ends of a lane; beyond which a limit is written as ∞
OCTAVE, ONE_AT = 0.82, -0.25  # stage units for twice the gain, and where a gain of one is
TICKS = ((same("¼"), 0.25), (same("½"), 0.5), (same("1"), 1.0), (same("2"), 2.0), (same("4"), 4.0))
NEAR, FAR, WIDE, BEHIND = -0.88, -0.42, 0.38, 0.4  # y of both lanes, their width, and how far the body moves back
FLOOR, LANE = 0.1, 0.26  # stage units: top of the trough, thickness of a lane
APRON, TICK_AT = 0.42, (0.05, 0.12)  # stage units: of the trough before the near lane; from its edge to the numbers, and their upper edge
THINNEST = 0.014  # stage units of a lane that tolerates next to nothing
BALL, SUNK, PIN = 0.13, 0.03, 0.34  # the ball, how deep it lies in the trough, the pin that carries it above the lane
NEAR_ONE = 0.5  # limits nearer to 1 than this are written in percent
SIZE_AT, BESIDE = 1.6, 0.1  # the gain beyond which no size stands; stage units from a lane to its size
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


def limits_words(low: float, high: float) -> str:
    """The gains from `low` to `high` as they stand beside a lane: the distances to 1 in percent where both are small."""
    if max(1 - low, high - 1) < NEAR_ONE:
        return f"−{format_number(100 * (1 - low), '.2g')} % … +{format_number(100 * (high - 1), '.2g')} %"
    return f"{format_number(low, '.2g')} … {'∞' if high > MOST_WRITTEN else format_number(high, '.2g')}"


def with_gain_lanes(body: Body, states: int, names: tuple[Text, Text], pale: bool = True) -> Body:
    """The body behind two lanes. After its states come the limits of the near lane, those of the far one, and the true gain.

    The ball is green on its pin where the near lane carries it, else it lies in the trough and is red. The limits of the near lane
    stand beside it; with `pale` it lies in a pale one as long as the far one. `names` are those of the lanes.
    """
    middle, long = (gain_place(LEAST_GAIN) + gain_place(MOST_GAIN)) / 2, gain_place(MOST_GAIN) - gain_place(LEAST_GAIN)
    back, front = FAR + WIDE / 2 + 0.08, NEAR - WIDE / 2 - 0.08
    trough = Pose((middle, (back + front - APRON) / 2, FLOOR / 2))
    marks = {f"gain mark {k}": Pose((gain_place(gain), (back + front) / 2, FLOOR)) for k, (_, gain) in enumerate(TICKS)}

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        low, high, far_low, far_high, true = map(float, x[states:states + 5])
        held = low < true < high
        up, across = FLOOR + (LANE + PIN + BALL if held else BALL - SUNK), gain_place(true)
        behind = {name: replace(each, position=moved_back(each.position)) for name, each in body.pose(x[:states], gain).items()}
        return {**behind, "trough": trough, **marks, "near lane": _lane(NEAR, low, high),
                **({"pale lane": _lane(NEAR, far_low, far_high)} if pale else {}),
                "far lane": _lane(FAR, far_low, far_high), "pin": pose_between((across, NEAR, FLOOR), (across, NEAR, up)),
                "true gain": Pose((across, NEAR, up), colour=HOLDS if held else FALLS)}

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return tuple(replace(arrow, tail=moved_back(arrow.tail), head=moved_back(arrow.head)) for arrow in body.arrows(x[:states], u, gain))

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return tuple(map(moved_back, body.anchors(x[:states], gain)))

    def limits(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        low, high = map(float, x[states:states + 2])
        at = (gain_place(min(high, SIZE_AT)) + BESIDE, NEAR - WIDE / 2 - 0.02, FLOOR + 0.68 * LANE)
        return ErrorMarks((), ((limits_words(low, high), at, "center-left"),))

    parts = (*body.parts, Part("trough", Box((long + 0.3, back - front + APRON, FLOOR)), DARK_GREY),
             *(Part(name, Box((0.03, back - front, 0.03)), METAL) for name in marks),
             Part("near lane", Box((1.0, WIDE, LANE)), PLANT_COLOUR),
             Part("far lane", Box((1.0, WIDE, LANE)), METAL),
             *((Part("pale lane", Box((1.0, WIDE + 0.02, LANE + 0.02)), METAL, opacity=0.3),) if pale else ()),
             Part("pin", Rod(0.025), METAL),
             Part("true gain", Ball(BALL), COLOURS["force"]))
    said = (*((word, (gain_place(gain), front - APRON + TICK_AT[0], FLOOR + TICK_AT[1])) for word, gain in TICKS),
            (text("input gain (model: 1)"), (gain_place(1.0), front - APRON - 0.06, 0.0)))
    lanes = ((names[0], (NAMES_AT, NEAR - WIDE / 2 - 0.08, 3.6 * FLOOR)), (names[1], (NAMES_AT, FAR, 6.2 * FLOOR)))
    before = tuple((name, moved_back(place)) for name, place in body.labels)
    return replace(body, parts=parts, pose=pose, arrows=arrows, anchors=anchors, labels=(*before, *said, *lanes), marks=limits)
