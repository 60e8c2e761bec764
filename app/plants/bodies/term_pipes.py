"""Lead unknown terms from gauge to gauge in pipes, through the block of a gain."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import sqrt

from ...colours import COLOURS
from ...text import Text, format_number, joined, text
from .body import METAL, PLANT_COLOUR, STEEL, Body, Box, ErrorMarks, Part, Pose, Rod, Vector, pose_between

PLATE_AT = 0.5  # of the way from the first end to the other: the block of the gain
BACK, TOP, PITCH = 0.13, 1.86, 0.52  # y of the pipes; how high the first one is, and down to the next
FULL, GLASS, LEAST = 0.18, 1.12, 1e-3  # radius of a pipe whose share is one; of the glass around it; what is next to nothing
COLLAR, COLLAR_LONG = 1.25, 0.05  # radius of the ring at the end of a pipe, times the pipe's; how long the ring is
NAME_ABOVE = 0.13  # stage units from a pipe to the upper edge of its name
MOST = 1.4  # of a share that is drawn
LAG_FULL, LAG_HIGH = 0.36, 1.3  # radius of the pipe of a lag whose share is one; how high it is
BLOCK, LAG_BLOCK, SIZE_BELOW = (0.26, 0.5), (0.26, 0.96, 1.2), 0.16  # of blocks of the gain; from a pipe to its size
POST, TABLE, PAST = 0.05, 0.1, 0.5  # radius of the post below a block, where it stands, how far a block is past its pipes
L_UP = 0.1  # from the middle of a block to the upper edge of its name
Across = tuple[float, float]  # where pipes begin and end


def thickness(share: float) -> float:
    """Of a pipe beside that of share one: its cross-section is the share."""
    return max(sqrt(min(max(share, 0.0), MOST)), LEAST)


def _collar(at: Vector, side: int, thick: float) -> Pose:
    """A ring at the end of a pipe, on the `side` where the pipe is: 1 for the right."""
    return pose_between(at, (at[0] + side * COLLAR_LONG, at[1], at[2]), COLLAR * thick)


def with_pipes(body: Body, states: int, terms: Sequence[tuple[str, float]], across: Across) -> Body:
    """The body with a blue pipe for each of the named `terms`, as thick as its share, up to the block.

    After the body's states come the shares that the gain leaves, pink behind the block.
    """
    heights = [TOP - PITCH * k for k in range(len(terms))]
    middle = across[0] + PLATE_AT * (across[1] - across[0])
    ends = [tuple((x, BACK, z) for x in (across[0], middle, across[1])) for z in heights]
    high = heights[0] - heights[-1] + PAST
    fixed = _standing((middle, BACK, (heights[0] + heights[-1]) / 2), high)
    for k, (_, share) in enumerate(terms):
        begin, plate, end = ends[k]
        empty = GLASS * max(thickness(share), 0.3)
        fixed |= {f"term {k}": pose_between(begin, plate, thickness(share)), f"glass {k}": pose_between(plate, end, empty),
                  f"first collar {k}": _collar(begin, 1, thickness(share)), f"last collar {k}": _collar(end, -1, empty)}

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        flows = {f"left {k}": pose_between(plate, end, thickness(float(share)))
                 for k, (share, (_, plate, end)) in enumerate(zip(x[states:], ends, strict=False))}
        return {**body.pose(x[:states], gain), **fixed, **flows}

    parts = tuple(part for k in range(len(terms)) for part in (
        Part(f"term {k}", Rod(FULL), PLANT_COLOUR), Part(f"left {k}", Rod(FULL), COLOURS["error"]),
        Part(f"glass {k}", Rod(FULL), STEEL, opacity=0.3),
        Part(f"first collar {k}", Rod(FULL), STEEL), Part(f"last collar {k}", Rod(FULL), STEEL)))
    labels = (*((name, ((across[0] + middle) / 2, BACK - FULL, z + FULL * thickness(share) + NAME_ABOVE))
                for (name, share), z in zip(terms, heights, strict=True)),
              _name_of_block(fixed["gain plate"].position, BLOCK[1]))
    told = text("Pipes from the dark gauges: unknown terms of the error, blue as they are, pink what L leaves of them.")
    return _joined(body, states, (*parts, *_block((*BLOCK, high))), pose, labels, told)


def with_lag_pipe(body: Body, states: int, names: tuple[Text, Text], full: float, across: Across) -> Body:
    """The body with one pink pipe from end to end through the block of the gain: what a differentiator misses, and L times that.

    After the body's states come both sizes, each written below its half; `names` are those of the halves. A pipe of size `full`
    has the cross-section of share one.
    """
    middle = across[0] + PLATE_AT * (across[1] - across[0])
    begin, plate, end = ((x, BACK, LAG_HIGH) for x in (across[0], middle, across[1]))
    halves, block = ((across[0] + middle) / 2, (middle + across[1]) / 2), _standing(plate, LAG_BLOCK[2])

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        missed, times = (thickness(float(size) / full) for size in x[states:states + 2])
        return {**body.pose(x[:states], gain), **block, "missed": pose_between(begin, plate, missed),
                "missed times L": pose_between(plate, end, times),
                "first collar": _collar(begin, 1, missed), "last collar": _collar(end, -1, times)}

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        own = () if body.marks is None else body.marks(x[:states], xhat[:states], gain).words
        sizes = [float(size) for size in x[states:states + 2]]
        below = [LAG_HIGH - LAG_FULL * thickness(size / full) - SIZE_BELOW for size in sizes]
        return ErrorMarks((), (*((format_number(size, ".2g"), (at, BACK - 0.5 * LAG_FULL, z), "center-center")
                                 for size, at, z in zip(sizes, halves, below, strict=True)), *own))

    parts = (*(Part(name, Rod(LAG_FULL), COLOURS["error"]) for name in ("missed", "missed times L")),
             *(Part(name, Rod(LAG_FULL), STEEL) for name in ("first collar", "last collar")), *_block(LAG_BLOCK))
    labels = ((names[0], (halves[0], BACK - 0.5 * LAG_FULL, LAG_HIGH + 0.3 * LAG_FULL + NAME_ABOVE)),
              (names[1], (halves[1], BACK - 0.5 * LAG_FULL, LAG_HIGH + 0.9 * LAG_FULL + NAME_ABOVE)),
              _name_of_block(plate, LAG_BLOCK[1]))
    told = text("Pipe: what the differentiator misses, and behind the block L times that.")
    return replace(_joined(body, states, parts, pose, labels, told), marks=marks)


def _block(size: Vector) -> tuple[Part, Part]:
    """The block of the gain, through which pipes go, and the post that carries it."""
    return Part("gain plate", Box(size), METAL), Part("gain post", Rod(POST), STEEL)


def _standing(middle: Vector, high: float) -> dict[str, Pose]:
    """The poses of a block and of its post."""
    across, y, z = middle
    return {"gain plate": Pose(middle), "gain post": pose_between((across, y, TABLE), (across, y, z - high / 2))}


def _name_of_block(middle: Vector, deep: float) -> tuple[str, Vector]:
    """L on the front of the block."""
    return "L", (middle[0], middle[1] - deep / 2 - 0.02, middle[2] + L_UP)


def _joined(body: Body, states: int, parts: tuple[Part, ...], pose: Callable[[Sequence[float], float], Mapping[str, Pose]],
            labels: tuple[tuple[Text | str, Vector], ...], told: Text) -> Body:
    """The body with more parts, whose own states are the first ones."""
    own = body.marks
    return replace(body, parts=(*body.parts, *parts), pose=pose, labels=(*body.labels, *labels), caption=joined(body.caption, told),
                   anchors=lambda x, gain: body.anchors(x[:states], gain), arrows=lambda x, u, gain: body.arrows(x[:states], u, gain),
                   marks=None if own is None else lambda x, xhat, gain: own(x[:states], xhat[:states], gain))
