"""Model a chip whose core temperature must be estimated from its case temperature."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ..colours import COLOURS, rgb
from ..engine import Plant
from ..text import format_number, text, text_in
from .bodies.body import (
    DARK_GREY,
    GHOST_NAME,
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
    Vector,
)
from .bodies.body import force_arrow as arrow
from .model import Model, Signal, Window

LEAKAGE = 1.4  # W/K that makes the default chip run away
STAGE_SCALE = 0.0125  # stage units per kelvin on the two columns
CHIP_X, BOARD_TOP = -0.62, 0.30  # middle of the chip, top of the board
CORE, CASE = 0.95, 1.42  # where the two columns stand
HEATING = CHIP_X + 0.95, -0.55, BOARD_TOP + 0.02  # the tail of the arrow of the heating power
FOOT_LABEL = -0.2, 0.37  # y and z of their names
SCALE_X, TICKS = 1.84, 5  # across: the numbers of the scale; its marks, 20 K from one to the next
BAR_X, TICK = CORE - 0.31, 0.07  # where the bar of the core's error stands, half the width of its ends
CORE_LABEL = CHIP_X, -0.42, BOARD_TOP + 0.18  # on the core: its temperature is not measured
SENSOR_LABEL = CHIP_X - 0.14, -0.56, BOARD_TOP + 0.9  # of what is measured
BRASS, SIDES, FRONT_CONTACTS, SIDE_CONTACTS = COLOURS["brass"], ("left", "right"), 9, 7
LOWEST_LEVEL, ZERO_LEVEL = 0.46, 0.95  # lowest level of a column, its level at ambient temperature
MAX_COLUMN_RISE, MAX_COLUMN_FALL = 1.2, 0.42  # highest and lowest drawn level from there
GLOW = tuple((kelvin, rgb(COLOURS[role])) for kelvin, role in (
    (-30.0, "dark"), (0.0, "unlit"), (20.0, "steel"), (45.0, "hot"), (90.0, "white-hot")))  # temperature above ambient in K, colour


@dataclass(frozen=True)
class Parameters:
    """core, case J/K: heat capacities. inner, outer K/W: heat resistance from core to case and from case to air."""

    core: float = 2.0
    case: float = 12.0
    inner: float = 0.5
    outer: float = 0.8


def runaway_leakage(parameters: Parameters = Parameters()) -> float:
    """The leakage in W/K above which the core heats itself without end: 1/(inner + outer)."""
    return 1.0 / (parameters.inner + parameters.outer)


def plant(parameters: Parameters = Parameters(), leakage: float = 0.0) -> Plant:
    """Temperatures above ambient of core and case in K, heating power in W, the case measured.

    core Ṫ₁ = u + leakage T₁ − (T₁ − T₂)/inner, case Ṫ₂ = (T₁ − T₂)/inner − T₂/outer, y = T₂. Leakage power in W/K
    grows with the core temperature, as leakage current does in silicon; above `runaway_leakage` one pole is positive.
    """
    k = parameters
    A = [[(leakage - 1 / k.inner) / k.core, 1 / (k.inner * k.core)],
         [1 / (k.inner * k.case), -(1 / k.inner + 1 / k.outer) / k.case]]
    return Plant(np.array(A), np.array([[1 / k.core], [0]]), np.array([[0, 1]]),
                 state_names=("core", "case"), input_names=("power",), output_names=("sensor",),
                 units=(("core", "K"), ("case", "K"), ("power", "W"), ("sensor", "K")),
                 name="chip-runaway" if leakage > runaway_leakage(k) else "chip")


def _parts() -> tuple[Part, ...]:
    feet = tuple(Part(f"foot {i}", Cylinder(0.09, 0.2), METAL) for i in range(4))
    posts = tuple(Part(f"post {i}", Rod(0.03), METAL) for i in range(4))
    fins = tuple(Part(f"fin {i}", Box((0.07, 1.0, 0.42)), STEEL) for i in range(7))
    columns = tuple(part for name in ("core", "case") for part in (
        Part(f"{name} socket", Cylinder(0.15, 0.16), STEEL),
        Part(f"{name} column", Rod(0.085), METAL),
        Part(f"{name} level", Cylinder(0.17, 0.05), PLANT_COLOUR, twin=True),
    ))
    ticks = tuple(Part(f"tick {i}", Box((1.0 if i == 0 else 0.8, 0.02, 0.03 if i == 0 else 0.014)), DARK_GREY)
                  for i in range(TICKS))
    return (
        *feet,
        Part("board", Box((3.4, 1.7, 0.1)), COLOURS["laminate"]),
        *(Part(f"screw {i}", Cylinder(0.075, 0.05), METAL) for i in range(4)),
        Part("package", Box((1.3, 1.3, 0.1)), COLOURS["ceramic"]),
        *(Part(f"contact {i}", Box((0.07, 0.16, 0.035)), BRASS) for i in range(FRONT_CONTACTS)),
        *(Part(f"contact {side} {i}", Box((0.16, 0.07, 0.035)), BRASS) for side in SIDES for i in range(SIDE_CONTACTS)),
        Part("die rim", Box((0.86, 0.86, 0.05)), BRASS),
        Part("die", Box((0.72, 0.72, 0.16)), STEEL),
        *posts,
        Part("spreader", Box((1.24, 1.1, 0.1)), STEEL),
        *fins,
        Part("sensor", Cylinder(0.08, 0.1), METAL),
        Part("scale", Box((1.16, 0.05, 1.9)), COLOURS["tube"]),
        *ticks,
        *columns,
    )


def _fixed() -> dict[str, Pose]:
    poses = {
        "board": Pose((0.0, 0.0, BOARD_TOP - 0.05)),
        "package": Pose((CHIP_X, 0.0, BOARD_TOP + 0.05)),
        "die rim": Pose((CHIP_X, 0.0, BOARD_TOP + 0.115)),
        "sensor": Pose((CHIP_X, -0.46, BOARD_TOP + 0.87)),
        "scale": Pose(((CORE + CASE) / 2, 0.3, BOARD_TOP + 0.95)),
        "core socket": Pose((CORE, 0.0, BOARD_TOP + 0.08)),
        "case socket": Pose((CASE, 0.0, BOARD_TOP + 0.08)),
    }
    for i, (sx, sy) in enumerate(((-1, -1), (1, -1), (-1, 1), (1, 1))):
        poses[f"foot {i}"] = Pose((1.5 * sx, 0.65 * sy, 0.1))
        poses[f"screw {i}"] = Pose((1.58 * sx, 0.73 * sy, BOARD_TOP + 0.01))
        poses[f"post {i}"] = Pose((CHIP_X + 0.55 * sx, 0.48 * sy, BOARD_TOP + 0.1), scale=(1.0, 1.0, 0.56))
    low = BOARD_TOP + 0.0175  # of the contacts, which stand out from under the package
    poses |= {f"contact {i}": Pose((CHIP_X + 0.14 * (i - 4), -0.69, low)) for i in range(FRONT_CONTACTS)}
    poses |= {f"contact {side} {i}": Pose((CHIP_X + 0.69 * sign, 0.17 * (i - 3), low))
              for side, sign in zip(SIDES, (-1, 1), strict=True) for i in range(SIDE_CONTACTS)}
    for i in range(TICKS):
        poses[f"tick {i}"] = Pose(((CORE + CASE) / 2, 0.265, ZERO_LEVEL + 20.0 * i * STAGE_SCALE))
    return poses


def glow(kelvin: float) -> tuple[int, int, int]:
    """The colour of a temperature above ambient: dark when cold, grey at ambient, white when hot."""
    value = min(max(kelvin, GLOW[0][0]), GLOW[-1][0])
    for (low, a), (high, b) in pairwise(GLOW):
        if value <= high:
            share = (value - low) / (high - low)
            return (round(a[0] + share * (b[0] - a[0])), round(a[1] + share * (b[1] - a[1])),
                    round(a[2] + share * (b[2] - a[2])))
    return GLOW[-1][1]


def body(parameters: Parameters = Parameters()) -> Body:
    """A chip under a raised heat sink, glowing with its temperatures, and two columns that show them as heights."""
    fixed = _fixed()

    def level(kelvin: float, gain: float) -> float:
        return ZERO_LEVEL + min(max(kelvin * STAGE_SCALE * gain, -MAX_COLUMN_FALL), MAX_COLUMN_RISE)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        core, case = float(x[0]), float(x[1])
        hot, warm = glow(core), glow(case)
        poses = dict(fixed)
        poses["die"] = Pose((CHIP_X, 0.0, BOARD_TOP + 0.18), colour=hot)
        poses["spreader"] = Pose((CHIP_X, 0.0, BOARD_TOP + 0.71), colour=warm)
        for i in range(7):
            poses[f"fin {i}"] = Pose((CHIP_X + 0.18 * (i - 3), 0.06, BOARD_TOP + 0.96), colour=warm)
        for name, kelvin, colour, at in (("core", core, hot, CORE), ("case", case, warm, CASE)):
            top = level(kelvin, gain)
            poses[f"{name} column"] = Pose((at, 0.0, LOWEST_LEVEL), scale=(1.0, 1.0, top - LOWEST_LEVEL), colour=colour)
            poses[f"{name} level"] = Pose((at, 0.0, top))
        return poses

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return (replace(arrow(HEATING, (0.0, 0.0, 1.0), float(u[0]), 40.0), called=(text("heating power"), 0.0)),)

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return ((CORE, -0.18, level(float(x[0]), gain)), (CASE, -0.18, level(float(x[1]), gain)))

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        true, believed = ((BAR_X, -0.2, level(float(states[0]), gain)) for states in (x, xhat))
        ends = tuple(((at[0] - TICK, at[1], at[2]), (at[0] + TICK, at[1], at[2])) for at in (true, believed))
        error, case = (format_number(value, ".1f") for value in (float(x[0]) - float(xhat[0]), float(x[1])))
        return ErrorMarks(((true, believed), *ends), (
            (f"e₁ = {error} K", (BAR_X - TICK, -0.2, (true[2] + believed[2]) / 2), "center-right"),
            ("T₁ = ?", CORE_LABEL, "center-center"), (f"T₂ = {case} K", SENSOR_LABEL, "center-right")))

    return Body(_parts(), pose, arrows, anchors, 1.0, text("Left column: core; right column: case, the only one "
                                                           "measured; a tick every 20 K"),
                ((text_in("chip", "core"), (CORE, *FOOT_LABEL)), (text_in("chip", "case"), (CASE, *FOOT_LABEL)),
                 *((f"{20 * i} K" if i else "0", (SCALE_X, 0.26, ZERO_LEVEL + 20.0 * i * STAGE_SCALE + 0.07)) for i in range(0, TICKS, 2))),
                names=(
        PartName(text("core: no sensor"), "die", (-0.6, -0.75, 0.16)),
        PartName(text("sensor on the case"), "sensor", (-0.2, -0.4, 0.75)),
        PartName(GHOST_NAME, "core level", (-0.6, -0.5, -0.3), True),
    ), marks=marks)


WATCHED = (
    Signal(text("core temperature"), (1.0, 0.0), "K"),
    Signal(text("case temperature"), (0.0, 1.0), "K"),
)

MODEL = Model(
    id="chip",
    label=text("Chip: core and case"),
    plant=plant(),
    body=body(),
    x0=(45.0, 20.0),
    guess=(0.0, 0.0),
    horizon=15.0,
    dt=0.03,
    controller_poles=(-1.3, -0.25),
    observer_poles=(-1.6 - 0.5j, -1.6 + 0.5j),
    controller_window=Window(-4.0, 1.0, 2.0),
    observer_window=Window(-4.0, 1.0, 2.0),
    kick=(20.0, 0.0),
    watched=WATCHED,
    u_max=60.0,
    input_unit="W",
    source="Tutorial on output feedback: a processor whose case is measured, its core not",
)

RUNAWAY_MODEL = replace(
    MODEL,
    id="chip-runaway",
    label=text("Chip with thermal runaway"),
    plant=plant(leakage=LEAKAGE),
    x0=(12.0, 6.0),
    controller_poles=(-1.0, -0.5),
    kick=(8.0, 0.0),
    source="Tutorial on output feedback; leakage power added",
)
