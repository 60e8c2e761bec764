"""Draw the ghosts of pinned designs on the stage, each with its name above it."""

from __future__ import annotations

from collections.abc import Sequence

import viser

from ...colours import COLOURS
from ...course.error_window import sample_at
from ...course.pinned_designs import Ghost
from ...plants.bodies.body import Body
from ..viser_private.stage_frames import Frame
from .scene_labels import SceneLabels
from .solids import Solids

OPACITY = 0.26
SMALLER, PIN_SCALE_STEP = 0.965, 0.02  # of the body: inside the present ghost, and each pin's inside the last one's
LIFT, NAME_GAP = 0.42, 0.3  # stage units from an anchor to the first name, and from one name to the next


class PinGhosts:
    """One set of parts a pin whose ghost is wanted."""

    def __init__(self, scene: viser.SceneApi, letters: SceneLabels) -> None:
        self._scene, self._letters = scene, letters
        self._ghosts: tuple[Ghost, ...] = ()
        self._body: Body | None = None
        self._parts: list[Solids] = []
        self._names: list[viser.LabelHandle] = []

    def show(self, ghosts: Sequence[Ghost], body: Body | None) -> bool:
        """The ghosts that are wanted now; others go. Whether any came or went."""
        before, self._ghosts = self._ghosts, tuple(ghosts) if body is not None else ()
        if body is self._body and [(g.place, g.name) for g in before] == [(g.place, g.name) for g in self._ghosts]:
            return False
        self.clear()
        self._body = body
        for ghost in self._ghosts:
            solids = Solids(self._scene, f"/pins/{ghost.place}", SMALLER - PIN_SCALE_STEP * ghost.place, coloured=False)
            for part in body.parts if body is not None else ():
                if part.twin:
                    solids.add(part, COLOURS["muted"], OPACITY)
            self._parts.append(solids)
            self._names.append(self._letters.write(f"/pins/{ghost.place}/name", ghost.name, (0.0, 0.0, 0.0), "bottom-center"))
        return True

    def place_at(self, t: float) -> tuple[int, ...]:
        """The sample of each ghost's own run at time t."""
        return tuple(sample_at(ghost.t, t) for ghost in self._ghosts)

    def place(self, samples: tuple[int, ...], frame: Frame) -> None:
        """Write into a frame where every ghost is at these samples."""
        body = self._body
        if body is None:
            return
        for ghost, solids, name, sample in zip(self._ghosts, self._parts, self._names, samples, strict=True):
            state = ghost.states[sample].tolist()
            solids.place(body.pose(state, body.gain), frame)
            x, y, z = next(iter(body.anchors(state, body.gain)), (0.0, 0.0, 0.0))
            frame[name.name, "position"] = (x, y, z + LIFT + NAME_GAP * ghost.place)

    def clear(self) -> None:
        """Take all of them off the stage."""
        for solids in self._parts:
            solids.remove()
        for name in self._names:
            self._letters.remove(name)
        self._parts, self._names = [], []
