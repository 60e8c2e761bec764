"""Draw the two-mass chain on the stage: walls or magnets, rail, blocks, springs, dampers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...text import text
from .body import (
    DARK_GREY,
    GHOST_NAME,
    LYING,
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
    Spring,
    Vector,
    bound_displacement,
    force_arrow,
    pose_between,
)

STAGE_SCALE = 0.6  # stage units per metre
WALL, RAIL_TOP = 2.0, 0.2  # inner face of the walls, top of the rail
REST_POSITIONS = (-0.72, 0.72)  # middles of the blocks at rest
BLOCK_EDGE = 0.56  # edge of a block
MAX_DRAWN_DISPLACEMENT = 0.42  # farthest drawn displacement of a block
MIDDLE = RAIL_TOP + BLOCK_EDGE / 2
MAGNET_X, MAGNET_NAME = WALL - 0.13, MIDDLE + 0.5  # across: a magnet; how high its name is
FULL_FORCE_N = 3.0  # N at which an arrow is about 0.6 long


def _wall(side: str, stiffness: float) -> tuple[Part, ...]:
    """What holds a block: a spring and a damper, the poles of a magnet, or nothing."""
    if stiffness == 0:
        return ()
    wall = Part(f"wall {side}", Box((0.2, 1.2, 1.05)), STEEL)
    if stiffness < 0:
        return (wall, *(Part(f"magnet {side} {pole}", Box((0.26, 0.3, 0.42)), colour)
                        for pole, colour in (("front", DARK_GREY), ("back", METAL))))
    return (wall, Part(f"spring {side}", Spring(0.12, 6.0, 0.028), METAL),
            Part(f"housing {side}", Cylinder(0.09, 0.42), STEEL), Part(f"rod {side}", Rod(0.04), METAL))


def _fixed(left: float, right: float) -> dict[str, Pose]:
    poses = {
        "base": Pose((0.0, 0.0, 0.06)),
        "rail front": Pose((0.0, -0.24, 0.16)),
        "rail back": Pose((0.0, 0.24, 0.16)),
    }
    for i, rest in enumerate(REST_POSITIONS):
        poses[f"rest mark {i + 1}"] = Pose((rest, -0.48, 0.126))
    for side, sign, stiffness in (("left", -1.0, left), ("right", 1.0, right)):
        if stiffness == 0:
            continue
        poses[f"wall {side}"] = Pose((sign * (WALL + 0.1), 0.0, 0.12 + 0.525))
        if stiffness < 0:
            poses[f"magnet {side} front"] = Pose((sign * MAGNET_X, -0.2, MIDDLE))
            poses[f"magnet {side} back"] = Pose((sign * MAGNET_X, 0.2, MIDDLE))
        else:
            poses[f"housing {side}"] = Pose((sign * (WALL - 0.21), 0.18, RAIL_TOP + 0.14), LYING)
    return poses


def held_at(block: int, x: Sequence[float], gain: float) -> Vector:
    """Where a hand holds a block: the middle of its front."""
    at = REST_POSITIONS[block] + bound_displacement(float(x[block]) * STAGE_SCALE * gain, MAX_DRAWN_DISPLACEMENT)
    return at, -0.4, MIDDLE


def chain_body(left: float, right: float, forces: Sequence[tuple[float, float]]) -> Body:
    """The chain with these wall stiffnesses; `forces` holds, for each input, its share on the two blocks."""
    fixed = _fixed(left, right)
    held = tuple((side, sign, i) for side, sign, i, stiffness in (("left", -1.0, 0, left), ("right", 1.0, 1, right))
                 if stiffness > 0)
    parts = (
        Part("base", Box((4.6, 1.2, 0.12)), DARK_GREY),
        Part("rail front", Box((4.1, 0.1, 0.08)), METAL),
        Part("rail back", Box((4.1, 0.1, 0.08)), METAL),
        *(Part(f"rest mark {i}", Box((0.05, 0.16, 0.012)), METAL) for i in (1, 2)),
        *_wall("left", left),
        *_wall("right", right),
        Part("spring", Spring(0.13, 7.0, 0.03), METAL),
        Part("housing", Rod(0.09), STEEL),
        Part("rod", Rod(0.04), METAL),
        *(Part(f"block {i}", Box((BLOCK_EDGE, 0.8, BLOCK_EDGE)), PLANT_COLOUR, twin=True) for i in (1, 2)),
    )

    def middles(x: Sequence[float], gain: float) -> tuple[float, float]:
        scale = STAGE_SCALE * gain
        return (
            REST_POSITIONS[0] + bound_displacement(float(x[0]) * scale, MAX_DRAWN_DISPLACEMENT),
            REST_POSITIONS[1] + bound_displacement(float(x[1]) * scale, MAX_DRAWN_DISPLACEMENT),
        )

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        at = middles(x, gain)
        start, end = at[0] + BLOCK_EDGE / 2, at[1] - BLOCK_EDGE / 2
        half = start + 0.55 * (REST_POSITIONS[1] - REST_POSITIONS[0] - BLOCK_EDGE)  # the housing rides on the left block
        poses = dict(fixed)
        poses["block 1"] = Pose((at[0], 0.0, MIDDLE))
        poses["block 2"] = Pose((at[1], 0.0, MIDDLE))
        poses["spring"] = pose_between((start, -0.16, RAIL_TOP + 0.38), (end, -0.16, RAIL_TOP + 0.38))
        poses["housing"] = pose_between((start, 0.18, RAIL_TOP + 0.14), (max(min(half, end), start + 0.02), 0.18, RAIL_TOP + 0.14))
        poses["rod"] = pose_between((start, 0.18, RAIL_TOP + 0.14), (end, 0.18, RAIL_TOP + 0.14))
        for side, sign, i in held:
            face, wall = at[i] + sign * BLOCK_EDGE / 2, sign * WALL
            poses[f"spring {side}"] = pose_between((wall, -0.16, RAIL_TOP + 0.38), (face, -0.16, RAIL_TOP + 0.38))
            poses[f"rod {side}"] = pose_between((wall, 0.18, RAIL_TOP + 0.14), (face, 0.18, RAIL_TOP + 0.14))
        return poses

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        at = middles(x, gain)
        return tuple(
            force_arrow((at[i], -0.46, MIDDLE), (1.0, 0.0, 0.0), float(value) * shares[i], FULL_FORCE_N)
            for value, shares in zip(u, forces, strict=False) for i in (0, 1) if shares[i]
        )

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return tuple((at, y, RAIL_TOP + BLOCK_EDGE) for at in middles(x, gain) for y in (-0.4, 0.4))

    return Body(parts, pose, arrows, anchors, 1.0, text("Two blocks on a rail; the green arrows are the forces"), names=(
        PartName(text("block 1"), "block 1", (0.0, -0.4, 0.8)),
        PartName(text("block 2"), "block 2", (0.0, -0.4, 0.8)),
        PartName(GHOST_NAME, "block 2", (0.9, -0.3, 0.62), True),
    ), labels=tuple((text("magnet"), (sign * MAGNET_X, -0.3, MAGNET_NAME)) for sign, stiffness in ((-1.0, left), (1.0, right))
                    if stiffness < 0))
