"""Draw levels of J of the carts over Re s and Im s of a complex pair, and the rectangle of RLO."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import MapFigure
from observer_lab.course.lesson import Outcome
from observer_lab.text import Text, text

from .criterion import criterion_4
from .study import Story

REAL = np.linspace(-2.0, -0.2, 37)  # rad/s; the left end of the region never lies right of it
HIGH = np.linspace(0.1, 3.5, 35)  # beyond, J grows on
NEAR_END = 1e-9  # rad/s: a point of the grid this near to an end lies in the rectangle
TIMES = (1 - 1e-9, 1.1, 2.0)  # levels of J, in shares of the least J in the rectangle
EDGE = len(TIMES) + 1


def pair_map(outcome: Outcome[Story], tab: Text) -> MapFigure:
    """J in shares of its least value in the rectangle, the edge of the rectangle, and where the pair is now."""
    design, now = outcome.design, outcome.metrics["J"]
    x, y = np.meshgrid(REAL, HIGH)
    J = criterion_4(x + 1j * y, x - 1j * y, design).sum(axis=0)
    inside = ((x >= design["region_low"] - NEAR_END) & (x <= design["region_high"] + NEAR_END) & (y <= design["region_tall"] + NEAR_END))
    k = np.unravel_index(int(np.argmin(np.where(inside, J, np.inf) if inside.any() else J)), J.shape)
    values = np.searchsorted(np.array(TIMES) * J[k], J)
    around = np.zeros_like(inside)
    around[1:] |= inside[:-1]
    around[:, 1:] |= inside[:, :-1]
    values[around & ~inside] = EDGE
    said = (text("A pair in the rectangle has the least J near {re:.2g} ± {im:.2g}j, about {least:.3g}; now J is {now:.3g}.",
                 re=x[k], im=y[k], least=J[k], now=now) if inside.any() else
            text("The rectangle has no room for a pair: largest |Im s| is {tall:.2g}.", tall=design["region_tall"]))
    upper = outcome.poles["observer"][np.argmax(outcome.poles["observer"].imag)]
    return MapFigure("map", text("J over Re s and Im s of a pair"), REAL, HIGH, values,
                     ((text("less than the best in the rectangle"), "force"), (text("as the best, within 10 %"), "plant"),
                      (text("up to twice as much"), "second"), (text("more than that"), "metal"), (text("edge of the rectangle"), "error")),
                     "Re s [rad/s]", "Im s [rad/s]", (float(upper.real), float(upper.imag)) if upper.imag else None, said, tab)
