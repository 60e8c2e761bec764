"""Draw gauges for the states of any plant, measured ones lit, and a large one for g."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ...colours import COLOURS
from ...text import same, subscript, text
from .body import (
    DARK_GREY,
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
)
from .body import force_arrow as arrow

LOWEST_LEVEL, ZERO_LEVEL = 0.26, 1.16  # lowest level of a column, and its level at zero
MAX_COLUMN_RISE, MAX_COLUMN_FALL = 1.0, 0.78  # how far a column can go from there
SMALL_GAUGES_X, LARGE_GAUGE_X = -0.82, 1.2  # the middle of the small gauges, and where the large one stands
SMALL_GAUGES_WIDE, MOST_GAP = 2.16, 0.68  # room of the small gauges, and the most from one to the next
LEAST_GAP = 0.36  # at which sizes of a small gauge are given
LABEL_AT = -0.32, 0.1  # y and z of the upper edge of a label
HIGH = -0.05, 2.3  # the same of one that stands high on its gauge
PER_STATE, PER_G = 0.28, 0.026  # stage units for one unit of a state and of g
BRIGHT, UNLIT = COLOURS["lit"], COLOURS["unlit"]
FULL_INPUT = 4.0


def gauge_gap(states: int) -> float:
    """From one small gauge to the next: fewer stand farther apart and are thicker."""
    return min(SMALL_GAUGES_WIDE / states, MOST_GAP)


def gauge_places(states: int) -> tuple[float, ...]:
    """Where the small gauges stand."""
    return tuple(SMALL_GAUGES_X + gauge_gap(states) * (i - (states - 1) / 2) for i in range(states))


def gauge_body(states: int, measured: Sequence[int]) -> Body:
    """Gauges for (x, g): entries 0 … states − 1 are the states, the last one is g, whose ghost is ĝ.

    `measured` states have a lit lamp and a blue column; the others are dark. A column follows its value nearly
    linearly around zero and never leaves its gauge.
    """
    places = gauge_places(states)
    lit = frozenset(measured)

    def level(value: float, unit: float, gain: float) -> float:
        return ZERO_LEVEL + bound_displacement(value * unit * gain, MAX_COLUMN_RISE if value > 0 else MAX_COLUMN_FALL)

    fixed = {"table": Pose((-0.2, 0.0, 0.05)), "large back": Pose((LARGE_GAUGE_X, 0.16, 1.22)),
             "large socket": Pose((LARGE_GAUGE_X, 0.0, 0.18)), "large zero": Pose((LARGE_GAUGE_X, 0.11, ZERO_LEVEL))}
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
        poses["large column"] = Pose((LARGE_GAUGE_X, 0.0, LOWEST_LEVEL), scale=(1.0, 1.0, top - LOWEST_LEVEL))
        poses["large level"] = Pose((LARGE_GAUGE_X, 0.0, top))
        return poses

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return (arrow((places[0] - 0.42, 0.0, ZERO_LEVEL), (0.0, 0.0, 1.0), float(u[0]), FULL_INPUT),)

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return ((LARGE_GAUGE_X, -0.32, level(float(x[states]), PER_G, gain)),)

    seen = ", ".join(str(i + 1) for i in sorted(lit))
    last = subscript(f"x{states}")
    return Body(_parts(states, lit), pose, arrows, anchors, 1.0, text("Small gauges: the states x₁ … {last}; {seen} are measured and "
                                                                      "lit; large gauge: g and its ghost ĝ",
                                                                      last=last, seen=seen),
                gauge_labels(tuple(subscript(f"x{i + 1}") for i in range(states)), "g"), names=_names(states, lit))


def gauge_labels(states: Sequence[str], large: str) -> tuple[tuple[str, Vector], ...]:
    """What stands before the foot of each gauge."""
    small = ((name, (x, *LABEL_AT)) for name, x in zip(states, gauge_places(len(states)), strict=True))
    return (*small, (large, (LARGE_GAUGE_X, *LABEL_AT)))


def named_high(body: Body) -> Body:
    """The body with the names of its gauges high on them: something stands before their feet."""
    return replace(body, labels=tuple((name, (x, *HIGH)) for name, (x, _, _) in body.labels))


def _names(states: int, lit: frozenset[int]) -> tuple[PartName, ...]:
    dark = sorted(frozenset(range(states)) - lit)
    return (*(PartName(text("lit: measured"), f"lamp {i}", (-0.1, -0.2, 0.18)) for i in sorted(lit)[:1]),
            *(PartName(text("dark: not measured"), f"lamp {i}", (0.14, -0.2, 0.18)) for i in dark[-1:]),
            PartName(same("g"), "large level", (-0.45, -0.4, 0.0)), PartName(text("ghost: ĝ"), "large level", (0.55, -0.4, 0.35), True))


def _parts(states: int, lit: frozenset[int]) -> tuple[Part, ...]:
    thick = gauge_gap(states) / LEAST_GAP
    small = tuple(part for i in range(states) for part in (
        Part(f"back {i}", Box((0.28 * thick, 0.05, 2.2)), METAL if i in lit else DARK_GREY),
        Part(f"socket {i}", Cylinder(0.12 * thick, 0.16), STEEL),
        Part(f"zero {i}", Box((0.28 * thick, 0.03, 0.02)), STEEL),
        Part(f"column {i}", Rod(0.06 * thick), PLANT_COLOUR if i in lit else UNLIT),
        Part(f"level {i}", Cylinder(0.11 * thick, 0.05), PLANT_COLOUR if i in lit else UNLIT),
        Part(f"lamp {i}", Ball(0.085 * thick ** 0.5), BRIGHT if i in lit else DARK_GREY),
    ))
    return (
        Part("table", Box((4.1, 0.9, 0.1)), DARK_GREY), *small,
        Part("large back", Box((0.78, 0.07, 2.35)), METAL),
        Part("large socket", Cylinder(0.3, 0.16), STEEL),
        Part("large zero", Box((0.78, 0.03, 0.025)), STEEL),
        Part("large column", Rod(0.15), STEEL),
        Part("large level", Cylinder(0.28, 0.07), PLANT_COLOUR, twin=True),
    )
