"""The stage: floor and light, the plant in solid parts, its ghost, forces, error lines."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
import viser

from ..lesson.figures import COLOURS
from ..lesson.lesson import Stage
from ..plants.body import Ball, Body, Box, Cylinder, Part, Pose, Spring, Vector
from ..text import wording
from . import phrases
from .letters import Letters
from .meshes import helix

PHONE = 0.62  # width over height below which the panels lie over the lower half
NARROW = 0.90  # width over height of a canvas that just shows both boards
SIGHT = 0.62  # radians of the field of view: the boards stay readable
BOARDS_BEHIND = 0.9  # stage units from what the composed view looks at to the boards
FLOOR, DARK_FLOOR = (214, 220, 229), (58, 66, 78)
SHORTEST = 0.05  # stage units: shorter arrows are not drawn
LARGEST_CLOUD = 0.9  # stage units
INSIDE = 0.985  # the ghost is drawn this much smaller: where it agrees, it vanishes into the body
BELOW: Vector = (0.0, 0.0, -9.0)
GHOST_COLOUR = COLOURS["estimate"]
CAMERAS = MappingProxyType({
    "all": ((0.0, -13.4, 3.4), (0.0, 0.6, 1.38)),
    "plant": ((0.0, -8.2, 2.9), (0.0, 0.0, 1.0)),
    "boards": ((0.0, -10.2, 3.6), (0.0, 1.6, 3.3)),
})


def rgb(colour: str) -> tuple[int, int, int]:
    """'#RRGGBB' as three bytes."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def aspect_of(camera: viser.CameraHandle) -> float:
    """Width over height of the canvas; 1 where the browser says nothing sensible of it."""
    if camera.image_height > 0 and camera.image_width > 0:
        return camera.image_width / camera.image_height
    return 1.0


def letters(camera: viser.CameraHandle, lecture: bool) -> float:
    """The size of letters (stage units) at the boards that is a certain share of the window's height in the composed view.

    1/48 in lecture mode, whatever the window: legible from the last row; else about ten pixels of a laptop or a phone.
    """
    (_, away, _), (_, near, _) = CAMERAS["all"]
    aspect = aspect_of(camera)
    depth = (near - away) * retreat(aspect) + BOARDS_BEHIND
    return (1 / 48 if lecture else 1 / 84 if aspect < PHONE else 1 / 72) * 2 * math.tan(SIGHT / 2) * depth


def retreat(aspect: float) -> float:
    """How many times farther away a narrow window looks from."""
    return max(1.0, NARROW / max(aspect, 0.2))


class StageView:
    """One tab's stage. Sends only what changed since the last pose."""

    def __init__(self, client: viser.ClientHandle) -> None:
        self._client = client
        self._scene = client.scene
        self._body: Body | None = None
        self._solid: dict[str, viser.SceneNodeHandle] = {}
        self._ghost: dict[str, viser.SceneNodeHandle] = {}
        self._last: dict[str, Pose] = {}
        self._forces: viser.ArrowsHandle | None = None
        self._errors: viser.LineSegmentsHandle | None = None
        self._clouds: list[viser.IcosphereHandle] = []
        self._names: list[viser.LabelHandle] = []
        self._letters = Letters(self._scene, 1.0)
        self._stage: Stage | None = None
        self._posed: tuple[Stage, int] | None = None
        self._arrived = False  # whether the browser has said that it looks from where it was told to
        self._seen_from, self._aspect = CAMERAS["all"], 1.0

    def furnish(self, dark: bool) -> None:
        """Floor, light, background and the default camera of an empty stage."""
        scene = self._scene
        scene.set_up_direction("+z")
        scene.configure_default_lights(False)
        scene.configure_environment_map(None)
        scene.add_light_hemisphere("/light/sky", sky_color=(255, 255, 255), ground_color=(196, 202, 214), intensity=2.1)
        scene.add_light_directional("/light/key", color=(255, 248, 236), intensity=2.3, position=(-4.0, -6.0, 9.0),
                                    cast_shadow=False)
        scene.add_light_directional("/light/fill", color=(226, 236, 255), intensity=0.5, position=(6.0, -5.0, 4.0),
                                    cast_shadow=False)
        scene.add_line_segments("/floor", _floor(), DARK_FLOOR if dark else FLOOR, thickness=0.012)
        scene.add_image("/shadow", _shade(), 5.6, 3.4, format="png", cast_shadow=False, receive_shadow=False,
                        position=(0.0, 0.1, 0.002))

    def follow_window(self) -> None:
        """Look again from the last named place whenever the window or a panel changes its shape."""
        @self._client.camera.on_update
        async def _(camera: viser.CameraHandle) -> None:
            self._arrived = self._arrived or np.allclose(self._eye(), np.ravel(self._seen_from), atol=0.02)
            if abs(aspect_of(camera) - self._aspect) > 0.03 * self._aspect:
                self._look()
                self._client.flush()

    def camera(self, preset: str) -> None:
        """Look from one of the named places."""
        self._seen_from = CAMERAS.get(preset, CAMERAS["all"])
        self._look()

    def look(self, camera: tuple[float, ...] | None) -> None:
        """Look from a position at a target, from where everything is seen for None."""
        self._seen_from = CAMERAS["all"] if camera is None else (camera[:3], camera[3:])
        self._look()

    def eye(self) -> tuple[float, ...] | None:
        """Position and target as `look` takes them, None where everything is seen from the usual place."""
        now = self._eye() if self._arrived else np.ravel(self._seen_from)
        if not np.all(np.isfinite(now)) or np.allclose(now, np.ravel(CAMERAS["all"]), atol=0.02):
            return None
        return tuple(now.tolist())

    def _eye(self) -> np.ndarray:
        """Position and target, six numbers, of a window that needs no adapting."""
        camera, (back, drop) = self._client.camera, self._fit(self._seen_from)
        lift = np.array((0.0, 0.0, drop))
        target = np.array(camera.look_at) + lift
        return np.concatenate([target + (np.array(camera.position) + lift - target) / back, target])

    def _fit(self, place: tuple[Sequence[float], Sequence[float]]) -> tuple[float, float]:
        """How many times farther off a narrow window looks from, and how far below the target a phone aims."""
        back = retreat(self._aspect)
        return back, 0.14 * back * abs(place[0][1] - place[1][1]) if self._aspect < PHONE else 0.0  # above a phone's sheet

    def _look(self) -> None:
        self._arrived = False
        position, target = self._seen_from
        self._aspect = aspect_of(self._client.camera)
        back, drop = self._fit(self._seen_from)
        aim = np.array(target) - (0.0, 0.0, drop)
        with self._client.atomic():
            self._client.camera.up_direction = (0.0, 0.0, 1.0)
            self._client.camera.position = aim + back * (np.array(position) - np.array(target))
            self._client.camera.look_at = aim
            self._client.camera.fov = SIGHT

    def build(self, stage: Stage | None, language: str, em: float) -> None:
        """Put a plant on the stage, instead of the last one."""
        self._last, self._solid, self._ghost, self._posed = {}, {}, {}, None
        self._forces = self._errors = None
        self._clouds, self._names = [], []
        self._stage, self._body = stage, stage.body if stage is not None else None
        self._letters = Letters(self._scene, em)
        if stage is None:
            return
        body = stage.body
        for part in body.parts:
            self._solid[part.name] = self._add(f"/plant/{part.name}", part, part.colour, part.opacity)
            if part.twin and stage.xhat is not None:
                self._ghost[part.name] = self._add(f"/ghost/{part.name}", part, GHOST_COLOUR, 0.42)
        none = _segments([])
        self._forces = self._scene.add_arrows("/forces", none, rgb(COLOURS["force"]), shaft_radius=0.035,
                                              head_radius=0.09, head_length=0.16)
        self._errors = self._scene.add_line_segments("/errors", none, rgb(COLOURS["error"]), thickness=0.028)
        self._clouds = [] if stage.spread is None or stage.xhat is None else [
            self._scene.add_icosphere(f"/spread/{i}", 1.0, rgb(GHOST_COLOUR), opacity=0.16, cast_shadow=False,
                                      receive_shadow=False)
            for i, _ in enumerate(body.anchors(stage.xhat[0].tolist(), body.gain))]
        self._factor(body, language)
        self._names = [self._letters.write(f"/name/{i}", wording(words, language), place, "top-center")
                       for i, (words, place) in enumerate(body.labels)]

    def fit(self, em: float) -> bool:
        """Write in letters as large as the window asks for; whether that changed anything."""
        return self._letters.resize(em)

    def _factor(self, body: Body, language: str) -> None:
        """How many times motion and arrows are exaggerated, beside the plant."""
        factors = ((phrases.EXAGGERATED, body.gain), (phrases.LONGER, body.forces))
        words = phrases.AND(language).join(phrase.format(factor=times)(language) for phrase, times in factors if times != 1)
        self._letters.write("/factor", words, (2.9, -0.6, 0.12), "center-right", visible=bool(words))

    def _add(self, name: str, part: Part, colour: str, opacity: float | None) -> viser.SceneNodeHandle:
        scene, shape = self._scene, part.shape
        look = {"color": rgb(colour), "opacity": opacity, "cast_shadow": False, "receive_shadow": False}
        if isinstance(shape, Box):
            return scene.add_box(name, dimensions=shape.size, **look)
        if isinstance(shape, Cylinder):
            return scene.add_cylinder(name, shape.radius, shape.height, **look)
        if isinstance(shape, Ball):
            return scene.add_icosphere(name, shape.radius, **look)
        vertices, faces = helix(shape.radius, shape.turns, shape.wire) if isinstance(shape, Spring) else _rod(shape.radius)
        return scene.add_mesh_simple(name, vertices, faces, **look)

    def show(self, stage: Stage | None, language: str, em: float) -> None:
        """Take a new run; another plant is put on the stage in place of the last one."""
        if (stage.body if stage is not None else None) is not self._body:
            for handle in (*self._solid.values(), *self._ghost.values(), *self._clouds, *self._names):
                handle.remove()
            self.build(stage, language, em)
        self._stage = stage

    def pose(self, t: float) -> None:
        """Move every part to time t of the run."""
        stage, body = self._stage, self._body
        if stage is None or body is None:
            return
        index = max(0, min(int(np.searchsorted(stage.t, t + 1e-9, side="right")) - 1, len(stage.t) - 1))
        if self._posed is not None and self._posed[0] is stage and self._posed[1] == index:
            return
        self._posed = stage, index
        x = stage.x[index].tolist()
        self._place(self._solid, "", body.pose(x, body.gain))
        if stage.xhat is not None and self._ghost:
            xhat = stage.xhat[index].tolist()
            self._place(self._ghost, "ghost ", body.pose(xhat, body.gain), INSIDE)
            believed = body.anchors(xhat, body.gain)
            self._join(body.anchors(x, body.gain), believed)
            if stage.spread is not None:
                self._cloud(believed, float(stage.spread[index]))
        if stage.u is not None and self._forces is not None:
            arrows = body.arrows(x, stage.u[index].tolist(), body.gain)
            seen = [(a.tail, a.head) for a in arrows if math.dist(a.tail, a.head) > SHORTEST]
            self._draw(self._forces, _segments(seen))

    def _cloud(self, believed: Sequence[Vector], radius: float) -> None:
        """How unsure the estimate is: a translucent ball about each anchor, never larger than the stage can hold."""
        size = min(max(radius, 1e-3), LARGEST_CLOUD)
        for handle, place in zip(self._clouds, believed, strict=True):
            handle.position = place
            handle.scale = size

    def _join(self, true: Sequence[tuple[float, float, float]], believed: Sequence[tuple[float, float, float]]) -> None:
        if self._errors is not None:
            pairs = zip(true, believed, strict=True)
            self._draw(self._errors, _segments([pair for pair in pairs if math.dist(*pair) > 0.3 * SHORTEST]))

    @staticmethod
    def _draw(handle: viser.ArrowsHandle | viser.LineSegmentsHandle, points: np.ndarray) -> None:
        if not np.array_equal(handle.points, points):
            handle.points = points

    def _place(self, handles: dict[str, viser.SceneNodeHandle], prefix: str, poses: Mapping[str, Pose],
               size: float = 1.0) -> None:
        for name, handle in handles.items():
            pose = poses[name]
            last = self._last.get(prefix + name)
            if pose == last:
                continue
            if last is None or pose.position != last.position:
                handle.position = pose.position
            if last is None or pose.wxyz != last.wxyz:
                handle.wxyz = pose.wxyz
            if last is None or pose.scale != last.scale:
                handle.scale = tuple(size * s for s in pose.scale)  # type: ignore[attr-defined]
            if pose.colour is not None and not prefix and (last is None or pose.colour != last.colour):
                handle.color = pose.colour  # type: ignore[attr-defined]
            self._last[prefix + name] = pose


def _floor(half: int = 8) -> np.ndarray:
    """The lines of the floor. viser's own grid is a shader over half the screen: too dear without a graphics card."""
    lines = [((x, -3.6, 0.0), (x, 2.0 * half, 0.0)) for x in range(-half, half + 1)]
    lines += [((-half, y - 0.6, 0.0), (half, y - 0.6, 0.0)) for y in range(-3, 2 * half + 1)]
    return np.array(lines, dtype=np.float32)


def _shade() -> np.ndarray:
    """A soft shadow to lay under the plant: a picture costs a slow machine far less than cast shadows."""
    y, x = np.mgrid[-1:1:96j, -1:1:128j]
    alpha = 95 * np.clip(1 - np.sqrt((np.abs(x) / 0.95) ** 2.6 + (np.abs(y) / 0.9) ** 2.6), 0.0, 1.0) ** 1.3
    return np.dstack([np.full((96, 128, 3), 40), alpha]).astype(np.uint8)


def _segments(pairs: list[tuple[Vector, Vector]]) -> np.ndarray:
    """Start and end points (k, 2, 3); viser keeps a node alive only if it has at least one, so one lies below the floor."""
    return np.array([*pairs, (BELOW, BELOW)], dtype=np.float32)


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

