"""Paint values over the rows of a record: the space between two traces, a trace, dots."""

from __future__ import annotations

import numpy as np

from observer_lab.colours import COLOURS, rgb

COLUMNS, ROWS = 1040, 500  # pixels of the panel
HALF, FINE = 4, 8  # pixels to either side of the trace; places in a column at which it is read
FREE = 0.08  # of a picture's height, above and below
EXPECTED, TINT = "estimate", 0.35  # of a band of what is expected: role, share of its colour
GROUND, FITTED, RULED, RULES = "paper", "floor", "chart-grid", 20  # of the panel, of the part of the fit, of its rules; how many there are


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
