"""Stand singular values before the deck as columns, with the tolerance as a plate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from observer_lab.colours import COLOURS, rgb
from observer_lab.plants.bodies.body import BENCH, Box, Part, Pose, Rod, Vector
from observer_lab.text import Text, text

from .study import RELATIVE, Ranks

LOWEST = -18.0  # decades below the largest singular value: a column without height
HIGH, THICK = 0.62, 0.07  # stage units of the largest value's column, and its radius
BEGIN, PITCH = -0.9, 0.3  # x of the first column, and to the next
ROWS = ((-1.1, 0.4), (-1.4, 0.14))  # y of a row and the height of its step: controllability, observability
DEEP, LEFT, RIGHT = 0.3, -2.5, 2.1  # of a step
ROLES = ("force", "plant")  # of columns that count
NAMES = text("controllability"), text("observability")
BELOW = rgb(COLOURS["muted"])  # a column that does not count
PLATE = 0.02


def rank_shares(r: Ranks, tolerance: float, measure: str) -> np.ndarray:
    """Heights of the columns (2n,), then of both plates: 0 to 1 over the decades below the largest value of a row."""
    rows = [values / values[0] for values in (r.reached, r.seen)]
    plates = [tolerance if measure == RELATIVE else tolerance / values[0] for values in (r.reached, r.seen)]
    decades = np.log10(np.maximum(np.concatenate([*rows, plates]), 10.0 ** LOWEST))
    return np.clip(1 - decades / LOWEST, 0.0, 1.0)


def rank_parts(count: int) -> tuple[Part, ...]:
    """Two steps with `count` columns each and a plate."""
    long = PITCH * count + 0.1
    return tuple(part for row, (_, high) in enumerate(ROWS) for part in (
        Part(f"rank step {row}", Box((RIGHT - LEFT, DEEP, high)), BENCH),
        *(Part(f"value {row} {k}", Rod(THICK), COLOURS[ROLES[row]]) for k in range(count)),
        Part(f"plate {row}", Box((long, 0.8 * DEEP, PLATE)), COLOURS["glass"], opacity=0.55)))


def rank_poses(shares: Sequence[float]) -> Mapping[str, Pose]:
    """Columns and plates at their heights; a column that ends below its plate is grey."""
    count = len(shares) // 2 - 1
    found: dict[str, Pose] = {}
    for row, (y, high) in enumerate(ROWS):
        plate = float(shares[2 * count + row])
        found[f"rank step {row}"] = Pose(((LEFT + RIGHT) / 2, y, high / 2))
        found[f"plate {row}"] = Pose((BEGIN + PITCH * (count - 1) / 2, y, high + HIGH * plate))
        for k, share in enumerate(shares[row * count:(row + 1) * count]):
            found[f"value {row} {k}"] = Pose((BEGIN + PITCH * k, y, high), scale=(1.0, 1.0, max(HIGH * float(share), 1e-3)),
                                             colour=rgb(COLOURS[ROLES[row]]) if share > plate else BELOW)
    return found


def rank_labels() -> tuple[tuple[Text | str, Vector], ...]:
    """The names of both rows, and what columns and plate are."""
    front = ROWS[-1][0] - DEEP / 2
    rows = ((name, ((LEFT + BEGIN - PITCH / 2) / 2, y - 0.1, high + 0.2)) for name, (y, high) in zip(NAMES, ROWS, strict=True))
    return (*rows, (text("singular values, 10⁻¹⁸ to 1; plate: tolerance"), (BEGIN + 1.5 * PITCH, front - 0.1, 0.0)))
