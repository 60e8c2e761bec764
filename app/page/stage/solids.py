"""Draw the solid parts of a body in the scene and place them."""

from __future__ import annotations

from collections.abc import Mapping

import viser

from ...colours import rgb
from ...plants.bodies.body import Ball, Box, Cylinder, Part, Pose, Rod, Shape, Spring
from ..viser_private.stage_frames import Frame
from .meshes import Mesh, bevelled_box, bevelled_cylinder, box_edges, helix, rims

EDGE, LARGE = 0.013, 0.33  # stage units: a line along an edge; a part so long or wide has them
FINE, COARSE = 4, 3  # how often the triangles of a ball are parted in four: of a large one, of others


class Solids:
    """The parts of one body, plant or ghost, each a node of the scene."""

    def __init__(self, scene: viser.SceneApi, root: str, size: float = 1.0, coloured: bool = True) -> None:
        self._scene, self._root, self._size, self._coloured = scene, root, size, coloured
        self._nodes: dict[str, viser.SceneNodeHandle] = {}

    def __bool__(self) -> bool:
        return bool(self._nodes)

    def add(self, part: Part, colour: str, opacity: float | None, edged: bool = False) -> None:
        """Put a part into the scene, with lines along its edges if it is `edged` and not small: by them a translucent part is seen."""
        node, shape = f"{self._root}/{part.name}", part.shape
        self._nodes[part.name] = self._node(node, shape, colour, opacity)
        if edged and isinstance(shape, Box | Cylinder) and (max(shape.size) if isinstance(shape, Box) else 2 * shape.radius) >= LARGE:
            lines = box_edges(shape.size) if isinstance(shape, Box) else rims(shape.radius, shape.height)
            self._scene.add_line_segments(f"{node}/edges", lines, rgb(colour), thickness=EDGE)

    def _node(self, name: str, shape: Shape, colour: str, opacity: float | None) -> viser.SceneNodeHandle:
        scene, opaque = self._scene, opacity is None  # these cast a shadow wherever the light does, see `light.js`
        look = {"color": rgb(colour), "opacity": opacity, "cast_shadow": opaque, "receive_shadow": opaque}
        if isinstance(shape, Ball):
            return scene.add_icosphere(name, shape.radius, subdivisions=FINE if shape.radius >= LARGE else COARSE, **look)
        return scene.add_mesh_simple(name, *_mesh(shape), **look)

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


def _mesh(shape: Box | Cylinder | Spring | Rod) -> Mesh:
    if isinstance(shape, Box):
        return bevelled_box(shape.size)
    if isinstance(shape, Cylinder):
        return bevelled_cylinder(shape.radius, -shape.height / 2, shape.height / 2)
    if isinstance(shape, Spring):
        return helix(shape.radius, shape.turns, shape.wire)
    return bevelled_cylinder(shape.radius, 0.0, 1.0, sides=16)
