"""Draw the face of a pole board as one texture, which is cheap on a slow machine."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw

from ...colours import palette, rgb
from ...course.lesson import Board
from ..charts.axes import ticks

PANE_SIZE_PX = (1100, 860)  # pixels of the s-plane across and up
FINER = 2  # drawn this much larger first, so that edges come out smooth
DAMPINGS = (0.2, 0.5, 0.8)
Colour = tuple[int, int, int]


class BoardColours(NamedTuple):
    """The colours of a board: its glass, the unstable part, axes, grid, arcs, leaders."""

    glass: Colour
    unstable: Colour
    axis: Colour
    fine: Colour
    arc: Colour
    leader: Colour  # from a name to its mark


def board_colours(dark: bool) -> BoardColours:
    """Those by day or in the dark."""
    return BoardColours(*(rgb(palette(dark)[f"glass{role}"]) for role in ("", "-unstable", "-axis", "-grid", "-arc", "-leader")))


FINE_WIDTH, ARC_WIDTH, AXIS_WIDTH = 2, 3, 5  # pixels


def draw_board_texture(board: Board, margin: float, ink: BoardColours) -> np.ndarray:
    """The s-plane of a board (rows, columns, 3), with a margin that is this part of its height on every side.

    Grid, circles of equal |s|, rays of equal damping, the axes, and the unstable half shaded; for a plant in discrete time
    the unit circle, with all that lies outside of it shaded.
    """
    return _pane(board.re_low, board.re_high, board.im_high, margin, board.disc, ink)


@lru_cache(maxsize=32)
def _pane(re_low: float, re_high: float, im_high: float, margin: float, disc: bool, ink: BoardColours) -> np.ndarray:
    across, up = (FINER * side for side in PANE_SIZE_PX)
    face = Image.new("RGB", (across, up), ink.glass)
    pen = ImageDraw.Draw(face)

    def at(re: float, im: float) -> tuple[float, float]:
        return (re - re_low) / (re_high - re_low) * across, (1 - im / im_high) / 2 * up

    def line(a: tuple[float, float], b: tuple[float, float], colour: tuple[int, int, int], width: int) -> None:
        pen.line((at(*a), at(*b)), colour, FINER * width)

    if disc:
        pen.rectangle(((0, 0), (across, up)), ink.unstable)
        pen.ellipse((at(-1.0, 1.0), at(1.0, -1.0)), ink.glass)
    elif re_high > 0:
        pen.rectangle((at(max(0.0, re_low), im_high), (across, up)), ink.unstable)
    for re in ticks(re_low, re_high):
        line((re, -im_high), (re, im_high), ink.fine, FINE_WIDTH)
    for im in ticks(-im_high, im_high, 4):
        line((re_low, im), (re_high, im), ink.fine, FINE_WIDTH)
    if disc:
        pen.ellipse((at(-0.5, 0.5), at(0.5, -0.5)), None, ink.arc, FINER * ARC_WIDTH)
        pen.ellipse((at(-1.0, 1.0), at(1.0, -1.0)), None, ink.axis, FINER * AXIS_WIDTH)
    elif re_low < 0:
        for radius in ticks(0, abs(re_low), 4)[1:]:
            pen.arc((at(-radius, radius), at(radius, -radius)), 90, 270, ink.arc, FINER * ARC_WIDTH)
        for zeta in DAMPINGS:
            for sign in (-1, 1):
                line((0.0, 0.0), (re_low, -sign * re_low * math.sqrt(1 - zeta**2) / zeta), ink.arc, ARC_WIDTH)
    line((re_low, 0.0), (re_high, 0.0), ink.axis, AXIS_WIDTH)
    if re_low < 0 < re_high:
        line((0.0, -im_high), (0.0, im_high), ink.axis, AXIS_WIDTH)
    edge = round(margin * PANE_SIZE_PX[1])
    whole = Image.new("RGB", (PANE_SIZE_PX[0] + 2 * edge, PANE_SIZE_PX[1] + 2 * edge), ink.glass)
    whole.paste(face.reduce(FINER), (edge, edge))
    picture = np.asarray(whole)
    picture.setflags(write=False)
    return picture
