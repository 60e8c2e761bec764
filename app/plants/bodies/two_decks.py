"""Stand two equal decks one above the other, each with its name, a bar on a light rail and its number."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from ...colours import COLOURS
from ...text import Text
from .body import DARK_GREY, PLANT_COLOUR, STEEL, Arrow, Body, Box, ErrorMarks, Part, Pose, Rod, Vector, pose_between

STOREY = 2.62  # stage units from one deck's floor to the other's
PILLAR_X, PILLAR_Y, SLAB_TOP = 2.5, 0.8, 0.14
BAR_FROM, BAR_LONG, BAR_AT = -2.45, 3.6, (-1.1, 0.5)  # where bars begin, how long one of 1 is, y and z before a slab
RAIL_SIZE, RAIL_AT, BAR = (5.2, 0.05, 0.68), (0.0, -1.0, 0.34), 0.1  # the light rail behind a bar; the radius of a bar
MOST_SHARE, LEAST_SHARE = 1.05, 0.01  # of the full length that a bar shows
NAME_AT, TITLE_AT = (-2.0, -1.06, 0.22), (1.0, -1.06, 0.21)  # below the bar on its rail: the name of each deck, what bars show
SIZE_AT = 1.45  # across: where the number of a bar begins
FLOORS = ("upper", "lower")


def two_decks(deck: Body, states: int, inputs: int, names: tuple[Text, Text],
              title: Text, said: Callable[[float], str], tags: Sequence[tuple[Text, Vector]] = (), ticks: Sequence[float] = (),
              beside: bool = True) -> Body:
    """The state is that of the upper deck, that of the lower one, the shares of the full length of both bars, and their numbers.

    A number is `said` at the end of its rail; `title` says what bars show. `tags` are words and where they stand at each of the decks,
    `ticks` are shares with a mark on each rail. Where the ghost has a bar, it lies `beside`.
    """
    heights = (STOREY, 0.0)
    rails = {f"{floor} rail": Pose((RAIL_AT[0], RAIL_AT[1], RAIL_AT[2] + height)) for floor, height in zip(FLOORS, heights, strict=True)}
    rails |= {f"{floor} tick {k}": Pose((BAR_FROM + BAR_LONG * share, RAIL_AT[1] - 0.06, RAIL_AT[2] + height))
              for floor, height in zip(FLOORS, heights, strict=True) for k, share in enumerate(ticks)}

    def split(x: Sequence[float]) -> tuple[Sequence[float], Sequence[float]]:
        return x[:states], x[states:2 * states]

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        poses = {f"pillar {k}": pose_between((across, y, SLAB_TOP), (across, y, STOREY)) for k, (across, y) in enumerate(PILLARS)}
        poses |= rails
        for floor, height, own, share in zip(FLOORS, heights, split(x), x[2 * states:2 * states + 2], strict=True):
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

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        return ErrorMarks((), tuple((said(float(number)), (SIZE_AT, BAR_AT[0], BAR_AT[1] + height), "center-left")
                                    for height, number in zip(heights, x[2 * states + 2:2 * states + 4], strict=True)))

    parts = (*(Part(f"pillar {k}", Rod(0.07), STEEL) for k in range(len(PILLARS))),
             *(replace(part, name=f"{floor} {part.name}") for floor in FLOORS for part in deck.parts),
             *(Part(f"{floor} rail", Box(RAIL_SIZE), COLOURS["paper"]) for floor in FLOORS),
             *(Part(f"{floor} tick {k}", Box((0.03, 0.04, RAIL_SIZE[2])), DARK_GREY) for floor in FLOORS for k in range(len(ticks))),
             *(Part(f"{floor} bar", Rod(BAR), PLANT_COLOUR, twin=beside) for floor in FLOORS))
    return replace(
        deck, parts=parts, pose=pose, arrows=arrows, anchors=anchors, marks=marks,
        labels=(*((words, _raised(NAME_AT, height)) for words, height in zip(names, heights, strict=True)),
                *((words, _raised(place, height)) for words, place in tags for height in heights), (title, _raised(TITLE_AT, STOREY))),
        names=tuple(replace(name, part=f"upper {name.part}") for name in deck.names))


PILLARS = tuple((across, y) for across in (-PILLAR_X, PILLAR_X) for y in (PILLAR_Y,))


def _raised(place: Vector, height: float) -> Vector:
    return place[0], place[1], place[2] + height
