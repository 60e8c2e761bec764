"""Draw the discs by which poles are dragged, large enough for a finger or a pointer."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import viser

from ..viser_private import page_scripts
from .meshes import disc
from .viewpoint import PHONE, aspect_of

POINTER, FINGER = 22.0 / 768, 26.0 / 844  # radius of a disc in heights of the window: 22 px on a laptop, 52 px across on a phone
MIN_RADIUS, MAX_RADIUS = 0.12, 0.9  # stage units
RADIUS_TOLERANCE = 0.06  # a radius that differs by less is not sent
FAINT = 0.16  # how much of the colour a disc has
LAYER = 0.003  # stage units between two discs, so that where they overlap none cuts into another
GRIPS = "/grips"  # how the name of such a node ends
LOCKS = "/locks"  # how that of the unseen discs ends, on crosses that no hand can move
OBSERVER_BOARD = "/board/observer/"  # how that of the one begins whose poles move the ghost most
Vector = tuple[float, float, float]


def handle_radius(camera: viser.CameraHandle, place: Sequence[float] | np.ndarray) -> float:
    """The radius (stage units) of a disc at `place` that takes POINTER of the window's height, FINGER on a phone.

    Not in the pixels that a browser tells: those are its drawing's, of which there are fewer while a slow machine moves
    the scene. A browser that says nothing sensible of its camera gets a radius within the bounds all the same.
    """
    eye, aim = np.asarray(camera.position, dtype=float), np.asarray(camera.look_at, dtype=float)
    ahead = aim - eye
    depth = float((np.asarray(place) - eye) @ ahead) / max(float(np.linalg.norm(ahead)), 1e-9)
    wanted = FINGER if aspect_of(camera) < PHONE else POINTER
    size = wanted * 2.0 * math.tan(camera.fov / 2) * depth
    return min(max(size, MIN_RADIUS), MAX_RADIUS) if math.isfinite(size) else 2 * MIN_RADIUS


class DragHandles:
    """The discs of one board in one node: one more thing to draw, however many poles there are."""

    def __init__(self, client: viser.ClientHandle, name: str, colour: str | None, middle: np.ndarray,
                 moved: Callable[[viser.SceneNodeDragEvent], Any]) -> None:
        """`colour` is None for discs that are not seen."""
        self._client, self._name, self._colour, self._middle, self._moved = client, name, colour, middle, moved
        self._node: viser.BatchedMeshHandle | None = None
        self._at = np.zeros((0, 3), dtype=np.float32)
        self._count, self._radius = 0, 0.0

    def show(self, places: Sequence[Vector]) -> None:
        """One disc at each place of the board's own frame; none where nothing can be dragged."""
        at = np.array(places, dtype=np.float32).reshape(-1, 3)
        at[:, 1] += LAYER * np.arange(len(at), dtype=np.float32)
        if np.array_equal(at, self._at):
            return
        self._at = at
        if self._node is not None and len(at) == self._count:
            self._node.batched_positions = at
            return
        if self._node is not None:
            self._node.remove()
        self._node, self._count = None, len(at)
        if self._count:
            self._make(at)

    def _make(self, at: np.ndarray) -> None:
        self._radius = handle_radius(self._client.camera, self._middle)
        upright = np.tile(np.array([1.0, 0.0, 0.0, 0.0], dtype=np.float32), (len(at), 1))
        self._node = self._client.scene.add_batched_meshes_simple(
            self._name, *disc(), upright, at, batched_scales=self._scales(), opacity=0.0 if self._colour is None else FAINT, lod="off",
            cast_shadow=False, receive_shadow=False)
        if self._colour is not None:
            page_scripts.flat_colour(self._client, self._name, self._colour)
        self._node.on_drag("left")(self._moved)

    def _scales(self) -> np.ndarray:
        return np.full(self._count, self._radius, dtype=np.float32)

    @property
    def misfit(self) -> bool:
        """Whether the discs would have to be of another size now; asked from the server's loop."""
        return (
            self._node is not None
            and abs(handle_radius(self._client.camera, self._middle) - self._radius) > RADIUS_TOLERANCE * self._radius
        )

    def fit(self) -> None:
        """Make the discs as large as they have to be now."""
        if self._node is not None and self.misfit:
            self._radius = handle_radius(self._client.camera, self._middle)
            self._node.batched_scales = self._scales()
