"""Stand two equal decks one above the other, each with its name, a bar on a light rail and its number."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from ...colours import COLOURS
from ...text import Text
from .body import DARK_GREY, PLANT_COLOUR, STEEL, Arrow, Ball, Body, Box, ErrorMarks, Part, Pose, Rod, Vector, pose_between

STOREY = 2.62  # stage units from one deck's floor to the other's
PILLAR_X, PILLAR_Y, SLAB_TOP = 2.5, 0.8, 0.14
BAR_FROM, BAR_LONG, BAR_AT = -2.45, 3.6, (-1.1, 0.18)  # where bars begin, how long one of 1 is, y and z before a slab
RAIL_SIZE, RAIL_AT, BAR = (5.2, 0.05, 0.34), (0.0, -1.0, 0.17), 0.1  # the light rail behind a bar, below the springs; the radius of a bar
MOST_SHARE, LEAST_SHARE = 1.05, 0.01  # of the full length that a bar shows
NAME_AT = -1.95, -1.06, -0.13  # below each rail: the name of its deck
TITLES_AT = (0.85, -1.06, -0.13), (0.3, -1.06, -0.13)  # below the upper and the lower rail: what bars show, which are good
SIZE_AT, SIZE_UP = 1.4, 0.1  # across: where the number of a bar begins; above the bar
RING = 0.05, 0.17  # along a bar and across it: the flat ring that shows where the bar ended before
LANE_Y, LANE_Z, LANE_LONG, BEAD = -2.4, 0.06, 3.6, 0.1  # the lane of a time on the floor before the lower deck; its bead
FLOORS = ("upper", "lower")


def two_decks(deck: Body, states: int, inputs: int, names: tuple[Text, Text],
              titles: tuple[Text, Text], said: Callable[[float], str], tags: Sequence[tuple[Text, Vector]] = (),
              ticks: Sequence[float] = (),
              beside: bool = True, colours: tuple[str, str] = (PLANT_COLOUR, PLANT_COLOUR), rings: Sequence[float] = (),
              lane: tuple[float, Text] | None = None) -> Body:
    """The state is that of the upper deck, that of the lower one, the shares of the full length of both bars, and their numbers.

    A number is `said` at the end of its rail; `titles` below the rails say what bars show. `tags` are words and where they stand at each
    of the decks, `ticks` are shares with a mark on each rail. Where the ghost has a bar, it lies `beside`. Each deck and its bar have one
    of the `colours`. `rings` are the shares of both bars before, and a `lane` before the lower deck has a bead at a share, and words.
    """
    heights, titles_at = (STOREY, 0.0), TITLES_AT if lane is None else 2 * TITLES_AT[:1]
    rails = {f"{floor} rail": Pose((RAIL_AT[0], RAIL_AT[1], RAIL_AT[2] + height)) for floor, height in zip(FLOORS, heights, strict=True)}
    rails |= {f"{floor} tick {k}": Pose((BAR_FROM + BAR_LONG * share, RAIL_AT[1] - 0.06, RAIL_AT[2] + height))
              for floor, height in zip(FLOORS, heights, strict=True) for k, share in enumerate(ticks)}
    rails |= {f"{floor} ring": Pose((BAR_FROM + BAR_LONG * min(max(share, LEAST_SHARE), MOST_SHARE), BAR_AT[0], BAR_AT[1] + height))
              for floor, height, share in zip(FLOORS, heights, rings, strict=False)}
    if lane is not None:
        rails["lane"] = Pose((BAR_FROM + LANE_LONG / 2, LANE_Y, LANE_Z / 2))
        rails["lane start"] = Pose((BAR_FROM, LANE_Y, LANE_Z + BEAD))
        rails["lane end"] = Pose((BAR_FROM + LANE_LONG, LANE_Y, LANE_Z + BEAD))
        rails["lane bead"] = Pose((BAR_FROM + LANE_LONG * min(max(lane[0], 0.0), 1.0), LANE_Y, LANE_Z + BEAD))

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
        return ErrorMarks((), tuple((said(float(number)), (SIZE_AT, BAR_AT[0], BAR_AT[1] + SIZE_UP + height), "center-left")
                                    for height, number in zip(heights, x[2 * states + 2:2 * states + 4], strict=True)))

    parts = (*(Part(f"pillar {k}", Rod(0.07), STEEL) for k in range(len(PILLARS))),
             *(replace(part, name=f"{floor} {part.name}", colour=colour if part.colour == PLANT_COLOUR else part.colour)
               for floor, colour in zip(FLOORS, colours, strict=True) for part in deck.parts),
             *(Part(f"{floor} rail", Box(RAIL_SIZE), COLOURS["paper"]) for floor in FLOORS),
             *(Part(f"{floor} tick {k}", Box((0.03, 0.04, RAIL_SIZE[2])), DARK_GREY) for floor in FLOORS for k in range(len(ticks))),
             *(Part(f"{floor} bar", Rod(BAR), colour, twin=beside) for floor, colour in zip(FLOORS, colours, strict=True)),
             *(Part(f"{floor} ring", Box((RING[0], 2 * RING[1], 2 * RING[1])), COLOURS["muted"], opacity=0.8)
               for floor, _ in zip(FLOORS, rings, strict=False)),
             *(() if lane is None else (
                 Part("lane", Box((LANE_LONG, 0.24, LANE_Z)), COLOURS["bench"]), Part("lane bead", Ball(BEAD), COLOURS["force"]),
                 *(Part(f"lane {end}", Box((0.04, 0.24, 2 * BEAD)), DARK_GREY) for end in ("start", "end")))))
    return replace(
        deck, parts=parts, pose=pose, arrows=arrows, anchors=anchors, marks=marks,
        labels=(*((words, _raised(NAME_AT, height)) for words, height in zip(names, heights, strict=True)),
                *((words, _raised(place, height)) for words, place in tags for height in heights),
                *((words, _raised(at, height)) for words, at, height in zip(titles, titles_at, heights, strict=True)),
                *(() if lane is None else ((lane[1], (BAR_FROM + LANE_LONG / 2, LANE_Y - 0.06, 0.0)),))),
        names=tuple(replace(name, part=f"upper {name.part}") for name in deck.names))


PILLARS = tuple((across, y) for across in (-PILLAR_X, PILLAR_X) for y in (PILLAR_Y,))


def _raised(place: Vector, height: float) -> Vector:
    return place[0], place[1], place[2] + height
