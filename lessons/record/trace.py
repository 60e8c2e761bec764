"""Show a record as a trace on a panel behind its tubes, with a bar where the run is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from observer_lab.colours import COLOURS, rgb
from observer_lab.course.figures.scene import PICTURE_DEPTH, PICTURE_FOOT, PICTURE_HEIGHT, PICTURE_WIDTH, StagePicture
from observer_lab.course.lesson import Stage
from observer_lab.plants.bodies.body import Body, Box, Part, Pose

COLUMNS, ROWS = 880, 400  # pixels of the panel
HALF = 3  # pixels to either side of the trace
FREE = 0.08  # of the panel's height, above and below
BAR, BEFORE = 0.035, 0.04  # stage units: how wide the bar is, and how far it stands before the panel
PALER = 0.45  # how far the output's blue goes toward white, so that it is seen on the dark panel


def _paint(image: np.ndarray, y: np.ndarray, low: float, high: float, colour: np.ndarray) -> None:
    """Draw a trace: in each column from the least to the largest of its samples and of the one before."""
    edges = np.linspace(0, len(y) - 1, COLUMNS + 1)
    for column in range(COLUMNS):
        part = np.interp(np.linspace(edges[column], edges[column + 1], 8), np.arange(len(y)), y)
        part = np.concatenate([part, y[int(np.ceil(edges[column])):int(edges[column + 1]) + 1]])
        rows = ((high - part) / (high - low) * (1 - 2 * FREE) + FREE) * ROWS
        image[max(int(rows.min()) - HALF, 0) : int(rows.max()) + HALF + 1, column] = colour


def panel(y: np.ndarray) -> StagePicture:
    """An output (n,) over the run, from the left edge to the right one; it is the same whatever estimates it."""
    image = np.empty((ROWS, COLUMNS, 3), np.uint8)
    image[:] = rgb(COLOURS["dark"])
    low, high = float(y.min()), float(y.max())
    high = high if high > low else low + 1.0
    pale = np.array(rgb(COLOURS["plant"])) * (1 - PALER) + 255 * PALER
    _paint(image, y, low, high, pale.astype(np.uint8))
    return StagePicture(image)


def with_trace(stage: Stage) -> Stage:
    """The stage of a record with the trace of its first output behind it; a bar goes along with the run."""
    body, count = stage.body, stage.x.shape[1]
    assert stage.xhat is not None
    share = (stage.t - stage.t[0]) / (stage.t[-1] - stage.t[0])

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        across = PICTURE_WIDTH * (float(x[count]) - 0.5)
        return {**body.pose(x, gain), "now": Pose((across, PICTURE_DEPTH - BEFORE, PICTURE_FOOT + PICTURE_HEIGHT / 2))}

    bar = Part("now", Box((BAR, BAR, PICTURE_HEIGHT)), COLOURS["lit"])
    traced: Body = replace(body, parts=(*body.parts, bar), pose=pose)
    x, xhat = (np.column_stack([values, share]) for values in (stage.x, stage.xhat))
    return replace(stage, body=traced, x=x, xhat=xhat, picture=panel(stage.x[:, 0]))
