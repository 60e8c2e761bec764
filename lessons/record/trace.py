"""Show a whole record as a trace on a panel above its tubes, and mark readings on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from observer_lab.colours import COLOURS, rgb
from observer_lab.course.figures.scene import PICTURE_DEPTH, PICTURE_HEIGHT, StagePicture
from observer_lab.course.lesson import Stage
from observer_lab.plants.bodies.body import GHOST_NAME, PLANT_COLOUR, Arrow, Ball, Body, Box, Part, PartName, Pose, Vector
from observer_lab.text import text

COLUMNS, ROWS = 1040, 400  # pixels of the panel
PANEL_WIDTH, PANEL_FOOT = 5.2, 1.36  # stage units: of the panel, above the tubes as they are seen
HALF, FINE = 3, 8  # pixels to either side of the trace; places in a column at which it is read
FREE = 0.08  # of the panel's height, above and below
BAR, BEFORE, PIN = 0.035, 0.04, 0.085  # stage units: how wide the bar is, how far it stands before the panel, how large a pin is
NEARER = 1.3  # stage units that the tubes stand nearer to the eye than alone
TITLE, NOTE = 0.22, -0.08  # stage units above the panel: the upper edge of the names of its parts; above its foot: of what is marked
READINGS = "floor"  # the role of the colour of readings
PALER, FITTED = 0.45, 0.3  # how far the output's blue, and the ground of the part of the fit, go toward white
FAULT, ASIDE, EXACT = "error", "paper", "lit"  # roles of the colours of marked readings
DOT, SMALL, RING = 6.5, 5.0, (9.0, 13.0)  # pixels: the radii of dots; the radii of a ring
STRIP = 9  # pixels: how high the strip is along the foot where readings have a bias


@dataclass(frozen=True, eq=False)
class Trace:
    """The first output of all rows (n,) and its readings; `first` is the row from which they judge.

    faulty, aside, exact: the rows of readings that jump, that the gate sets aside, and of a second sensor; `biased`: a row from which
    the readings have a bias.
    """

    y: np.ndarray
    readings: np.ndarray
    first: int
    faulty: np.ndarray
    aside: np.ndarray
    exact: np.ndarray
    biased: int | None = None

    @property
    def ends(self) -> tuple[float, float]:
        """The values at the lower and the upper edge, but for what is free there."""
        both = np.concatenate([self.y, self.readings])
        low, high = float(both.min()), float(both.max())
        return low, high if high > low else low + 1.0

    def share(self, row: float) -> float:
        """Where a row is, as a share of the panel's width."""
        return row / (len(self.y) - 1)


def _paler(role: str, share: float) -> np.ndarray:
    return (np.array(rgb(COLOURS[role])) * (1 - share) + 255 * share).astype(np.uint8)


def _row(y: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """On which row of pixels values stand."""
    low, high = ends
    return ((high - y) / (high - low) * (1 - 2 * FREE) + FREE) * ROWS


def _paint(image: np.ndarray, y: np.ndarray, ends: tuple[float, float], colour: np.ndarray) -> None:
    """Draw a trace: in each column from the least to the largest of its samples and of those at its edges."""
    places = (np.arange(COLUMNS)[:, None] + np.linspace(0, 1, FINE)) / COLUMNS * (len(y) - 1)
    samples = np.arange(len(y))
    rows = _row(np.interp(places, samples, y), ends)
    top, foot = rows.min(axis=1), rows.max(axis=1)
    column = np.minimum(samples * COLUMNS // max(len(y) - 1, 1), COLUMNS - 1)
    np.minimum.at(top, column, _row(y, ends))
    np.maximum.at(foot, column, _row(y, ends))
    high = np.arange(ROWS)[:, None]
    image[(high >= np.maximum(top.astype(int) - HALF, 0)) & (high <= foot.astype(int) + HALF)] = colour


def _dots(image: np.ndarray, trace: Trace, rows: np.ndarray, values: np.ndarray, radii: tuple[float, float], role: str) -> None:
    """Mark readings by discs or rings."""
    edge = int(radii[1])
    around = np.arange(-edge, edge + 1)
    away = np.hypot(around[:, None], around)
    down, across = np.nonzero((away >= radii[0]) & (away <= radii[1]))
    for k in rows:
        y, x = int(_row(values[k], trace.ends)) + around[down], int(trace.share(k) * (COLUMNS - 1)) + around[across]
        seen = (y >= 0) & (y < ROWS) & (x >= 0) & (x < COLUMNS)
        image[y[seen], x[seen]] = rgb(COLOURS[role])


def panel(trace: Trace) -> StagePicture:
    """A record over the width of the panel: its output before its readings. The part used for the fit has a paler ground."""
    image = np.empty((ROWS, COLUMNS, 3), np.uint8)
    image[:] = rgb(COLOURS["dark"])
    image[:, : round(trace.share(trace.first) * COLUMNS)] = _paler("dark", FITTED)
    if trace.biased is not None:
        image[-STRIP:, round(trace.share(trace.biased) * COLUMNS):] = rgb(COLOURS[FAULT])
    _paint(image, trace.readings, trace.ends, np.array(rgb(COLOURS[READINGS]), np.uint8))
    _paint(image, trace.y, trace.ends, _paler("plant", PALER))
    _dots(image, trace, trace.faulty, trace.readings, (0.0, DOT), FAULT)
    _dots(image, trace, trace.aside, trace.readings, RING, ASIDE)
    _dots(image, trace, trace.exact, trace.y, (0.0, SMALL), EXACT)
    return StagePicture(image, PANEL_WIDTH, PANEL_FOOT)


def height(y: float, low: float, high: float) -> float:
    """How high above the floor a value stands on the panel of an output between these two; beyond them at the panel's edge."""
    share = FREE + (1 - 2 * FREE) * (y - low) / (high - low)
    return PANEL_FOOT + PICTURE_HEIGHT * min(max(share, 0.0), 1.0)


def _near(at: Vector) -> Vector:
    return at[0], at[1] - NEARER, at[2]


def with_trace(stage: Stage, trace: Trace) -> Stage:
    """The stage of a record with the trace of its first output above it.

    A bar goes along with the run, with a pin at the output on the trace and a ghost of it at the estimate.
    """
    body, count, (low, high) = stage.body, stage.x.shape[1], trace.ends
    assert stage.xhat is not None
    split = trace.share(trace.first)
    share = split + (1 - split) * (stage.t - stage.t[0]) / (stage.t[-1] - stage.t[0])

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        across = PANEL_WIDTH * (float(x[count]) - 0.5)
        return {**{name: replace(each, position=_near(each.position)) for name, each in body.pose(x, gain).items()},
                "now": Pose((across, PICTURE_DEPTH - BEFORE, PANEL_FOOT + PICTURE_HEIGHT / 2)),
                "pin": Pose((across, PICTURE_DEPTH - BEFORE - PIN, height(float(x[0]), low, high)))}

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return tuple(replace(each, tail=_near(each.tail), head=_near(each.head)) for each in body.arrows(x, u, gain))

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        return tuple(map(_near, body.anchors(x, gain)))

    marks = Part("now", Box((BAR, BAR, PICTURE_HEIGHT)), COLOURS["lit"]), Part("pin", Ball(PIN), PLANT_COLOUR, twin=True)
    titles = tuple((words, (PANEL_WIDTH * (middle - 0.5), PICTURE_DEPTH, PANEL_FOOT + PICTURE_HEIGHT + TITLE)) for words, middle in
                   ((text("used for the fit"), split / 2), (text("not used: judges the filter"), (1 + split) / 2)))
    marked = text("marked: jumps and bias") if len(trace.faulty) else text("dots: second sensor") if len(trace.exact) else None
    if marked is not None:
        titles = (*titles, (marked, (PANEL_WIDTH * ((1 + split) / 2 - 0.5), PICTURE_DEPTH, PANEL_FOOT + NOTE)))
    names = (PartName(text("output"), "collar 0", (0.45, -0.1, 0.25)), PartName(GHOST_NAME, "collar 0", (0.45, -0.1, -0.25), True))
    traced: Body = replace(body, parts=(*body.parts, *marks), pose=pose, arrows=arrows, anchors=anchors, names=names,
                           labels=(*((words, _near(at)) for words, at in body.labels), *titles))
    x, xhat = (np.column_stack([values, share]) for values in (stage.x, stage.xhat))
    return replace(stage, body=traced, x=x, xhat=xhat, picture=panel(trace))
