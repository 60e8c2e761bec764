"""Show a whole record as a trace on a panel, with a tube that goes along it, and mark readings on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from observer_lab.colours import COLOURS, rgb
from observer_lab.course.figures.scene import StagePicture
from observer_lab.plants.bodies.body import (
    BENCH,
    DARK_GREY,
    GHOST_NAME,
    METAL,
    PLANT_COLOUR,
    STEEL,
    Arrow,
    Body,
    Box,
    Cylinder,
    Part,
    PartName,
    Pose,
    Vector,
    force_arrow,
)
from observer_lab.plants.bodies.own_body import GLASS_COLOUR, MOST_ARROWS
from observer_lab.text import Text, text

from .below import COLUMNS, FREE, NOTHING_BELOW, ROWS, Below, band_colour, paint, paint_below, row_of, ruled

PANEL_WIDTH, PANEL_HIGH, PANEL_FOOT = 5.2, 2.5, 0.3  # stage units: of the panel, a little above the floor
PANEL_DEEP, FRAME = 0.78, 0.07  # stage units: how far behind the middle of the stage it stands; of its frame
ABOVE_TUBES = 1.36  # stage units: its foot where more tubes stand before it
BEFORE, GLASS, COLLAR, THICK = 0.36, 0.12, 0.22, 0.1  # stage units: of the tube before the panel: its distance, radii and collar
BASE, RAIL, BAR, NOW = (0.7, 0.4, 0.14), 0.06, 0.035, 0.02  # stage units: of the tube's base, of the rail, of lines
NEARER = 1.3  # stage units that further tubes stand nearer to the eye than alone
POST, COLUMN, LEAST_COLUMN = 0.025, 0.3, 0.01  # stage units: radius of what the tube stands on; side and least height of a column
BENCH_Y, BENCH_DEEP, BENCH_HIGH, BENCH_TOP = -0.1, 0.42, 0.12, -0.18  # stage units: of the bench of columns; top above the panel's foot
NAMED, LIES = 0.75, 0.06  # where the name of what is below stands: share of its height; stage units from the panel to it
TITLE, NOTES, LOWER, LOWEST = 0.3, (-0.3, -0.16), (-0.86, -0.3), (-1.15, -0.3)  # names above the panel; rows: y, z from its foot
READINGS, OUTPUT = "grey", "plant"  # the roles of the colours of readings and of the output
WIDTHS = 2.0  # standard deviations of the band of expected readings
FAULT, ASIDE, EXACT = "error", "reference", "dark"  # roles of the colours of marked readings
DOT, SMALL, RING = 6.5, 5.0, (9.0, 13.0)  # pixels: the radii of dots; the radii of a ring
STRIP = 9  # pixels: how high the strip is along the foot where readings have a bias


@dataclass(frozen=True, eq=False)
class Trace:
    """The first output of all rows (n,) and its readings; `first` is the row from which they judge.

    predicted, spread: what the filter expects of each reading (n,) and its standard deviation √S (n,). faulty, aside, exact: the rows of
    readings that jump, that the gate sets aside, and of a second sensor; `biased`: a row from which the readings have a bias.
    """

    y: np.ndarray
    readings: np.ndarray
    first: int
    predicted: np.ndarray
    spread: np.ndarray
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


def _dots(image: np.ndarray, trace: Trace, rows: np.ndarray, values: np.ndarray, radii: tuple[float, float], role: str) -> None:
    """Mark readings by discs or rings."""
    edge = int(radii[1])
    around = np.arange(-edge, edge + 1)
    away = np.hypot(around[:, None], around)
    down, across = np.nonzero((away >= radii[0]) & (away <= radii[1]))
    for k in rows:
        y, x = int(row_of(image, values[k], trace.ends)) + around[down], int(trace.share(k) * (COLUMNS - 1)) + around[across]
        seen = (y >= 0) & (y < len(image)) & (x >= 0) & (x < COLUMNS)
        image[y[seen], x[seen]] = rgb(COLOURS[role])


def panel_foot(count: int) -> float:
    """How high above the floor the panel begins, with this many outputs."""
    return PANEL_FOOT if count == 1 else ABOVE_TUBES


def panel(trace: Trace, foot: float, below: Below = NOTHING_BELOW) -> StagePicture:
    """A record over the width of the panel: its output before its readings, before what the filter expects of them.

    The part used for the fit has a greyer ground and no band. What is shown `below` takes the lower part of the panel.
    """
    split, away = trace.share(trace.first), WIDTHS * trace.spread
    whole = ruled(split)
    line = round((1 - below.share) * ROWS)
    image = whole[:line]
    paint_below(whole[line:], below, trace.first, split)
    paint(image, trace.ends, trace.predicted - away, trace.predicted + away, split, band_colour())
    if trace.biased is not None:
        image[-STRIP:, round(trace.share(trace.biased) * COLUMNS):] = rgb(COLOURS[FAULT])
    paint(image, trace.ends, trace.readings, trace.readings, 0.0, np.array(rgb(COLOURS[READINGS]), np.uint8))
    paint(image, trace.ends, trace.y, trace.y, 0.0, np.array(rgb(COLOURS[OUTPUT]), np.uint8))
    _dots(image, trace, trace.faulty, trace.readings, (0.0, DOT), FAULT)
    _dots(image, trace, trace.aside, trace.readings, RING, ASIDE)
    _dots(image, trace, trace.exact, trace.y, (0.0, SMALL), EXACT)
    return StagePicture(whole, PANEL_WIDTH, foot, PANEL_HIGH, PANEL_DEEP)


def height(y: float, low: float, high: float) -> float:
    """How high above the panel's foot a value stands on the panel of an output between these two; beyond them at the panel's edge."""
    share = FREE + (1 - 2 * FREE) * (y - low) / (high - low)
    return PANEL_HIGH * min(max(share, 0.0), 1.0)


def _near(at: Vector) -> Vector:
    return at[0], at[1] - NEARER, at[2]


def _columns(below: Below, foot: float) -> tuple[tuple[Part, ...], dict[str, Pose], list[tuple[Text | str, Vector]]]:
    """A numbered column for each singular value on a bench, a bar at the edge. Those of the model's states have the colour of estimates."""
    if not below.columns:
        return (), {}, []
    unit, pitch, low = PANEL_HIGH * below.share / below.ends[1], PANEL_WIDTH / len(below.columns), foot + BENCH_TOP
    parts, poses, front = [Part("bench", Box((PANEL_WIDTH, BENCH_DEEP, BENCH_HIGH)), BENCH)], dict[str, Pose](), BENCH_Y - BENCH_DEEP / 2
    poses["bench"] = Pose((0.0, BENCH_Y, low - BENCH_HIGH / 2))
    numbers: list[tuple[Text | str, Vector]] = []
    for k, value in enumerate(below.columns):
        high, across = max(unit * value, LEAST_COLUMN), pitch * (k + 0.5) - PANEL_WIDTH / 2
        parts.append(Part(f"column {k}", Box((COLUMN, COLUMN, high)), COLOURS["estimate" if k < below.used else "muted"]))
        poses[f"column {k}"] = Pose((across, BENCH_Y, low + high / 2))
        numbers.append((str(k + 1), (across, front - 0.03, low - 0.02)))
    before, high = BENCH_Y - 0.6 * COLUMN, max(unit * below.edge, LEAST_COLUMN)
    parts.append(Part("edge", Box((PANEL_WIDTH, BAR, BAR)), COLOURS["dark"]))
    poses["edge"] = Pose((0.0, before, low + unit * below.edge))
    for side, sign in (("left", -1), ("right", 1)):
        parts.append(Part(f"edge {side}", Box((BAR, BAR, high)), COLOURS["dark"]))
        poses[f"edge {side}"] = Pose((sign * (PANEL_WIDTH - BAR) / 2, before, low + high / 2))
    return tuple(parts), poses, numbers


def _frame(foot: float) -> tuple[tuple[Part, ...], dict[str, Pose]]:
    """Bars around the panel; those at its sides stand on the floor."""
    high, side = foot + PANEL_HIGH + FRAME, (PANEL_WIDTH + FRAME) / 2
    upright, across = Box((FRAME, FRAME, high)), Box((PANEL_WIDTH, FRAME, FRAME))
    places = {"frame left": (-side, PANEL_DEEP, high / 2), "frame right": (side, PANEL_DEEP, high / 2),
              "frame top": (0.0, PANEL_DEEP, high - FRAME / 2), "frame foot": (0.0, PANEL_DEEP, foot - FRAME / 2)}
    parts = tuple(Part(name, upright if at[0] else across, METAL) for name, at in places.items())
    return parts, {name: Pose(at) for name, at in places.items()}


def body_with_trace(trace: Trace, count: int, strongest: Sequence[float], others: Body | None, below: Below = NOTHING_BELOW) -> Body:
    """The trace of a record's first output on a panel, and a tube that goes along it with the run.

    A state of the body is the `count` outputs and the share of the panel's width. The tube's collar is as high as the output on the
    trace, its ghost as the estimate. The tubes of `others`, which are further outputs, stand on the floor before it.
    `strongest`: per input the value whose arrow is longest.
    """
    low, high = trace.ends
    foot, deep = panel_foot(count), PANEL_DEEP - BEFORE
    split, part = trace.share(trace.first), 1 - below.share
    line, tall = foot + PANEL_HIGH * below.share, PANEL_HIGH * part  # where the record begins, and how high it is
    columns, standing, numbers = _columns(below, foot)
    frame, around = _frame(foot)

    def up(y: float) -> float:
        return line + part * height(y, low, high)

    def across(x: Sequence[float]) -> float:
        return PANEL_WIDTH * (float(x[count]) - 0.5)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        at = across(x)
        rest = {} if others is None else others.pose(x[1:], gain)
        return {**{name: replace(each, position=_near(each.position)) for name, each in rest.items()}, **standing, **around,
                "rail": Pose((0.0, deep, foot - BASE[2])), "base": Pose((at, deep, foot - BASE[2] / 2)),
                "glass": Pose((at, deep, line + tall / 2)),
                "now": Pose((at, PANEL_DEEP - BAR, foot + PANEL_HIGH / 2)),
                **({"post": Pose((at, deep, (foot + line) / 2))} if below.share else {}),
                "cap": Pose((at, deep, foot + PANEL_HIGH)),
                "reading": Pose((at, deep, up(float(x[0]))))}

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        return tuple(force_arrow((across(x) - 1.6 * COLLAR - 0.25 * j, deep, line + tall / 2), (0.0, 0.0, 1.0), float(u[j]), most)
                     for j, most in enumerate(strongest[:MOST_ARROWS]))

    def anchors(x: Sequence[float], gain: float) -> tuple[Vector, ...]:
        rest = () if others is None else tuple(map(_near, others.anchors(x[1:], gain)))
        return ((across(x), deep - COLLAR, up(float(x[0]))), *rest)

    parts = (Part("rail", Box((PANEL_WIDTH, RAIL, RAIL)), STEEL), Part("base", Box(BASE), DARK_GREY),
             Part("now", Box((NOW, NOW, PANEL_HIGH)), COLOURS["dark"]), Part("cap", Cylinder(1.1 * GLASS, 0.06), METAL),
             Part("glass", Cylinder(GLASS, tall), GLASS_COLOUR, opacity=0.12),
             Part("reading", Cylinder(COLLAR, THICK), PLANT_COLOUR, twin=True), *frame, *columns)
    if below.share:
        parts = (*parts, Part("post", Cylinder(POST, PANEL_HIGH * below.share), METAL))
    top = foot + PANEL_HIGH + TITLE
    row, lower, lowest = ((y, foot + up_by) for y, up_by in (NOTES, LOWER, LOWEST))
    labels = [*((words, (PANEL_WIDTH * (middle - 0.5), PANEL_DEEP, top)) for words, middle in
                ((text("used for the fit"), split / 2), (text("not used: judges the filter"), (1 + split) / 2))), *numbers,
              (text("band: readings expected, ±2σ"), (PANEL_WIDTH * split / 2, *(lower if below.columns else row)))]
    if below.columns:
        labels.append((below.name, (PANEL_WIDTH * (split / 2 - 0.5), *lower)))
    elif below.share:
        labels.append((below.name, (PANEL_WIDTH * (split / 2 - 0.5), PANEL_DEEP - LIES, foot + PANEL_HIGH * below.share * NAMED)))
    marked = text("marked: jumps and bias") if len(trace.faulty) else text("dots: second sensor") if len(trace.exact) else None
    if marked is not None:
        labels.append((marked, (PANEL_WIDTH * (split / 2 - 0.5), *(lowest if below.columns else row))))
    names = (PartName(text("output"), "reading", (-0.75, -0.1, 0.5)), PartName(GHOST_NAME, "reading", (-0.75, -0.1, -0.5), True))
    if others is not None:
        parts, labels = (*others.parts, *parts), [*((words, _near(at)) for words, at in others.labels), *labels]
    note = text("The tube goes along the record; green arrows: inputs.")
    return Body(parts, pose, arrows, anchors, 1.0, note, tuple(labels), names=names)
