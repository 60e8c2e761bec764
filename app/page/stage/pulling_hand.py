"""Let a hand pull the plant on the stage, and draw its force as a spring."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence

import viser

from ...colours import COLOURS, rgb
from ...course.knobs import ByHand
from ...plants.bodies.body import Vector, pose_between
from ...plants.grip import Grip
from ..viser_private.stage_frames import Frame
from .meshes import helix

REACH = 1.1  # stage units that the spring of the largest force is long
SPRING = (0.07, 9.0, 0.02)  # its radius, turns and wire
AWAY: Vector = (0.0, 0.0, -9.0)  # where a spring is that nobody holds
Record = tuple[tuple[float, float], ...]
Pulled = Callable[[str, ByHand, int], object]  # the knob of the grip, what the hand does, and a number for each time it takes hold


def force_at(record: Record, t: float) -> float:
    """The force of a record at time t: that of the last sample up to it."""
    return next((force for begin, force in reversed(record) if begin <= t + 1e-9), 0.0)


def stretch(grip: Grip, start: Sequence[float], end: Sequence[float]) -> float:
    """The force of a spring from `start`, which is on the plant, to `end`, where the hand is: what lies along its direction counts."""
    along = sum((b - a) * axis for a, b, axis in zip(start, end, grip.along, strict=True))
    return along / REACH * grip.most


class PullingHand:
    """The grips of one body: their springs, and the hand that holds one of them."""

    def __init__(self, scene: viser.SceneApi, gain: float) -> None:
        self._scene, self._gain = scene, gain
        self._springs: dict[str, viser.MeshHandle] = {}
        self._grips: dict[str, tuple[Grip, Record]] = {}
        self._count = time.monotonic_ns()  # told apart from the grips of every board
        self._holds = False

    def listen(self, grips: Sequence[Grip], nodes: Mapping[str, viser.SceneNodeHandle], pulled: Pulled) -> None:
        """Let a hand take hold of the parts of these grips."""
        for grip in grips:
            for part in grip.parts:
                nodes[part].on_drag("left")(self._listener(grip, pulled))

    def _listener(self, grip: Grip, pulled: Pulled) -> Callable[[viser.SceneNodeDragEvent], object]:
        async def moved(event: viser.SceneNodeDragEvent) -> None:
            if event.phase == "start":
                self._count += 1
            elif not self._holds:  # a move that arrives after the hand has let go would hold the plant for ever
                return
            self._holds = event.phase != "end"
            force = stretch(grip, event.start_position, event.end_position)  # the first moves with the plant
            if math.isfinite(force):
                pulled(grip.knob, ByHand(force, event.phase == "end"), self._count)
        return moved

    def take(self, held: Sequence[tuple[Grip, Record]]) -> None:
        """The records of a run; a spring is put into the scene where somebody has pulled."""
        self._grips = {grip.knob: (grip, record) for grip, record in held}
        for grip, record in held:
            if record and grip.knob not in self._springs:
                vertices, faces = helix(*SPRING)
                self._springs[grip.knob] = self._scene.add_mesh_simple(
                    f"/pull/{grip.knob}", vertices, faces, color=rgb(COLOURS["steel"]), cast_shadow=False, receive_shadow=False,
                    position=AWAY)

    def place(self, t: float, x: Sequence[float], frame: Frame) -> None:
        """Write into a frame where the springs are at time t of the run, whose state is x."""
        for knob, (grip, record) in self._grips.items():
            node = self._springs.get(knob)
            if node is None:
                continue
            at = grip.at(x, self._gain)
            length = min(max(force_at(record, t) / grip.most, -1.0), 1.0) * REACH
            end = tuple(a + length * axis for a, axis in zip(at, grip.along, strict=True))
            pose = pose_between(at, (end[0], end[1], end[2])) if length else pose_between(AWAY, AWAY)
            frame[node.name, "position"], frame[node.name, "wxyz"], frame[node.name, "scale"] = pose.position, pose.wxyz, pose.scale

    def remove(self) -> None:
        """Take the springs out of the scene."""
        for node in self._springs.values():
            node.remove()
        self._springs, self._grips = {}, {}
