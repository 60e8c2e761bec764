"""Draw gauges for a plant without a physical shape: states, observer states, input, model errors.

What moves here is (x, z, δ, u): n columns for the plant, q for the observer, a slider for each error of the model in shares of the
largest one, and one tall gauge for the input. Only the gauge of u has a ghost, since a functional observer estimates K x alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...colours import COLOURS
from ...text import Text, same, subscript, text
from .body import (
    DARK_GREY,
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

BASE_TOP, BASE_DEEP, BASE_Y, ZERO_LEVEL = 0.12, 1.5, -0.25, 1.0  # top of the base, its depth and middle, level of the value 0
MAX_DRAWN_LEVEL = 0.7  # farthest drawn level from zero
GAUGE = 0.0  # where the gauge of u stands
SIDE_ROOM, MOST_GAP = 1.2, 0.6  # room of the columns on either side, and the most from one to the next
FIRST_COLUMN_OFFSET = 0.85  # from the gauge to the nearest column on either side
OBSERVER_COLOUR = COLOURS["estimate"]
SLIDERS = (-1.4, 0.0, 1.4)  # where the three errors of the model stand
SLIDER_Y, SLIDER_HALF, BEAD = -0.72, 0.52, 0.11
PANEL_LOW, PANEL_HIGH, PANEL_Y = 0.18, 1.86, 0.2  # of the plates behind the gauges
NAME_AT = 0.0, 2.02  # y and z of the upper edge of a gauge's name
SCALE_AT = 0.49  # from the gauge of u to the numbers of its scale


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


def _slider_parts() -> tuple[Part, ...]:
    return tuple(part for k, _ in enumerate(SLIDERS) for part in (
        Part(f"track {k}", Box((2 * SLIDER_HALF, 0.1, 0.05)), STEEL), Part(f"model {k}", Box((0.03, 0.26, 0.12)), METAL),
        Part(f"bead {k}", Ball(BEAD), PLANT_COLOUR)))


def _slider_places() -> dict[str, Pose]:
    return {name: Pose((at, SLIDER_Y, BASE_TOP + up))
            for k, at in enumerate(SLIDERS) for name, up in ((f"track {k}", 0.02), (f"model {k}", 0.05))}


def rack_body(n: int, q: int, full: Sequence[float], errors: Sequence[Text]) -> Body:
    """The rack for n plant states and q observer states; `full`: the values (x, z, u) drawn about 0.5 high; `errors` of the model."""
    places, last = columns(n, q), n + q
    names = (*(f"x{i + 1}" for i in range(n)), *(f"z{i + 1}" for i in range(q)), "u")
    parts = [Part("base", Box((4.4, BASE_DEEP, BASE_TOP)), DARK_GREY), *_slider_parts(),
             Part("zero plant", Box((gap(n) * (n - 1) + 0.5, 0.02, 0.02)), DARK_GREY),
             Part("zero observer", Box((gap(q) * (q - 1) + 0.5, 0.02, 0.02)), DARK_GREY),
             Part("zero u", Box((0.7, 0.02, 0.03)), DARK_GREY)]
    fixed = {"base": Pose((0.0, BASE_Y, BASE_TOP / 2)), **_slider_places(),
             "zero plant": Pose(((places[0] + places[n - 1]) / 2, 0.2, ZERO_LEVEL)),
             "zero observer": Pose(((places[n] + places[last - 1]) / 2, 0.2, ZERO_LEVEL)),
             "zero u": Pose((GAUGE, 0.2, ZERO_LEVEL))}
    for k, (name, place) in enumerate(zip(names, places, strict=True)):
        wide = k == last
        r = 0.34 if wide else min(0.42 * gap(n if k < n else q), 0.22)  # of the collar that shows the value
        colour = PLANT_COLOUR if wide or k < n else OBSERVER_COLOUR
        parts += [Part(f"{name} socket", Cylinder(0.8 * r, 0.1), STEEL),
                  Part(f"{name} plate", Box((2.2 * r, 0.05, PANEL_HIGH - PANEL_LOW)), METAL),
                  Part(f"{name} column", Rod(0.45 * r), STEEL),
                  Part(f"{name} level", Cylinder(r, 0.14 if wide else 0.12), colour, twin=wide)]
        fixed[f"{name} socket"] = Pose((place, 0.0, BASE_TOP + 0.05))
        fixed[f"{name} plate"] = Pose((place, PANEL_Y, (PANEL_LOW + PANEL_HIGH) / 2))
        fixed[f"{name} column"] = Pose((place, 0.0, BASE_TOP), scale=(1.0, 1.0, ZERO_LEVEL + MAX_DRAWN_LEVEL + 0.1 - BASE_TOP))

    tall = bound_displacement(0.5, MAX_DRAWN_LEVEL)
    scale = tuple((same(f"{sign}{full[last]:g}"), (GAUGE + SCALE_AT, PANEL_Y, ZERO_LEVEL + side * tall + 0.06))
                  for sign, side in (("", 1.0), ("−", -1.0)))
    parts += [Part(f"scale {k}", Box((0.16, 0.02, 0.03)), DARK_GREY) for k in range(2)]
    fixed |= {f"scale {k}": Pose((GAUGE + 0.31, PANEL_Y - 0.04, ZERO_LEVEL + side * tall)) for k, side in enumerate((1.0, -1.0))}
    called = (text("plant {name}", name=subscript("x1")), *(subscript(f"x{i + 1}") for i in range(1, n)),
              text("observer {name}", name=subscript("z1" if q > 1 else "z")), *(subscript(f"z{i + 1}") for i in range(1, q)),
              text("input {name}", name=same("u")))
    labels = (*((name, (place, *NAME_AT)) for name, place in zip(called, places, strict=True)), *scale,
              *((words, (at, SLIDER_Y - 0.2, 0.0)) for words, at in zip(errors, SLIDERS, strict=True)))

    def level(k: int, value: float, gain: float) -> float:
        return ZERO_LEVEL + bound_displacement(0.5 * gain * float(value) / full[k], MAX_DRAWN_LEVEL)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        shown = (*x[:last], x[-1])
        beads = {f"bead {k}": Pose((at + SLIDER_HALF * min(max(float(share), -1.0), 1.0), SLIDER_Y, BASE_TOP + BEAD))
                 for k, (at, share) in enumerate(zip(SLIDERS, x[last:-1], strict=True))}
        return {**fixed, **beads, **{f"{name} level": Pose((place, 0.0, level(k, shown[k], gain)))
                                     for k, (name, place) in enumerate(zip(names, places, strict=True))}}

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return (force_arrow((GAUGE, -0.4, 0.3), (-1.0, 0.0, 0.0), float(u[0]), full[last]),)

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return tuple((GAUGE + side, 0.0, level(last, x[-1], gain)) for side in (-0.3, 0.3))

    return Body(tuple(parts), pose, arrows, anchors, 1.0, text("Blue columns: the plant's states; red columns: "
                                                               "the observer's. The gauge shows the input wanted, "
                                                               "its ghost the input given; the green arrow too. Beads in front: "
                                                               "how far the plant is from the model"), labels, names=(
        PartName(text("error of the model"), "bead 2", (0.35, -0.1, 0.42)),
        PartName(GHOST_NAME, "u level", (1.2, -0.4, -0.25), True),
    ))
