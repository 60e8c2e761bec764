"""Show a record as a trace on a panel behind its tubes, with a bar and pins where the run is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from observer_lab.colours import COLOURS, rgb
from observer_lab.course.figures.scene import PICTURE_DEPTH, PICTURE_FOOT, PICTURE_HEIGHT, PICTURE_WIDTH, StagePicture
from observer_lab.course.lesson import Stage
from observer_lab.plants.bodies.body import PLANT_COLOUR, Ball, Body, Box, Part, Pose

COLUMNS, ROWS = 880, 400  # pixels of the panel
HALF = 3  # pixels to either side of the trace
FREE = 0.08  # of the panel's height, above and below
BAR, BEFORE, PIN = 0.035, 0.04, 0.085  # stage units: how wide the bar is, how far it stands before the panel, how large a pin is
READINGS = "floor"  # the role of the colour of readings
PALER = 0.45  # how far the output's blue goes toward white, so that it is seen on the dark panel


def _paint(image: np.ndarray, y: np.ndarray, low: float, high: float, colour: np.ndarray) -> None:
    """Draw a trace: in each column from the least to the largest of its samples and of the one before."""
    edges = np.linspace(0, len(y) - 1, COLUMNS + 1)
    for column in range(COLUMNS):
        part = np.interp(np.linspace(edges[column], edges[column + 1], 8), np.arange(len(y)), y)
        part = np.concatenate([part, y[int(np.ceil(edges[column])):int(edges[column + 1]) + 1]])
        rows = ((high - part) / (high - low) * (1 - 2 * FREE) + FREE) * ROWS
        image[max(int(rows.min()) - HALF, 0) : int(rows.max()) + HALF + 1, column] = colour


def panel(y: np.ndarray, readings: np.ndarray, ends: tuple[float, float]) -> StagePicture:
    """An output (n,) over the run, from the left edge to the right one, before its readings; it is the same whatever estimates it.

    `ends` are the values at the lower and the upper edge, but for what is free there.
    """
    image = np.empty((ROWS, COLUMNS, 3), np.uint8)
    image[:] = rgb(COLOURS["dark"])
    low, high = ends
    pale = np.array(rgb(COLOURS["plant"])) * (1 - PALER) + 255 * PALER
    _paint(image, readings, low, high, np.array(rgb(COLOURS[READINGS]), np.uint8))
    _paint(image, y, low, high, pale.astype(np.uint8))
    return StagePicture(image)


def height(y: float, low: float, high: float) -> float:
    """How high above the floor a value stands on the panel of an output between these two; beyond them at the panel's edge."""
    share = FREE + (1 - 2 * FREE) * (y - low) / (high - low)
    return PICTURE_FOOT + PICTURE_HEIGHT * min(max(share, 0.0), 1.0)


def with_trace(stage: Stage, readings: np.ndarray) -> Stage:
    """The stage of a record with the trace of its first output behind it, before that of the readings (n_t,).

    A bar goes along with the run, with a pin at the output on the trace and a ghost of it at the estimate.
    """
    body, count = stage.body, stage.x.shape[1]
    both = np.concatenate([stage.x[:, 0], readings])
    low, high = float(both.min()), float(both.max())
    high = high if high > low else low + 1.0
    assert stage.xhat is not None
    share = (stage.t - stage.t[0]) / (stage.t[-1] - stage.t[0])

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        across = PICTURE_WIDTH * (float(x[count]) - 0.5)
        return {**body.pose(x, gain), "now": Pose((across, PICTURE_DEPTH - BEFORE, PICTURE_FOOT + PICTURE_HEIGHT / 2)),
                "pin": Pose((across, PICTURE_DEPTH - BEFORE - PIN, height(float(x[0]), low, high)))}

    marks = Part("now", Box((BAR, BAR, PICTURE_HEIGHT)), COLOURS["lit"]), Part("pin", Ball(PIN), PLANT_COLOUR, twin=True)
    traced: Body = replace(body, parts=(*body.parts, *marks), pose=pose)
    x, xhat = (np.column_stack([values, share]) for values in (stage.x, stage.xhat))
    return replace(stage, body=traced, x=x, xhat=xhat, picture=panel(stage.x[:, 0], readings, (low, high)))
