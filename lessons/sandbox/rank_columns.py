"""Stand singular values as columns in place of a plant, the tolerance as a plate."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from observer_lab.colours import COLOURS, rgb
from observer_lab.engine.structure import Observability
from observer_lab.plants.bodies.body import BENCH, DARK_GREY, Body, Box, ErrorMarks, Part, Pose, Rod, Vector
from observer_lab.plants.bodies.gain_lanes import moved_back
from observer_lab.plants.bodies.own_body import MOST_IN_ROW
from observer_lab.text import format_number, same, text

from .analyses import Refusal

LOWEST, HIGH = -2.0, 1.75  # decades below the largest value: the foot of a column; stage units of the largest value's column
ZERO = -30.0  # decades that stand for a value of zero
LEFT, RIGHT, FLOOR = -2.25, 2.27, 0.2  # x of the step's ends, its height
NEAR, DEEP, WALL_Y, WALL, TOP = 0.12, 0.8, 0.54, 0.04, 2.4  # y of columns, depth of their step; y, thickness and top of the wall behind
FIRST, LONG, WIDEST, THICK = -1.2, 2.6, 0.87, 0.16  # x of the first column, to the last one at most; to the next at most; a column's radius
PLATE, PLATE_DEEP, BESIDE, LETTER = 0.03, 0.56, 0.34, 0.07  # thickness and depth of the plate; beyond the columns; half a letter
MARKS = ((same("1"), 0.0), (same("0.1"), -1.0), (same("0.01"), -2.0))
MARKS_AT = -1.8  # x of the marks' words
MOST_SIZES = 6  # columns whose sizes have room beside one another
COUNTS, BELOW = COLOURS["second"], rgb(COLOURS["muted"])  # a column that counts, one that does not
AWAY = Pose((0.0, 0.0, -9.0))  # out of sight


def columns_of(seen: Observability | Refusal, tolerance: float) -> np.ndarray | None:
    """Decades of the singular values over the largest (n,), then that of the tolerance; None where there are none to draw."""
    if isinstance(seen, Refusal) or len(seen.modes) > MOST_IN_ROW or seen.singular_values[0] <= 0:
        return None
    shares = np.append(seen.singular_values / seen.singular_values[0], tolerance)
    return np.log10(np.maximum(shares, 10.0 ** ZERO))


def high_of(decade: float) -> float:
    """How high a column is, in stage units: 0 at the lowest decade and below."""
    return HIGH * min(max(1 - decade / LOWEST, 0.0), 1.0)


def with_columns(body: Body, states: int, kept: Collection[str], up: float) -> Body:
    """A column for each state in place of the body; after its states comes what `columns_of` gives.

    Of the body's parts those that are `kept` stay, `up` higher.
    """
    pitch = min(LONG / max(states - 1, 1), WIDEST)
    across = [FIRST + pitch * k for k in range(states)]
    middle, thick = (across[0] + across[-1]) / 2, min(THICK, 0.35 * pitch)
    long = across[-1] - across[0] + 2 * BESIDE
    fixed = {"column step": Pose(((LEFT + RIGHT) / 2, NEAR, FLOOR / 2)), "column wall": Pose(((LEFT + RIGHT) / 2, WALL_Y, TOP / 2))}
    fixed |= {f"column mark {k}": Pose((middle, WALL_Y - WALL / 2, FLOOR + high_of(decade))) for k, (_, decade) in enumerate(MARKS)}

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        stays = {name: replace(each, position=moved_back(each.position, 0.0, up)) if name in kept else AWAY
                 for name, each in body.pose(x[:states], gain).items()}
        decades, tolerance = x[states:2 * states], float(x[2 * states])
        drawn = {f"column {k}": Pose((at, NEAR, FLOOR), scale=(1.0, 1.0, max(high_of(float(each)), 1e-3)),
                                     colour=rgb(COUNTS) if each > tolerance else BELOW)
                 for k, (at, each) in enumerate(zip(across, decades, strict=True))}
        drawn["tolerance"] = Pose((middle, NEAR, FLOOR + high_of(tolerance)))
        return {**stays, **fixed, **drawn}

    def sizes(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        decades, tolerance = x[states:2 * states], float(x[2 * states])
        tops: tuple[tuple[str, Vector, str], ...] = tuple(
            (format_number(10.0 ** float(each), ".3g"), (at, NEAR, FLOOR + high_of(float(each)) + 2 * PLATE), "bottom-center")
            for at, each in zip(across, decades, strict=True)) if states <= MOST_SIZES else ()
        beside = (across[-1] + BESIDE + LETTER, NEAR, FLOOR + high_of(tolerance))
        return ErrorMarks((), (*tops, (f"τ = {format_number(10.0 ** tolerance, '.2g')}", beside, "center-left")))

    parts = (*body.parts, Part("column step", Box((RIGHT - LEFT, DEEP, FLOOR)), BENCH),
             Part("column wall", Box((RIGHT - LEFT, WALL, TOP)), COLOURS["grey"]),
             *(Part(f"column mark {k}", Box((long, 0.01, 0.012)), DARK_GREY) for k in range(len(MARKS))),
             *(Part(f"column {k}", Rod(thick), COUNTS) for k in range(states)),
             Part("tolerance", Box((long, PLATE_DEEP, PLATE)), COLOURS["force"], opacity=0.6))
    labels = (*((name, (MARKS_AT, WALL_Y - WALL, FLOOR + high_of(decade) + LETTER)) for name, decade in MARKS),
              (text("singular values of O over the largest; plate: tolerance τ"), (middle, NEAR - DEEP / 2 - 0.08, 0.0)))
    return replace(body, parts=parts, pose=pose, labels=labels, marks=sizes, names=tuple(name for name in body.names if name.part in kept),
                   anchors=lambda x, gain: (AWAY.position,), arrows=lambda x, u, gain: ())
