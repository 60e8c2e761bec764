"""Draw the deck with its sensors and its seven observers.

A faulty part turns pink, an identified one gets a flag. The record that the stage plays is (state (6), which of the seven parts fail,
which one is accused), 1 or 0 each, then, where the bank is shown, the test value of each observer over its threshold (7).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from observer_lab.colours import COLOURS, rgb
from observer_lab.plants.bodies.body import (
    BENCH,
    DARK_GREY,
    GHOST_NAME,
    METAL,
    Ball,
    Body,
    Box,
    ErrorMarks,
    Part,
    PartName,
    Pose,
    Rod,
    Vector,
    pose_between,
)
from observer_lab.plants.bodies.deck_body import STAGE_SCALE, deck_body
from observer_lab.plants.platform.model import Parameters
from observer_lab.text import same, text

from .observer_bank import MEMBER_NAMES

DECK_PARAMETERS = Parameters()
FAILING, HONEST, COIL, STEEL_GREY, MASS = (rgb(COLOURS[role]) for role in ("error", "second", "coil", "steel", "metal"))
FLAG, POLE = COLOURS["lamp"], COLOURS["dark"]
BELOW: Vector = (0.0, 0.0, -9.0)
SIDES = (("left", -1.0), ("right", 1.0))
BANK_SHOWN, DECK_ALONE = "bank", "deck"  # what stands before the deck: the bars of its observers, or nothing
GAUGE_AT, GAUGE_UP, GAUGE_Y = 1.02, 0.17, -0.42  # where the horizontal sensors stand on the deck
FRONT_EDGE, MARK_UP = -0.68, -0.02  # where the sensors' names are on the deck, from its middle
STATES = 20  # what of the record is about the deck
BENCH_Y, BENCH_HIGH, BAR_PITCH, BAR_RADIUS = -1.38, 0.1, 0.52, 0.12  # of the bars before the deck, in stage units
TALL_AT_THRESHOLD, HIGHEST, LEAST = 0.36, 2.6, 0.03  # how high a bar is at its threshold; the most and the least that is drawn, of it
OVER, WITHIN = rgb(COLOURS["error"]), rgb(COLOURS["plant"])
LINE_END = 3.6 * BAR_PITCH
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


def _sensor_names(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
    """The names of the four sensors on the deck's front edge, below each of them."""
    deck = BASE.pose(x[:6], gain)["deck"]
    apart = DECK_PARAMETERS.s * STAGE_SCALE
    return ErrorMarks((), tuple((f"{name}{side}", _carried(deck, sign * across, MARK_UP, FRONT_EDGE), "center-center")
                                for side, sign in (("L", -1.0), ("R", 1.0)) for name, across in (("V", apart), ("H", GAUGE_AT))))


DECK = Body(
    _parts(), _pose, lambda x, u, gain: BASE.arrows(x[:6], u, gain), lambda x, gain: BASE.anchors(x[:6], gain), BASE.gain,
    text("Blue: sensors VL, VR (near the middle) and HL, HR (with needles). Pink: what really fails; the flag: the diagnosed part"),
    names=(PartName(text("coil u1"), "coil left", (-0.28, -0.4, 0.12)), PartName(text("coil u2"), "coil right", (0.28, -0.4, 0.12)),
           PartName(text("coil u3"), "coil across", (0.2, -0.2, 0.6)), PartName(GHOST_NAME, "payload lid", (-0.7, -0.2, 0.5), True)),
    marks=_sensor_names)


def bar_places() -> tuple[float, ...]:
    """Where along the bench the seven bars stand."""
    middle = (len(MEMBER_NAMES) - 1) / 2
    return tuple(BAR_PITCH * (k - middle) for k in range(len(MEMBER_NAMES)))


def _with_bank(body: Body) -> Body:
    """The deck behind a bench with a bar for each observer, and a line across them at the threshold."""
    level, before = BENCH_HIGH + TALL_AT_THRESHOLD, BENCH_Y - BAR_RADIUS - 0.03
    parts = (Part("bank bench", Box((2 * LINE_END, 0.44, BENCH_HIGH)), BENCH),
             Part("threshold", Box((2 * LINE_END, 0.03, 0.03)), DARK_GREY),
             *(Part(f"threshold post {side}", Box((0.05, 0.05, TALL_AT_THRESHOLD)), DARK_GREY) for side, _ in SIDES),
             *(Part(f"test {k}", Rod(BAR_RADIUS), COLOURS["plant"]) for k in range(len(MEMBER_NAMES))))
    fixed = {"bank bench": Pose((0.0, BENCH_Y, BENCH_HIGH / 2)), "threshold": Pose((0.0, before, level)),
             **{f"threshold post {side}": Pose((sign * (LINE_END - 0.03), before, BENCH_HIGH + TALL_AT_THRESHOLD / 2))
                for side, sign in SIDES}}

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        bars = {}
        for k, (across, value) in enumerate(zip(bar_places(), x[STATES:], strict=True)):
            top = BENCH_HIGH + TALL_AT_THRESHOLD * min(max(float(value), LEAST), HIGHEST)
            bars[f"test {k}"] = replace(pose_between((across, BENCH_Y, BENCH_HIGH), (across, BENCH_Y, top)),
                                        colour=OVER if value > 1 else WITHIN)
        return {**body.pose(x, gain), **fixed, **bars}
    labels = (*((same(name), (across, BENCH_Y - 0.3, 0.02)) for across, name in zip(bar_places(), MEMBER_NAMES, strict=True)),
              (text("test value of each observer; −HL: without HL"), (0.0, BENCH_Y - 0.58, 0.02)),
              (text("threshold"), (LINE_END + 0.42, BENCH_Y - 0.15, level - 0.12)))
    said = text("Pink: what really fails; the flag: the diagnosed part. Bars: the test value of each observer, −HL is the one without HL. "
                "Above the line it gives an alarm")
    return replace(body, parts=(*body.parts, *parts), pose=pose, labels=labels, caption=said)


BODIES = MappingProxyType({BANK_SHOWN: _with_bank(DECK), DECK_ALONE: DECK})
