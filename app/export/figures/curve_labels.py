"""Name curves directly where the name is clear of other curves, else in a legend."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.lines import Line2D
from matplotlib.transforms import Bbox

from .style import SMALL_PT

__all__ = ["label_curves"]

PLACES_PER_CURVE = 48  # places along a curve that are tried
LABEL_GAP_PX = 4.0  # pixels between a curve and its name
ALONE = 9.0  # pixels by which the nearest other curve must be farther away than the named one


@dataclass(frozen=True)
class _Place:
    clearance: float
    box: Bbox
    x: float
    y: float


def label_curves(axes: Axes, lines: list[Line2D]) -> bool:
    """Name every line that has a label (a name shared by several once). True if direct labels fitted all of them.

    A name stands where its box lies inside the axes, touches no curve and no other name, and the nearest curve is
    clearly its own. If one name finds no such place, all go to a legend, so that nobody has to guess.
    """
    named = [line for line in lines if not str(line.get_label()).startswith("_")]
    if not named or (len(named) == 1 and len(lines) == 1 and not named[0].get_label()):
        return True
    canvas = axes.figure.canvas
    if not isinstance(canvas, FigureCanvasAgg):
        raise TypeError("label_curves needs a figure on an Agg canvas.")
    renderer = canvas.get_renderer()
    inside = axes.get_window_extent(renderer).padded(-6)
    paths = [_pixels(line) for line in lines]
    taken: list[Bbox] = []
    chosen: list[tuple[Line2D, _Place]] = []
    for line in named:
        size = _size(axes, str(line.get_label()), renderer)
        own = lines.index(line)
        place = _best(paths, own, size, inside, taken)
        if place is None:
            _legend(axes, named, paths, inside)
            return False
        taken.append(place.box.padded(2))
        chosen.append((line, place))
    for line, place in chosen:
        x, y = axes.transAxes.inverted().transform((place.x, place.y))
        axes.text(float(x), float(y), str(line.get_label()), transform=axes.transAxes, color=line.get_color(),
                  fontsize=SMALL_PT, ha="left", va="bottom", zorder=6)
    return True


def _legend(axes: Axes, named: list[Line2D], paths: list[np.ndarray], inside: Bbox) -> None:
    """A legend in the corner that covers the fewest points of curves."""
    low, high = np.asarray(inside.min), np.asarray(inside.max)
    share = (np.vstack(paths) - low) / (high - low)
    corners: dict[Any, tuple[int, int]] = {"upper right": (1, 1), "upper left": (0, 1), "lower right": (1, 0),
                                           "lower left": (0, 0)}
    crowd = {name: int(np.count_nonzero((np.abs(share - corner) < (0.45, 0.3)).all(axis=1)))
             for name, corner in corners.items()}
    axes.legend(handles=named, loc=min(crowd, key=lambda name: crowd[name]), borderaxespad=0.3, labelspacing=0.25)


def _size(axes: Axes, label: str, renderer: object) -> tuple[float, float]:
    probe = axes.text(0, 0, label, fontsize=SMALL_PT)
    box = probe.get_window_extent(renderer)  # type: ignore[arg-type]
    probe.remove()
    return box.width, box.height


def _pixels(line: Line2D) -> np.ndarray:
    """The curve in pixels (n, 2), close points filled in, what is far outside held back."""
    points = line.get_transform().transform(np.column_stack(line.get_data()))
    points = np.clip(points[np.isfinite(points).all(axis=1)], -1e5, 1e5)
    if len(points) < 2:
        return points.reshape(-1, 2)
    steps = np.maximum(1, np.ceil(np.abs(np.diff(points, axis=0)).max(axis=1) / 3)).astype(int)
    steps = np.minimum(steps, 400)
    pieces = [a + np.linspace(0, 1, k, endpoint=False)[:, None] * (b - a)
              for a, b, k in zip(points[:-1], points[1:], steps, strict=True)]
    return np.vstack([*pieces, points[-1:]])


def _best(paths: list[np.ndarray], own: int, size: tuple[float, float], inside: Bbox,
          taken: list[Bbox]) -> _Place | None:
    width, height = size
    mine = paths[own]
    seen = mine[(mine[:, 0] >= inside.x0) & (mine[:, 0] <= inside.x1) & (mine[:, 1] >= inside.y0)
                & (mine[:, 1] <= inside.y1)]
    if not len(seen):
        return None
    others = [path for k, path in enumerate(paths) if k != own and len(path)]
    best = None
    for anchor in seen[np.unique(np.linspace(0, len(seen) - 1, PLACES_PER_CURVE).astype(int))]:
        for x, y in (
            (anchor[0] - width / 2, anchor[1] + LABEL_GAP_PX),
            (anchor[0] - width / 2, anchor[1] - LABEL_GAP_PX - height),
            (anchor[0] + LABEL_GAP_PX, anchor[1] + LABEL_GAP_PX),
            (anchor[0] + LABEL_GAP_PX, anchor[1] - LABEL_GAP_PX - height),
            (anchor[0] - LABEL_GAP_PX - width, anchor[1] + LABEL_GAP_PX),
            (anchor[0] - LABEL_GAP_PX - width, anchor[1] - LABEL_GAP_PX - height),
        ):
            box = Bbox.from_bounds(x, y, width, height)
            if box.x0 < inside.x0 or box.x1 > inside.x1 or box.y0 < inside.y0 or box.y1 > inside.y1:
                continue
            if any(box.overlaps(other) for other in taken):
                continue
            near = _distance(mine, box)
            clear = min((_distance(path, box) for path in others), default=60.0)
            if near < 1.0 or clear < near + ALONE:
                continue
            place = _Place(min(clear, 60.0) - 2 * near, box, x, y)
            if best is None or place.clearance > best.clearance + 1e-6:
                best = place
    return best


def _distance(path: np.ndarray, box: Bbox) -> float:
    """From a curve to a box in pixels; 0 if the curve enters it."""
    gap = np.maximum(np.maximum(box.min - path, path - box.max), 0.0)
    return float(np.hypot(gap[:, 0], gap[:, 1]).min())
