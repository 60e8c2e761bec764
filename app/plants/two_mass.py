"""Model the two-mass chain and its variants with a hidden motion.

Two blocks on a rail with a spring and a damper between them, each of them held to its own wall or not. With two
identical blocks held alike, the motion splits into the common one (both move together) and the relative one: a
sensor of the distance never sees the common motion, and an actuator between the blocks never moves it. What holds
the blocks then decides whether the hidden motion settles or departs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import Literal

import numpy as np

from ..engine import EngineError, Plant
from ..engine.systems import phrase
from ..text import Text, text
from .bodies.chain_body import chain_body, held_at
from .grip import Grip
from .model import Model, Signal, Window

Sensor = Literal["first", "second", "both", "distance", "centre"]
Actuator = Literal["first", "second", "both", "opposed", "equal"]
Case = Literal["unseen-stable", "unseen-unstable", "unmoved-stable", "unmoved-unstable"]
SENSOR_CHOICES: Mapping[str, tuple[tuple[float, float], ...]] = MappingProxyType({
    "first": ((1, 0),), "second": ((0, 1),), "both": ((1, 0), (0, 1)), "distance": ((-1, 1),), "centre": ((0.5, 0.5),),
})
ACTUATORS: Mapping[str, tuple[tuple[float, float], ...]] = MappingProxyType({
    "first": ((1, 0),), "second": ((0, 1),), "both": ((1, 0), (0, 1)), "opposed": ((-1, 1),), "equal": ((1, 1),),
})
STATE_NAMES = ("q1", "q2", "v1", "v2")


@dataclass(frozen=True)
class Parameters:
    """m1, m2 kg; left, between, right N/m; damping of the same three in N s/m.

    A negative wall stiffness is the pull of a magnet that grows as the block comes nearer.
    """

    m1: float = 1.0
    m2: float = 1.0
    left: float = 4.0
    between: float = 6.0
    right: float = 0.0
    left_damping: float = 0.2
    between_damping: float = 0.3
    right_damping: float = 0.0


def plant(parameters: Parameters = Parameters(), sensor: Sensor = "second", actuator: Actuator = "first") -> Plant:
    """M q̈ + D q̇ + K q = F u, y = H q; state (q1, q2, v1, v2). Raises EngineError for an unknown sensor or actuator.

    Sensors: a block's position, both, their distance q2 − q1, or their centre. Actuators: a force on a block, one on
    each, `opposed` (one force that pushes the blocks apart), `equal` (one force on both alike).
    """
    if sensor not in SENSOR_CHOICES:
        raise EngineError("There is no sensor {sensor} on the chain; choose one of {sensors}.",
                          sensor=f'{sensor!r}', sensors=", ".join(SENSOR_CHOICES))
    if actuator not in ACTUATORS:
        raise EngineError("There is no actuator {actuator} on the chain; choose one of {actuators}.",
                          actuator=f'{actuator!r}', actuators=", ".join(ACTUATORS))
    k = parameters
    masses = np.array([[k.m1], [k.m2]])
    K = np.array([[k.left + k.between, -k.between], [-k.between, k.right + k.between]])
    D = np.array([[k.left_damping + k.between_damping, -k.between_damping],
                  [-k.between_damping, k.right_damping + k.between_damping]])
    F, H = np.array(ACTUATORS[actuator]).T, np.array(SENSOR_CHOICES[sensor])
    outputs = ("position 1", "position 2") if sensor == "both" else (sensor,)
    inputs = ("force 1", "force 2") if actuator == "both" else ("force",)
    return Plant(np.block([[np.zeros((2, 2)), np.eye(2)], [-K / masses, -D / masses]]),
                 np.vstack([np.zeros_like(F), F / masses]), np.hstack([H, np.zeros_like(H)]),
                 state_names=STATE_NAMES, input_names=inputs, output_names=outputs,
                 units=(*((q, "m") for q in STATE_NAMES[:2]), *((v, "m/s") for v in STATE_NAMES[2:]),
                        *((name, "N") for name in inputs), *((name, "m") for name in outputs)),
                 name="two-mass")


WATCHED = (
    Signal(text("position of the right block"), (0.0, 1.0, 0.0, 0.0), "m"),
    Signal(text("position of the left block"), (1.0, 0.0, 0.0, 0.0), "m"),
    Signal(text("distance of the blocks"), (-1.0, 1.0, 0.0, 0.0), "m"),
)

def grips(parameters: Parameters, most: float) -> tuple[Grip, ...]:
    """The two blocks, each pulled along the rail with at most so many newtons."""
    labels = text("force of a hand on the left block"), text("force of a hand on the right block")
    mass = parameters.m1, parameters.m2
    return tuple(Grip(("pull", "pull_2")[i], labels[i], (f"block {i + 1}",), partial(held_at, i), (1.0, 0.0, 0.0),
                      tuple(1 / mass[i] if j == 2 + i else 0.0 for j in range(4)), most) for i in (0, 1))


MODEL = Model(
    id="two-mass",
    label=text("Two masses and a spring"),
    plant=plant(),
    body=chain_body(4.0, 0.0, ACTUATORS["first"]),
    x0=(0.35, -0.25, 0.0, 0.0),
    guess=(0.0, 0.0, 0.0, 0.0),
    horizon=8.0,
    dt=0.016,
    controller_poles=(-1.2 - 1.6j, -1.2 + 1.6j, -1.5 - 3j, -1.5 + 3j),
    observer_poles=(-3 - 2j, -3 + 2j, -3.5 - 4j, -3.5 + 4j),
    controller_window=Window(-6.0, 2.0, 6.0),
    observer_window=Window(-8.0, 2.0, 6.0),
    kick=(0.0, 0.0, 0.8, 0.0),
    watched=WATCHED,
    u_max=3.0,
    grips=grips(Parameters(), 3.0),
    source="Two masses in a chain, in every textbook of vibration",
)


@dataclass(frozen=True)
class Hidden:
    """A chain whose common motion is hidden: from the sensor (`unseen`) or from the actuator (not `unseen`).

    `motion` says which physical motion it is, `direction` (4,) is that motion as a change of position in the state,
    `poles` are its two poles, which no gain moves: of the observer if unseen, of the controller otherwise.
    """

    case: Case
    model: Model
    unseen: bool
    stable: bool
    motion: Text
    direction: tuple[float, float, float, float]
    poles: tuple[complex, complex]


SETTLES = Parameters(left=0.3, right=0.3, left_damping=0.5, right_damping=0.5)
DEPARTS = replace(SETTLES, left=-0.5, right=-0.5)
LABELS: Mapping[Case, tuple[Text, Text]] = MappingProxyType({
    "unseen-stable": (
        text("Distance sensor, blocks on soft springs"),
        text("both blocks drifting together, unseen by the sensor of their distance")),
    "unseen-unstable": (
        text("Distance sensor, blocks between magnets"),
        text("both blocks pulled away together by the magnets, unseen by the sensor of their distance")),
    "unmoved-stable": (
        text("Actuator between the blocks, on soft springs"),
        text("both blocks drifting together, unmoved by a force that acts between them")),
    "unmoved-unstable": (
        text("Actuator between the blocks, between magnets"),
        text("both blocks pulled away together by the magnets, unmoved by a force that acts between them")),
})


def common_poles(parameters: Parameters) -> tuple[complex, complex]:
    """The roots of m s² + c s + k: the common motion of two identical blocks held alike. Raises EngineError if not."""
    k = parameters
    if (k.m1, k.left, k.left_damping) != (k.m2, k.right, k.right_damping):
        raise EngineError("The common motion is only hidden when both blocks are identical and held alike.")
    low, high = np.sort_complex(np.roots([k.m1, k.left_damping, k.left]).astype(complex))
    return complex(low), complex(high)


def hidden(case: Case, parameters: Parameters | None = None) -> Hidden:
    """One of the four cases, with default or own parameters of two identical blocks held alike.

    unseen: distance measured, force on the left block. unmoved: force between the blocks, left block measured; with
    the same parameters its plant hides the same motion, by duality. Raises EngineError for an unknown case and for
    blocks that differ, or whose common motion does not fit the name (stable: both poles left of the axis).
    """
    if case not in LABELS:
        raise EngineError("There is no case {case}; choose one of {labels}.",
                          case=f'{case!r}', labels=", ".join(LABELS))
    unseen, stable = case.startswith("unseen"), not case.endswith("unstable")
    chosen = parameters or (SETTLES if stable else DEPARTS)
    fixed = common_poles(chosen)
    if (fixed[1].real < 0) != stable:
        motion = phrase("unstable") if stable else phrase("stable")
        raise EngineError("With these parameters the common motion is {motion}, so they do not fit the case {case}; change the "
                          "wall stiffness or the damping.", motion=motion, case=case)
    label, motion = LABELS[case]
    actuator: Actuator = "first" if unseen else "opposed"
    built = plant(chosen, "distance" if unseen else "first", actuator)
    slow, fast = (-0.9 - 1.2j, -0.9 + 1.2j), (-2.5 - 2j, -2.5 + 2j)
    model = replace(
        MODEL, id=f"two-mass-{case}", label=label, plant=built,
        body=chain_body(chosen.left, chosen.right, ACTUATORS[actuator]),
        x0=(0.4, 0.1, 0.0, 0.0) if stable else (0.16, -0.04, 0.0, 0.0), horizon=8.0,
        controller_poles=(*(slow if unseen else fixed), -1.5 - 3j, -1.5 + 3j),
        observer_poles=(*(fixed if unseen else fast), -3.5 - 4j, -3.5 + 4j),
        kick=(0.0, 0.0, 0.4, 0.4) if stable else (0.0, 0.0, 0.05, 0.05), grips=grips(chosen, 0.6),
        watched=(WATCHED[2], *WATCHED[:2], Signal(
            text("centre of the blocks"), (0.5, 0.5, 0.0, 0.0), "m")),
    )
    return Hidden(case, model, unseen, stable, motion, (1.0, 1.0, 0.0, 0.0), fixed)


HIDDEN: Mapping[str, Hidden] = MappingProxyType({case: hidden(case) for case in LABELS})
