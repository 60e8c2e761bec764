"""Draw gauges for the states of any plant, measured ones lit, and a large one for g."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...colours import COLOURS
from ...text import subscript, text
from .body import (
    BENCH,
    DARK_GREY,
    METAL,
    PLANT_COLOUR,
    STEEL,
    Arrow,
    Ball,
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
from .body import force_arrow as arrow

LOWEST_LEVEL, ZERO_LEVEL = 0.26, 1.16  # lowest level of a column, and its level at zero
MAX_COLUMN_RISE, MAX_COLUMN_FALL = 1.0, 0.78  # how far a column can go from there
SMALL_GAUGES, LARGE_GAUGE_X = (-1.9, 0.26), 1.2  # where the small gauges begin and end, and where the large one stands
MOST_GAP = 0.68  # from one small gauge to the next
TABLE_LEFT, TABLE_PAST = -2.25, 0.65  # where the table begins, and how far past the large gauge it goes
LEAST_GAP = 0.36  # at which sizes of a small gauge are given
LABEL_AT = -0.05, 2.3  # y and z of the upper edge of a label
PLATE_HALF, LARGE_HALF = 0.14, 0.39  # half the width of a small plate, times its thickness, and of the large one
BEYOND, MARK_BELOW, MARK_BEFORE = 2.0, 0.3, 0.42  # of the way to an end: a value that is past it; from a level to its arrow
PER_STATE, PER_G = 0.28, 0.026  # stage units for one unit of a state and of g
NOWHERE = (0.0, 0.0, -99.0)  # where an arrow is that nothing asks for
BRIGHT, UNLIT = COLOURS["lit"], COLOURS["unlit"]
FULL_INPUT, INPUT_ASIDE, NAME_ASIDE = 4.0, 0.36, 0.2  # at the longest arrow; from the first gauge to it, and on to its name


def gauge_gap(states: int, room: tuple[float, float] = SMALL_GAUGES) -> float:
    """From one small gauge to the next: fewer stand farther apart and are thicker."""
    return min((room[1] - room[0]) / states, MOST_GAP)


def gauge_places(states: int, measured: Sequence[int], room: tuple[float, float] = SMALL_GAUGES) -> tuple[float, ...]:
    """Where the small gauge of each state stands: the measured ones first, on the left."""
    order = sorted(range(states), key=lambda i: (i not in measured, i))
    middle, gap = (room[0] + room[1]) / 2, gauge_gap(states, room)
    return tuple(middle + gap * (order.index(i) - (states - 1) / 2) for i in range(states))


def free_space(states: int, measured: Sequence[int], room: tuple[float, float], large: float) -> tuple[float, float]:
    """Where the last small plate ends and the large one, at `large`, begins."""
    return max(gauge_places(states, measured, room)) + PLATE_HALF * gauge_gap(states, room) / LEAST_GAP, large - LARGE_HALF


def gauge_body(states: int, measured: Sequence[int], room: tuple[float, float] = SMALL_GAUGES, large: float = LARGE_GAUGE_X) -> Body:
    """Gauges for (x, g): entries 0 … states − 1 are the states, the last one is g, whose ghost is ĝ.

    `measured` states have a lit lamp and a blue column; the others are dark. A column follows its value nearly
    linearly around zero and never leaves its gauge; one whose value is far past its end has an arrow on it. The small gauges stand
    in a `room`, the large one at `large`.
    """
    lit, thick = frozenset(measured), gauge_gap(states, room) / LEAST_GAP
    places = gauge_places(states, measured, room)

    def level(value: float, unit: float, gain: float) -> float:
        return ZERO_LEVEL + bound_displacement(value * unit * gain, MAX_COLUMN_RISE if value > 0 else MAX_COLUMN_FALL)

    fixed = {"table": Pose(((TABLE_LEFT + large + TABLE_PAST) / 2, 0.0, 0.05)), "large back": Pose((large, 0.16, 1.22)),
             "large socket": Pose((large, 0.0, 0.18)), "large zero": Pose((large, 0.11, ZERO_LEVEL))}
    for i, x in enumerate(places):
        fixed |= {f"back {i}": Pose((x, 0.12, 1.22)), f"socket {i}": Pose((x, 0.0, 0.18)),
                  f"zero {i}": Pose((x, 0.08, ZERO_LEVEL)), f"lamp {i}": Pose((x, 0.04, 2.42))}

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        poses = dict(fixed)
        for i, place in enumerate(places):
            top = level(float(x[i]), PER_STATE, gain)
            poses[f"column {i}"] = Pose((place, 0.0, LOWEST_LEVEL), scale=(1.0, 1.0, top - LOWEST_LEVEL))
            poses[f"level {i}"] = Pose((place, 0.0, top))
        top = level(float(x[states]), PER_G, gain)
        poses["large column"] = Pose((large, 0.0, LOWEST_LEVEL), scale=(1.0, 1.0, top - LOWEST_LEVEL))
        poses["large level"] = Pose((large, 0.0, top))
        return poses

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return (arrow((min(places) - INPUT_ASIDE, 0.0, ZERO_LEVEL), (0.0, 0.0, 1.0), float(u[0]), FULL_INPUT),)

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return ((large, -0.32, level(float(x[states]), PER_G, gain)),)

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        found = list[tuple[str, Vector, str]]()
        all_places, units = (*places, large), (*(PER_STATE,) * states, PER_G)
        for place, value, unit in zip(all_places, map(float, x), units, strict=False):
            past = abs(value * unit * gain) > BEYOND * (MAX_COLUMN_RISE if value > 0 else MAX_COLUMN_FALL)
            sign, up = ("↑", -MARK_BELOW) if value > 0 else ("↓", MARK_BELOW)
            before = MARK_BEFORE if place == large else MARK_BEFORE / 2
            found.append((sign, (place, -before, level(value, unit, gain) + up) if past else NOWHERE, "center-center"))
        return ErrorMarks((), tuple(found))

    seen = ", ".join(str(i + 1) for i in sorted(lit))
    last = subscript(f"x{states}")
    told = text("Small gauges: the states x₁ … {last}; {seen} are measured and lit; large gauge: g and its ghost ĝ", last=last, seen=seen)
    return Body(_parts(states, lit, thick, large), pose, arrows, anchors, 1.0, told,
                (*gauge_labels(places, tuple(subscript(f"x{i + 1}") for i in range(states)), "g", large),
                 ("u", (min(places) - INPUT_ASIDE - NAME_ASIDE, 0.0, ZERO_LEVEL + 0.08))), names=_names(states, lit, places), marks=marks)


def gauge_labels(places: Sequence[float], states: Sequence[str], large: str, at: float = LARGE_GAUGE_X) -> tuple[tuple[str, Vector], ...]:
    """The names of the gauges, high on them: something may stand before their feet."""
    return (*((name, (x, *LABEL_AT)) for name, x in zip(states, places, strict=True)), (large, (at, *LABEL_AT)))


def _names(states: int, lit: frozenset[int], places: Sequence[float]) -> tuple[PartName, ...]:
    dark = sorted(frozenset(range(states)) - lit, key=lambda i: places[i])
    return (*(PartName(text("lit: measured"), f"lamp {i}", (-0.1, -0.2, 0.18)) for i in sorted(lit)[:1]),
            *(PartName(text("dark: not measured"), f"lamp {i}", (0.14, -0.2, 0.18)) for i in dark[-1:]),
            PartName(text("ghost: ĝ"), "large level", (0.3, -0.4, 0.35), True, (0.28, 0.0, 0.0)))


def _parts(states: int, lit: frozenset[int], thick: float, large: float) -> tuple[Part, ...]:
    small = tuple(part for i in range(states) for part in (
        Part(f"back {i}", Box((2 * PLATE_HALF * thick, 0.05, 2.2)), COLOURS["tube"] if i in lit else METAL),
        Part(f"socket {i}", Cylinder(0.12 * thick, 0.16), STEEL),
        Part(f"zero {i}", Box((0.28 * thick, 0.03, 0.02)), STEEL),
        Part(f"column {i}", Rod(0.06 * thick), PLANT_COLOUR if i in lit else UNLIT),
        Part(f"level {i}", Cylinder(0.11 * thick, 0.05), PLANT_COLOUR if i in lit else UNLIT),
        Part(f"lamp {i}", Ball(0.085 * thick ** 0.5), BRIGHT if i in lit else DARK_GREY),
    ))
    return (
        Part("table", Box((large + TABLE_PAST - TABLE_LEFT, 0.9, 0.1)), BENCH), *small,
        Part("large back", Box((2 * LARGE_HALF, 0.07, 2.35)), COLOURS["tube"]),
        Part("large socket", Cylinder(0.3, 0.16), STEEL),
        Part("large zero", Box((2 * LARGE_HALF, 0.03, 0.025)), STEEL),
        Part("large column", Rod(0.15), STEEL),
        Part("large level", Cylinder(0.28, 0.07), PLANT_COLOUR, twin=True),
    )
