"""Draw the solid parts of a body in the scene and place them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import viser

from ...colours import rgb
from ...plants.bodies.body import Ball, Box, Cylinder, Part, Pose, Shape, Spring
from ..viser_private.stage_frames import Frame
from .meshes import helix


class Solids:
    """The parts of one body, plant or ghost, each a node of the scene."""

    def __init__(self, scene: viser.SceneApi, root: str, size: float = 1.0, coloured: bool = True) -> None:
        self._scene, self._root, self._size, self._coloured = scene, root, size, coloured
        self._nodes: dict[str, viser.SceneNodeHandle] = {}

    def __bool__(self) -> bool:
        return bool(self._nodes)

    def add(self, part: Part, colour: str, opacity: float | None) -> None:
        """Put a part into the scene."""
        self._nodes[part.name] = self._node(f"{self._root}/{part.name}", part.shape, colour, opacity)

    def _node(self, name: str, shape: Shape, colour: str, opacity: float | None) -> viser.SceneNodeHandle:
        scene, look = self._scene, {"color": rgb(colour), "opacity": opacity, "cast_shadow": False, "receive_shadow": False}
        if isinstance(shape, Box):
            return scene.add_box(name, dimensions=shape.size, **look)
        if isinstance(shape, Cylinder):
            return scene.add_cylinder(name, shape.radius, shape.height, **look)
        if isinstance(shape, Ball):
            return scene.add_icosphere(name, shape.radius, **look)
        vertices, faces = helix(shape.radius, shape.turns, shape.wire) if isinstance(shape, Spring) else _rod(shape.radius)
        return scene.add_mesh_simple(name, vertices, faces, **look)

    def place(self, poses: Mapping[str, Pose], frame: Frame) -> None:
        """Write into a frame where every part is."""
        for name, handle in self._nodes.items():
            pose, node = poses[name], handle.name
            frame[node, "position"] = pose.position
            frame[node, "wxyz"] = pose.wxyz
            x, y, z = pose.scale
            frame[node, "scale"] = (self._size * x, self._size * y, self._size * z)
            if pose.colour is not None and self._coloured:
                frame[node, "color"] = pose.colour

    @property
    def nodes(self) -> Mapping[str, viser.SceneNodeHandle]:
        """The nodes of the parts by their names."""
        return self._nodes

    def remove(self) -> None:
        """Take all parts out of the scene."""
        for node in self._nodes.values():
            node.remove()
        self._nodes = {}


def _rod(radius: float, sides: int = 16) -> tuple[np.ndarray, np.ndarray]:
    ring = 2 * np.pi * np.arange(sides) / sides
    circle = np.column_stack([radius * np.cos(ring), radius * np.sin(ring)])
    bottom, top = (np.column_stack([circle, np.full(sides, z)]) for z in (0.0, 1.0))
    vertices = np.vstack([bottom, top, [[0, 0, 0]], [[0, 0, 1]]]).astype(np.float32)
    faces = []
    for i in range(sides):
        j = (i + 1) % sides
        faces += [(i, j, sides + j), (i, sides + j, sides + i), (j, i, 2 * sides), (sides + i, sides + j, 2 * sides + 1)]
    return vertices, np.array(faces, dtype=np.uint32)
