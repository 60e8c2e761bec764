"""Model a geared arm with a DC motor: data, equations with load torque, body.

Motor: maxon RE 40, graphite brushes, 150 W, order number 148867 (24 V winding), as its data sheet prints it. Gear: maxon GP 42 C, order
number 203116, 15 : 1, absolute 91/6. Encoder: maxon HEDL 5540, order number 110514, 500 lines, counted four times. The arm's inertia, its
friction and the load are chosen for this lab; the gear's own inertia and losses are left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import atan2, cos, pi, radians, sin
from types import MappingProxyType

import numpy as np

from ..engine import Plant
from ..text import same, text
from .bodies.body import (
    ASKED,
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
    Quaternion,
    Rod,
    Vector,
    force_arrow,
    pose_between,
)
from .grip import Grip
from .model import Model, Signal, Window


@dataclass(frozen=True)
class DataSheet:
    """What the sheet of the motor prints, in SI units: nominal voltage V, resistance Ω, inductance H, torque constant N m/A, rotor kg m².

    Under them what follows from these, printed too: no-load speed rad/s and current A, stall torque N m and current A, speed constant
    rad/(s V), and the current A that the winding bears for good.
    """

    voltage: float = 24.0
    resistance: float = 0.299
    inductance: float = 0.082e-3
    torque_constant: float = 30.2e-3
    rotor: float = 142e-7
    no_load_speed: float = 7580 * pi / 30
    no_load_current: float = 0.137
    stall_torque: float = 2.42
    stall_current: float = 80.2
    speed_constant: float = 317 * pi / 30
    nominal_current: float = 6.0


MOTOR_DATA = DataSheet()


@dataclass(frozen=True)
class Parameters:
    """`ratio` of the gear; `arm` kg m² and `friction` N m s/rad at the joint, both chosen; `lines` of the encoder; the motor's sheet."""

    ratio: float = 91 / 6
    arm: float = 0.12
    friction: float = 0.05
    lines: int = 500
    sheet: DataSheet = MOTOR_DATA

    @property
    def reflected(self) -> float:
        """The rotor's inertia as the joint feels it, N² J_r in kg m²."""
        return self.ratio**2 * self.sheet.rotor

    @property
    def inertia(self) -> float:
        """Arm and rotor together, kg m²."""
        return self.arm + self.reflected

    @property
    def torque(self) -> float:
        """Torque at the joint for one ampere, N k in N m/A."""
        return self.ratio * self.sheet.torque_constant


PARAMETERS = Parameters()
CURRENT_INDEX, SPEED_INDEX, ANGLE_INDEX, LOAD_INDEX = range(4)  # of the state


def plant(parameters: Parameters = PARAMETERS) -> Plant:
    """L i̇ = u − R i − N k ω,  J ω̇ = N k i − b ω − τ,  θ̇ = ω,  τ̇ = 0, y = θ; state (i, ω, θ, τ) in A, rad/s, rad, N m, input in V.

    The load torque τ is a state that nothing drives: what changes it comes from outside.
    """
    p, m = parameters, parameters.sheet
    A = np.zeros((4, 4))
    A[CURRENT_INDEX, :2] = -m.resistance / m.inductance, -p.torque / m.inductance
    A[SPEED_INDEX, [CURRENT_INDEX, SPEED_INDEX, LOAD_INDEX]] = p.torque / p.inertia, -p.friction / p.inertia, -1 / p.inertia
    A[ANGLE_INDEX, SPEED_INDEX] = 1.0
    B, C = np.array([[1 / m.inductance], [0], [0], [0]]), np.array([[0, 0, 1, 0]])
    return Plant(A, B, C, state_names=("i", "omega", "theta", "tau"),
                 input_names=("voltage",), output_names=("angle",), name="arm",
                 units=(("i", "A"), ("omega", "rad/s"), ("theta", "rad"), ("tau", "N m"), ("voltage", "V"), ("angle", "rad")))


# --- the body -----------------------------------------------------------------------------------------------------------
POINTING_AWAY: Quaternion = (cos(pi / 4), -sin(pi / 4), 0.0, 0.0)  # an upright cylinder's axis points away
JOINT: Vector = (-0.8, 0.0, 0.98)
ARM_LENGTH, DIAL = 1.3, 0.52  # lengths of the arm and of the dial's needle
FACE: Vector = (1.36, 0.1, 0.98)  # the middle of the dial of the load
FULL_TORQUE_NM = 3.0  # N m at which the needle lies flat
VOLTAGE_FOOT: Vector = (-1.72, -0.3, 0.78)  # where the arrow of the motor's voltage begins
FULL_VOLTAGE, ASKED_BESIDE = 3.0, 0.18  # V at which it is 0.6 long; how far beside it the voltage asked for stands
STAND_X = VOLTAGE_FOOT[0] - ASKED_BESIDE / 2  # across: the stand on which both arrows are zero
FLANK, FLANK_FROM, FLANK_LONG, PLAY_GAIN = 0.035, 0.26, 0.56, 10.0  # radius, begin and end of a flank; how many times the play is drawn
ARM_THICK = 0.075
MARKS_NM, MARK, NUMBER = (-3.0, -1.5, 0.0, 1.5, 3.0), (0.56, 0.64), 0.84  # loads; from and to, and where their numbers are, from the middle


def on_dial(torque: float, away: float) -> Vector:
    """A point of the dial for a load in N m. No load is above the middle; one that presses the arm down is to the right."""
    turn = radians(90.0) * max(-1.2, min(1.2, torque / FULL_TORQUE_NM))
    return FACE[0] + away * sin(turn), FACE[1] - 0.06, FACE[2] + away * cos(turn)


BODY_PARTS = (
    Part("base", Box((4.1, 1.3, 0.1)), DARK_GREY),
    Part("column", Box((0.5, 0.5, JOINT[2] - 0.1)), STEEL),
    Part("motor", Cylinder(0.24, 0.72), METAL),
    Part("gear", Cylinder(0.28, 0.3), DARK_GREY),
    Part("hub", Cylinder(0.2, 0.5), STEEL),
    Part("arm", Rod(ARM_THICK), PLANT_COLOUR, twin=True),
    *(Part(f"flank {side}", Rod(FLANK), METAL) for side in ("below", "above")),
    Part("hand", Ball(0.16), PLANT_COLOUR, twin=True),
    Part("dial", Cylinder(0.66, 0.06), METAL),
    Part("dial foot", Rod(0.06), STEEL),
    *(Part(f"mark {k}", Rod(0.014), DARK_GREY) for k in range(5)),
    Part("voltage plate", Box((0.6, 0.3, 0.04)), METAL),
    Part("voltage stand", Rod(0.06), STEEL),
    Part("needle", Rod(0.035), PLANT_COLOUR, twin=True),
    Part("needle tip", Ball(0.07), PLANT_COLOUR, twin=True),
)
FIXED_POSES = MappingProxyType({
    "base": Pose((0.0, 0.0, 0.05)),
    "column": Pose((JOINT[0], 0.3, (JOINT[2] + 0.1) / 2)),
    "motor": Pose((JOINT[0], 0.75, JOINT[2]), POINTING_AWAY),
    "gear": Pose((JOINT[0], 0.25, JOINT[2]), POINTING_AWAY),
    "hub": Pose((JOINT[0], 0.0, JOINT[2]), POINTING_AWAY),
    "dial": Pose((FACE[0], FACE[1] + 0.08, FACE[2]), POINTING_AWAY),
    "dial foot": pose_between((FACE[0], FACE[1] + 0.08, 0.1), (FACE[0], FACE[1] + 0.08, FACE[2] - 0.6)),
    "voltage plate": Pose((STAND_X, VOLTAGE_FOOT[1], VOLTAGE_FOOT[2] - 0.02)),
    "voltage stand": pose_between((STAND_X, -0.2, 0.1), (STAND_X, -0.2, VOLTAGE_FOOT[2] - 0.04)),
    **{f"mark {k}": pose_between(on_dial(torque, MARK[0]), on_dial(torque, MARK[1])) for k, torque in enumerate(MARKS_NM)},
})


def hand(angle: float) -> Vector:
    """Where the hand is for an angle above level, in rad."""
    return JOINT[0] + ARM_LENGTH * cos(angle), -0.28, JOINT[2] + ARM_LENGTH * sin(angle)


def _flank(arm: float, away: float, side: int) -> Pose:
    """A flank of the gear that carries the arm, `away` in rad from it, drawn PLAY_GAIN times as far; the play is never drawn negative."""
    angle = arm + side * (PLAY_GAIN * max(away, 0.0) + atan2(ARM_THICK + FLANK, FLANK_LONG))
    begin, end = ((JOINT[0] + long * cos(angle), -0.28, JOINT[2] + long * sin(angle)) for long in (FLANK_FROM, FLANK_LONG))
    return pose_between(begin, end)


def body() -> Body:
    """The arm on its geared motor, to scale, and a dial of the load torque; the amber arrow at the hand is the load, the green one the
    voltage, a thin one what is asked for. After the state may come the motor's angle less the arm's and half of the play, both in rad.
    """
    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        tip, shown = hand(float(x[ANGLE_INDEX])), on_dial(float(x[LOAD_INDEX]), DIAL)
        ahead, half = (float(v) for v in x[4:6]) if len(x) > 4 else (0.0, 0.0)
        flanks = {f"flank {name}": _flank(float(x[ANGLE_INDEX]), half + side * ahead, side) for name, side in (("below", -1), ("above", 1))}
        return FIXED_POSES | flanks | {
            "arm": pose_between((JOINT[0], -0.28, JOINT[2]), tip), "hand": Pose(tip),
            "needle": pose_between((FACE[0], FACE[1] - 0.06, FACE[2]), shown), "needle tip": Pose(shown)}

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        angle, tip = float(x[ANGLE_INDEX]), hand(float(x[ANGLE_INDEX]))
        across = (sin(angle), 0.0, -cos(angle))
        beside = VOLTAGE_FOOT[0] - ASKED_BESIDE, *VOLTAGE_FOOT[1:]
        return (force_arrow((tip[0], -0.5, tip[2]), across, float(x[LOAD_INDEX]), 2.0, "disturbance"),
                force_arrow(VOLTAGE_FOOT, (0.0, 0.0, 1.0), float(u[0]), FULL_VOLTAGE),
                *(force_arrow(beside, (0.0, 0.0, 1.0), float(asked), FULL_VOLTAGE, ASKED) for asked in u[1:]))

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return hand(float(x[ANGLE_INDEX])), on_dial(float(x[LOAD_INDEX]), DIAL)

    return Body(
        BODY_PARTS,
        pose,
        arrows,
        anchors,
        1.0,
        text("A geared arm, to scale, and a dial of the load torque, which nothing measures. The arrow at the hand is the load, "
             "the green arrow the voltage"),
        labels=((text("load torque [N m]"), (FACE[0], -0.5, 0.34)), (text("motor voltage"), (VOLTAGE_FOOT[0], -0.5, 0.4)),
                (text("thin: commanded"), (VOLTAGE_FOOT[0], -0.5, 0.22)),
                *((same(f"{torque:g}"), on_dial(torque, NUMBER)) for torque in MARKS_NM[2:])),
        names=(
            PartName(text("motor"), "motor", (-0.5, 0.0, 0.7)),
            PartName(text("arm: its angle is measured"), "hand", (0.5, -0.2, 0.16)),
            PartName(GHOST_NAME, "needle tip", (-0.2, -0.2, 0.5), True),
        ),
    )


DEGREES = 180 / pi
MODEL = Model(
    id="arm",
    label=text("Geared arm with a DC motor"),
    plant=plant(),
    body=body(),
    x0=(0.0, 0.0, 0.0, 0.0),
    guess=(0.0, 0.0, 0.0, 0.0),
    horizon=2.4,
    dt=0.004,
    controller_poles=(-7 - 7j, -7 + 7j),
    observer_poles=(-14 - 6j, -14 + 6j, -12 + 0j),
    controller_window=Window(-30.0, 6.0, 20.0),
    observer_window=Window(-80.0, 15.0, 40.0),
    kick=(0.0, 2.0, 0.0, 0.0),
    grips=(Grip("pull", text("torque of a hand on the arm"), ("hand", "arm"), lambda x, gain: hand(float(x[ANGLE_INDEX])), (0.0, 0.0, 1.0),
                (0.0, 1 / PARAMETERS.inertia, 0.0, 0.0), 1.0, "N m"),),
    watched=(
        Signal(text("angle of the arm θ"), (0.0, 0.0, 1.0, 0.0), "°", DEGREES),
        Signal(text("speed of the arm ω"), (0.0, 1.0, 0.0, 0.0), "rad/s"),
        Signal(text("load torque τ"), (0.0, 0.0, 0.0, 1.0), "N m"),
        Signal(text("current of the motor i"), (1.0, 0.0, 0.0, 0.0), "A"),
    ),
    u_max=24.0,
    input_unit="V",
    source="maxon RE 40, order number 148867; gear GP 42 C, 203116; encoder HEDL 5540, 110514; the arm is chosen",
)
