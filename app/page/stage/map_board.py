"""Draw a map in front of the stage; a click chooses two start values."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import viser

from ...colours import COLOURS, palette, rgb
from ...course.figures.records import MapFigure
from ...session.state.view import Picture
from ...text import label_in_language
from ..charts.axes import ticks
from ..charts.text_layout import fold_lines
from ..words import phrases
from .scene_labels import SceneLabels

MAP_WIDTH, MAP_DEPTH, MAP_TILT_RAD = 3.2, 1.7, 0.42  # stage units, radians
NEARER = 0.75  # of the way from the eye to the boards: letters of this size look as large as theirs
CENTRE = np.array([0.0, -2.75, 0.36])
MAP_ACROSS, MAP_UP = np.array([1.0, 0.0, 0.0]), np.array([0.0, math.cos(MAP_TILT_RAD), math.sin(MAP_TILT_RAD)])
FAR_EDGE_SCALE = 0.85  # of the width of the near edge that the far one seems to have
EDGE_NUMBER_GAP = 0.06  # stage units between the map's edge and its numbers
LINE_HEIGHT_EM = 2.0  # height of a line in the size of its letters, laid on the map's plane, which the eye sees from low above
Vector = tuple[float, float, float]


class Written(NamedTuple):
    """Words on the map's face or beside it: the place in stage units, and which point of the words stands there."""

    words: str
    at: Vector
    anchor: str


def map_of(picture: Picture) -> MapFigure | None:
    """The map that lies on the stage, if the lesson has one; in the guide only in scenes that name it."""
    figure = None if picture.lesson.pick is None else next((f for f in picture.seen if isinstance(f, MapFigure)), None)
    return figure if figure is None or picture.scene is None or figure.id in picture.scene.figures else None


def edges(figure: MapFigure) -> tuple[tuple[float, float], tuple[float, float]]:
    """A map's outer edges: half a cell beyond the first and last values."""
    out = []
    for v in (figure.x, figure.y):
        half = (float(v[1]) - float(v[0])) / 2 if len(v) > 1 else 0.5
        out.append((float(v[0]) - half, float(v[-1]) + half))
    return out[0], out[1]


def place(x: float, y: float, left: float = 0.0, down: float = 0.0) -> Vector:
    """The point of the stage at shares (x, y) of the map, moved to the left and towards the eye by stage units."""
    point = CENTRE + MAP_ACROSS * ((x - 0.5) * MAP_WIDTH - left) + MAP_UP * ((y - 0.5) * MAP_DEPTH - down)
    return float(point[0]), float(point[1]), float(point[2])


def written(figure: MapFigure, language: str, em: float) -> dict[str, Written]:
    """What is written in letters of size `em`: numbers at the left and the near edge, the nearer ones below the farther, under them
    the title with the names of the axes; in the middle of a map that is empty, that it is."""
    (x0, x1), (y0, y1) = edges(figure)
    out = {}
    for x in ticks(float(figure.x[0]), float(figure.x[-1]), 5):
        out[f"/map/x{x:g}"] = Written(
            f"{x:g}".replace("-", "−"), place((x - x0) / (x1 - x0), 0.0, down=EDGE_NUMBER_GAP + LINE_HEIGHT_EM / 2 * em), "top-center"
        )
    for y in ticks(float(figure.y[0]), float(figure.y[-1]), max(1, min(4, int(MAP_DEPTH / (LINE_HEIGHT_EM * em)) - 1))):
        out[f"/map/y{y:g}"] = Written(f"{y:g}".replace("-", "−"), place(0.0, (y - y0) / (y1 - y0), left=EDGE_NUMBER_GAP), "center-right")
    axes = f"→  {label_in_language(figure.x_label, language)}   ↑  {label_in_language(figure.y_label, language)}"
    title = fold_lines(f"{figure.title(language)}   {axes}", (MAP_WIDTH + 2.0) / em)
    out["/map/title"] = Written(title, place(0.5, 0.0, down=EDGE_NUMBER_GAP + 1.6 * LINE_HEIGHT_EM * em), "top-center")
    if np.all(figure.values < 0):
        out["/map/empty"] = Written(
            fold_lines(phrases.MAP_EMPTY(language), FAR_EDGE_SCALE * MAP_WIDTH / em - 1.0), place(0.5, 0.6), "center-center"
        )
    return out


class MapBoard:
    """The map as a picture in the scene; a click gives the point of the map under it."""

    def __init__(self, client: viser.ClientHandle, language: str, em: float, dark: bool, pick: Callable[[float, float], object]) -> None:
        self._scene, self._language, self._pick = client.scene, language, pick
        self._whole = client.scene.add_frame("/map", show_axes=False)
        self._empty = rgb(palette(dark)["empty"])
        self._letters = SceneLabels(client.scene, em * NEARER)
        self._labels: dict[str, tuple[viser.LabelHandle, Written]] = {}
        self._figure: MapFigure | None = None
        self._image: viser.ImageHandle | None = None
        self._mark: viser.IcosphereHandle | None = None

    def show(self, figure: MapFigure | None) -> None:
        """Draw the map's present values; None hides it."""
        if self._whole.visible != (figure is not None):
            self._whole.visible = figure is not None
        if figure is None:
            return
        if self._figure is not None and figure.values is self._figure.values and figure.marked == self._figure.marked:
            return
        first = self._image is None or self._figure is None or figure.values is not self._figure.values
        self._figure = figure
        if first:
            self._paint(figure)
        if figure.marked is not None:
            (x0, x1), (y0, y1) = edges(figure)
            where = place((figure.marked[0] - x0) / (x1 - x0), (figure.marked[1] - y0) / (y1 - y0))
            if self._mark is None:
                self._mark = self._scene.add_icosphere("/map/mark", 0.055, rgb(COLOURS["reference"]), position=where)
            else:
                self._mark.position = where

    def _paint(self, figure: MapFigure) -> None:
        colours = np.array([self._empty, *(rgb(COLOURS[role]) for _, role in figure.categories)], dtype=np.uint8)
        small = colours[np.asarray(figure.values, dtype=int)[::-1] + 1]
        scale = max(1, math.ceil(240 / max(small.shape[:2])))
        image = np.kron(small, np.ones((scale, scale, 1), dtype=np.uint8))
        if self._image is None:
            half = MAP_TILT_RAD / 2 + math.pi / 2
            self._image = self._scene.add_image("/map/picture", image, MAP_WIDTH, MAP_DEPTH, format="png", cast_shadow=False,
                                                receive_shadow=False, position=tuple(CENTRE),
                                                wxyz=(math.cos(half), math.sin(half), 0.0, 0.0))

            @self._image.on_click
            async def _(event: viser.SceneNodePointerEvent) -> None:
                self._clicked(np.array(event.ray_origin), np.array(event.ray_direction))
        else:
            self._image.image = image
        self._letter()

    def _letter(self) -> None:
        """Write what is to be read now, and where."""
        assert self._figure is not None
        wanted = written(self._figure, self._language, self._letters.em)
        for name, (label, _) in self._labels.items():  # hidden, not taken away: larger letters may need fewer numbers for a while
            if label.visible != (name in wanted):
                label.visible = name in wanted
        for name, what in wanted.items():
            anchor: Any = what.anchor
            held = self._labels.get(name)
            if held is not None and what != held[1]:
                held[0].text, held[0].position = what.words, what.at
            self._labels[name] = self._letters.write(name, what.words, what.at, anchor) if held is None else held[0], what

    def needs_resize(self, em: float) -> bool:
        """Whether `fit` has something to do; asked from the server's loop."""
        return self._letters.misfit(em * NEARER)

    def fit(self, em: float) -> None:
        """Write in letters as large as the window asks for."""
        if self._letters.resize(em * NEARER) and self._figure is not None:
            self._letter()

    def _clicked(self, origin: np.ndarray, ray: np.ndarray) -> None:
        normal = np.cross(MAP_ACROSS, MAP_UP)
        slope = float(ray @ normal)
        if self._figure is None or abs(slope) < 1e-9:
            return
        hit = origin + ray * float((CENTRE - origin) @ normal) / slope - CENTRE
        (x0, x1), (y0, y1) = edges(self._figure)
        x = x0 + (float(hit @ MAP_ACROSS) / MAP_WIDTH + 0.5) * (x1 - x0)
        y = y0 + (float(hit @ MAP_UP) / MAP_DEPTH + 0.5) * (y1 - y0)
        self._pick(min(max(x, x0), x1), min(max(y, y0), y1))
