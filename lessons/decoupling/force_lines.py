"""Draw on the stage of the deck the force of the side spring and the line of the coil."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from observer_lab.plants.bodies.body import Arrow, Body, ErrorMarks, force_arrow
from observer_lab.plants.bodies.deck_body import DECK_HALF_WIDTH, FULL_FORCE_N, PLANE, RIGHTWARD, STAGE_SCALE, THICK
from observer_lab.plants.platform import model
from observer_lab.text import format_number

COIL, SIDE_FORCE, LOWER = 2, 5, 10  # places: of the coil's arrow, of the spring's force in the inputs, of the offset in the state
OFFSET_DRAWN = 5.0  # times that the coil's offset is drawn larger: millimetres on a deck of half a metre
BELOW = 0.0, 0.0, -9.0  # out of sight
WORDS_AT = DECK_HALF_WIDTH + 0.1, -0.72, PLANE + 0.36


def side_spring(x: np.ndarray, ground: np.ndarray) -> np.ndarray:
    """Force (n_t,) in N of the horizontal spring and its damper on the deck; x (n_t, 10), ground (n_t, 2) vertical and horizontal in m.

    The ground is held from one sample to the next, so at a sample the deck and its coils have felt the ground of the sample before.
    """
    k = model.Parameters()
    felt = np.concatenate([[0.0], ground[:-1, 1]])
    return k.kx * (felt - x[:, 0] - k.h * x[:, 2]) - k.cx * (x[:, 5] + k.h * x[:, 7])


def with_force_lines(body: Body, times: float) -> Body:
    """The deck with its spring's force, drawn `times` larger, and the coil's arrow as far below that line as the coil is."""
    def drop(x: Sequence[float]) -> float:
        return OFFSET_DRAWN * STAGE_SCALE * float(x[LOWER])

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        drawn = list(body.arrows(x, u[:SIDE_FORCE], gain))
        coil, lower = drawn[COIL], drop(x)
        drawn[COIL] = replace(coil, tail=(*coil.tail[:2], coil.tail[2] - lower), head=(*coil.head[:2], coil.head[2] - lower))
        across, near, up = body.anchors(x, gain)[0]
        return (*drawn, force_arrow((across, near - 0.05, up - THICK / 2), RIGHTWARD, times * float(u[SIDE_FORCE]), FULL_FORCE_N,
                                    "disturbance"))

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        at = WORDS_AT if x[LOWER] else BELOW
        return ErrorMarks((), ((f"Δh = {format_number(1e3 * float(x[LOWER]), '.3g')} mm", at, "top-center"),))
    return replace(body, arrows=arrows, marks=marks)
