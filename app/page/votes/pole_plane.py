"""Draw a small complex plane: to place a pole on, or with the poles that a class has placed."""

from __future__ import annotations

import html
import json
import math

from ...classroom.answer_grids import PoleGrid, with_conjugate
from ...classroom.votes import Vote
from ...text import Text, format_number
from ..charts.axes import ticks
from ..words import phrases

WIDTH, HEIGHT = 320.0, 240.0  # of the plane in units of its drawing
LEFT, RIGHT, TOP, BOTTOM = 1.3, 3.1, 0.7, 1.9  # room around it, in letters of its numbers
LETTER = 12.0  # of a plane that has the whole width
ARM = 7.0  # half the width of a cross
DOT, LARGEST_DOT = 3.0, 12.0  # radii: of one pole, and of the place that most have chosen


def pole_words(pole: complex) -> str:
    """−4 ± 5j, or −2."""
    real = f"{pole.real + 0.0:.4g}".replace("-", "−")
    return real if pole.imag == 0 else f"{real} ± {abs(pole.imag):.4g}j"


def placing_html(vote: Vote, grid: PoleGrid, title: Text | None, language: str) -> str:
    """The plane on which a follower places a pole by tap, drag or arrow keys, the pole in words, and the button that sends it."""
    told = {"low": grid.re_low, "high": grid.re_high, "top": grid.im_high, "step": grid.step, "width": WIDTH, "height": HEIGHT}
    name = html.escape(phrases.POLE_PLANE(language), quote=True)
    head = "" if title is None else f'<figcaption>{html.escape(title(language))}</figcaption>'
    return (f'<figure class="ol-place" data-vote="{vote.number}" data-plane="{html.escape(json.dumps(told), quote=True)}">{head}'
            f'<p class="ol-note">{html.escape(phrases.PLACE_POLE_HOW(language))}</p>'
            f'{_plane(grid, _cross(1) + _cross(-1), f"""role="application" tabindex="0" aria-label="{name}" """, LETTER)}'
            f'<p class="ol-number"><output aria-live="polite">–</output><button type="button" class="ol-do" disabled '
            f'data-room="pole:{vote.number}">{html.escape(phrases.SEND(language))}</button></p></figure>')


def cloud_svg(vote: Vote, grid: PoleGrid, language: str, beside: int) -> str:
    """The poles that were placed as discs, larger where more have chosen the same place; so many planes stand beside each other."""
    cloud = vote.cloud
    most = max((count for _, count in cloud), default=1)
    discs = "".join(_disc(grid, each, count, most) for pole, count in cloud for each in with_conjugate(pole))
    said = ", ".join(f"{pole_words(pole)}: {count}" for pole, count in cloud)
    name = html.escape(f"{phrases.PLACED_POLES(language)} {said}".strip(), quote=True)
    return _plane(grid, discs, f'role="img" aria-label="{name}" ', LETTER * beside)


def _at(grid: PoleGrid, pole: complex) -> tuple[float, float]:
    """Where a pole stands in the drawing."""
    return (pole.real - grid.re_low) / (grid.re_high - grid.re_low) * WIDTH, (1 - pole.imag / grid.im_high) / 2 * HEIGHT


def _disc(grid: PoleGrid, pole: complex, count: int, most: int) -> str:
    x, y = _at(grid, pole)
    radius = DOT + (LARGEST_DOT - DOT) * math.sqrt((count - 1) / max(most - 1, 1))
    return f'<circle class="ol-placed" cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}"/>'


def _cross(sign: int) -> str:
    """A cross that stands nowhere yet; the upper one is the hand's, the lower one its conjugate."""
    return (f'<path class="ol-cross" data-sign="{sign}" visibility="hidden" '
            f'd="M{-ARM:g},{-ARM:g}L{ARM:g},{ARM:g}M{-ARM:g},{ARM:g}L{ARM:g},{-ARM:g}"/>')


def _plane(grid: PoleGrid, marks: str, given: str, letter: float) -> str:
    """Grid, axes and the part where a pole is unstable, under the marks."""
    zero_x, zero_y = _at(grid, 0j)
    out = [f'<rect class="ol-glass" width="{WIDTH:g}" height="{HEIGHT:g}"/>', _unstable(grid)]
    for re in ticks(grid.re_low, grid.re_high):
        x, _ = _at(grid, complex(re))
        out.append(f'<path class="ol-rule" d="M{x:.1f},0V{HEIGHT:g}"/>'
                   f'<text x="{x:.1f}" y="{HEIGHT + 1.3 * letter:g}" text-anchor="middle">{format_number(re, "g")}</text>')
    for im in ticks(-grid.im_high, grid.im_high, 4):
        _, y = _at(grid, complex(0, im))
        out.append(f'<path class="ol-rule" d="M0,{y:.1f}H{WIDTH:g}"/>')
        out.append(f'<text x="{WIDTH + 0.3 * letter:g}" y="{y + 0.35 * letter:.1f}">{format_number(im, "g")}j</text>' if im else "")
    out.append(f'<path class="ol-axis" d="M0,{zero_y:.1f}H{WIDTH:g}"/>')
    if grid.re_low < 0 < grid.re_high:
        out.append(f'<path class="ol-axis" d="M{zero_x:.1f},0V{HEIGHT:g}"/>')
    view = f"{-LEFT * letter:g} {-TOP * letter:g} {WIDTH + (LEFT + RIGHT) * letter:g} {HEIGHT + (TOP + BOTTOM) * letter:g}"
    return f'<svg class="ol-plane" viewBox="{view}" font-size="{letter:g}" {given}>{"".join(out)}{marks}</svg>'


def _unstable(grid: PoleGrid) -> str:
    """The right half, or in discrete time what lies outside the unit circle."""
    x, y = _at(grid, complex(max(grid.re_low, 0.0), grid.im_high))
    if not grid.disc:
        return f'<rect class="ol-unstable" x="{x:.1f}" y="{y:.1f}" width="{max(WIDTH - x, 0.0):.1f}" height="{HEIGHT:g}"/>'
    (left, top), (right, bottom) = _at(grid, complex(-1, 1)), _at(grid, complex(1, -1))
    return (f'<rect class="ol-unstable" width="{WIDTH:g}" height="{HEIGHT:g}"/><ellipse class="ol-glass" '
            f'cx="{(left + right) / 2:.1f}" cy="{(top + bottom) / 2:.1f}" rx="{(right - left) / 2:.1f}" ry="{(bottom - top) / 2:.1f}"/>')
