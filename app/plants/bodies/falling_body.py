"""Model a body falling through the atmosphere, of which a radar measures the distance.

State (h, v, β): altitude in m, speed downwards in m/s, drag coefficient in 1/m. ḣ = −v, v̇ = −e^{−κh} v² β, β̇ = 0, and
y = √(M² + (h − H)²). Athans, Wishner and Bertolini, IEEE Trans. Automatic Control 13 (1968) 504–514; the same case with an
unscented filter: Julier, Uhlmann and Durrant-Whyte, IEEE Trans. Automatic Control 45 (2000) 477–482. They count in feet.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import asinh, atan2, cos, exp, hypot, sin

import numpy as np

from ...colours import COLOURS, rgb
from ...engine import NonlinearPlant
from ...text import text
from .body import (
    BENCH,
    DARK_GREY,
    GHOST_NAME,
    METAL,
    PLANT_COLOUR,
    STEEL,
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
    pose_between,
    turned,
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


STAGE_SCALE = 0.026 / 1000  # stage units per metre of the fall, the same across and upwards
CAPSULE = 0.22  # radius of the body, which alone is not to scale
GROUND_LEVEL, TRACK, LANE, GHOST_LANE = 0.16, -0.8, 1.22, 1.95  # the ground; across: where the body falls, the band, the ghost beside it
LEVEL = GROUND_LEVEL + 1.3 * CAPSULE  # of the body's middle on the ground
DISH = (TRACK - 100_000 * FOOT_M * STAGE_SCALE, LEVEL + 100_000 * FOOT_M * STAGE_SCALE)
RULER_AT, TICKS_KM, TOP = 0.27, range(30, 91, 30), LEVEL + 108_000 * STAGE_SCALE  # across; altitudes with a mark; the ruler's upper end
GHOST_SIZE = 0.75  # of the body: what counts is where it is in its band
CEILING = TOP - 2 * GHOST_SIZE * CAPSULE  # of the ghost's middle
ARC_Y, TANGENT_Y = -0.34, -0.38  # before the body, which would else hide them: the line of equal distances and the tangent
HOT = 900.0  # m/s² at which the shield glows brightest
GLOW = tuple(rgb(COLOURS[role]) for role in ("steel", "warm-steel", "white-hot"))
ARC_PIECES, ARC_STEP = 12, 0.13  # of the line of equal distances, and radians from one end of a piece to the other
TANGENT = 0.6  # stage units to either side
NAME_OFF, NOWHERE = 0.07, -9.0  # from the end of a line to its name; out of sight
BAND, BAND_Y = 0.4, 0.06  # half the width of the band of ±3σ; stage units before it: the line of the true altitude
ERROR_GAIN, SOFT = 100.0, 0.3  # times that a small error is exaggerated; stage units from which on a larger one is less


def drawn_error(error: float) -> float:
    """Stage units for an error of the altitude in m: a hundred times to scale near zero, rising with the logarithm far off.

    The map is monotone: the truth is drawn inside a band exactly where it is inside.
    """
    return SOFT * asinh(ERROR_GAIN * STAGE_SCALE * error / SOFT)


def glow(slowing: float) -> tuple[int, int, int]:
    """The colour of the shield at a deceleration in m/s²."""
    at = 2 * min(max(slowing / HOT, 0.0), 1.0)
    low = min(int(at), 1)
    return tuple(round(a + (at - low) * (b - a)) for a, b in zip(GLOW[low], GLOW[low + 1], strict=True))  # type: ignore[return-value]


def _parts() -> tuple[Part, ...]:
    estimate = COLOURS["estimate"]
    return (
        Part("ground", Box((4.5, 1.5, GROUND_LEVEL)), BENCH),
        Part("mast", Rod(0.05), STEEL),
        Part("turret", Cylinder(0.1, 0.1), STEEL),
        Part("dish", Cylinder(0.22, 0.05), METAL),
        Part("beam", Rod(0.02), COLOURS["lamp"], opacity=0.5),
        Part("ruler", Rod(0.03), STEEL),
        *(Part(f"tick {each}", Box((0.2, 0.04, 0.025)), DARK_GREY) for each in TICKS_KM),
        Part("true altitude", Rod(0.024), PLANT_COLOUR),
        *(Part(f"arc {i}", Rod(0.02), COLOURS["muted"]) for i in range(ARC_PIECES)),
        Part("tangent", Rod(0.034), estimate, twin=True, unseen=True, edged=False),
        Part("band", Box((2 * BAND, 0.04, 1.0)), estimate, twin=True, unseen=True, edged=False),
        *(Part(f"band {end}", Box((2 * BAND, 0.08, 0.035)), estimate, twin=True, unseen=True, edged=False) for end in ("top", "foot")),
        Part("estimated altitude", Rod(0.02), estimate, twin=True, unseen=True, edged=False),
        Part("capsule", Cylinder(CAPSULE, 2 * CAPSULE), PLANT_COLOUR, twin=True, edged=False),
        Part("nose", Ball(CAPSULE), PLANT_COLOUR, twin=True, edged=False),
        Part("shield", Cylinder(1.5 * CAPSULE, 0.4 * CAPSULE), STEEL, twin=True, edged=False),
    )


def body(parameters: Parameters = PARAMETERS) -> Body:
    """A capsule, the radar with its beam and a ruler, to scale but for the capsule's size; the ghost has a lane of its own.

    A state (h, v, β) is followed by what its ghost shows: error and 3σ of the altitude in m, the altitude at which the filter
    takes its tangent, negative for none, and 1 for the ghost itself.
    """
    k = parameters
    fixed = {
        "ground": Pose((0.0, 0.0, GROUND_LEVEL / 2)),
        "mast": pose_between((DISH[0], 0.0, GROUND_LEVEL), (DISH[0], 0.0, DISH[1])),
        "turret": Pose((DISH[0], 0.0, DISH[1])),
        "ruler": pose_between((RULER_AT, 0.0, GROUND_LEVEL), (RULER_AT, 0.0, TOP)),
        **{f"tick {each}": Pose((RULER_AT, 0.0, _level(1000.0 * each))) for each in TICKS_KM},
    }

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        error, reach, slope, ghostly = map(float, x[3:7]) if len(x) > 3 else (0.0, 0.0, -1.0, 0.0)
        true, poses = _level(float(x[0])), dict(fixed)
        across, up = TRACK - DISH[0], true - DISH[1]
        far = hypot(across, up)
        sight = (DISH[0] + 0.13 * across / far, 0.0, DISH[1] + 0.13 * up / far)
        poses["dish"] = Pose(sight, pose_between((DISH[0], 0.0, DISH[1]), sight).wxyz)
        poses["beam"] = pose_between(sight, (TRACK, 0.0, true))
        poses["true altitude"] = pose_between((LANE + BAND + 0.1, -BAND_Y, true), (TRACK, -BAND_Y, true))
        angle = atan2(up, across)
        for i in range(ARC_PIECES):
            low, high = (angle + ARC_STEP * (i + side - ARC_PIECES / 2) for side in (0, 1))
            ends = [(DISH[0] + far * cos(each), ARC_Y, max(DISH[1] + far * sin(each), GROUND_LEVEL)) for each in (low, high)]
            poses[f"arc {i}"] = pose_between(ends[0], ends[1])
        seen = atan2(_level(slope) - DISH[1], across)
        steep = (TANGENT * sin(seen), -TANGENT * cos(seen)) if slope >= 0 else (0.0, 0.0)
        poses["tangent"] = pose_between((TRACK - steep[0], TANGENT_Y, true - steep[1]), (TRACK + steep[0], TANGENT_Y, true + steep[1]))
        foot, middle, top = (_shown(true, each) for each in (error - reach, error, error + reach))
        poses["band"] = Pose((LANE, 0.0, (top + foot) / 2), scale=(1.0, 1.0, max(top - foot, 1e-3)))
        poses |= {"band top": Pose((LANE, 0.0, top)), "band foot": Pose((LANE, 0.0, foot)),
                  "estimated altitude": pose_between((LANE - BAND, -BAND_Y, middle), (GHOST_LANE, -BAND_Y, middle))}
        at, z, size = (GHOST_LANE, middle, GHOST_SIZE) if ghostly else (TRACK, true, 1.0)
        slowing = exp(min(-k.density * float(x[0]), 50.0)) * float(x[1])**2 * float(x[2])
        poses["capsule"] = Pose((at, 0.0, z), scale=(size, size, size))
        poses["nose"] = Pose((at, 0.0, z + size * CAPSULE), scale=(size, size, size))
        poses["shield"] = Pose((at, 0.0, z - 1.1 * size * CAPSULE), scale=(size, size, size), colour=glow(slowing))
        return poses

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        true = _level(float(x[0]))
        return ((LANE, -2 * BAND_Y, _shown(true, float(x[3])) if len(x) > 6 and x[6] else true),)

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        now = pose(x, gain)
        far, tangent, top = now[f"arc {ARC_PIECES - 1}"], now["tangent"], pose(xhat, gain)["band top"].position[2]
        across, _, up = _end_of(far)
        right, _, level = max(tangent.position, _end_of(tangent))
        drawn = tangent.scale[2] > TANGENT
        return ErrorMarks((), (
            (text("equal distances"), (across, ARC_Y, up + NAME_OFF), "bottom-center"),
            (text("tangent"), (right + NAME_OFF, TANGENT_Y, level if drawn else NOWHERE), "center-left"),
            (text("±3σ × 100"), (LANE, -BAND_Y, top + NAME_OFF), "bottom-center")))

    return Body(_parts(), pose, lambda x, u, gain: (), anchors, 1.0, text(
        "A falling body and the radar that measures its distance; a ruler with a mark every 30 km. The ghost falls beside its "
        "band of ±3σ. Errors are drawn 100 times larger, large ones less. Blue line: the true altitude. Grey: equal distances from "
        "the radar. Orange: the estimate and the tangent that the filter uses"),
        tuple((f"{each} km", (RULER_AT + 0.24, 0.0, _level(1000.0 * each) + 0.06)) for each in TICKS_KM), marks=marks, names=(
        PartName(text("radar"), "dish", (-0.5, 0.0, 0.35)),
        PartName(text("falling body"), "capsule", (-0.35, 0.0, 0.75)),
        PartName(text("true altitude"), "true altitude", (-0.15, 0.0, -0.75)),
        PartName(GHOST_NAME, "nose", (0.0, 0.0, 0.5), True),
    ))


def _end_of(rod: Pose) -> Vector:
    x, y, z = turned((0.0, 0.0, rod.scale[2]), rod.wxyz)
    return rod.position[0] + x, rod.position[1] + y, rod.position[2] + z


def _shown(true: float, error: float) -> float:
    """How high an error in m is drawn in the lane of the ghost."""
    return min(max(true + drawn_error(error), GROUND_LEVEL), CEILING)


def _level(altitude: float) -> float:
    """How high an altitude in m is on the stage."""
    return LEVEL + min(max(altitude, 0.0), 95_000.0) * STAGE_SCALE
