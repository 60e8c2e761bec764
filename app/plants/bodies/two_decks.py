"""Stand two equal decks one above the other, each with its name and a bar of its motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ...text import Text
from .body import PLANT_COLOUR, STEEL, Arrow, Body, Part, Pose, Rod, Vector, pose_between

STOREY = 2.62  # stage units from one deck's floor to the other's
PILLAR_X, PILLAR_Y, SLAB_TOP = 2.5, 0.8, 0.14
BAR_FROM, BAR_LONG, BAR_AT = -2.45, 4.2, (-1.02, 0.07)  # where bars begin, how long one of 1 is, y and z before a slab
MOST_SHARE, LEAST_SHARE = 1.15, 0.01  # of the motion without control that a bar shows
NAME_AT = (-1.15, -1.04, -0.06)  # between posts and sensors of the deck below
FLOORS = ("upper", "lower")


def two_decks(deck: Body, states: int, inputs: int, names: tuple[Text, Text],
              tags: Sequence[tuple[Text, Vector]] = ()) -> Body:
    """The state is that of the upper deck, that of the lower one, and the share of motion that each bar shows.

    `tags` are words and where they stand at each of the decks.
    """
    heights = (STOREY, 0.0)

    def split(x: Sequence[float]) -> tuple[Sequence[float], Sequence[float]]:
        return x[:states], x[states:2 * states]

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        poses = {f"pillar {k}": pose_between((across, y, SLAB_TOP), (across, y, STOREY)) for k, (across, y) in enumerate(PILLARS)}
        for floor, height, own, share in zip(FLOORS, heights, split(x), x[2 * states:], strict=True):
            poses |= {f"{floor} {name}": replace(each, position=_raised(each.position, height))
                      for name, each in deck.pose(own, gain).items()}
            y, z = BAR_AT
            long = BAR_LONG * min(max(float(share), LEAST_SHARE), MOST_SHARE)
            poses[f"{floor} bar"] = pose_between((BAR_FROM, y, z + height), (BAR_FROM + long, y, z + height))
        return poses

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return tuple(replace(arrow, tail=_raised(arrow.tail, height), head=_raised(arrow.head, height))
                     for height, own, forces in zip(heights, split(x), (u[:inputs], u[inputs:]), strict=True)
                     for arrow in deck.arrows(own, forces, gain))

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return tuple(_raised(place, height) for height, own in zip(heights, split(x), strict=True) for place in deck.anchors(own, gain))

    parts = (*(Part(f"pillar {k}", Rod(0.07), STEEL) for k in range(len(PILLARS))),
             *(replace(part, name=f"{floor} {part.name}") for floor in FLOORS for part in deck.parts),
             *(Part(f"{floor} bar", Rod(0.07), PLANT_COLOUR, twin=True) for floor in FLOORS))
    return replace(
        deck, parts=parts, pose=pose, arrows=arrows, anchors=anchors,
        labels=(*((words, _raised(NAME_AT, height)) for words, height in zip(names, heights, strict=True)),
                *((words, _raised(place, height)) for words, place in tags for height in heights)),
        names=tuple(replace(name, part=f"upper {name.part}") for name in deck.names))


PILLARS = tuple((across, y) for across in (-PILLAR_X, PILLAR_X) for y in (PILLAR_Y,))


def _raised(place: Vector, height: float) -> Vector:
    return place[0], place[1], place[2] + height
