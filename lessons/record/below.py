"""Paint values over the rows of a record, and show below it what a filter says of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from observer_lab.colours import COLOURS, rgb
from observer_lab.engine.identification import FilteredRecord, RecordFit
from observer_lab.text import NO_WORDS, Text, text

from .fusion import EVERY
from .knobs import DEVIATION, ERROR, INNOVATIONS, VALUES

SHARE = 0.4  # of the panel's height
SPREADS, REACH = 2.0, 6.0  # standard deviations of an innovation: of the band, and of the upper edge as the fit has it
HEADROOM, MOST = 1.25, 10  # from the largest value to the upper edge; singular values that are shown
HIGHEST = 1.05  # a correlation that reaches the upper edge
RULE = 0.5  # how far the line at 0 goes toward white
COLUMNS, ROWS = 1040, 500  # pixels of the panel
HALF, FINE = 4, 8  # pixels to either side of the trace; places in a column at which it is read
FREE = 0.08  # of a picture's height, above and below
EXPECTED, TINT = "estimate", 0.35  # of a band of what is expected: role, share of its colour
GROUND, FITTED, RULED, RULES = "paper", "floor", "chart-grid", 20  # of the panel, of the part of the fit, of its rules; how many there are


@dataclass(frozen=True, eq=False)
class Line:
    """Values (n_t,) of the rows that judge, in the colour of a role."""

    values: np.ndarray
    role: str


@dataclass(frozen=True, eq=False)
class Below:
    """What the lower part of the panel shows: lines over the rows that judge before a band, or columns with an edge.

    ends: the values at its lower and upper edge. low, high: of the band (n_t,). columns: singular values, of which the model has the
    first `used` as states; `edge` is what noise alone would give.
    """

    name: Text
    share: float
    ends: tuple[float, float] = (0.0, 1.0)
    low: np.ndarray | None = None
    high: np.ndarray | None = None
    lines: Sequence[Line] = ()
    columns: Sequence[float] = ()
    used: int = 0
    edge: float = 0.0


NOTHING_BELOW = Below(NO_WORDS, 0.0)


def shown_below(kind: str, found: RecordFit, judged: FilteredRecord, errors: Sequence[np.ndarray],
                deviation: Callable[[], tuple[np.ndarray, float]]) -> Below:
    """What is shown of a fit and of the filter with the Q of the design.

    errors (n_t,): of the filter as it was fitted, of the one with this Q, and of the smoother if it is on. deviation: gives σ of the
    estimated output and its largest value with one sensor.

    No edge depends on the factor of Q or on the gate, so that the picture keeps its scale while those are moved.
    """
    if kind == INNOVATIONS:
        return _innovations(found, judged)
    if kind == ERROR:
        return _errors(errors)
    if kind == DEVIATION:
        return _deviation(len(judged.track.innovations) - judged.first, *deviation())
    if kind == VALUES:
        s = found.subspace
        return Below(text("singular values; line: noise alone"), SHARE, (0.0, HIGHEST), columns=s.singular_values[:MOST].tolist(),
                     used=len(s.A), edge=float(s.edge))
    return NOTHING_BELOW


def _innovations(found: RecordFit, judged: FilteredRecord) -> Below:
    """The innovations, y - ŷ, and the band ±2√S in which 95 % of them are expected."""
    first = judged.first
    away = SPREADS * np.sqrt(judged.track.S[first:, 0, 0])
    edge = REACH * float(np.sqrt(found.judged.track.S[-1, 0, 0]))
    return Below(text("innovations, edges ±{edge:.2g}", edge=edge), SHARE, (-edge, edge), -away, away,
                 (Line(np.nan_to_num(judged.track.innovations[first:, 0]), "dark"),))


def _errors(errors: Sequence[np.ndarray]) -> Below:
    """The error of the filter, and before it that of the smoother."""
    fitted, *errors = errors
    edge, roles = HEADROOM * float(np.abs(fitted).max()), ("second", "estimate")
    return Below(text("estimate less output, edges ±{edge:.2g}", edge=edge), SHARE, (-edge, edge),
                 lines=tuple(Line(each, role) for each, role in zip(errors, roles, strict=False)))


def _deviation(rows: int, sigma: np.ndarray, largest: float) -> Below:
    """σ of the estimated output in each row that judges, above 0: after the rows that were computed it repeats its last period."""
    edge = HEADROOM * largest
    sigma = np.concatenate([sigma, np.tile(sigma[-EVERY:], -(-rows // EVERY))])[:rows]
    return Below(text("σ of the estimate, 0 to {edge:.2g}", edge=edge), SHARE, (0.0, edge), lines=(Line(sigma, "estimate"),))


def paint_below(image: np.ndarray, below: Below, first: int, start: float) -> None:
    """Paint a band and lines over the rows that judge: those from `first` on, which begin at a share of the width."""
    def rows(values: np.ndarray) -> np.ndarray:
        return np.concatenate([np.zeros(first), values])
    low, high = below.ends
    inner = low + FREE * (high - low), high - FREE * (high - low)
    if below.low is not None and below.high is not None:
        paint(image, inner, rows(below.low), rows(below.high), start, band_colour())
    if below.low is not None or below.lines:
        level = np.zeros(2)
        paint(image, inner, level, level, start, paler("dark", RULE))
    for line in below.lines:
        paint(image, inner, rows(line.values), rows(line.values), start, np.array(rgb(COLOURS[line.role]), np.uint8))


def paler(role: str, share: float) -> np.ndarray:
    """A role's colour, by a share toward white."""
    return (np.array(rgb(COLOURS[role])) * (1 - share) + 255 * share).astype(np.uint8)


def band_colour() -> np.ndarray:
    """The estimate's colour, as it looks on paper."""
    return paler(EXPECTED, 1 - TINT)


def ruled(split: float) -> np.ndarray:
    """The panel's pixels before anything is painted: paper with upright rules, greyer over this share of the width from the left."""
    image = np.empty((ROWS, COLUMNS, 3), np.uint8)
    image[:] = rgb(COLOURS[GROUND])
    image[:, np.arange(1, RULES) * COLUMNS // RULES] = rgb(COLOURS[RULED])
    image[:, : round(split * COLUMNS)] = rgb(COLOURS[FITTED])
    return image


def row_of(image: np.ndarray, y: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """On which row of pixels values stand."""
    low, high = ends
    return ((high - y) / (high - low) * (1 - 2 * FREE) + FREE) * len(image)


def paint(image: np.ndarray, ends: tuple[float, float], low: np.ndarray, high: np.ndarray, start: float, colour: np.ndarray) -> None:
    """Fill the space between two traces of all rows of the record, or draw one, from a share of the width on."""
    count, left = len(low), round(start * COLUMNS)
    places = (np.arange(COLUMNS)[:, None] + np.linspace(0, 1, FINE)) / COLUMNS * (count - 1)
    samples = np.arange(count)
    top = row_of(image, np.interp(places, samples, high), ends).min(axis=1)
    foot = row_of(image, np.interp(places, samples, low), ends).max(axis=1)
    column = np.minimum(samples * COLUMNS // max(count - 1, 1), COLUMNS - 1)
    np.minimum.at(top, column, row_of(image, high, ends))
    np.maximum.at(foot, column, row_of(image, low, ends))
    rows = np.arange(len(image))[:, None]
    inside = (rows >= np.maximum(top.astype(int) - HALF, 0)) & (rows <= foot.astype(int) + HALF)
    inside[:, :left] = False
    image[inside] = colour
