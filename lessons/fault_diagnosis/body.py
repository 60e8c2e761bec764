"""Draw the deck with its sensors; a faulty part turns pink, an identified one gets a flag.

The record that the stage plays is (state (6), which of the seven parts fail, which one is accused), 1 or 0 each.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from observer_lab.colours import COLOURS, rgb
from observer_lab.plants.bodies.body import METAL, Ball, Body, Box, Part, PartName, Pose, Rod, Vector, pose_between
from observer_lab.plants.bodies.deck_body import deck_body
from observer_lab.plants.platform.model import Parameters
from observer_lab.text import same, text

DECK_PARAMETERS = Parameters()
FAILING, HONEST, COIL, STEEL_GREY, MASS = (rgb(COLOURS[role]) for role in ("error", "second", "coil", "steel", "metal"))
FLAG, POLE = COLOURS["lamp"], COLOURS["dark"]
BELOW: Vector = (0.0, 0.0, -9.0)
SIDES = (("left", -1.0), ("right", 1.0))
GAUGE_AT, GAUGE_UP, GAUGE_Y = 1.02, 0.17, -0.42  # where the horizontal sensors stand on the deck
BASE = deck_body(DECK_PARAMETERS.a, DECK_PARAMETERS.b, DECK_PARAMETERS.s, DECK_PARAMETERS.h)


def _carried(deck: Pose, across: float, up: float, y: float) -> Vector:
    """Where a point of the deck is when the deck stands at this pose."""
    angle = -2 * math.atan2(deck.wxyz[2], deck.wxyz[0])
    c, s = math.cos(angle), math.sin(angle)
    x, _, z = deck.position
    return x + c * across - s * up, y, z + s * across + c * up


def _parts() -> tuple[Part, ...]:
    gauges = tuple(part for side, _ in SIDES for part in (
        Part(f"gauge {side}", Box((0.3, 0.26, 0.16)), COLOURS["second"]), Part(f"needle {side}", Rod(0.035), METAL)))
    own = tuple(replace(part, twin=False) if part.name.startswith(("sensor", "test mass")) else part for part in BASE.parts)
    return (*own, *gauges, Part("flag pole", Rod(0.025), POLE), Part("flag", Ball(0.13), FLAG))


def _pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
    poses = dict(BASE.pose(x[:6], gain))
    fails = [float(v) > 0.5 for v in x[6:13]]
    for index, (side, sign) in enumerate(SIDES):
        up_down, across = fails[2 * index], fails[2 * index + 1]
        at = _carried(poses["deck"], sign * GAUGE_AT, GAUGE_UP, GAUGE_Y)
        end = _carried(poses["deck"], sign * (GAUGE_AT + 0.45), GAUGE_UP, GAUGE_Y)
        poses[f"sensor {side}"] = replace(poses[f"sensor {side}"], colour=FAILING if up_down else HONEST)
        poses[f"test mass {side}"] = replace(poses[f"test mass {side}"], colour=FAILING if up_down else MASS)
        poses[f"gauge {side}"] = Pose(at, poses["deck"].wxyz, colour=FAILING if across else HONEST)
        poses[f"needle {side}"] = replace(pose_between(at, end), colour=FAILING if across else STEEL_GREY)
    for index, coil in enumerate(("coil left", "coil right", "coil across")):
        poses[coil] = replace(poses[coil], colour=FAILING if fails[4 + index] else COIL)
    return poses | _flag(poses, [float(v) > 0.5 for v in x[13:20]])


def _flag(poses: Mapping[str, Pose], accused: Sequence[bool]) -> dict[str, Pose]:
    """The flag over the accused part; below the floor while nobody is accused."""
    if not any(accused):
        return {"flag pole": Pose(BELOW), "flag": Pose(BELOW)}
    feet = ("test mass left", "gauge left", "test mass right", "gauge right", "coil left", "coil right", "coil across")
    foot = poses[feet[list(accused).index(True)]].position
    low = (foot[0], foot[1] - (0.3 if accused[4] or accused[5] else 0.0), foot[2])
    top = (low[0], low[1], low[2] + 0.75)
    return {"flag pole": pose_between(low, top), "flag": Pose(top)}


BODY = Body(
    _parts(), _pose, lambda x, u, gain: BASE.arrows(x[:6], u, gain), lambda x, gain: BASE.anchors(x[:6], gain), BASE.gain,
    text("Blue: sensors VL, VR (near the middle) and HL, HR (with needles). Pink: what really fails; the flag: the diagnosed part"),
    names=(PartName(same("VL"), "test mass left", (0.0, -0.2, 0.5)), PartName(same("VR"), "test mass right", (0.0, -0.2, 0.5)),
           PartName(same("HL"), "gauge left", (-0.4, -0.3, 0.5)), PartName(same("HR"), "gauge right", (0.4, -0.3, 0.5))))
