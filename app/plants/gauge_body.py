"""A plant without a shape of its own: upright gauges for the states, those measured lit, and a large one for g."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..text import lowered, text
from .body import DARK, METAL, PLANT, STEEL, Arrow, Ball, Body, Box, Cylinder, Part, Pose, Rod, Vector, bounded
from .body import force_arrow as arrow

FOOT, ZERO = 0.26, 1.16  # lowest level of a column, and its level at zero
RISE, FALL = 1.0, 0.78  # how far a column can go from there
FIRST, APART, LARGE = -1.72, 0.36, 1.2  # where the gauges stand
PER_STATE, PER_G = 0.28, 0.026  # stage units for one unit of a state and of g
BRIGHT, UNLIT = "#FFF3C4", "#5A616C"
FULL_INPUT = 4.0


def gauge_body(states: int, measured: Sequence[int]) -> Body:
    """Gauges for (x, g): entries 0 … states − 1 are the states, the last one is g, whose ghost is ĝ.

    `measured` states have a lit lamp and a blue column; the others are dark. A column follows its value nearly
    linearly around zero and never leaves its gauge.
    """
    places = tuple(FIRST + APART * i for i in range(states))
    lit = frozenset(measured)

    def level(value: float, unit: float, gain: float) -> float:
        return ZERO + bounded(value * unit * gain, RISE if value > 0 else FALL)

    fixed = {"table": Pose((-0.2, 0.0, 0.05)), "large back": Pose((LARGE, 0.16, 1.22)),
             "large socket": Pose((LARGE, 0.0, 0.18)), "large zero": Pose((LARGE, 0.11, ZERO))}
    for i, x in enumerate(places):
        fixed |= {f"back {i}": Pose((x, 0.12, 1.22)), f"socket {i}": Pose((x, 0.0, 0.18)),
                  f"zero {i}": Pose((x, 0.08, ZERO)), f"lamp {i}": Pose((x, 0.04, 2.42))}

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        poses = dict(fixed)
        for i, place in enumerate(places):
            top = level(float(x[i]), PER_STATE, gain)
            poses[f"column {i}"] = Pose((place, 0.0, FOOT), scale=(1.0, 1.0, top - FOOT))
            poses[f"level {i}"] = Pose((place, 0.0, top))
        top = level(float(x[states]), PER_G, gain)
        poses["large column"] = Pose((LARGE, 0.0, FOOT), scale=(1.0, 1.0, top - FOOT))
        poses["large level"] = Pose((LARGE, 0.0, top))
        return poses

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return (arrow((FIRST - 0.42, 0.0, ZERO), (0.0, 0.0, 1.0), float(u[0]), FULL_INPUT),)

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return ((LARGE, -0.32, level(float(x[states]), PER_G, gain)),)

    seen = ", ".join(str(i + 1) for i in sorted(lit))
    last = lowered(f"x{states}")
    return Body(_parts(states, lit), pose, arrows, anchors, 1.0, text("Small gauges: the states x₁ … {last}, of "
                                                                      "which {seen} are measured and lit; large "
                                                                      "gauge: g and its ghost ĝ",
                                                                      last=last, seen=seen))


def _parts(states: int, lit: frozenset[int]) -> tuple[Part, ...]:
    small = tuple(part for i in range(states) for part in (
        Part(f"back {i}", Box((0.28, 0.05, 2.2)), STEEL if i in lit else DARK),
        Part(f"socket {i}", Cylinder(0.12, 0.16), METAL),
        Part(f"zero {i}", Box((0.28, 0.03, 0.02)), METAL),
        Part(f"column {i}", Rod(0.06), PLANT if i in lit else UNLIT),
        Part(f"level {i}", Cylinder(0.11, 0.05), PLANT if i in lit else UNLIT),
        Part(f"lamp {i}", Ball(0.085), BRIGHT if i in lit else DARK),
    ))
    return (
        Part("table", Box((4.1, 0.9, 0.1)), DARK), *small,
        Part("large back", Box((0.78, 0.07, 2.35)), STEEL),
        Part("large socket", Cylinder(0.3, 0.16), METAL),
        Part("large zero", Box((0.78, 0.03, 0.025)), METAL),
        Part("large column", Rod(0.15), METAL),
        Part("large level", Cylinder(0.28, 0.07), PLANT, twin=True),
    )
