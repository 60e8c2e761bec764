"""Draw the deck, and above it the 2σ ellipsoids of its velocities before and after one sample.

The record that the stage plays is the deck's state (6), then three ellipsoids of seven numbers: half axes (3) in stage units,
rotation (w, x, y, z). Right v_x, away ω, up v_z.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import Rotation

from observer_lab.colours import COLOURS
from observer_lab.plants.bodies.body import STEEL, Ball, Body, Part, PartName, Pose, Rod, Vector, pose_between
from observer_lab.text import text

from .knobs import MODEL

STATE_COUNT = 6
VELOCITY_INDEX = (3, 5, 4)  # v_x to the right, ω away from the viewer, v_z up
ELLIPSOIDS = ("last", "prediction", "estimate")
NUMBERS = 7  # of one ellipsoid
HUNG_AT: Vector = (0.0, 0.0, 2.8)  # stage units: where the ellipsoids hang
LONGEST, LEAST = 0.7, 0.02  # stage units: half axes are drawn no longer and no shorter
SETTLED = 0.36  # stage units: half axes of the settled prediction of a filter with the right Q and R
ARM = 0.74  # stage units: half length of an axis

PARTS = (
    Part("last", Ball(1.0), COLOURS["muted"]),
    Part("estimate", Ball(1.0), COLOURS["estimate"]),
    Part("prediction", Ball(1.0), COLOURS["disturbance"], opacity=0.4),
    *(Part(f"axis {way}", Rod(0.01), STEEL) for way in ("right", "away", "up")),
)


def ellipsoids(last: np.ndarray, prior: np.ndarray, posterior: np.ndarray | None, settled: np.ndarray) -> np.ndarray:
    """The numbers that the stage shows: P(k−1), P⁻(k) and P(k) of the velocities, over the σ of a `settled` prediction.

    Before the sample, without `posterior`, the last estimate is drawn within the prediction; after it, the new estimate. All are
    smaller by one factor where one would be too large for the stage.
    """
    pick = np.ix_(VELOCITY_INDEX, VELOCITY_INDEX)
    size = np.sqrt(np.maximum(np.diag(settled)[list(VELOCITY_INDEX)], 1e-300))
    halves, turns = np.zeros((3, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))
    for i, P in enumerate((last if posterior is None else None, prior, posterior)):
        if P is not None:
            values, V = np.linalg.eigh(P[pick] / np.outer(size, size))
            V = V * np.sign(V[np.argmax(np.abs(V), axis=0), range(3)])  # their signs are the library's, the picture's are not
            halves[i] = np.sqrt(np.maximum(values, 0.0))
            turns[i] = Rotation.from_matrix(V * np.sign(np.linalg.det(V))).as_quat(canonical=True)[[3, 0, 1, 2]]
    return np.hstack([halves * min(SETTLED, LONGEST / halves.max()), turns]).ravel()


def _axis(way: Vector) -> Pose:
    low, high = (tuple(at + sign * ARM * d for at, d in zip(HUNG_AT, way, strict=True)) for sign in (-1, 1))
    return pose_between(low, high)  # type: ignore[arg-type]


AXES = MappingProxyType(
    {"axis right": _axis((1.0, 0.0, 0.0)), "axis away": _axis((0.0, 1.0, 0.0)), "axis up": _axis((0.0, 0.0, 1.0))})


def _ellipsoid(numbers: Sequence[float]) -> Pose:
    half = [float(h) for h in numbers[:3]]
    thick = tuple(max(h, LEAST) if any(half) else 1e-3 for h in half)
    return Pose(HUNG_AT, tuple(map(float, numbers[3:])), thick)  # type: ignore[arg-type]


def _deck() -> Body:
    deck = MODEL.body

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        tail = x[STATE_COUNT:]
        shown = {name: _ellipsoid(tail[NUMBERS * i:NUMBERS * (i + 1)]) for i, name in enumerate(ELLIPSOIDS)}
        return {**deck.pose(x[:STATE_COUNT], gain), **AXES, **shown}

    return replace(
        deck, parts=(*deck.parts, *PARTS), pose=pose, arrows=lambda x, u, gain: deck.arrows(x[:STATE_COUNT], u, gain),
        anchors=lambda x, gain: deck.anchors(x[:STATE_COUNT], gain),
        caption=text("Above the deck: expected errors (2σ) of the velocities at sample k; vx right, vz up, ω away"),
        names=(PartName(text("expected errors"), "estimate", (1.1, -0.2, 0.2)),
               *(name for name in deck.names if name.part != "seat left")))


DECK_BODY = _deck()
