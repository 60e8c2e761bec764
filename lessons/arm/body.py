"""Draw the arm with its target, the angle to it, and the sizes of load and voltage.

After the state come the motor's angle less the arm's and half of the play, the target's angle, all in rad, and the applied voltage in V.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import cos, degrees, sin

from observer_lab.colours import COLOURS
from observer_lab.plants.arm import ANGLE_INDEX, FULL_VOLTAGE, JOINT, LOAD_INDEX, MODEL, VOLTAGE_FOOT, hand
from observer_lab.plants.bodies.body import (
    DARK_GREY,
    Body,
    ErrorMarks,
    Part,
    PartName,
    Pose,
    Rod,
    Vector,
    force_arrow,
    pose_between,
)
from observer_lab.text import format_number, text

TARGET, VOLTAGE = 6, 7  # in the record of the stage
OWN = 6  # what of it the plant's own body takes
BEHIND_ARM, DASH_FROM, DASH_TO, DASHES = -0.2, 0.3, 1.72, 9  # y of the target's line; where its dashes begin and end, from the joint
ARC, ARC_PARTS, ANGLE_WORDS = 1.56, 12, 1.82  # radius of the arc from the target to the arm, its parts; where its size is
LEAST_AWAY, LEAST_LOAD = 0.5, 0.005  # degrees and N m: nothing less is marked
BELOW: Vector = (0.0, 0.0, -9.0)
ARROW_GAP, LOAD_WORDS = 0.2, (0.26, 0.08)  # from the head of the arrow of the voltage to its size; from the hand to that of the load


def _around(angle: float, away: float, y: float = BEHIND_ARM) -> Vector:
    """A point in the plane of the arm, at an angle above level and `away` from the joint."""
    return JOINT[0] + away * cos(angle), y, JOINT[2] + away * sin(angle)


def _pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
    target, angle = float(x[TARGET]), float(x[ANGLE_INDEX])
    step = (DASH_TO - DASH_FROM) / (DASHES - 0.4)
    dashes = {f"target {k}": pose_between(_around(target, DASH_FROM + k * step), _around(target, DASH_FROM + (k + 0.6) * step))
              for k in range(DASHES)}
    ends = [_around(target + (angle - target) * k / ARC_PARTS, ARC) for k in range(ARC_PARTS + 1)]
    shown = abs(degrees(angle - target)) >= LEAST_AWAY
    arc = {f"away {k}": pose_between(ends[k], ends[k + 1]) if shown else Pose(BELOW) for k in range(ARC_PARTS)}
    return {**MODEL.body.pose(x[:OWN], gain), **dashes, **arc}


def _marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
    """The size of the load and of the voltage at their arrows, and the angle between arm and target."""
    angle, target, load, voltage = (float(x[k]) for k in (ANGLE_INDEX, TARGET, LOAD_INDEX, VOLTAGE))
    tip, away = hand(angle), degrees(angle - target)
    top = force_arrow(VOLTAGE_FOOT, (0.0, 0.0, 1.0), max(voltage, 0.0), FULL_VOLTAGE).head
    end = _around((angle + target) / 2, ANGLE_WORDS, -0.3)
    load_at = (tip[0] + LOAD_WORDS[0], tip[1], tip[2] + LOAD_WORDS[1])
    return ErrorMarks((), (
        (f"τ = {format_number(load, '.2g')} N m", load_at if abs(load) >= LEAST_LOAD else BELOW, "center-left"),
        (f"u = {format_number(voltage, '.2f')} V", (top[0] - 0.09, top[1], top[2] + ARROW_GAP), "bottom-center"),
        (f"{format_number(abs(away), '.2g')}°", end if abs(away) >= LEAST_AWAY else BELOW, "center-center")))


BODY: Body = replace(
    MODEL.body, pose=_pose, marks=_marks, anchors=lambda x, gain: MODEL.body.anchors(x[:OWN], gain),
    arrows=lambda x, u, gain: MODEL.body.arrows(x[:OWN], u, gain),
    parts=(*MODEL.body.parts, *(Part(f"target {k}", Rod(0.022), DARK_GREY) for k in range(DASHES)),
           *(Part(f"away {k}", Rod(0.03), COLOURS["error"]) for k in range(ARC_PARTS))),
    names=(*MODEL.body.names, PartName(text("target"), f"target {DASHES - 1}", (-0.45, -0.1, 0.0))))
