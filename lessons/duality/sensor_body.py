"""Put the sensor that turns on the stage of the block: a dial, its pointer and a beam to the block."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from observer_lab.colours import COLOURS
from observer_lab.course.lesson import Stage
from observer_lab.plants.bodies.body import (
    DARK_GREY,
    STEEL,
    Body,
    Box,
    Cylinder,
    Part,
    PartName,
    Pose,
    Quaternion,
    Rod,
    pose_between,
)
from observer_lab.plants.spring_damper import BLOCK_EDGE
from observer_lab.text import text_in

DIAL, FACE, HAND = (1.86, 0.0, 0.98), -0.08, 0.25  # the middle of the dial, how far before it the pointer is, its length
BEAM_Z, POST_FOOT = 0.6, 0.12
FACING: Quaternion = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)  # turns an upright cylinder toward the viewer
SENSOR_PARTS = (
    Part("sensor post", Box((0.12, 0.14, DIAL[2] - POST_FOOT)), STEEL),
    Part("sensor dial", Cylinder(0.28, 0.08), DARK_GREY),
    Part("sensor pointer", Rod(0.045), COLOURS["lit"]),
    Part("sensor beam", Rod(0.016), COLOURS["lit"]),
)


def with_sensor(body: Body) -> Body:
    """The block with its sensor. After the two states a record holds the sensor's angle in rad: 0 measures q, a right angle v."""
    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        poses, turn = body.pose(x, gain), float(x[2])
        face = poses["block"].position[0] + BLOCK_EDGE / 2
        across, _, up = DIAL
        hub, tip = (across, FACE, up), (across + HAND * math.cos(turn), FACE, up + HAND * math.sin(turn))
        return {**poses, "sensor post": Pose((across, 0.0, (POST_FOOT + up) / 2)), "sensor dial": Pose(DIAL, FACING),
                "sensor pointer": pose_between(hub, tip), "sensor beam": pose_between((across, 0.0, BEAM_Z), (face, 0.0, BEAM_Z))}
    return replace(body, parts=(*body.parts, *SENSOR_PARTS), pose=pose,
                   labels=(("q", (DIAL[0] + 0.38, FACE, DIAL[2] + 0.08)), ("v", (DIAL[0], FACE, DIAL[2] + 0.46))),
                   names=(*body.names, PartName(text_in("stage", "sensor"), "sensor dial", (0.1, -0.6, -0.75))))


def turned_stage(stage: Stage, body: Body, degrees: float) -> Stage:
    """The stage of a run with this body, whose sensor is turned by an angle."""
    def with_angle(states: np.ndarray) -> np.ndarray:
        return np.column_stack([states, np.full(len(states), math.radians(degrees))])
    return replace(stage, body=body, x=with_angle(stage.x), xhat=None if stage.xhat is None else with_angle(stage.xhat))
