"""Set the look of exported figures: thin axes, serif mathematics, the page's colours, caption lines."""

from __future__ import annotations

import re
import threading
import unicodedata
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any

import matplotlib

from ...colours import COLOURS
from ...course.figures.records import Curve, Dash
from .fonts import families

INK_COLOUR, RULE_COLOUR, GRID_COLOUR = (COLOURS[role] for role in ("print-ink", "print-rule", "print-grid"))
BODY_PT, SMALL_PT, TITLE_PT = 8.0, 7.0, 9.0  # pt
PRINT = 0.6  # points of a printed line for each pixel of a line on the screen
# in line widths
MATPLOTLIB_DASHES: Mapping[Dash, Any] = MappingProxyType({
    "solid": "-", "dash": (0, (4.5, 2.5)), "dot": (0, (1.0, 2.0)), "pin1": (0, (2.5, 2.5)), "pin2": (0, (11.0, 2.5)),
    "pin3": (0, (8.0, 2.5, 1.5, 2.5)), "pin4": (0, (5.0, 1.6, 1.6, 1.6, 1.6, 1.6))})

_LOCK = threading.Lock()  # matplotlib's settings belong to the process: one drawing at a time
NEVER_FIRST = "，。；：、！？）》”’,.;:!?)%"


@contextmanager
def export_style(language: str) -> Iterator[None]:
    """matplotlib set to our look for the time of one drawing; other threads wait."""
    settings: dict[Any, Any] = {
        "font.family": families(language), "font.size": BODY_PT, "mathtext.fontset": "stix", "axes.unicode_minus": True,
        "axes.linewidth": 0.5, "axes.edgecolor": RULE_COLOUR, "axes.labelcolor": INK_COLOUR, "text.color": INK_COLOUR,
        "axes.labelsize": BODY_PT, "axes.titlesize": TITLE_PT, "axes.titlelocation": "left", "axes.labelpad": 2.5,
        "axes.spines.top": False, "axes.spines.right": False, "axes.grid": False,
        "xtick.color": RULE_COLOUR, "ytick.color": RULE_COLOUR, "xtick.labelcolor": INK_COLOUR, "ytick.labelcolor": INK_COLOUR,
        "xtick.labelsize": SMALL_PT, "ytick.labelsize": SMALL_PT, "xtick.direction": "in", "ytick.direction": "in",
        "xtick.major.width": 0.5, "ytick.major.width": 0.5, "xtick.minor.width": 0.35, "ytick.minor.width": 0.35,
        "xtick.major.size": 3.0, "ytick.major.size": 3.0, "xtick.minor.size": 1.6, "ytick.minor.size": 1.6,
        "lines.scale_dashes": True, "lines.solid_capstyle": "round", "legend.frameon": False, "legend.fontsize": SMALL_PT,
        "legend.handlelength": 2.4, "path.simplify_threshold": 0.05,
        "svg.hashsalt": "observer-lab", "svg.fonttype": "path", "pdf.fonttype": 42, "pdf.compression": 9,
    }
    with _LOCK, matplotlib.rc_context(settings), warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph .* missing from")  # a letter that no installed font has is drawn as a box
        yield


def curve_style(curve: Curve) -> dict[str, Any]:
    """Colour, dashes and width of a curve, as keywords of `Axes.plot`."""
    return {"color": COLOURS[curve.role], "linestyle": MATPLOTLIB_DASHES[curve.dash], "linewidth": PRINT * curve.width}


def escape_mathtext(text: str) -> str:
    """A text as it stands, a dollar sign included: mathematics would take Chinese and index figures from it."""
    return text.replace("$", r"\$")


def text_width_em(text: str) -> float:
    """About how many em a text takes: 1 for a Chinese character, half of it for a Latin letter."""
    return sum(1.0 if unicodedata.east_asian_width(c) in "WF" else 0.0 if unicodedata.combining(c) else 0.5
               for c in text)


def wrap(text: str, em: float) -> list[str]:
    """The text in lines of at most `em` em, as far as its words allow."""
    lines, line = [], ""
    for piece in re.findall(r"[^\S\n]+|[\u2e80-\u9fff\uff00-\uffef“”]|[^\s\u2e80-\u9fff\uff00-\uffef“”]+", text):
        if line and text_width_em(line + piece.rstrip()) > em and piece[0] not in NEVER_FIRST:
            lines.append(line.rstrip())
            line = piece.lstrip()
        else:
            line += piece
    return [*lines, line.rstrip()] if line.strip() else lines
