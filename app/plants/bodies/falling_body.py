"""Model a body falling through the atmosphere, of which a radar measures the distance.

State (h, v, β): altitude in m, speed downwards in m/s, drag coefficient in 1/m. ḣ = −v, v̇ = −e^{−κh} v² β, β̇ = 0, and
y = √(M² + (h − H)²). Athans, Wishner and Bertolini, IEEE Trans. Automatic Control 13 (1968) 504–514; the same case with an
unscented filter: Julier, Uhlmann and Durrant-Whyte, IEEE Trans. Automatic Control 45 (2000) 477–482. They count in feet.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import atan2, cos, exp, hypot, sin

import numpy as np

from ...colours import COLOURS, rgb
from ...engine import NonlinearPlant
from ...text import text
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
    force_arrow,
    pose_between,
)

FOOT_M = 0.3048  # m
TRUE_START = (300_000 * FOOT_M, 20_000 * FOOT_M, 1e-3 / FOOT_M)  # the true start of both papers
GUESS = (300_000 * FOOT_M, 20_000 * FOOT_M, 3e-5 / FOOT_M)  # what their filters begin with
START_SIGMAS = (1e3 * FOOT_M, 2e3 * FOOT_M, 1e-2 / FOOT_M)  # and its standard deviations: √(1e6, 4e6, 1e-4) in feet
NOISE = 100 * FOOT_M  # m, standard deviation of a distance (variance 10⁴ ft²)
SAMPLE_S = 1.0  # s between two distances


@dataclass(frozen=True)
class Parameters:
    """density 1/m: how fast the air thins with height; side, height m: where the radar stands beside and above."""

    density: float = 5e-5 / FOOT_M
    side: float = 100_000 * FOOT_M
    height: float = 100_000 * FOOT_M


PARAMETERS = Parameters()


def plant(parameters: Parameters = PARAMETERS) -> NonlinearPlant:
    """The fall and the distance, with their slopes by hand."""
    k = parameters

    def rhs(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        out = np.zeros_like(x)
        np.negative(x[1], out=out[0])
        out[1] = np.exp(-k.density * x[0]) * x[2] * x[1] * out[0]
        return out

    def slope(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        thin = np.exp(-k.density * x[0])
        J = np.zeros((x.shape[1], 3, 3))
        J[:, 0, 1] = -1.0
        J[:, 1, 2] = by_drag = -thin * x[1] * x[1]
        J[:, 1, 0] = -k.density * x[2] * by_drag
        J[:, 1, 1] = -2 * thin * x[1] * x[2]
        return J

    def output(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.sqrt(k.side**2 + (x[:1] - k.height)**2)

    def output_slope(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        above = x[0] - k.height
        J = np.zeros((x.shape[1], 1, 3))
        J[:, 0, 0] = above / np.sqrt(k.side**2 + above**2)
        return J

    return NonlinearPlant(3, 0, 1, rhs, slope, output, output_slope, "falling body")


STAGE_SCALE = 0.03 / 1000  # stage units per metre of the fall, the same across and upwards
GROUND_LEVEL, TRACK, LANE = 0.16, 0.1, 1.0  # the ground; where the body falls; stage units to the lane of its ghost, right of it
DISH = (TRACK - 100_000 * FOOT_M * STAGE_SCALE, GROUND_LEVEL + 100_000 * FOOT_M * STAGE_SCALE)
NAME_ABOVE = 0.18  # stage units: the upper edge of a lane's name over its rail
CAPSULE = 0.3  # radius of the body, which alone is not to scale
SCALE_TOP_KM = 95.0  # km, end of the scale
SCALE_AT = 1.7
TOP = GROUND_LEVEL + 1000 * SCALE_TOP_KM * STAGE_SCALE
ARC_Y = 0.04  # stage units behind the plane of the fall: the line of equal distances; the tangent is before it
HOT = 900.0  # m/s² at which the shield glows brightest
GLOW = tuple(rgb(COLOURS[role]) for role in ("steel", "warm-steel", "white-hot"))
ARC_PIECES, ARC_STEP = 12, 0.13  # of the line of equal distances, and radians from one end of a piece to the other
TANGENT = 0.75  # stage units to either side
BAND, BAND_END = 0.035, 0.27  # radius of the bar of ±3σ through the ghost, and of its ends
ERROR_GAIN = 100.0  # times that the lesson exaggerates the error of the ghost


def glow(slowing: float) -> tuple[int, int, int]:
    """The colour of the shield at a deceleration in m/s²."""
    at = 2 * min(max(slowing / HOT, 0.0), 1.0)
    low = min(int(at), 1)
    return tuple(round(a + (at - low) * (b - a)) for a, b in zip(GLOW[low], GLOW[low + 1], strict=True))  # type: ignore[return-value]


def _parts() -> tuple[Part, ...]:
    ticks = tuple(Part(f"tick {i}", Box((0.22, 0.04, 0.025)), METAL) for i in range(4))
    return (
        Part("ground", Box((4.4, 1.5, GROUND_LEVEL)), DARK_GREY),
        Part("air", Box((4.3, 0.02, 0.9)), COLOURS["air"], opacity=0.12),
        Part("mast", Rod(0.06), STEEL),
        Part("turret", Cylinder(0.13, 0.1), STEEL),
        Part("dish", Cylinder(0.28, 0.06), METAL),
        Part("beam", Rod(0.02), COLOURS["lamp"], opacity=0.5),
        Part("scale", Rod(0.03), STEEL),
        *(Part(f"rail {k}", Rod(0.022), METAL) for k in range(2)),
        *ticks,
        *(Part(f"arc {i}", Rod(0.018), COLOURS["muted"]) for i in range(ARC_PIECES)),
        Part("tangent", Rod(0.026), COLOURS["estimate"], twin=True, unseen=True),
        Part("band", Cylinder(BAND, 1.0), COLOURS["estimate"], twin=True, unseen=True),
        *(Part(f"band {end}", Cylinder(BAND_END, 0.03), COLOURS["estimate"], twin=True, unseen=True) for end in ("top", "foot")),
        Part("capsule", Cylinder(CAPSULE, 2 * CAPSULE), PLANT_COLOUR, twin=True),
        Part("nose", Ball(CAPSULE), PLANT_COLOUR, twin=True),
        Part("shield", Cylinder(1.5 * CAPSULE, 0.4 * CAPSULE), STEEL, twin=True),
    )


def body(parameters: Parameters = PARAMETERS) -> Body:
    """A capsule, the radar with its beam, and a scale with a mark every 30 km; to scale, but for the capsule's size.

    A state may be followed by the reach of 3σ in m and by 1 for a ghost in a lane of its own.
    """
    k = parameters
    fixed = {
        "ground": Pose((0.0, 0.0, GROUND_LEVEL / 2)),
        "air": Pose((0.0, 0.7, GROUND_LEVEL + 0.45)),  # behind all that falls, which would else be seen through it
        "mast": pose_between((DISH[0], 0.0, GROUND_LEVEL), (DISH[0], 0.0, DISH[1])),
        "turret": Pose((DISH[0], 0.0, DISH[1])),
        "scale": pose_between((SCALE_AT, 0.0, GROUND_LEVEL), (SCALE_AT, 0.0, GROUND_LEVEL + 1000 * SCALE_TOP_KM * STAGE_SCALE)),
        **{f"rail {k}": pose_between((TRACK + LANE * k, 0.0, GROUND_LEVEL), (TRACK + LANE * k, 0.0, TOP)) for k in range(2)},
        **{f"tick {i}": Pose((SCALE_AT, 0.0, GROUND_LEVEL + 30_000 * i * STAGE_SCALE)) for i in range(4)},
    }

    def at(x: Sequence[float]) -> Vector:
        return TRACK, 0.0, GROUND_LEVEL + 1.3 * CAPSULE + min(max(float(x[0]), 0.0), 1000 * SCALE_TOP_KM) * STAGE_SCALE

    def in_lane(x: Sequence[float]) -> Vector:
        across, deep, up = at(x)
        return across + (LANE * float(x[4]) if len(x) > 4 else 0.0), deep, up

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        place, lane = at(x), in_lane(x)[0]
        poses = dict(fixed)
        across, up = place[0] - DISH[0], place[2] - DISH[1]
        far = max(hypot(across, up), 1e-9)
        sight = (DISH[0] + 0.16 * across / far, 0.0, DISH[1] + 0.16 * up / far)
        turned = pose_between((DISH[0], 0.0, DISH[1]), sight)
        slowing = exp(min(-k.density * float(x[0]), 50.0)) * float(x[1])**2 * float(x[2]) if len(x) > 2 else 0.0
        poses["dish"] = Pose(sight, turned.wxyz)
        poses["beam"] = pose_between(sight, place)
        angle = atan2(up, across)
        for i in range(ARC_PIECES):
            low, high = (angle + ARC_STEP * (i + side - ARC_PIECES / 2) for side in (0, 1))
            ends = [(DISH[0] + far * cos(each), ARC_Y, max(DISH[1] + far * sin(each), GROUND_LEVEL)) for each in (low, high)]
            poses[f"arc {i}"] = pose_between(ends[0], ends[1])
        steep = (-TANGENT * up / far, TANGENT * across / far)
        poses["tangent"] = pose_between((place[0] - steep[0], -ARC_Y, max(place[2] - steep[1], GROUND_LEVEL)),
                                        (place[0] + steep[0], -ARC_Y, max(place[2] + steep[1], GROUND_LEVEL)))
        reach = float(x[3]) * STAGE_SCALE if len(x) > 3 else 0.0
        top, foot = min(place[2] + reach, TOP), max(place[2] - reach, GROUND_LEVEL)
        poses["band"] = Pose((lane, 0.0, (top + foot) / 2), scale=(1.0, 1.0, max(top - foot, 1e-3)))
        poses |= {"band top": Pose((lane, 0.0, top)), "band foot": Pose((lane, 0.0, foot))}
        poses["capsule"] = Pose((lane, 0.0, place[2]))
        poses["nose"] = Pose((lane, 0.0, place[2] + CAPSULE))
        poses["shield"] = Pose((lane, 0.0, place[2] - 1.1 * CAPSULE), colour=glow(slowing))
        return poses

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        place = at(x)
        slowing = exp(min(-k.density * float(x[0]), 50.0)) * float(x[1])**2 * float(x[2])
        return (force_arrow((place[0] - 2 * CAPSULE, 0.0, place[2]), (0.0, 0.0, 1.0), slowing, HOT, "disturbance"),)

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return (in_lane(x),)

    return Body(_parts(), pose, arrows, anchors, 1.0, text("A falling body and the radar that measures its "
                                                           "distance; a mark every 30 km. The ghost falls beside it; its error is "
                                                           "drawn 100 times larger. Grey: equal distances "
                                                           "from the radar. Red: the tangent at the estimate, and a bar "
                                                           "of ±3σ about it"),
        tuple((words, (TRACK + LANE * k, 0.0, TOP + NAME_ABOVE)) for k, words in enumerate((text("body"), text("estimate ± 3σ")))), names=(
        PartName(text("radar"), "dish", (-0.8, 0.0, 0.3)),
        PartName(text("falling body"), "capsule", (-0.45, 0.0, 0.85)),
        PartName(text("equal distances"), f"arc {ARC_PIECES - 3}", (0.3, 0.0, 0.8)),
        PartName(GHOST_NAME, "capsule", (1.0, 0.0, 0.1), True),
    ))
