"""Draw a body for any plant: a glass tube for each state, with a collar for the value.

Up to ten tubes stand in one row; more stand in rows behind, each a step higher. A lamp is lit over a state that an
output reads by itself; arrows in front of the first row are the inputs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ...colours import COLOURS
from ...text import NO_WORDS, Text, joined, text
from .body import (
    BENCH,
    GHOST_NAME,
    METAL,
    PLANT_COLOUR,
    STEEL,
    Arrow,
    Ball,
    Body,
    Box,
    Cylinder,
    Part,
    PartName,
    Pose,
    Rod,
    Vector,
    bound_displacement,
    force_arrow,
)

ROW_WIDTH, MOST_IN_ROW, MOST_ARROWS = 4.2, 10, 4
ARROW_FOOT = 1.05  # stage units above the floor, where an arrow begins: it ends above the step
GLASS_COLOUR, LIT_COLOUR, UNLIT_COLOUR = (COLOURS[role] for role in ("tube", "lit", "unlit"))
FRONT, ROW_GAP, ROW_STEP_HEIGHT = -0.35, 0.62, 0.5  # y of the first row, distance to the next, how much higher it stands


def rows_of(count: int) -> tuple[int, ...]:
    """How many tubes stand in each row, the longest in front."""
    rows = max(1, math.ceil(count / MOST_IN_ROW))
    return tuple(count // rows + (1 if i < count % rows else 0) for i in range(rows))


def tubes_body(names: Sequence[Text | str], full: Sequence[float], measured: Sequence[int], strongest: Sequence[float]) -> Body:
    """Tubes for states called `names`; a state of size `full` is drawn at about the end of its tube.

    `measured`: states that an output reads alone. `strongest`: per input the value whose arrow is longest.
    """
    count, rows = len(names), rows_of(len(names))
    tall = 0.76 if len(rows) == 1 else 0.42  # half the height of a tube
    gap = min(0.9, ROW_WIDTH / rows[0])
    radius, lit = min(0.16, 0.24 * gap), frozenset(measured)
    feet = tuple(((j - (size - 1) / 2) * gap, FRONT + ROW_GAP * i, 0.16 + ROW_STEP_HEIGHT * i)
                 for i, size in enumerate(rows) for j in range(size))
    parts, fixed = _stand(rows, gap)
    for k, (x, y, foot) in enumerate(feet):
        parts += [Part(f"tube {k}", Cylinder(radius, 2 * tall), GLASS_COLOUR, opacity=0.3),
                  Part(f"socket {k}", Cylinder(1.25 * radius, 0.06), METAL),
                  Part(f"zero {k}", Cylinder(1.12 * radius, 0.014), STEEL),
                  Part(f"stem {k}", Rod(0.45 * radius), PLANT_COLOUR, opacity=0.6),
                  Part(f"collar {k}", Cylinder(1.5 * radius, 0.075), PLANT_COLOUR, twin=True),
                  Part(f"lamp {k}", Ball(0.5 * radius), LIT_COLOUR if k in lit else UNLIT_COLOUR)]
        fixed |= {f"tube {k}": Pose((x, y, foot + tall)), f"socket {k}": Pose((x, y, foot + 0.01)),
                  f"zero {k}": Pose((x, y, foot + tall)), f"lamp {k}": Pose((x, y, foot + 2 * tall + 0.6 * radius))}

    def height(k: int, value: float, gain: float) -> float:
        return feet[k][2] + tall + bound_displacement(0.75 * tall * gain * value / full[k], tall - 0.7 * radius)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        poses = dict(fixed)
        for k, (across, y, foot) in enumerate(feet):
            top = height(k, float(x[k]), gain)
            poses[f"collar {k}"] = Pose((across, y, top))
            poses[f"stem {k}"] = Pose((across, y, foot), scale=(1.0, 1.0, top - foot))
        return poses

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        drawn = min(len(strongest), MOST_ARROWS)
        aside = gap / 2 if (rows[0] - drawn) % 2 == 0 else 0.0  # between tubes, before none of them
        places = [(j - (drawn - 1) / 2) * gap - aside for j in range(drawn)]
        return tuple(force_arrow((x, FRONT - 0.35, ARROW_FOOT), (0.0, 0.0, 1.0), float(u[j]), strongest[j]) for j, x in enumerate(places))

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return tuple((across, y - 1.5 * radius, height(k, float(x[k]), gain)) for k, (across, y, _) in enumerate(feet))

    labels = tuple((name, (x, y - 1.5 * radius, foot - 0.03)) for name, (x, y, foot) in zip(names, feet, strict=True)
                   ) if count <= MOST_IN_ROW else ()
    seen = text("A lit lamp: that state is measured by itself.") if lit else NO_WORDS
    note = joined(text("One tube per state, from left to right and front to back; green arrows: inputs."), seen)
    lamp = (PartName(text("lit: measured"), f"lamp {min(lit)}", (0.3, -0.2, 0.2)),) if lit else ()
    names = (*lamp, PartName(text("state"), "collar 0", (-0.45, -0.3, 0.3)),
             PartName(GHOST_NAME, f"collar {count - 1}", (0.3, -0.3, -0.6) if count > 1 else (0.7, -0.3, -0.25), True))
    return Body(tuple(parts), pose, arrows, anchors, 1.0, note, labels, names=names)


def _stand(rows: tuple[int, ...], gap: float) -> tuple[list[Part], dict[str, Pose]]:
    """The steps that the rows stand on."""
    parts, poses = [], {}
    for i, size in enumerate(rows):
        high = 0.13 + ROW_STEP_HEIGHT * i
        parts.append(Part(f"step {i}", Box((max(size * gap + 0.2, 1.0), ROW_GAP - 0.08, high)), BENCH))
        poses[f"step {i}"] = Pose((0.0, FRONT + ROW_GAP * i, high / 2))
    return parts, poses
