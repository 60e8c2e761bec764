"""Draw trails that fade with age: a ghost's path and the way a pole was dragged."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
import viser

from ...colours import COLOURS, palette, rgb
from ...course.lesson import Stage
from ...plants.bodies.body import Vector
from ..viser_private.stage_frames import Frame, flatten_segments

ERROR_NODE = "/errors"
THIN, MIN_ERROR_LINE_LENGTH = 0.042, 0.015  # stage units: width of a line of the error, and the length below which it is not drawn
SEGMENTS = 12  # of one trail
TRAIL_RUN_SHARE = 1 / 12  # of the run that a ghost's trail reaches back
MAX_TRAILS = 3  # anchors of a body that draw a trail
FRONT = 0.1  # stage units: the anchors that lie this near the foremost one draw it
PALEST = 0.3  # of a trail's colour that its oldest piece has, the rest is that of the ground
TRAIL_WIDTH = 0.03  # stage units
TRAIL_STEP = 0.06  # stage units between two points of a pole's way
Pair = tuple[Vector, Vector]
Colour = tuple[int, int, int]
DARK_WHITE_SHARE = 0.35  # of white in a ghost's trail in the dark
HIDDEN_SEGMENT: Pair = ((0.0, 0.0, -9.0), (0.0, 0.0, -9.0))  # of a line that is not seen


def faded(colour: Colour, ground: Colour) -> np.ndarray:
    """The colours (SEGMENTS, 2, 3) of a trail's pieces, the youngest first: from a colour to nearly that of the ground."""
    share = np.linspace(1.0, PALEST, SEGMENTS + 1)[:, None]
    ends = np.round(share * np.array(colour) + (1 - share) * np.array(ground)).astype(np.uint8)
    return np.stack([ends[:-1], ends[1:]], axis=1)


def ghostly(dark: bool, role: str = "estimate") -> np.ndarray:
    """The colours of the trail of a ghost with the colour of a role, by day or in the dark."""
    red, green, blue = rgb(COLOURS[role])
    ground = rgb(palette(dark)["horizon"])
    return faded((_lit(red), _lit(green), _lit(blue)) if dark else (red, green, blue), ground)


def _lit(part: int) -> int:
    return round(part + DARK_WHITE_SHARE * (255 - part))


def filled(pairs: Sequence[Pair], count: int) -> list[Pair]:
    """Exactly so many lines: those that are missing lie where nobody sees them, since colours belong to places in the list."""
    return [*pairs[:count], *[HIDDEN_SEGMENT] * (count - len(pairs))]


class GhostTrail:
    """The ways of the foremost anchors of a ghost along one run, point for point when they are first asked for."""

    def __init__(self, stage: Stage) -> None:
        self._stage, self._known = stage, dict[int, tuple[Vector, ...]]()
        self._every = max(1, round(TRAIL_RUN_SHARE * len(stage.t) / SEGMENTS))  # samples from one point to the next
        first = self._anchors(0)
        near = min((y for _, y, _ in first), default=0.0) + FRONT
        self._drawn = [k for k, (_, y, _) in enumerate(first) if y <= near][:MAX_TRAILS]

    @property
    def count(self) -> int:
        """How many trails there are."""
        return len(self._drawn)

    def _anchors(self, sample: int) -> tuple[Vector, ...]:
        stage = self._stage
        assert stage.xhat is not None
        return stage.body.anchors(stage.xhat[sample].tolist(), stage.body.gain)

    def _point(self, sample: int) -> tuple[Vector, ...]:
        if sample not in self._known:
            self._known[sample] = self._anchors(sample)
        return self._known[sample]

    def lines(self, sample: int, now: Sequence[Vector]) -> list[Pair]:
        """SEGMENTS lines for each trail, from where its anchor is `now`, at a sample, back along its way."""
        last = (sample - 1) // self._every  # of the points that have been passed
        passed = [self._point(k * self._every) for k in range(last, max(last - SEGMENTS, -1), -1)]
        return [pair for k in self._drawn for pair in filled(list(pairwise([now[k], *(point[k] for point in passed)])), SEGMENTS)]


class ErrorLines:
    """The lines from a plant to its ghost and, in the same node so that they cost nothing more to draw, the ghost's trails.

    With trails every line has its place in the node, since it has its colour there.
    """

    def __init__(self, scene: viser.SceneApi, stage: Stage, trails: bool, dark: bool) -> None:
        self._trail = GhostTrail(stage) if trails and stage.xhat is not None else None
        self._room = len(stage.body.anchors(stage.x[0].tolist(), stage.body.gain))
        colours: Colour | np.ndarray = rgb(COLOURS["error"])
        count = 1
        if self._trail is not None:
            fading = ghostly(dark, stage.body.ghost)
            colours = np.concatenate([np.full((self._room, 2, 3), colours, np.uint8), *[fading] * self._trail.count])
            count = len(colours)
        scene.add_line_segments(ERROR_NODE, np.array([HIDDEN_SEGMENT] * count, np.float32), colours, thickness=THIN)

    def take(self, stage: Stage) -> None:
        """Another run of the same body."""
        if self._trail is not None:
            self._trail = GhostTrail(stage)

    def place(self, sample: int, true: Sequence[Vector], believed: Sequence[Vector], calm: bool, frame: Frame) -> None:
        """Write into a frame where the lines are at a sample; no trails where nothing is to move by itself."""
        pairs = [pair for pair in zip(true, believed, strict=True) if math.dist(*pair) > MIN_ERROR_LINE_LENGTH]
        if self._trail is None:
            frame[ERROR_NODE, "points"] = flatten_segments([*pairs, HIDDEN_SEGMENT])
            return
        trails = [] if calm else self._trail.lines(sample, believed)
        frame[ERROR_NODE, "points"] = flatten_segments([*filled(pairs, self._room), *filled(trails, SEGMENTS * self._trail.count)])


class PoleTrail:
    """The way by which a hand has dragged a pole, and its mirror image, on a board; one node of the scene while there is one.

    The server's loop writes down the way, the tab's thread draws it.
    """

    def __init__(self, scene: viser.SceneApi, name: str, colour: Colour, ground: Colour, local: Callable[[complex, float], Vector]) -> None:
        self._scene, self._name, self._local = scene, name, local
        self._colours = np.concatenate([faded(colour, ground)] * 2)
        self._way: tuple[complex, ...] = ()
        self._drawn: tuple[complex, ...] = ()
        self._node: viser.LineSegmentsHandle | None = None

    def begin(self, pole: complex) -> None:
        """A hand takes hold of a pole."""
        self._way = (pole,)

    def reach(self, pole: complex) -> None:
        """The hand has come to a place."""
        way = self._way
        if len(way) > 1 and math.dist(self._local(way[-2], 0.0), self._local(pole, 0.0)) < TRAIL_STEP:
            way = way[:-1]
        self._way = (*way, pole)[-SEGMENTS - 1:]

    def end(self) -> None:
        """The knobs rest and no hand holds a pole: nothing is left to be seen."""
        self._way = ()

    def draw(self) -> None:
        """Show what has come since the last time."""
        way = self._way
        if way == self._drawn:
            return
        self._drawn = way
        lines = []
        for mirrored in (False, True):
            points = [self._local(pole.conjugate() if mirrored else pole, 0.015) for pole in reversed(way)]
            lines += filled(list(pairwise(points)), SEGMENTS)
        points = np.array(lines, dtype=np.float32)
        if self._node is None:
            self._node = self._scene.add_line_segments(self._name, points, self._colours, thickness=TRAIL_WIDTH)
        else:
            self._node.points = points
        if self._node.visible != (len(way) > 1):
            self._node.visible = len(way) > 1
