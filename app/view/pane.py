"""The face of a pole board as a picture: one texture costs a slow machine far less than a hundred lines in the scene."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from PIL import Image, ImageDraw

from ..lesson.lesson import Board
from .ticks import ticks

SIZE = (1100, 860)  # pixels of the s-plane across and up
FINER = 2  # drawn this much larger first, so that edges come out smooth
DAMPINGS = (0.2, 0.5, 0.8)
GLASS, UNSTABLE, INK = (255, 255, 255), (246, 214, 214), (40, 44, 52)
FINE, ARC = (214, 220, 229), (172, 184, 202)
FINE_WIDTH, ARC_WIDTH, AXIS_WIDTH = 2, 3, 5  # pixels


def pane(board: Board, margin: float) -> np.ndarray:
    """The s-plane of a board (rows, columns, 3), with a margin that is this part of its height on every side.

    Grid, circles of equal |s|, rays of equal damping, the axes, and the unstable half shaded; for a plant in discrete time
    the unit circle, with all that lies outside of it shaded.
    """
    return _pane(board.re_low, board.re_high, board.im_high, margin, board.disc)


@lru_cache(maxsize=32)
def _pane(re_low: float, re_high: float, im_high: float, margin: float, disc: bool) -> np.ndarray:
    across, up = (FINER * side for side in SIZE)
    face = Image.new("RGB", (across, up), GLASS)
    pen = ImageDraw.Draw(face)

    def at(re: float, im: float) -> tuple[float, float]:
        return (re - re_low) / (re_high - re_low) * across, (1 - im / im_high) / 2 * up

    def line(a: tuple[float, float], b: tuple[float, float], colour: tuple[int, int, int], width: int) -> None:
        pen.line((at(*a), at(*b)), colour, FINER * width)

    if disc:
        pen.rectangle(((0, 0), (across, up)), UNSTABLE)
        pen.ellipse((at(-1.0, 1.0), at(1.0, -1.0)), GLASS)
    elif re_high > 0:
        pen.rectangle((at(max(0.0, re_low), im_high), (across, up)), UNSTABLE)
    for re in ticks(re_low, re_high):
        line((re, -im_high), (re, im_high), FINE, FINE_WIDTH)
    for im in ticks(-im_high, im_high, 4):
        line((re_low, im), (re_high, im), FINE, FINE_WIDTH)
    if disc:
        pen.ellipse((at(-0.5, 0.5), at(0.5, -0.5)), None, ARC, FINER * ARC_WIDTH)
        pen.ellipse((at(-1.0, 1.0), at(1.0, -1.0)), None, INK, FINER * AXIS_WIDTH)
    elif re_low < 0:
        for radius in ticks(0, abs(re_low), 4)[1:]:
            pen.arc((at(-radius, radius), at(radius, -radius)), 90, 270, ARC, FINER * ARC_WIDTH)
        for zeta in DAMPINGS:
            for sign in (-1, 1):
                line((0.0, 0.0), (re_low, -sign * re_low * math.sqrt(1 - zeta**2) / zeta), ARC, ARC_WIDTH)
    line((re_low, 0.0), (re_high, 0.0), INK, AXIS_WIDTH)
    if re_low < 0 < re_high:
        line((0.0, -im_high), (0.0, im_high), INK, AXIS_WIDTH)
    edge = round(margin * SIZE[1])
    whole = Image.new("RGB", (SIZE[0] + 2 * edge, SIZE[1] + 2 * edge), GLASS)
    whole.paste(face.reduce(FINER), (edge, edge))
    picture = np.asarray(whole)
    picture.setflags(write=False)
    return picture
