"""Write a question's figure into which a hand draws a prediction."""

from __future__ import annotations

import html
import json

from ...course.figures.records import PlaneFigure
from ...course.guiding.questions import DrawnQuestion
from .svg import axes_of_plane


def sketch_frame(question: DrawnQuestion, figure: PlaneFigure, drawn: str, high: float, language: str, key: str, how: str,
                 send: str) -> str:
    """The figure as it is `drawn`, open to a hand, with what to do and the button `send`; in this browser its name is `key`."""
    axes = axes_of_plane(figure, language, high)
    columns = [round(axes.at(x, 0.0)[0], 1) for x in question.columns]
    told = {"question": key, "columns": columns, "top": axes.frame.top, "foot": axes.frame.bottom, "bars": question.bars}
    name = html.escape(how, quote=True)
    inside = '<path class="ol-sketched" fill="none" d=""/><circle class="ol-caret" r="5"/></svg>'
    drawn = drawn.replace("</svg>", inside, 1).replace('role="img"', f'role="application" tabindex="0" aria-description="{name}"', 1)
    return (f'<div class="ol-sketch" data-sketch="{html.escape(json.dumps(told), quote=True)}">{drawn}<p class="ol-number">'
            f'<span class="ol-note">{name}</span>{send}</p></div>')
