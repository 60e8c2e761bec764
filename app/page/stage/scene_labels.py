"""Write the labels of one part of the scene, all in one size that follows the window."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import viser

from ...colours import palette
from ...plants.bodies.body import Vector
from ..charts.text_layout import Box, text_width
from ..viser_private import viser_internals

Size = float | Callable[[float], float]
ROW_HEIGHT_EM, NAME_GAP_EM = 1.3, 0.3  # letters: from one row of names to the next, and between two names of a row
INVISIBLE_CHANGE = 0.03  # of the size of letters: a change that nobody sees


def colour_labels(client: viser.ClientHandle, dark: bool) -> None:
    """Write all labels of the scene in the theme's ink on the theme's ground."""
    colours = palette(dark)
    viser_internals.run_script(client, "labels", ink=colours["label"], ground=colours["page"])


class SceneLabels:
    """Labels in the scene; `em` is the size of their letters in stage units, each label has its own multiple of it.

    The multiple may depend on `em`, where words have to fit into a room.
    """

    def __init__(self, scene: viser.SceneApi, em: float) -> None:
        self.scene, self.em = scene, em
        self._written: dict[str, tuple[viser.LabelHandle, Size]] = {}

    def write(self, name: str, words: str, at: tuple[float, float, float], anchor: Any, size: Size = 1.0,
              **look: Any) -> viser.LabelHandle:
        """A label of the scene, in place of one of that name."""
        label = self.scene.add_label(name, words, position=at, anchor=anchor, font_size_mode="scene",
                                      font_scene_height=_height(size, self.em), **look)
        self._written[name] = label, size
        return label

    def remove(self, label: viser.LabelHandle) -> None:
        """Take a label away."""
        self._written.pop(label.name, None)
        label.remove()

    def misfit(self, em: float) -> bool:
        """Whether letters of that size would be seen to be others."""
        return abs(em - self.em) > INVISIBLE_CHANGE * self.em

    def resize(self, em: float) -> bool:
        """Write everything in letters of another size; whether that changed anything that is seen."""
        if em == self.em:
            return False
        self.em = em
        for label, size in self._written.values():
            label.font_scene_height = _height(size, em)
        return True


def stagger_names(names: Sequence[tuple[str, Vector]], em: float) -> tuple[tuple[str, Vector], ...]:
    """Names that hang from places of the scene, in letters of a size: one that would lie on another hangs just below it."""
    taken, out = list[Box](), list[tuple[str, Vector]]()
    for words, (x, y, z) in names:
        half, tall = em * (text_width(words, 1.0) + NAME_GAP_EM) / 2, ROW_HEIGHT_EM * em
        box = Box(x - half, -z, x + half, tall - z)
        while met := [other.bottom for other in taken if box.meets(other)]:
            box = Box(box.left, max(met), box.right, max(met) + tall)
        taken.append(box)
        out.append((words, (x, y, -box.top)))
    return tuple(out)


def _height(size: Size, em: float) -> float:
    return em * (size(em) if callable(size) else size)
