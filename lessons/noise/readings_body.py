"""Show the last readings of the noisy sensor above the block, in a band of one sigma."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from observer_lab.colours import COLOURS
from observer_lab.course.figures.scene import last_readings
from observer_lab.course.lesson import Stage
from observer_lab.plants.bodies.body import Ball, Body, Box, Part, PartName, Pose, bound_displacement
from observer_lab.plants.spring_damper import BLOCK_EDGE, MAX_DRAWN_DISPLACEMENT, RAIL_TOP, REST_POSITION, STAGE_SCALE
from observer_lab.text import text

READINGS = 12  # that stand above the block, the latest lowest
LOWEST, STEP, FRONT = RAIL_TOP + BLOCK_EDGE + 0.08, 0.042, -0.1  # z of the latest reading, from one to the next, y of all
BAND_HIGH = READINGS * STEP
ASIDE = (0.85, -0.4, 0.3)  # from the block to its name: above it are the readings
LEAST_HALF = 0.01  # stage units: a band is no narrower
READING_PARTS = (
    *(Part(f"reading {k}", Ball(0.034), COLOURS["second"]) for k in range(READINGS)),
    Part("noise band", Box((2.0, 0.02, BAND_HIGH)), COLOURS["second"], opacity=0.22),
    Part("true position", Box((0.014, 0.03, BAND_HIGH)), COLOURS["plant"]),
)


def with_readings(body: Body) -> Body:
    """The block under its readings. After the two states a record holds σ of one reading in m, then the last readings in m."""
    def across(metres: float, gain: float) -> float:
        return REST_POSITION + bound_displacement(metres * STAGE_SCALE * gain, MAX_DRAWN_DISPLACEMENT)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        true, sigma = float(x[0]), float(x[2])
        ends = across(true - sigma, gain), across(true + sigma, gain)
        middle = LOWEST - STEP / 2 + BAND_HIGH / 2
        poses = {f"reading {k}": Pose((across(float(y), gain), FRONT, LOWEST + k * STEP)) for k, y in enumerate(x[3:])}
        half = max((ends[1] - ends[0]) / 2, LEAST_HALF)
        return {**body.pose(x, gain), **poses, "true position": Pose((across(true, gain), FRONT + 0.03, middle)),
                "noise band": Pose(((ends[0] + ends[1]) / 2, FRONT + 0.06, middle), scale=(half, 1.0, 1.0))}
    names = tuple(replace(name, away=name.away if name.ghost else ASIDE) for name in body.names if name.part != "spring")
    return replace(body, parts=(*body.parts, *READING_PARTS), pose=pose,
                   names=(*names, PartName(text("the last 12 readings"), f"reading {READINGS - 1}", (0.75, -0.2, 0.35))))


def stage_with_readings(stage: Stage, y: np.ndarray, sigma: float) -> Stage:
    """The stage of a run with the readings y (n_t,) of the sensor; before the first one there is none."""
    def with_them(states: np.ndarray) -> np.ndarray:
        return np.column_stack([states, np.full(len(states), sigma), last_readings(y, READINGS)])
    return replace(stage, x=with_them(stage.x), xhat=None if stage.xhat is None else with_them(stage.xhat), readings=READINGS)
