"""Draw the platform on the stage: ground, springs, voice coils, deck, payload, sensors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import cos, sin

from ...text import text
from .body import (
    COIL,
    DARK_GREY,
    GHOST_NAME,
    LYING,
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
    Spring,
    Vector,
    about_y,
    bound_displacement,
    force_arrow,
    pose_between,
)

STAGE_SCALE = 7.5  # stage units per metre: coils at ±0.20 m stand at ±1.5
MOTION_GAIN = 20.0  # times that motion is exaggerated: 2 mm is drawn as 0.3
SLAB, PLANE, THICK = 0.14, 1.42, 0.18  # top of the slab, height of the deck plane, thickness of the deck
DECK_HALF_WIDTH, DECK_DEPTH, POST = 1.66, 1.3, 2.38  # half width and depth of the deck, where the posts stand
SHIFT, LIFT, TILT = 0.34, 0.42, 0.28  # limits that keep a diverging deck on the stage
SENSOR_TOP = 0.10  # height of a sensor's base plate
MASS_REST = 0.24  # height of a test mass above its base plate
FULL_FORCE_N = 2.0  # N at which an arrow is about 0.6 long
UPWARD, RIGHTWARD = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)

Poser = Callable[[Sequence[float], float], Mapping[str, Pose]]
Placed = tuple[float, float, float, float, float]  # dx, dz of the deck plane's middle, angle, its cosine and sine


def _placed(x: Sequence[float], gain: float, height: float) -> Placed:
    """Stage displacement of the middle of the deck plane, which lies `height` metres below the centre of mass."""
    scale = STAGE_SCALE * gain
    angle = bound_displacement(float(x[2]) * gain, TILT)
    dx = bound_displacement(float(x[0]) * scale, SHIFT) + height * STAGE_SCALE * angle
    return dx, bound_displacement(float(x[1]) * scale, LIFT), angle, cos(angle), sin(angle)


def _at(placed: Placed, across: float, up: float, y: float = 0.0) -> Vector:
    """Where a point of the deck is: `across` from its middle, `up` from its plane; positive angle lifts the right."""
    dx, dz, _, c, s = placed
    return (dx + c * across - s * up, y, PLANE + dz + s * across + c * up)


def _parts() -> tuple[Part, ...]:
    fixed = [
        Part("slab", Box((2 * POST + 0.5, 1.9, SLAB)), DARK_GREY),
        Part("post left", Box((0.2, 0.5, PLANE + 0.2 - SLAB)), STEEL),
        Part("post right", Box((0.2, 0.5, PLANE + 0.2 - SLAB)), STEEL),
        Part("coil across yoke", Cylinder(0.2, 0.12), STEEL),
        Part("coil across", Cylinder(0.15, 0.26), COIL),
        Part("rod across", Rod(0.05), METAL),
        Part("spring across", Spring(0.13, 5.0, 0.028), METAL),
    ]
    for side in ("left", "right"):
        fixed += [
            Part(f"seat {side}", Cylinder(0.2, 0.06), STEEL),
            Part(f"spring {side}", Spring(0.15, 7.0, 0.032), METAL),
            Part(f"coil {side} yoke", Cylinder(0.19, 0.14), STEEL),
            Part(f"coil {side}", Cylinder(0.15, 0.42), COIL),
            Part(f"rod {side}", Rod(0.05), METAL),
            Part(f"sensor {side}", Box((0.34, 0.34, SENSOR_TOP)), DARK_GREY, twin=True),
            Part(f"servo {side}", Spring(0.06, 4.0, 0.014), METAL),
            Part(f"test mass {side}", Ball(0.1), METAL, twin=True),
        ]
    return (
        *fixed,
        Part("deck", Box((2 * DECK_HALF_WIDTH, DECK_DEPTH, THICK)), PLANT_COLOUR, twin=True),
        Part("payload", Box((0.56, 0.7, 0.46)), METAL, twin=True),
        Part("payload lid", Box((0.4, 0.5, 0.07)), STEEL, twin=True),
    )


def _fixed_poses(a: float, b: float) -> dict[str, Pose]:
    """What never moves, placed once."""
    tall = PLANE + 0.2 - SLAB
    poses = {
        "slab": Pose((0.0, 0.0, SLAB / 2)),
        "post left": Pose((-POST, 0.0, SLAB + tall / 2)),
        "post right": Pose((POST, 0.0, SLAB + tall / 2)),
        "coil across yoke": Pose((POST - 0.16, 0.0, PLANE), LYING),
        "coil across": Pose((POST - 0.22, 0.0, PLANE), LYING),
    }
    for side, sign in (("left", -1.0), ("right", 1.0)):
        poses[f"seat {side}"] = Pose((sign * a * STAGE_SCALE, -0.28, SLAB + 0.03))
        poses[f"coil {side} yoke"] = Pose((sign * b * STAGE_SCALE, 0.22, SLAB + 0.07))
        poses[f"coil {side}"] = Pose((sign * b * STAGE_SCALE, 0.22, SLAB + 0.28))
    return poses


def _poser(a: float, b: float, s: float, h: float, masses: bool) -> Poser:
    fixed = _fixed_poses(a, b)
    top, under = THICK / 2, -THICK / 2

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        placed = _placed(x, gain, h)
        turn = about_y(-placed[2])
        poses = dict(fixed)
        poses["deck"] = Pose(_at(placed, 0.0, 0.0), turn)
        poses["payload"] = Pose(_at(placed, 0.0, top + 0.23), turn)
        poses["payload lid"] = Pose(_at(placed, 0.0, top + 0.495), turn)
        poses["spring across"] = pose_between((-POST + 0.1, 0.0, PLANE), _at(placed, -DECK_HALF_WIDTH, 0.0))
        poses["rod across"] = pose_between((POST - 0.2, 0.0, PLANE), _at(placed, DECK_HALF_WIDTH, 0.0))
        for side, sign, index in (("left", -1.0, 3), ("right", 1.0, 4)):
            foot, place = sign * a * STAGE_SCALE, sign * s * STAGE_SCALE
            poses[f"spring {side}"] = pose_between((foot, -0.28, SLAB + 0.06), _at(placed, foot, under, -0.28))
            coil = sign * b * STAGE_SCALE
            poses[f"rod {side}"] = pose_between((coil, 0.22, SLAB + 0.3), _at(placed, coil, under, 0.22))
            relative = float(x[index]) - float(x[1]) - sign * s * float(x[2]) if masses else 0.0
            rise = MASS_REST + bound_displacement(relative * STAGE_SCALE * gain, 0.11)
            plate = _at(placed, place, top + SENSOR_TOP, -0.1)
            mass = _at(placed, place, top + SENSOR_TOP + rise, -0.1)
            poses[f"sensor {side}"] = Pose(_at(placed, place, top + SENSOR_TOP / 2, -0.1), turn)
            poses[f"servo {side}"] = pose_between(plate, mass)
            poses[f"test mass {side}"] = Pose(mass, turn)
        return poses

    return pose


def _body(a: float, b: float, s: float, h: float, masses: bool) -> Body:
    front = -DECK_DEPTH / 2 - 0.05

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        placed = _placed(x, gain, h)
        drawn = (
            force_arrow(_at(placed, -b * STAGE_SCALE, 0.0, front), UPWARD, float(u[0]), FULL_FORCE_N),
            force_arrow(_at(placed, b * STAGE_SCALE, 0.0, front), UPWARD, float(u[1]), FULL_FORCE_N),
            force_arrow(_at(placed, DECK_HALF_WIDTH, 0.0, front), RIGHTWARD, float(u[2]), FULL_FORCE_N),
        )
        if len(u) < 5:
            return drawn
        ground = (0.0, -1.0, SLAB)  # ground motion, at the same exaggeration as the deck's
        return (
            *drawn,
            force_arrow(ground, UPWARD, float(u[3]) * STAGE_SCALE * gain, 1.0, "disturbance"),
            force_arrow(ground, RIGHTWARD, float(u[4]) * STAGE_SCALE * gain, 1.0, "disturbance"),
        )

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        placed = _placed(x, gain, h)
        return tuple(
            _at(placed, across, THICK / 2, y) for across in (-DECK_HALF_WIDTH, DECK_HALF_WIDTH) for y in (-DECK_DEPTH / 2, DECK_DEPTH / 2)
        )

    return Body(_parts(), _poser(a, b, s, h, masses), arrows, anchors, MOTION_GAIN, text("Deck on two springs and a side "
                                                                                  "spring; green arrows are the "
                                                                                  "coil forces"), names=(
        PartName(text("deck"), "deck", (-0.95, -0.7, -0.4)),
        PartName(text("coil"), "coil right", (0.95, -0.6, 0.35)),
        PartName(text("spring"), "seat left", (-0.9, -0.4, 0.25)),
        PartName(GHOST_NAME, "payload lid", (0.9, -0.3, 0.4), True),
    ))


def held_at(h: float, x: Sequence[float], gain: float) -> Vector:
    """Where a hand holds the deck, whose centre of mass is h metres above its plane: above the right coil, at the front."""
    return _at(_placed(x, gain, h), DECK_HALF_WIDTH - 0.16, 0.0, -DECK_DEPTH / 2)


def deck_body(a: float, b: float, s: float, h: float) -> Body:
    """The rigid deck, state (x, z, θ, …): half distances of springs, coils and sensors, centre of mass height, in m."""
    return _body(a, b, s, h, False)


def platform_body(a: float, b: float, s: float, h: float) -> Body:
    """The same with moving test masses, state (x, z, θ, p_L, p_R, …)."""
    return _body(a, b, s, h, True)
