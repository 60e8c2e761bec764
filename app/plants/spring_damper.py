"""Model the spring-damper: a block on a rail with spring, damper and force."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ..engine import Plant
from ..text import format_number, text
from .bodies.body import (
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
    ErrorMarks,
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
from .grip import Grip
from .model import Model, Signal, Window

STAGE_SCALE = 0.7  # stage units per metre
WALL, REST_POSITION, RAIL_TOP = -1.7, 0.45, 0.2  # right face of the wall, middle of the block at rest, top of the rail
BLOCK_EDGE = 0.72  # edge of the block
MAX_DRAWN_DISPLACEMENT = 0.85  # farthest drawn displacement
MARKS_AT, TICK = (-0.68, 0.16), 0.09  # y and z of the bar between the left faces, half the height of its ends
BELOW_BASE = -0.02  # z of the upper edge of its number: below the front of the base


@dataclass(frozen=True)
class Parameters:
    """m kg, b N s/m, k N/m."""

    m: float = 1.0
    b: float = 0.5
    k: float = 1.0


def plant(parameters: Parameters = Parameters()) -> Plant:
    """m q̈ + b q̇ + k q = u, y = q; state (q, q̇) in m and m/s, input in N."""
    m, b, k = parameters.m, parameters.b, parameters.k
    return Plant(np.array([[0, 1], [-k / m, -b / m]]), np.array([[0], [1 / m]]), np.array([[1, 0]]),
                 state_names=("q", "v"), input_names=("force",), output_names=("position",),
                 units=(("q", "m"), ("v", "m/s"), ("force", "N"), ("position", "m")), name="spring-damper")


BODY_PARTS = (
    Part("base", Box((4.1, 1.3, 0.12)), DARK_GREY),
    Part("wall", Box((0.22, 1.3, 1.25)), STEEL),
    Part("rail front", Box((3.75, 0.1, 0.08)), METAL),
    Part("rail back", Box((3.75, 0.1, 0.08)), METAL),
    Part("rest mark", Box((0.05, 0.16, 0.012)), METAL),
    Part("block", Box((BLOCK_EDGE, 0.9, BLOCK_EDGE)), PLANT_COLOUR, twin=True),
    Part("spring", Spring(0.15, 8.0, 0.032), METAL),
    Part("damper housing", Cylinder(0.12, 0.8), STEEL),
    Part("damper rod", Rod(0.05), METAL),
)
FIXED_POSES = MappingProxyType({
    "base": Pose((0.0, 0.0, 0.06)),
    "wall": Pose((WALL - 0.11, 0.0, 0.12 + 0.625)),
    "rail front": Pose((0.17, -0.3, 0.16)),
    "rail back": Pose((0.17, 0.3, 0.16)),
    "rest mark": Pose((REST_POSITION, -0.52, 0.126)),
    "damper housing": Pose((WALL + 0.4, 0.22, RAIL_TOP + 0.2), LYING),
})


def body(parameters: Parameters = Parameters()) -> Body:
    """The block on its rail; the position is drawn to scale, at most 0.85 stage units from rest."""
    full = max(parameters.k, 1e-6)  # N that hold the spring stretched by one metre

    def middle(x: Sequence[float], gain: float) -> float:
        return REST_POSITION + bound_displacement(float(x[0]) * STAGE_SCALE * gain, MAX_DRAWN_DISPLACEMENT)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        at = middle(x, gain)
        face = at - BLOCK_EDGE / 2
        return FIXED_POSES | {
            "block": Pose((at, 0.0, RAIL_TOP + BLOCK_EDGE / 2)),
            "spring": pose_between((WALL, -0.2, RAIL_TOP + 0.45), (face, -0.2, RAIL_TOP + 0.45)),
            "damper rod": pose_between((WALL + 0.15, 0.22, RAIL_TOP + 0.2), (face, 0.22, RAIL_TOP + 0.2)),
        }

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        tail = (middle(x, gain), -0.52, RAIL_TOP + BLOCK_EDGE / 2)
        return (force_arrow(tail, (1.0, 0.0, 0.0), float(u[0]), full),)

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        at = middle(x, gain)
        return ((at, -0.45, RAIL_TOP + BLOCK_EDGE), (at, 0.45, RAIL_TOP + BLOCK_EDGE))

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        true, believed = ((middle(states, gain) - BLOCK_EDGE / 2, *MARKS_AT) for states in (x, xhat))
        ends = tuple(((at[0], at[1], at[2] - TICK), (at[0], at[1], at[2] + TICK)) for at in (true, believed))
        word = ((true[0] + believed[0]) / 2, MARKS_AT[0], BELOW_BASE)
        size = format_number(float(x[0]) - float(xhat[0]), ".2f")
        return ErrorMarks(((true, believed), *ends), ((f"e₁ = {size} m", word, "top-center"),))

    return Body(BODY_PARTS, pose, arrows, anchors, 1.0, text("A block on a rail between a spring and a damper; the "
                                                        "green arrow is the force"), names=(
        PartName(text("block"), "block", (0.0, -0.5, 0.85)),
        PartName(text("spring and damper"), "spring", (0.3, -0.3, 0.75)),
        PartName(GHOST_NAME, "block", (-0.75, -0.3, 0.75), True),
    ), marks=marks)


def held_at(x: Sequence[float], gain: float) -> Vector:
    """Where a hand holds the block: the middle of its front."""
    at = REST_POSITION + bound_displacement(float(x[0]) * STAGE_SCALE * gain, MAX_DRAWN_DISPLACEMENT)
    return at, -0.45, RAIL_TOP + BLOCK_EDGE / 2


MODEL = Model(
    id="spring-damper",
    label=text("Spring, mass and damper"),
    plant=plant(),
    body=body(),
    x0=(1.0, 0.0),
    guess=(0.0, 0.0),
    horizon=12.0,
    dt=0.024,
    controller_poles=(-0.8 - 0.8j, -0.8 + 0.8j),
    observer_poles=(-1.5 - 1j, -1.5 + 1j),
    controller_window=Window(-5.0, 1.5, 3.0),
    observer_window=Window(-5.0, 1.5, 3.0),
    kick=(0.0, 1.0),
    watched=(
        Signal(text("position of the block"), (1.0, 0.0), "m"),
        Signal(text("velocity of the block"), (0.0, 1.0), "m/s"),
    ),
    u_max=1.0,
    grips=(Grip("pull", text("force of a hand on the block"), ("block",), held_at, (1.0, 0.0, 0.0), (0.0, 1.0), 2.0),),
    source="Observer notes, example of the mass on a spring: m = 1, b = 0.5, k = 1",
)
