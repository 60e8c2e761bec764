"""Draw gauges for a plant without a physical shape: states, observer states, input, model errors.

What moves here is (x, z, rows, J, u): n columns for the plant, q for the observer, one tall gauge for the input, before them the rows
of the causes of the error of u, and on the right the three parts of J. Only the gauge of u has a ghost, since a functional observer
estimates K x alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...colours import COLOURS
from ...text import same, subscript, text
from .body import (
    BENCH,
    DARK_GREY,
    GHOST_NAME,
    PLANT_COLOUR,
    STEEL,
    Arrow,
    Body,
    Box,
    Cylinder,
    ErrorMarks,
    Part,
    PartName,
    Pose,
    Rod,
    Vector,
    bound_displacement,
)
from .cause_rows import LEFT, RIGHT, CauseRows
from .criterion_tower import SLABS, CriterionTower

BASE_TOP, BASE_DEEP, ZERO_LEVEL = 0.12, 0.9, 0.9  # height of the base and its depth, level of the value 0
MAX_DRAWN_LEVEL = 0.62  # farthest drawn level from zero
GAUGE = 0.0  # where the gauge of u stands
SIDE_ROOM, MOST_GAP = 1.2, 0.6  # room of the columns on either side, and the most from one to the next
FIRST_COLUMN_OFFSET = 0.98  # from the gauge to the nearest column on either side
WIDE, COLLAR = 0.42, 0.09  # radius of the collar of u, and its height
OBSERVER_COLOUR = COLOURS["estimate"]
PANEL_LOW, PANEL_HIGH, PANEL_Y = 0.18, 1.68, 0.2  # of the plates behind the gauges
NAME_AT = 0.0, 1.84  # y and z of the upper edge of a gauge's name
SCALE_AT = 0.59  # from the gauge of u to the numbers of its scale
TOWER = 2.11  # where the tower of J stands


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


def rack_body(n: int, q: int, full: Sequence[float], rows: CauseRows, most: float | None = None) -> Body:
    """The rack for n plant states and q observer states; `full`: the values (x, z, u) drawn about 0.5 high; `rows` before it.

    `most`: the J that fills its tower, None without one.
    """
    places, last, up = columns(n, q), n + q, rows.top - BASE_TOP
    tower = None if most is None else CriterionTower(TOWER, rows.top, most)
    names = (*(f"x{i + 1}" for i in range(n)), *(f"z{i + 1}" for i in range(q)), "u")
    zero, panel = ZERO_LEVEL + up, up + (PANEL_LOW + PANEL_HIGH) / 2
    parts = [Part("base", Box((RIGHT - LEFT, BASE_DEEP, rows.top)), BENCH), *rows.parts(), *(() if tower is None else tower.parts()),
             Part("zero plant", Box((gap(n) * (n - 1) + 0.5, 0.02, 0.02)), DARK_GREY),
             Part("zero observer", Box((gap(q) * (q - 1) + 0.5, 0.02, 0.02)), DARK_GREY),
             Part("zero u", Box((0.95, 0.02, 0.03)), DARK_GREY)]
    fixed = {"base": Pose((0.0, 0.0, rows.top / 2)), **rows.fixed(), **({} if tower is None else tower.fixed()),
             "zero plant": Pose(((places[0] + places[n - 1]) / 2, 0.2, zero)),
             "zero observer": Pose(((places[n] + places[last - 1]) / 2, 0.2, zero)),
             "zero u": Pose((GAUGE, 0.2, zero))}
    for k, (name, place) in enumerate(zip(names, places, strict=True)):
        wide = k == last
        r = WIDE if wide else min(0.42 * gap(n if k < n else q), 0.22)  # of the collar that shows the value
        colour = PLANT_COLOUR if wide or k < n else OBSERVER_COLOUR
        parts += [Part(f"{name} socket", Cylinder(0.8 * r, 0.1), STEEL),
                  Part(f"{name} plate", Box((2.2 * r, 0.05, PANEL_HIGH - PANEL_LOW)), COLOURS["tube"]),
                  Part(f"{name} column", Rod(0.45 * r), STEEL),
                  Part(f"{name} level", Cylinder(r, COLLAR), colour, twin=wide)]
        fixed[f"{name} socket"] = Pose((place, 0.0, rows.top + 0.05))
        fixed[f"{name} plate"] = Pose((place, PANEL_Y, panel))
        fixed[f"{name} column"] = Pose((place, 0.0, rows.top), scale=(1.0, 1.0, ZERO_LEVEL + MAX_DRAWN_LEVEL + 0.1 - BASE_TOP))

    tall = bound_displacement(0.5, MAX_DRAWN_LEVEL)
    scale = tuple((same(f"{sign}{full[last]:g}"), (GAUGE + SCALE_AT, PANEL_Y, zero + side * tall + 0.06))
                  for sign, side in (("", 1.0), ("−", -1.0)))
    parts += [Part(f"scale {k}", Box((0.16, 0.02, 0.03)), DARK_GREY) for k in range(2)]
    fixed |= {f"scale {k}": Pose((GAUGE + 0.41, PANEL_Y - 0.04, zero + side * tall)) for k, side in enumerate((1.0, -1.0))}
    called = (text("plant {name}", name=subscript("x1")), *(subscript(f"x{i + 1}") for i in range(1, n)),
              text("observer {name}", name=subscript("z1" if q > 1 else "z")), *(subscript(f"z{i + 1}") for i in range(1, q)),
              text("input {name}", name=same("u")))
    labels = (*((name, (place, NAME_AT[0], NAME_AT[1] + up)) for name, place in zip(called, places, strict=True)), *scale, *rows.labels())

    def level(k: int, value: float, gain: float) -> float:
        return zero + bound_displacement(0.5 * gain * float(value) / full[k], MAX_DRAWN_LEVEL)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        shown = (*x[:last], x[-1])
        index = len(x) - 1 - len(SLABS)
        levels = {f"{name} level": Pose((place, 0.0, level(k, shown[k], gain)))
                  for k, (name, place) in enumerate(zip(names, places, strict=True))}
        return {**fixed, **rows.moving(x[last:index]), **({} if tower is None else tower.moving(x[index:-1])), **levels}

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return ()

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return tuple((GAUGE + side, 0.0, level(last, x[-1], gain)) for side in (-0.38, 0.38))

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        assert tower is not None
        return tower.words(x[-1 - len(SLABS):-1])

    return Body(tuple(parts), pose, arrows, anchors, 1.0, text(
        "Blue columns: the plant's states; orange columns: the observer's. The gauge shows the input wanted, its ghost the input given. "
        "Rows in front: a bead is an error of the model, its bar what it adds to the error of the input. The last bar is the sum. "
        "The slabs on the right are the parts of J"),
        labels, marks=None if tower is None else marks, names=(
        PartName(text("input wanted"), "u level", (-0.75, -0.4, -0.4)),
        PartName(GHOST_NAME, "u level", (0.75, -0.4, 0.6), True),
        PartName(text("error of the model"), "bead 2", (0.34, -0.2, 0.14)),
        PartName(text("adds to the error"), "part 2", (0.5, -0.3, 0.5)),
    ))
