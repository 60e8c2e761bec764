"""Write on the stage: names at the ends of lines to a plant's parts, the error to scale."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import viser

from ...colours import COLOURS, palette, rgb
from ...plants.bodies.body import Body, ErrorMarks, PartName, Pose, Vector, turned
from ...text import label_in_language
from ..viser_private.stage_frames import Frame, flatten_segments, letters_of
from .scene_labels import SceneLabels
from .trails import HIDDEN_SEGMENT, Pair

ERROR_BARS, BAR_THICK = "/error-bars", 0.055  # the node of the bars, and how thick they are in stage units
WORDS_SIZE = 1.3  # of the letters of its words, beside those of a name
LINES, HALO = "/named/lines", "/named/halo"
THIN, ROUND_IT, BEHIND = 0.011, 0.026, 0.012  # stage units: a line, the light around it before a dark part, how far behind it that is
AWAY: Vector = (0.0, BEHIND, 0.0)
APART, BELOW = 0.05, (0.0, 0.0, -9.0)  # stage units between a part and its ghost from which on the ghost has a name; out of sight


class PartNames:
    """The names that are on the stage, none at first; a name goes with its part."""

    def __init__(self, scene: viser.SceneApi, letters: SceneLabels) -> None:
        self._scene, self._letters = scene, letters
        self._shown: tuple[PartName, ...] = ()
        self._labels: list[viser.LabelHandle] = []
        self._lines: list[viser.LineSegmentsHandle] = []

    def show(self, body: Body | None, ghostly: bool, language: str, dark: bool) -> bool:
        """The names of a body, of its ghost's parts only where there is a ghost, none for None. Whether any came or went."""
        wanted = () if body is None else tuple(name for name in body.names if ghostly or not name.ghost)
        if wanted == self._shown:
            return False
        self.clear()
        self._shown = wanted
        self._labels = [self._letters.write(f"/named/{i}", label_in_language(name.words, language), (0.0, 0.0, 0.0), _anchor(name.away))
                        for i, name in enumerate(wanted)]
        colours = palette(dark)
        self._lines = [self._scene.add_line_segments(path, np.array([HIDDEN_SEGMENT], np.float32), rgb(colours[role]), thickness=thick)
                       for path, role, thick in ((LINES, "glass-leader", THIN), (HALO, "glass", ROUND_IT))]
        return True

    def place(self, poses: Mapping[str, Pose], ghost: Mapping[str, Pose], frame: Frame) -> None:
        """Write into a frame where the names and their lines are, with the plant and its ghost in these poses."""
        pairs: list[Pair] = []
        for name, label in zip(self._shown, self._labels, strict=True):
            there = _end_of_line(name, ghost if name.ghost else poses)
            if name.ghost and name.part in poses and math.dist(there, _end_of_line(name, poses)) < APART:
                there = BELOW  # it lies in the plant
            at = _moved(there, name.away)
            frame[label.name, "position"] = at
            pairs.append((there, at))
        if self._lines:
            frame[LINES, "points"] = flatten_segments([*pairs, HIDDEN_SEGMENT])
            frame[HALO, "points"] = flatten_segments([*((_moved(a, AWAY), _moved(b, AWAY)) for a, b in pairs), HIDDEN_SEGMENT])

    def clear(self) -> None:
        """Take all of them off the stage."""
        for label in self._labels:
            self._letters.remove(label)
        for line in self._lines:
            line.remove()
        self._shown, self._labels, self._lines = (), [], []


class ErrorMarkLines:
    """The bars and words of an error that is drawn to scale."""

    def __init__(self, scene: viser.SceneApi, letters: SceneLabels, first: ErrorMarks, language: str) -> None:
        self._letters, self._language = letters, language
        self._bars = scene.add_line_segments(ERROR_BARS, np.array([HIDDEN_SEGMENT], np.float32), rgb(COLOURS["error"]), thickness=BAR_THICK)
        self._labels = [letters.write(f"/error-words/{i}", label_in_language(words, language), at, anchor, WORDS_SIZE)
                        for i, (words, at, anchor) in enumerate(first.words)]

    def place(self, marks: ErrorMarks, frame: Frame) -> None:
        """Write into a frame where they are."""
        frame[ERROR_BARS, "points"] = flatten_segments([*marks.bars, HIDDEN_SEGMENT])
        for label, (words, at, _) in zip(self._labels, marks.words, strict=True):
            frame[label.name, "position"], frame[label.name, "text"] = at, letters_of(label_in_language(words, self._language))

    def remove(self) -> None:
        """Take them off the stage."""
        self._bars.remove()
        for label in self._labels:
            self._letters.remove(label)


def _end_of_line(name: PartName, poses: Mapping[str, Pose]) -> Vector:
    pose = poses[name.part]
    return _moved(pose.position, turned(name.at, pose.wxyz))


def _moved(place: Sequence[float], by: Vector) -> Vector:
    return (place[0] + by[0], place[1] + by[1], place[2] + by[2])


def _anchor(away: Vector) -> str:
    """The side of the words at which the line ends."""
    across, _, up = away
    if abs(across) > abs(up):
        return "center-left" if across > 0 else "center-right"
    return "bottom-center" if up > 0 else "top-center"
