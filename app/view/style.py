"""The page's own style: one sheet, variables for what changes."""

from __future__ import annotations

import math
from string import Template

from . import page


def sheet(lecture: bool, veiled: bool) -> str:
    """The style element for the present state."""
    sheets = ["page.css", *(["lecture.css"] if lecture else []), *(["veil.css"] if veiled else [])]
    return "<style>" + "".join(map(page.source, sheets)) + "</style>"


def clock(t: float, horizon: float, speed: float, caption: str, share: str = "", now: str = "") -> str:
    """The cursor in all time plots and the clock beside the transport, in one element; `share` and `now` stand for t if given."""
    share = share or f"{t / horizon if horizon > 0 else 0.0:.4f}"
    return Template(page.source("clock.html")).substitute(
        share=share, now=now or f"{t:.{digits_of(horizon)}f}", horizon=f"{horizon:g}", speed=f"{speed:g}", caption=caption)


def digits_of(horizon: float) -> int:
    """How many decimals of a second the clock of a run shows."""
    return 2 if horizon >= 2 or horizon <= 0 else 2 - math.floor(math.log10(horizon))
