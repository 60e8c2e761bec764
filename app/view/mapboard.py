"""A map to click on: a figure over two start values, lying in front of the stage like an open book."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import viser

from ..lesson.figures import COLOURS, MapFigure
from ..text import wording
from . import phrases
from .letters import Letters
from .solids import rgb
from .ticks import ticks

WIDTH, DEPTH, TILT = 3.2, 1.7, 0.42  # stage units, radians
NEARER = 0.75  # of the way from the eye to the boards: letters of this size look as large as theirs
CENTRE = np.array([0.0, -2.75, 0.36])


class MapBoard:
    """The map as a picture in the scene; a click gives the point of the map under it."""

    def __init__(self, client: viser.ClientHandle, language: str, em: float, pick: Callable[[float, float], object]) -> None:
        self._scene, self._language, self._pick = client.scene, language, pick
        self._letters = Letters(client.scene, em * NEARER)
        self._figure: MapFigure | None = None
        self._image: viser.ImageHandle | None = None
        self._mark: viser.IcosphereHandle | None = None
        self._title: viser.LabelHandle | None = None
        self._across = np.array([1.0, 0.0, 0.0])
        self._up = np.array([0.0, math.cos(TILT), math.sin(TILT)])

    def show(self, figure: MapFigure) -> None:
        """Draw the map's present values."""
        if self._figure is not None and figure.values is self._figure.values and figure.marked == self._figure.marked:
            return
        first = self._image is None or self._figure is None or figure.values is not self._figure.values
        self._figure = figure
        if first:
            self._paint(figure)
        if figure.marked is not None:
            where = self._at(*figure.marked)
            if self._mark is None:
                self._mark = self._scene.add_icosphere("/map/mark", 0.055, (0, 0, 0), position=where)
            else:
                self._mark.position = where

    def _name(self, figure: MapFigure) -> str:
        empty = bool(np.all(figure.values < 0))
        across, up = wording(figure.x_label, self._language), wording(figure.y_label, self._language)
        tail = phrases.MAP_EMPTY(self._language) if empty else f"→  {across}   ↑  {up}"
        return f"{figure.title(self._language)}   {tail}"

    def _paint(self, figure: MapFigure) -> None:
        colours = np.array([(226, 229, 234), *(rgb(COLOURS[role]) for _, role in figure.categories)], dtype=np.uint8)
        small = colours[np.asarray(figure.values, dtype=int)[::-1] + 1]
        scale = max(1, math.ceil(240 / max(small.shape[:2])))
        image = np.kron(small, np.ones((scale, scale, 1), dtype=np.uint8))
        if self._image is None:
            half = TILT / 2 + math.pi / 2
            self._image = self._scene.add_image("/map/picture", image, WIDTH, DEPTH, format="png", cast_shadow=False,
                                                receive_shadow=False, position=tuple(CENTRE),
                                                wxyz=(math.cos(half), math.sin(half), 0.0, 0.0))
            self._letter(figure)

            @self._image.on_click
            async def _(event: viser.SceneNodePointerEvent) -> None:
                self._clicked(np.array(event.ray_origin), np.array(event.ray_direction))
        else:
            self._image.image = image
        if self._title is not None and self._title.text != self._name(figure):
            self._title.text = self._name(figure)

    def _letter(self, figure: MapFigure) -> None:
        for x in ticks(float(figure.x[0]), float(figure.x[-1]), 5):
            self._letters.write(f"/map/x{x:g}", f"{x:g}".replace("-", "−"), self._at(x, float(figure.y[0]), down=0.06), "top-center")
        for y in ticks(float(figure.y[0]), float(figure.y[-1]), 4):
            self._letters.write(f"/map/y{y:g}", f"{y:g}".replace("-", "−"), self._at(float(figure.x[0]), y, left=0.06), "center-right")
        x, y, z = (CENTRE + self._up * (DEPTH / 2 - 0.2)).tolist()
        self._title = self._letters.write("/map/title", "", (x, y, z), "bottom-center")

    def fit(self, em: float) -> bool:
        """Write in letters as large as the window asks for; whether that changed anything."""
        return self._letters.resize(em * NEARER)

    def _at(self, x: float, y: float, left: float = 0.0, down: float = 0.0) -> tuple[float, float, float]:
        assert self._figure is not None
        (x0, x1), (y0, y1) = self._edges()
        point = (CENTRE + self._across * ((x - x0) / (x1 - x0) - 0.5) * WIDTH
                 + self._up * ((y - y0) / (y1 - y0) - 0.5) * DEPTH)
        point = point - left * self._across - down * self._up
        return float(point[0]), float(point[1]), float(point[2])

    def _edges(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The map's outer edges: half a cell beyond the first and last values."""
        assert self._figure is not None
        out = []
        for v in (self._figure.x, self._figure.y):
            half = (float(v[1]) - float(v[0])) / 2 if len(v) > 1 else 0.5
            out.append((float(v[0]) - half, float(v[-1]) + half))
        return out[0], out[1]

    def _clicked(self, origin: np.ndarray, ray: np.ndarray) -> None:
        normal = np.cross(self._across, self._up)
        slope = float(ray @ normal)
        if self._figure is None or abs(slope) < 1e-9:
            return
        hit = origin + ray * float((CENTRE - origin) @ normal) / slope - CENTRE
        (x0, x1), (y0, y1) = self._edges()
        x = x0 + (float(hit @ self._across) / WIDTH + 0.5) * (x1 - x0)
        y = y0 + (float(hit @ self._up) / DEPTH + 0.5) * (y1 - y0)
        self._pick(min(max(x, x0), x1), min(max(y, y0), y1))
