"""Draw plants with their sensors and the ellipsoid of states that fit the data.

The record that the stage plays is (state, sensors, cloud, and the state of a second deck if one is wanted). Of the cloud: middle (3),
half axes (3), rotation (w, x, y, z), truth (3), in typical sizes; right, away, up.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from types import MappingProxyType

from observer_lab.colours import COLOURS, rgb
from observer_lab.plants.bodies.body import (
    DARK_GREY,
    METAL,
    PLANT_COLOUR,
    STEEL,
    UNTURNED,
    Arrow,
    Ball,
    Body,
    Box,
    Part,
    PartName,
    Pose,
    Rod,
    Vector,
    bound_displacement,
    pose_between,
)
from observer_lab.plants.bodies.deck_body import deck_body
from observer_lab.plants.platform.model import Parameters
from observer_lab.text import Text, same, text

CLOUD, MIDDLE = 0.3, (0.0, -0.1, 3.2)  # stage units per typical size, and where the cloud hangs
MIN_HALF_AXIS = 0.025  # an ellipsoid is never drawn thinner
MAX_DRAWN_DISTANCE, ARM, FAR_ARM = 3.4, 3.1, 6.5  # typical sizes: of the cloud at most, of the axes and the needle, of the axis away
SECOND_FROM = 24  # of a record of the deck: where the state of a second one begins
OFF, ON = rgb(COLOURS["off"]), rgb(COLOURS["plant"])
TO_THE_FRONT = 0.38  # stage units: a vertical sensor before its usual place
HALF_TURN = (0.0, 1.0, 0.0, 0.0)  # half a turn: a rod that hangs instead of standing
DECK_PARAMETERS = Parameters()
WIDEST, ROOM, POST_Y, MOST_NAMED = 1.3, 4.8, 0.28, 6  # columns: widest and whole room, how far behind their posts stand, named ones
SMALL = "₁₂₃₄₅₆"

CLOUD_PARTS = (
    Part("cloud", Ball(1.0), COLOURS["estimate"], opacity=0.38),
    Part("truth", Ball(0.055), PLANT_COLOUR),
    Part("axis right", Rod(0.012), STEEL),
    Part("axis away", Rod(0.012), STEEL),
    Part("axis up", Rod(0.012), STEEL),
)


def _hung(point: Sequence[float]) -> Vector:
    x, y, z = (min(max(float(v), -MAX_DRAWN_DISTANCE), MAX_DRAWN_DISTANCE) * CLOUD for v in point)
    return MIDDLE[0] + x, MIDDLE[1] + y, MIDDLE[2] + z


def _axis(along: int, far: float = ARM) -> Pose:
    step = [0.0, 0.0, 0.0]
    step[along] = CLOUD
    low, high = (tuple(m + long * d for m, d in zip(MIDDLE, step, strict=True)) for long in (-ARM, far))
    return pose_between(low, high)  # type: ignore[arg-type]


AXES = MappingProxyType({"axis right": _axis(0), "axis away": _axis(1, FAR_ARM), "axis up": _axis(2)})


AXIS_NAMES = ((same("x"), (MIDDLE[0] + CLOUD * ARM + 0.14, MIDDLE[1], MIDDLE[2] + 0.08)),  # of the deck
              (same("z"), (MIDDLE[0] + 0.14, MIDDLE[1], MIDDLE[2] + CLOUD * ARM + 0.05)),
              (same("θ"), (MIDDLE[0], MIDDLE[1] + CLOUD * FAR_ARM, MIDDLE[2] + 0.2)))


def cloud_poses(c: Sequence[float]) -> dict[str, Pose]:
    """The ellipsoid of states that the data so far allow, the true one, and the axes."""
    half = tuple(max(float(h) * CLOUD, MIN_HALF_AXIS) for h in c[3:6])
    return {**AXES, "cloud": Pose(_hung(c[:3]), (float(c[6]), float(c[7]), float(c[8]), float(c[9])), half),  # type: ignore[arg-type]
            "truth": Pose(_hung(c[10:13]))}


@lru_cache(maxsize=128)
def _deck_with(place: float) -> Body:
    return deck_body(DECK_PARAMETERS.a, DECK_PARAMETERS.b, place, DECK_PARAMETERS.h)


def _carried(deck: Pose, across: float, up: float, y: float) -> Vector:
    """Where a point of the deck is when the deck stands at this pose."""
    angle = -2 * math.atan2(deck.wxyz[2], deck.wxyz[0])
    c, s = math.cos(angle), math.sin(angle)
    x, _, z = deck.position
    return x + c * across - s * up, y, z + s * across + c * up


def _before(pose: Pose) -> Pose:
    """On the front edge of the deck, where the payload does not hide it."""
    x, y, z = pose.position
    return replace(pose, position=(x, y - TO_THE_FRONT, z))


def _deck_pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
    """State (6), places of both vertical sensors in m, which of the three are on (1 or 0), cloud (13)."""
    state, (left, right), on = x[:6], x[6:8], x[8:11]
    poses = dict(_deck_with(round(-float(left), 4)).pose(state, gain))
    other = _deck_with(round(float(right), 4)).pose(state, gain)
    for name in ("sensor", "servo", "test mass"):
        poses |= {f"{name} {side}": _before(placed[f"{name} {side}"]) for side, placed in (("left", poses), ("right", other))}
    across = Pose(_carried(poses["deck"], -1.45, 0.19, -0.45), poses["deck"].wxyz)
    poses["sensor across"] = across
    poses["needle across"] = pose_between(across.position, _carried(poses["deck"], -1.05, 0.19, -0.45))
    for name, lit in zip(("left", "right", "across"), on, strict=True):
        live = float(lit) > 0.5
        poses[f"sensor {name}"] = replace(poses[f"sensor {name}"], colour=ON if live else OFF)
        mark = f"test mass {name}" if name != "across" else "needle across"
        if not live:  # a sensor that is off has lost its mark as well as its colour
            poses[mark] = replace(poses[mark], scale=(0.02, 0.02, 0.02))
    if len(x) > SECOND_FROM:
        poses["second deck"] = _deck_with(DECK_PARAMETERS.s).pose(x[SECOND_FROM:], gain)["deck"]
    return poses | cloud_poses(x[11:SECOND_FROM])


def _deck() -> Body:
    base = _deck_with(DECK_PARAMETERS.s)
    parts = tuple(replace(part, twin=False) if part.name.startswith(("sensor", "test mass")) else part
                  for part in base.parts)
    return Body(
        (*parts, Part("sensor across", Box((0.3, 0.3, 0.16)), STEEL), Part("needle across", Rod(0.045), METAL),
         *CLOUD_PARTS),
        _deck_pose, lambda x, u, gain: base.arrows(x[:6], u, gain), lambda x, gain: base.anchors(x[:6], gain), base.gain,
        text("Sensors that are on are blue; above, the states (x right, z up, θ away) that the data so far allow"),
        labels=AXIS_NAMES, names=(
            PartName(text("states that the data allow"), "cloud", (-0.95, -0.2, 0.45)),
            PartName(text("sensor that is on"), "sensor across", (-0.35, -0.1, 0.5)), PartName(text("deck"), "deck", (-0.95, -0.7, -0.4))))


def columns_body(count: int, label: Text) -> Body:
    """A plant without a shape: one column a state, as high as the state, on a post; the needle in the cloud points along C.

    Few columns have names; the axes of the cloud bear those of the states along them.
    """
    pitch = min(WIDEST, ROOM / count)
    width = 0.55 * pitch
    base, full = 1.1, 0.75

    def place(i: int) -> float:
        return (i - (count - 1) / 2) * pitch

    def top(x: Sequence[float], i: int) -> Vector:
        return place(i), 0.0, base + bound_displacement(float(x[i]) * full, 0.95)

    fixed = {"plinth": Pose((0.0, 0.0, 0.06))} | {f"foot {i}": Pose((place(i), 0.0, base)) for i in range(count)}
    fixed |= {f"post {i}": pose_between((place(i), POST_Y, 0.12), (place(i), POST_Y, base + full)) for i in range(count)}

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        poses = dict(fixed)
        for i in range(count):
            head = top(x, i)
            rise = head[2] - base
            poses[f"head {i}"] = Pose(head)
            poses[f"stem {i}"] = Pose((head[0], 0.0, base), UNTURNED if rise >= 0 else HALF_TURN, (1.0, 1.0, max(abs(rise), 1e-6)))
        poses["needle"] = pose_between(_hung((0, 0, 0)), _hung([ARM * float(c) for c in x[count:count + 3]]))
        return poses | cloud_poses(x[count + 3:])

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return ()

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return tuple(top(x, i) for i in range(count))

    parts = [Part("plinth", Box((count * pitch + 0.4, 1.2, 0.12)), DARK_GREY), Part("needle", Rod(0.03), METAL), *CLOUD_PARTS]
    for i in range(count):
        parts += [Part(f"foot {i}", Box((width, 0.5, 0.03)), STEEL), Part(f"post {i}", Rod(0.045), STEEL),
                  Part(f"stem {i}", Rod(0.2 * width), METAL),
                  Part(f"head {i}", Box((width, 0.4, 0.12)), PLANT_COLOUR, twin=True)]
    named = tuple((same(f"x{SMALL[i]}"), (place(i), -0.45, 0.2)) for i in range(count if count <= MOST_NAMED else 0))
    ends = ((ARM + 0.4, 0, 0), (0, 0, ARM + 0.15), (0, FAR_ARM + 0.2, 0))[:count]
    axes = tuple((same(f"x{SMALL[i]}"), tuple(m + CLOUD * d for m, d in zip(MIDDLE, end, strict=True))) for i, end in enumerate(ends))
    return Body(tuple(parts), pose, arrows, anchors, 1.0, label, (*named, *axes),  # type: ignore[arg-type]
                names=(PartName(text("what the sensor reads"), "needle", (0.9, -0.2, 0.25)),))


COLUMNS_CAPTION = text("One column per state; above, the states that the data so far allow, and the direction of C")
DECK_BODY = _deck()


def _two_decks() -> Body:
    deck = next(part for part in DECK_BODY.parts if part.name == "deck")
    second = replace(deck, name="second deck", colour=COLOURS["second"], opacity=0.5, twin=False)
    return replace(DECK_BODY, parts=(*DECK_BODY.parts, second))


TWO_DECKS = _two_decks()


@lru_cache(maxsize=32)
def body_of(name: str, count: int, two: bool = False) -> Body:
    """The body of a case with `count` states; for the deck also `two` of them."""
    return columns_body(count, COLUMNS_CAPTION) if name != "deck" else TWO_DECKS if two else DECK_BODY


