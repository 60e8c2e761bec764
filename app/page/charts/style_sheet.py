"""Write the page's style sheet, with variables for what changes."""

from __future__ import annotations

import math
from decimal import ROUND_HALF_UP, Decimal
from string import Template

from ...session.state.view import Picture
from .. import web


def sheet(lecture: bool, figures: tuple[str, ...] = (), numbers: bool = False) -> str:
    """The style element for the present state, with a veil over some figures and over the numbers."""
    sheets = ["viser_dom.css", "page.css", "guide.css", *(["lecture.css"] if lecture else []), *(["numbers.css"] if numbers else [])]
    also = [Template(web.file_text("veil.css")).substitute(figure=figure) for figure in figures]
    return "<style>" + "".join([web.style_rules(*sheets), *also]) + "</style>"


def sheet_of(picture: Picture) -> str:
    """The style element for a picture: veiled is what would answer while a prediction waits."""
    again = picture.lesson.again if picture.asks_second_prediction else None
    if picture.veiled:
        return sheet(picture.state.lecture, picture.lesson.veil, True)
    return sheet(picture.state.lecture, *(((), False) if again is None else (again.figures, again.numbers)))


def figure_class(figure: str) -> str:
    """What the class of a chart's curves ends with, so that the page finds the chart of a figure."""
    return f":{figure}:"


def clock(t: float, horizon: float, speed: float, caption: str, share: str = "", now: str = "") -> str:
    """The cursor in all time plots and the clock beside the transport, in one element; `share` and `now` stand for t if given."""
    share = share or fixed(t / horizon if horizon > 0 else 0.0, 4)
    return Template(web.file_text("clock.html")).substitute(
        share=share, now=now or fixed(t, clock_decimals(horizon)), horizon=f"{horizon:g}", speed=f"{speed:g}", caption=caption)


def fixed(value: float, decimals: int) -> str:
    """A number with so many decimals as a script of the page writes it: halfway between two it is the larger one."""
    return f"{Decimal(value).quantize(Decimal(1).scaleb(-decimals), ROUND_HALF_UP):f}"


def clock_decimals(horizon: float) -> int:
    """How many decimals of a second the clock of a run shows."""
    return 2 if horizon >= 2 or horizon <= 0 else 2 - math.floor(math.log10(horizon))
