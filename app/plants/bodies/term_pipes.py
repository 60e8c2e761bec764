"""Lead unknown terms from gauge to gauge in pipes, through the plate of a gain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import sqrt

from ...colours import COLOURS
from ...text import Text, format_number, joined, text
from .body import METAL, PLANT_COLOUR, STEEL, Body, Box, ErrorMarks, Part, Pose, Rod, Vector, pose_between

BEGIN, PLATE, END = -0.75, 0.32, 0.86  # across: behind the dark gauges, the plate, behind the large gauge
BACK, TOP, PITCH = 0.3, 1.86, 0.45  # y of the pipes; how high the first one is, and down to the next
FULL, GLASS, LEAST = 0.18, 1.12, 1e-3  # radius of a pipe whose share is one; of the glass around it; what is next to nothing
SIZE_AT = 0.5  # across: the size of what a differentiator misses
NAME_AT, NAME_ABOVE = -0.02, 0.13  # across: the names of the pipes; stage units from a pipe to the upper edge of its name
MOST = 1.4  # of a share that is drawn


def thickness(share: float) -> float:
    """Of a pipe beside that of share one: its cross-section is the share."""
    return max(sqrt(min(max(share, 0.0), MOST)), LEAST)


def with_pipes(body: Body, states: int, terms: Sequence[tuple[str, float]], lag: Text | None = None, full: float = 1.0) -> Body:
    """The body with a blue pipe for each of the named `terms`, as thick as its share, up to the plate.

    After the body's states come the shares that the gain leaves, pink behind the plate, and with a `lag` that of what a
    differentiator misses: a pipe of its own, past the plate, with its size on it; `full` is the size of share one.
    """
    heights = [TOP - PITCH * k for k in range(len(terms) + (lag is not None))]
    ends = [tuple((across, BACK, z) for across in (BEGIN, PLATE, END)) for z in heights]
    fixed = {"gain plate": Pose((PLATE, BACK, (heights[0] + heights[len(terms) - 1]) / 2))}
    for k, (_, share) in enumerate(terms):
        begin, plate, end = ends[k]
        fixed |= {f"term {k}": pose_between(begin, plate, thickness(share)),
                  f"glass {k}": pose_between(plate, end, GLASS * max(thickness(share), 0.3))}
    if lag is not None:
        fixed[f"glass {len(terms)}"] = pose_between(ends[-1][0], ends[-1][2], GLASS)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        flows = {}
        for k, (share, (begin, plate, end)) in enumerate(zip(x[states:], ends, strict=False)):
            flows[f"left {k}"] = pose_between(plate if k < len(terms) else begin, end, thickness(float(share)))
        return {**body.pose(x[:states], gain), **fixed, **flows}

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return body.anchors(x[:states], gain)

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        size = format_number(full * float(x[states + len(terms)]), ".2g")
        return ErrorMarks((), ((size, (SIZE_AT, BACK - 1.3 * FULL, heights[-1]), "center-center"),))

    named = [name for name, _ in terms] + ([] if lag is None else [lag])
    parts = (*(Part(f"term {k}", Rod(FULL), PLANT_COLOUR) for k in range(len(terms))),
             *(Part(f"left {k}", Rod(FULL), COLOURS["error"]) for k in range(len(heights))),
             *(Part(f"glass {k}", Rod(FULL), STEEL, opacity=0.3) for k in range(len(heights))),
             Part("gain plate", Box((0.06, 0.44, heights[0] - heights[len(terms) - 1] + 0.5)), METAL))
    labels = (*body.labels, *((name, (NAME_AT, BACK - FULL, z + FULL + NAME_ABOVE)) for name, z in zip(named, heights, strict=True)),
              ("L", (PLATE, BACK, heights[0] + 0.25 + NAME_ABOVE)))
    told = text("Pipes from the dark gauges: unknown terms of the error, blue as they are, pink what L leaves of them.")
    return replace(body, parts=(*body.parts, *parts), pose=pose, anchors=anchors, labels=labels, caption=joined(body.caption, told),
                   marks=body.marks if lag is None else marks,
                   arrows=lambda x, u, gain: body.arrows(x[:states], u, gain))
