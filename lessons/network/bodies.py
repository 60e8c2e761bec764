"""Draw the plants of lesson 18, each with two lamps that show its packets.

The record that the stage plays is (state, measurement heard, input heard, share of the sample, earlier packets of both links); a packet
is 1 or 0, −1 before the run. On the ridge four more say where a delayed force would be right (whether that is shown, and the place), and
the estimate and 3σ of the filter, in cm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import atan2, copysign, hypot

from observer_lab.colours import COLOURS, rgb
from observer_lab.plants.bodies.body import (
    DARK_GREY,
    GHOST_NAME,
    METAL,
    PLANT_COLOUR,
    STEEL,
    UNTURNED,
    Arrow,
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
    about_y,
    bound_displacement,
    force_arrow,
    pose_between,
)
from observer_lab.text import format_number, text

LIT_COLOUR, UNLIT_COLOUR = rgb(COLOURS["lamp"]), rgb(COLOURS["dark"])
LAMPS = (("sensor", -1.62), ("input", 1.62))
LAMP_Y, LAMP_HEIGHT = -1.2, 0.42  # in front of the plant
PACKETS = 8  # on each belt: this sample's and those before it
BELT_Y, BELT_BEGIN, PITCH = -1.02, 0.14, 0.175  # in front of the plant: from its middle outwards
UNSEEN = -9.0  # below the floor
PACKET = (0.13, 0.12, 0.09)
SLICES, RIDGE_WIDTH, CREST, TRACK = 21, 3.4, 1.25, 0.05  # of the ridge; how thick its track is
MAX_DRAWN_POSITION, STEEP = 1.5, 0.36  # farthest drawn place of the ball, drop of the ridge at one stage unit squared
SCALE = 0.16  # stage units per centimetre on the ridge
BALL, TARGET_SHADE = 0.16, 0.45
GATE_TOP, GATE_THICK, GATE_WORDS = CREST + 0.72, 0.03, 0.12  # of the gate ± 3σ: how high and thick it is, from it to its size
HALF_TURN = (0.0, 1.0, 0.0, 0.0)  # half a turn


def with_lamps(body: Body, n: int) -> Body:
    """The body of a plant with n states, for each link a lamp, bright where a packet has just arrived, and a belt of its last packets."""
    parts, fixed = list(body.parts), {}
    for name, x in LAMPS:
        parts += [Part(f"{name} lamp foot", Cylinder(0.12, 0.06), STEEL), Part(f"{name} lamp post", Rod(0.03), METAL),
                  Part(f"{name} lamp", Ball(0.11), DARK_GREY)]
        fixed[f"{name} lamp foot"] = Pose((x, LAMP_Y, 0.03))
        fixed[f"{name} lamp post"] = Pose((x, LAMP_Y, 0.0), scale=(1.0, 1.0, LAMP_HEIGHT))
        parts += [Part(f"{name} belt", Box((PACKETS * PITCH, 0.2, 0.03)), STEEL),
                  *(Part(f"{name} packet {k}", Box(PACKET), DARK_GREY) for k in range(PACKETS))]
        fixed[f"{name} belt"] = Pose((copysign(BELT_BEGIN + (PACKETS - 1) * PITCH / 2, x), BELT_Y, 0.015))

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        poses = {**body.pose(x[:n], gain), **fixed}
        for (name, place), heard in zip(LAMPS, x[n:n + 2], strict=True):
            on = float(heard) > 0.5
            size = 1.0 if on else 0.55  # a lamp that is out is smaller as well as darker
            poses[f"{name} lamp"] = Pose((place, LAMP_Y, LAMP_HEIGHT), scale=(size, size, size), colour=LIT_COLOUR if on else UNLIT_COLOUR)
        share, *earlier = x[n + 2:] or (0.0, *(2 * (PACKETS - 1)) * (-1.0,))
        for i, (name, place) in enumerate(LAMPS):
            for k, heard in enumerate((x[n + i], *earlier[i * (PACKETS - 1):(i + 1) * (PACKETS - 1)])):
                poses[f"{name} packet {k}"] = _packet(copysign(1.0, place), k + share, float(heard))
        return poses

    return replace(
        body, parts=tuple(parts), pose=pose, arrows=lambda x, u, gain: body.arrows(x[:n], u, gain),
        anchors=lambda x, gain: body.anchors(x[:n], gain),
        caption=text("{caption}. Lamps in front: measurement (left) and input (right), bright when a packet "
                     "arrives. The belts carry the last packets; a lost one is dark",
                     caption=body.caption))


def _packet(side: float, age: float, came: float) -> Pose:
    """A packet on its belt, so many samples old, moved outwards; one that was lost lies flat and dark, one before the run is not seen."""
    at, height = BELT_BEGIN + min(age, PACKETS - 1.0) * PITCH, 1.0 if came > 0.5 else 0.2
    return Pose((side * at, BELT_Y, 0.03 + height * PACKET[2] / 2 if came >= 0 else UNSEEN), scale=(1.0, 1.0, height),
                colour=LIT_COLOUR if came > 0.5 else UNLIT_COLOUR)


def _ridge(x: float) -> float:
    return CREST - STEEP * x * x


def _under(x: float) -> float:
    """How high the ridge is below its track, near a place across the stage."""
    return _ridge(abs(x) + RIDGE_WIDTH / SLICES / 2) - TRACK / 2


def _on_ridge(place: float, gain: float) -> Vector:
    at = bound_displacement(place * SCALE * gain, MAX_DRAWN_POSITION)
    return at, 0.0, _ridge(at) + BALL


def ridge_with_target() -> Body:
    """The ridge with its lamps and belts, a green ball where the acting force would be right, and a gate of the estimate ± 3σ."""
    body, links = with_lamps(ridge_body(), 1), 1 + 3 + 2 * (PACKETS - 1)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        shown, place, believed, wide = x[links:] or (0.0, 0.0, 0.0, 0.0)
        there = _on_ridge(float(place), gain)
        return {**body.pose(x[:links], gain), "target": Pose(there if shown > 0.5 else (there[0], 0.0, UNSEEN)),
                **_gate(float(believed), float(wide), gain)}

    def size(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        left, right = gate_ends(float(x[-2]), float(x[-1]), gain)
        return ErrorMarks((), ((f"3σ = {format_number(float(x[-1]), '.2g')} cm", ((left + right) / 2, 0.0, GATE_TOP + GATE_WORDS),
                                "bottom-center"),))

    gate = tuple(Part(f"gate {name}", Rod(GATE_THICK), COLOURS["estimate"]) for name in ("left", "right", "top"))
    return replace(body, parts=(*body.parts, Part("target", Ball(BALL), COLOURS["force"], opacity=TARGET_SHADE), *gate), pose=pose,
                   marks=size, names=(*body.names, PartName(text("gate: ± 3σ"), "gate left", (-0.55, -0.2, 0.3))))


def gate_ends(believed: float, wide: float, gain: float) -> tuple[float, float]:
    """Where across the stage the posts of the gate stand."""
    left, right = (_on_ridge(believed + side * wide, gain)[0] for side in (-1.0, 1.0))
    return left, right


def _gate(believed: float, wide: float, gain: float) -> dict[str, Pose]:
    """Two posts where the ridge carries them, and a bar over the ball from one to the other."""
    left, right = gate_ends(believed, wide, gain)
    posts = {f"gate {name}": pose_between((at, 0.0, _ridge(at)), (at, 0.0, GATE_TOP)) for name, at in (("left", left), ("right", right))}
    return {**posts, "gate top": pose_between((left, 0.0, GATE_TOP), (right, 0.0, GATE_TOP))}


def ridge_body() -> Body:
    """A ball on the crest of a ridge, its place in cm: the farther off, the faster it rolls away."""
    width = RIDGE_WIDTH / SLICES
    middles = tuple((i - (SLICES - 1) / 2) * width for i in range(SLICES))
    fixed = {"base": Pose((0.0, 0.0, 0.05))}
    for i, x in enumerate(middles):
        low, high = x - width / 2, x + width / 2
        fixed[f"slice {i}"] = Pose((x, 0.1, (0.1 + _under(x)) / 2))
        fixed[f"track {i}"] = Pose((x, 0.1, (_ridge(low) + _ridge(high) - TRACK) / 2), about_y(-atan2(_ridge(high) - _ridge(low), width)))

    def centre(x: Sequence[float], gain: float) -> Vector:
        return _on_ridge(float(x[0]), gain)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        return fixed | {"ball": Pose(centre(x, gain))}

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        at = centre(x, gain)
        return (force_arrow((at[0], -0.5, at[2]), (1.0, 0.0, 0.0), float(u[0]), 4.0),)

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return (centre(x, gain),)

    slices = tuple(Part(f"slice {i}", Box((width, 0.84, _under(x) - 0.1)), STEEL) for i, x in enumerate(middles))
    slices += tuple(Part(f"track {i}", Box((hypot(width, _ridge(x + width / 2) - _ridge(x - width / 2)) + 0.02, 0.9, TRACK)), METAL)
                    for i, x in enumerate(middles))
    return Body((Part("base", Box((4.0, 1.3, 0.1)), DARK_GREY), *slices, Part("ball", Ball(BALL), PLANT_COLOUR, twin=True)),
                pose, arrows, anchors, 1.0, text("A ball on a ridge rolls away by itself; the green arrow is the "
                                                 "input, the orange gate is the estimate ± 3σ"), names=(
        PartName(text("measurement arrives"), "sensor lamp", (0.5, -0.1, -0.6)),
        PartName(text("input arrives"), "input lamp", (-0.5, -0.1, -0.6)),
        PartName(GHOST_NAME, "ball", (0.7, -0.2, 0.6), True),
    ))


def columns_body(count: int, full: float) -> Body:
    """One column a state, as high as the state; `full` is drawn 0.7 high."""
    base = 1.0

    def place(i: int) -> float:
        return (i - (count - 1) / 2) * 1.1

    def top(x: Sequence[float], i: int, gain: float) -> Vector:
        return place(i), 0.0, base + bound_displacement(0.7 * gain * float(x[i]) / full, 0.8)

    fixed = {"plinth": Pose((0.0, 0.0, 0.06))}
    for i in range(count):
        fixed |= {f"foot {i}": Pose((place(i), 0.12, base)), f"back {i}": Pose((place(i), 0.4, base))}

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        poses = dict(fixed)
        for i in range(count):
            head = top(x, i, gain)
            rise = head[2] - base
            poses[f"head {i}"] = Pose(head)
            poses[f"stem {i}"] = Pose((head[0], 0.0, base), UNTURNED if rise >= 0 else HALF_TURN, (1.0, 1.0, max(abs(rise), 1e-6)))
        return poses

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return (force_arrow((place(0) - 0.6, 0.0, base), (0.0, 0.0, 1.0), float(u[0]), full),)

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return tuple(top(x, i, gain) for i in range(count))

    parts = [Part("plinth", Box((3.6, 1.2, 0.12)), DARK_GREY)]
    for i in range(count):
        parts += [Part(f"back {i}", Box((0.66, 0.05, 1.76)), STEEL), Part(f"foot {i}", Box((0.62, 0.5, 0.03)), METAL),
                  Part(f"stem {i}", Rod(0.09), METAL),
                  Part(f"head {i}", Box((0.5, 0.42, 0.12)), PLANT_COLOUR, twin=True)]
    return Body(tuple(parts), pose, arrows, anchors, 1.0, text("One column per state; only their sum is measured; "
                                                               "the green arrow is the input"))
