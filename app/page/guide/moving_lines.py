"""Write lines of algebra that come one by one: terms light up, cancel or gather, a matrix turns over.

In a line `\\color{gone}{…}` is struck out once all lines that hold such a term have come, and `\\color{lit}{…}` lights up. A bracket grows
under `\\color{gather}{…}`: under terms that share a factor, then under what they become. `\\color{turn}{…}` turns over its diagonal, as a
transpose does. Where motion is unwanted the style sheet shows the last picture.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..words.prose import mathml

MARKS = ("gone", "lit", "gather", "turn")


def moving_lines(lines: Sequence[str]) -> str:
    """The lines as HTML, each with its place in the order; nothing for none."""
    if not lines:
        return ""
    cut = max((k + 1 for k, line in enumerate(lines) if "{gone}" in line), default=0)
    return f'<div class="ol-formula ol-moving" style="--cut:{cut}">' + "".join(
        f'<div style="--at:{k}">{_marked(mathml(line, True))}</div>' for k, line in enumerate(lines)) + "</div>"


def _marked(markup: str) -> str:
    """MathML whose marks have become classes of the style sheet."""
    for mark in MARKS:
        markup = markup.replace(f'mathcolor="{mark}"', f'class="ol-{mark}"')
    return markup
