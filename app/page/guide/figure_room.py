"""Estimate the room that the card of a scene leaves to its figure."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Sequence

from ...session.state.view import Picture
from ..charts.axes import ROW_HEIGHT_PX, TOP_PX, H, W
from ..charts.print_sizes import FRAME_PX, Sizes

ABOVE, BUTTONS, TO_DRAW, CAPTION = 92.0, 45.0, 70.0, 70.0  # px above the text; of the buttons; below a question, and another figure
TEXT_LINE, OPTION_LINE, OPTION_FRAME = 21.3, 18.4, 17.6  # px of a line; of an option around its lines
ACTION, KNOB, FORMULA, ALGEBRA_LINE = 16.0, 36.0, 46.0, 30.0  # px of an action around its lines; of a knob; of equations
LATIN, WIDE = 7.0, 14.6  # px of a letter and of a Chinese character
LOWEST, HIGHEST = 190.0, 420.0  # of a figure, whose width is `axes.W`
SILENT = re.compile(r"\\[a-zA-Z]+|[${}^_*]|\]\([^)]*\)|[\[\]]")  # what of a sentence takes no room of its own


def room_for_question(text: str, options: Sequence[str], sizes: Sizes) -> float:
    """The height of a question's figure below a text and options."""
    usual = sizes.question()
    if sizes.state.lecture or sizes.sheet:
        return usual
    wide = sizes.right - FRAME_PX
    used = ABOVE + BUTTONS + TO_DRAW + TEXT_LINE * _lines(text, wide)
    used += sum(OPTION_FRAME + OPTION_LINE * _lines(f"A {option}", wide - FRAME_PX) for option in options)
    return min(max(_free(used, wide, sizes), LOWEST + TOP_PX), usual)


def room_for_drawing(picture: Picture, sizes: Sizes) -> float:
    """The height of a plane or a map that is the only figure of a scene."""
    scene, words = picture.scene, picture.scene_words
    if sizes.state.lecture or sizes.sheet or scene is None or len(scene.figures) > 1:
        return sizes.drawing(len(scene.figures) if scene is not None else 1)
    wide = sizes.right - FRAME_PX
    used = ABOVE + BUTTONS + CAPTION + TEXT_LINE * _lines(words.text, wide)
    used += ACTION + TEXT_LINE * _lines(words.do, wide) if words.do else 0.0
    used += TEXT_LINE * _lines(words.say, wide) if words.say and scene.id in picture.state.done else 0.0
    used += KNOB * len(scene.knobs) + FORMULA * len(scene.formulas) + ALGEBRA_LINE * len(scene.lines)
    return min(max(_free(used, wide, sizes), float(H)), HIGHEST)


def _free(used: float, wide: float, sizes: Sizes) -> float:
    """What is left of the window's height, in the units of a drawing."""
    return round((sizes.state.window[1] - used) * W / wide - ROW_HEIGHT_PX)


def _lines(words: str, wide: float) -> int:
    """How many lines words take in a column so wide."""
    told = SILENT.sub("", words)
    across = sum(WIDE if unicodedata.east_asian_width(c) in "WF" else LATIN for c in told)
    return max(1, math.ceil(across / wide))
