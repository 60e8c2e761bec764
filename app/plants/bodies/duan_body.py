"""Draw gauges for a plant without a physical shape: states, observer states, input.

What moves here is (x, z, u): n columns for the plant, q for the observer, one tall gauge for the input. Only the
gauge of u has a ghost, since a functional observer estimates K x and nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...colours import COLOURS
from ...text import text
from .body import (
    DARK_GREY,
    METAL,
    PLANT_COLOUR,
    STEEL,
    Arrow,
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

BASE_TOP, ZERO_LEVEL = 0.12, 1.0  # top of the base, level of the value 0
MAX_DRAWN_LEVEL = 0.7  # farthest drawn level from zero
GAUGE = 0.0  # where the gauge of u stands
SIDE_ROOM, MOST_GAP = 1.2, 0.6  # room of the columns on either side, and the most from one to the next
FIRST_COLUMN_OFFSET = 0.85  # from the gauge to the nearest column on either side
OBSERVER_COLOUR = COLOURS["estimate"]


def gap(count: int) -> float:
    """From one of so many columns to the next; fewer stand farther apart and are thicker."""
    return min(SIDE_ROOM / max(count - 1, 1), MOST_GAP)


def columns(n: int, q: int) -> tuple[float, ...]:
    """Where the columns of x, of z and the gauge of u stand, in that order."""
    return (
        *(GAUGE - FIRST_COLUMN_OFFSET - gap(n) * (n - 1 - i) for i in range(n)),
        *(GAUGE + FIRST_COLUMN_OFFSET + gap(q) * i for i in range(q)),
        GAUGE,
    )


def rack_body(n: int, q: int, full: Sequence[float]) -> Body:
    """The rack for n plant states and q observer states; `full`: the values (x, z, u) drawn about 0.5 high."""
    places, last = columns(n, q), n + q
    names = (*(f"x{i + 1}" for i in range(n)), *(f"z{i + 1}" for i in range(q)), "u")
    parts = [Part("base", Box((4.4, 1.2, BASE_TOP)), DARK_GREY),
             Part("zero plant", Box((gap(n) * (n - 1) + 0.5, 0.02, 0.02)), METAL),
             Part("zero observer", Box((gap(q) * (q - 1) + 0.5, 0.02, 0.02)), METAL),
             Part("zero u", Box((0.7, 0.02, 0.03)), METAL)]
    fixed = {"base": Pose((0.0, 0.0, BASE_TOP / 2)),
             "zero plant": Pose(((places[0] + places[n - 1]) / 2, 0.2, ZERO_LEVEL)),
             "zero observer": Pose(((places[n] + places[last - 1]) / 2, 0.2, ZERO_LEVEL)),
             "zero u": Pose((GAUGE, 0.2, ZERO_LEVEL))}
    for k, (name, place) in enumerate(zip(names, places, strict=True)):
        wide = k == last
        r = 0.3 if wide else 0.36 * gap(n if k < n else q)  # of the collar that shows the value
        colour = PLANT_COLOUR if wide or k < n else OBSERVER_COLOUR
        parts += [Part(f"{name} socket", Cylinder(0.8 * r, 0.1), STEEL),
                  Part(f"{name} column", Rod(0.3 * r), METAL),
                  Part(f"{name} level", Cylinder(r, 0.12 if wide else 0.1), colour, twin=wide)]
        fixed[f"{name} socket"] = Pose((place, 0.0, BASE_TOP + 0.05))
        fixed[f"{name} column"] = Pose((place, 0.0, BASE_TOP), scale=(1.0, 1.0, ZERO_LEVEL + MAX_DRAWN_LEVEL + 0.1 - BASE_TOP))

    def level(k: int, value: float, gain: float) -> float:
        return ZERO_LEVEL + bound_displacement(0.5 * gain * float(value) / full[k], MAX_DRAWN_LEVEL)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        return fixed | {f"{name} level": Pose((place, 0.0, level(k, x[k], gain)))
                        for k, (name, place) in enumerate(zip(names, places, strict=True))}

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return (force_arrow((GAUGE, -0.4, 0.3), (-1.0, 0.0, 0.0), float(u[0]), full[last]),)

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return tuple((GAUGE + side, 0.0, level(last, x[last], gain)) for side in (-0.28, 0.28))

    return Body(tuple(parts), pose, arrows, anchors, 1.0, text("Blue columns: the plant's states; red columns: "
                                                               "the observer's. The gauge shows the input wanted, "
                                                               "its ghost the input given; the green arrow too"), names=(
        PartName(text("plant's states"), "x2 level", (-0.6, -0.4, 0.85)),
        PartName(text("observer's state"), "z1 level", (0.3, -0.4, 0.9)),
        PartName(text("input"), "u level", (0.0, -0.4, 0.75)),
    ))
