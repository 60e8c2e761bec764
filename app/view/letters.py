"""The words of one part of the scene: all in letters of one size, which a window of another shape changes."""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType
from typing import Any

import viser

from . import quirks

Size = float | Callable[[float], float]
UNSEEN = 0.03  # of the size of letters: a change that nobody sees
INK = MappingProxyType({False: ("#000000", "#ffffff"), True: ("#e9ecf1", "#1d2127")})  # of labels and of their ground, by day and by night


def ink_labels(client: viser.ClientHandle, dark: bool) -> None:
    """Write all labels of the scene in the theme's ink on the theme's ground."""
    ink, ground = INK[dark]
    quirks.run(client, "labels", ink=ink, ground=ground)


class Letters:
    """Labels in the scene; `em` is the size of their letters in stage units, each label has its own multiple of it.

    The multiple may depend on `em`, where words have to fit into a room.
    """

    def __init__(self, scene: viser.SceneApi, em: float) -> None:
        self._scene, self.em = scene, em
        self._written: dict[str, tuple[viser.LabelHandle, Size]] = {}

    def write(self, name: str, words: str, at: tuple[float, float, float], anchor: Any, size: Size = 1.0,
              **look: Any) -> viser.LabelHandle:
        """A label of the scene, in place of one of that name."""
        label = self._scene.add_label(name, words, position=at, anchor=anchor, font_size_mode="scene",
                                      font_scene_height=_height(size, self.em), **look)
        self._written[name] = label, size
        return label

    def remove(self, label: viser.LabelHandle) -> None:
        """Take a label away."""
        self._written.pop(label.name, None)
        label.remove()

    def resize(self, em: float) -> bool:
        """Write everything in letters of another size; whether that changed anything that is seen."""
        if abs(em - self.em) <= UNSEEN * self.em:
            return False
        self.em = em
        for label, size in self._written.values():
            label.font_scene_height = _height(size, em)
        return True


def _height(size: Size, em: float) -> float:
    return em * (size(em) if callable(size) else size)
