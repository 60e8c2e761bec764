"""Draw gauges as tracks with bands and needles, in the size of the print."""

from __future__ import annotations

import html

from ...colours import COLOURS, for_words
from ...course.figures.gauges import Gauge, GaugeFigure
from ...text import label_in_language
from .axes import W
from .text_layout import LARGE_PRINT_PX, WORDS_PX, fold_lines, text_width

TOP_PX, SIDE_PX, TRACK_PX, BETWEEN_PX = 30.0, 14.0, 13.0, 9.0  # px above the first gauge, beside it, of its track, to the next one
LINE_EM = 1.45  # letters from one line to the next
NEEDLE_PX = 7.0  # px, half of a needle or an arrow across


def gauges(figure: GaugeFigure, language: str, large: bool) -> tuple[str, float]:
    """The drawing and its height."""
    out, y, size = [], TOP_PX, LARGE_PRINT_PX if large else WORDS_PX
    for gauge in figure.gauges:
        drawn, high = _gauge(gauge, language, y, size)
        out.append(drawn)
        y += high + BETWEEN_PX
    return "".join(out), y


def _gauge(gauge: Gauge, language: str, top: float, size: float) -> tuple[str, float]:
    """One gauge from `top` down, and its height: words, track, ends of the band, and a verdict too long to stand beside the name."""
    line, across = LINE_EM * size, W - 2 * SIDE_PX
    name, verdict = gauge.name(language), gauge.verdict(language)
    value = label_in_language(gauge.value, language)
    beside = f"{value} · {verdict}"
    fits = text_width(f"{name}  {beside}", size) <= across
    out = [_words(SIDE_PX, top + size, name, "start"),
           _words(W - SIDE_PX, top + size, beside if fits else value, "end", f' fill="{_words_colour(gauge)}" font-weight="600"')]
    y = top + line
    low, high = (SIDE_PX + share * across for share in gauge.band)
    out.append(f'<rect x="{SIDE_PX}" y="{y:.1f}" width="{across}" height="{TRACK_PX}" rx="3" fill="{COLOURS["chart-grid"]}"/>'
               f'<rect x="{low:.1f}" y="{y:.1f}" width="{high - low:.1f}" height="{TRACK_PX}" fill="{COLOURS["right"]}" '
               f'fill-opacity="{0.12 if gauge.role == "muted" else 0.35}"/>')
    out.append(_needle(gauge, y + TRACK_PX / 2, across))
    y += TRACK_PX + size
    out += [_words(x, y + 1, said, "end" if share == 1 else "start" if share == 0 else "middle", f' fill="{COLOURS["dimmed"]}"')
            for x, share, said in zip((low, high), gauge.band, gauge.ends, strict=True)]
    y += line - size
    for said in [] if fits else fold_lines(verdict, across / size).split("\n"):
        out.append(_words(SIDE_PX, y + size, said, "start", f' fill="{_words_colour(gauge)}"'))
        y += line
    return "".join(out), y - top


def _needle(gauge: Gauge, y: float, across: float) -> str:
    """The needle of a number on the track, or an arrow at one end for a number outside."""
    if gauge.at is None:
        return ""
    x, colour, r = SIDE_PX + min(max(gauge.at, 0.0), 1.0) * across, COLOURS[gauge.role], NEEDLE_PX
    if 0 <= gauge.at <= 1:
        return (f'<rect class="ol-needle" x="{x - 2.5:.1f}" y="{y - r - 1.5:.1f}" width="5" height="{2 * r + 3:.1f}" rx="2.5" '
                f'fill="{colour}" stroke="{COLOURS["paper"]}"/>')
    way = 1 if gauge.at > 1 else -1
    return (f'<polygon class="ol-beyond" points="{x + 9 * way:.1f},{y:.1f} {x - 5 * way:.1f},{y - r:.1f} {x - 5 * way:.1f},{y + r:.1f}" '
            f'fill="{colour}" stroke="{COLOURS["paper"]}"/>')


def _words_colour(gauge: Gauge) -> str:
    return COLOURS["dimmed"] if gauge.role == "muted" else for_words(COLOURS[gauge.role])


def _words(x: float, y: float, said: str, anchor: str, more: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{more}>{html.escape(said)}</text>'
