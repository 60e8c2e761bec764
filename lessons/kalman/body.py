"""Draw the deck, and above it ellipsoids of a sample, errors or the gain.

A record is the deck's state (6), then ellipsoids of seven numbers: half axes (3) in stage units, rotation (w, x, y, z). Right v_x,
away ω, up v_z. One sample has three of them. The errors have two, then the dots (x, y, z) from their middle, then the ratio of the
RMS error to the stated σ. The gain has its size alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import Rotation

from observer_lab.colours import COLOURS
from observer_lab.plants.bodies.body import DARK_GREY, STEEL, Ball, Body, Box, ErrorMarks, Part, PartName, Pose, Rod, Vector, pose_between
from observer_lab.text import Text, format_number, text

from .knobs import ERRORS, GAIN, MODEL, STEP

STATE_COUNT = 6
VELOCITY_INDEX = (3, 5, 4)  # v_x to the right, ω away from the viewer, v_z up
NUMBERS = 7  # of one ellipsoid
HUNG_AT: Vector = (0.0, 0.0, 2.95)  # stage units: where the ellipsoids hang
LONGEST, LEAST = 0.7, 0.02  # stage units: half axes are drawn no longer and no shorter
SETTLED = 0.36  # stage units: half axes of the settled prediction of a filter with the right Q and R
ARM, FAR_ARM = 0.78, 2.2  # stage units: half length of an axis; the far half of the axis that points away
DOTS, FARTHEST = 42, 0.76  # errors that are drawn as dots; stage units: how far from the middle a dot is drawn at most
FOOT_Z, HIGH, MOST_HIGH, WIDE = 2.4, 0.32, 1.44, 0.42  # stage units: foot of the gains, height of a gain of 1, the highest, their width
SHELF, SHELF_Y, SHELF_DEEP, POST_X = 1.5, 1.2, 0.56, 0.6  # stage units: width of the shelf, how far behind the deck, its depth, its posts
GAIN_AT = (-0.36, 0.36)  # across: the gain of the right Q and R, and that of this filter
LEFT_NAME, RIGHT_NAME = (-1.2, 0.0, 2.62), (1.2, 0.0, 2.62)  # where names of shells hang, so that a line ends above each
HIDDEN: Vector = (0.0, 0.0, -9.0)

WAYS = ("right", "away", "up")
LAST = Part("last", Ball(1.0), COLOURS["muted"])
ESTIMATE = Part("estimate", Ball(1.0), COLOURS["estimate"])
PREDICTION = Part("prediction", Ball(1.0), COLOURS["disturbance"], opacity=0.4)
STATED = Part("estimate", Ball(1.0), COLOURS["estimate"], opacity=0.4)
ACTUAL = Part("actual", Ball(1.0), COLOURS["error"], opacity=0.25)
SHELLS = (LAST, PREDICTION, ESTIMATE)  # of one sample, in the order of the record


def ellipsoids(last: np.ndarray, prior: np.ndarray, posterior: np.ndarray | None, settled: np.ndarray) -> np.ndarray:
    """The numbers that the stage shows: P(k−1), P⁻(k) and P(k) of the velocities, over the σ of a `settled` prediction.

    Before the sample, without `posterior`, the last estimate is drawn within the prediction; after it, the new estimate. All are
    smaller by one factor where one would be too large for the stage.
    """
    pick = np.ix_(VELOCITY_INDEX, VELOCITY_INDEX)
    size = np.sqrt(np.maximum(np.diag(settled)[list(VELOCITY_INDEX)], 1e-300))
    found = np.array([ellipsoid(None if P is None else P[pick] / np.outer(size, size))
                      for P in (last if posterior is None else None, prior, posterior)])
    found[:, :3] *= min(SETTLED, LONGEST / found[:, :3].max())
    return found.ravel()


def ellipsoid(P: np.ndarray | None) -> np.ndarray:
    """Half axes and rotation (7,) of the ellipsoid xᵀP⁻¹x = 1, P 3×3; nothing of it without P."""
    if P is None:
        return np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    values, V = np.linalg.eigh(P)
    V = V * np.sign(V[np.argmax(np.abs(V), axis=0), range(3)])  # their signs are the library's, the picture's are not
    turn = Rotation.from_matrix(V * np.sign(np.linalg.det(V))).as_quat(canonical=True)[[3, 0, 1, 2]]
    return np.hstack([np.sqrt(np.maximum(values, 0.0)), turn])


def error_record(e: np.ndarray, stated: np.ndarray, settled: np.ndarray, first: int) -> np.ndarray:
    """The numbers of each sample (n_t, …) that show errors e (n_t, n) beside the `stated` P: both ellipsoids, the dots, the ratio.

    Errors count from the sample `first` on and stay. All of it is over the σ of a `settled` prediction.
    """
    index = list(VELOCITY_INDEX)
    size = np.sqrt(np.maximum(np.diag(settled)[index], 1e-300))
    e, P = e[:, index] / size, stated[np.ix_(index, index)] / np.outer(size, size)
    n_t, begun = len(e), np.arange(len(e)) - first + 1
    count = np.maximum(begun, 1)
    late = np.where((begun > 0)[:, None], e, 0.0)
    moments = np.cumsum(late[:, :, None] * late[:, None, :], axis=0) / count[:, None, None]
    ratio = np.sqrt(np.trace(np.linalg.solve(P, moments), axis1=1, axis2=2) / 3)
    shells = np.array([[ellipsoid(P), ellipsoid(moments[k] if begun[k] >= DOTS // 2 else None)] for k in range(n_t)])
    unit = min(SETTLED, LONGEST / shells[:, :, :3].max())
    shells[:, :, :3] *= unit
    at = np.linspace(first, n_t - 1, DOTS).astype(int)
    dots = e[at] * unit / 2  # a half axis is 2σ
    dots *= np.minimum(1.0, FARTHEST / np.maximum(np.linalg.norm(dots, axis=1), 1e-12))[:, None]
    shown = np.where((np.arange(n_t)[:, None] >= at)[:, :, None], dots, 0.0)
    return np.hstack([shells.reshape(n_t, -1), shown.reshape(n_t, -1), np.where(begun >= DOTS // 2, ratio, 0.0)[:, None]])


def _axis(way: Vector, far: float) -> Pose:
    low, high = (tuple(at + long * d for at, d in zip(HUNG_AT, way, strict=True)) for long in (-ARM, far))
    return pose_between(low, high)  # type: ignore[arg-type]


AXES = MappingProxyType({
    "axis right": _axis((1.0, 0.0, 0.0), ARM), "axis away": _axis((0.0, 1.0, 0.0), FAR_ARM), "axis up": _axis((0.0, 0.0, 1.0), ARM)})
AXIS_NAMES: tuple[tuple[Text | str, Vector], ...] = (
    ("vx", (ARM + 0.13, 0.0, HUNG_AT[2] + 0.08)), ("vz", (0.15, 0.0, HUNG_AT[2] + ARM + 0.04)),
    ("ω", (0.0, FAR_ARM, HUNG_AT[2] + 0.2)))


def _ellipsoid(numbers: Sequence[float]) -> Pose:
    half = [float(h) for h in numbers[:3]]
    thick = tuple(max(h, LEAST) if any(half) else 1e-3 for h in half)
    return Pose(HUNG_AT, tuple(map(float, numbers[3:])), thick)  # type: ignore[arg-type]


def _leader(start: Vector, numbers: Sequence[float]) -> Pose:
    """A line from a name to the surface of an ellipsoid, none where there is no ellipsoid."""
    half = np.maximum(np.asarray(numbers[:3], dtype=float), LEAST)
    if not np.any(numbers[:3]):
        return pose_between(HUNG_AT, HUNG_AT)
    way = np.subtract(start, HUNG_AT)
    turned = Rotation.from_quat(np.asarray(numbers)[[4, 5, 6, 3]]).inv().apply(way)
    end = np.array(HUNG_AT) + way / np.linalg.norm(turned / half)
    return pose_between(start, tuple(end.tolist()))  # type: ignore[arg-type]


Shown = Callable[[Sequence[float]], Mapping[str, Pose]]


def _above(parts: tuple[Part, ...], shown: Shown, labels: tuple[tuple[Text, Vector], ...], caption: Text, name: PartName,
           marks: Callable[[Sequence[float]], ErrorMarks] | None = None) -> Body:
    """The deck with parts above it, which `shown` poses from the numbers after the state."""
    deck = MODEL.body
    return replace(
        deck, parts=(*deck.parts, *parts), pose=lambda x, gain: {**deck.pose(x[:STATE_COUNT], gain), **shown(x[STATE_COUNT:])},
        arrows=lambda x, u, gain: deck.arrows(x[:STATE_COUNT], u, gain), anchors=lambda x, gain: deck.anchors(x[:STATE_COUNT], gain),
        caption=caption, labels=labels, names=(name, *(each for each in deck.names if each.part != "seat left")),
        marks=None if marks is None else lambda x, xhat, gain: marks(x[STATE_COUNT:]))


CROSS = tuple(Part(f"axis {way}", Rod(0.01), STEEL) for way in WAYS)
LINES = (Part("left line", Rod(0.008), DARK_GREY), Part("right line", Rod(0.008), DARK_GREY))
EXPECTED = PartName(text("expected errors"), "estimate", (-0.95, 0.0, 0.45))


def _step_body(updated: bool) -> Body:
    inner = 2 if updated else 0

    def shown(tail: Sequence[float]) -> Mapping[str, Pose]:
        each = [tail[NUMBERS * i:NUMBERS * (i + 1)] for i in range(len(SHELLS))]
        return {**AXES, **{part.name: _ellipsoid(numbers) for part, numbers in zip(SHELLS, each, strict=True)},
                "left line": _leader(LEFT_NAME, each[1]), "right line": _leader(RIGHT_NAME, each[inner])}

    return _above(
        (LAST, ESTIMATE, PREDICTION, *CROSS, *LINES), shown,
        ((text("prediction"), LEFT_NAME), (text("estimate") if updated else text("last estimate"), RIGHT_NAME), *AXIS_NAMES),
        text("Above the deck: expected errors (2σ) of the velocities at sample k; vx right, vz up, ω away"), EXPECTED)


def _errors_body() -> Body:
    first, size = 2 * NUMBERS, 3 * DOTS

    def shown(tail: Sequence[float]) -> Mapping[str, Pose]:
        stated, actual = tail[:NUMBERS], tail[NUMBERS:first]
        dots = {}
        for k in range(DOTS):
            away = [float(v) for v in tail[first + 3 * k:first + 3 * k + 3]]
            dots[f"error {k}"] = Pose((HUNG_AT[0] + away[0], HUNG_AT[1] + away[1], HUNG_AT[2] + away[2]) if any(away) else HIDDEN)
        return {**dots, **AXES, "estimate": _ellipsoid(stated), "actual": _ellipsoid(actual),
                "left line": _leader(LEFT_NAME, actual), "right line": _leader(RIGHT_NAME, stated)}

    def marks(tail: Sequence[float]) -> ErrorMarks:
        ratio = float(tail[first + size])
        return ErrorMarks((), ((f"RMS = {format_number(ratio, '.2g')} σ", (0.95, 0.0, 3.4) if ratio > 0 else HIDDEN, "center-left"),))

    return _above(
        (STATED, ACTUAL, *CROSS, *LINES, *(Part(f"error {k}", Ball(0.045), COLOURS["error"]) for k in range(DOTS))), shown,
        ((text("actual errors (2σ)"), LEFT_NAME), (text("stated (2σ)"), RIGHT_NAME), *AXIS_NAMES),
        text("Above the deck: stated and actual errors of the velocities; vx right, vz up, ω away"), EXPECTED, marks)


def _gain_body() -> Body:
    def bar(across: float, size: float) -> Pose:
        high = min(max(HIGH * size, LEAST), MOST_HIGH)
        return Pose((across, SHELF_Y, FOOT_Z + high / 2), scale=(1.0, 1.0, high))

    def shown(tail: Sequence[float]) -> Mapping[str, Pose]:
        return {"gain foot": Pose((0.0, SHELF_Y, FOOT_Z - 0.03)), "gain base": Pose((0.0, SHELF_Y, 0.03)),
                **{f"gain post {side}": Pose((sign * POST_X, SHELF_Y, FOOT_Z / 2)) for side, sign in (("left", -1.0), ("right", 1.0))},
                "right gain": bar(GAIN_AT[0], 1.0), "gain": bar(GAIN_AT[1], float(tail[0])),
                "gain mark": Pose((0.0, SHELF_Y + 0.2, FOOT_Z + HIGH))}

    def marks(tail: Sequence[float]) -> ErrorMarks:
        size = float(tail[0])
        return ErrorMarks((), ((f"× {format_number(size, '.3g')}", (GAIN_AT[1], SHELF_Y, FOOT_Z + 0.06 + min(HIGH * size, MOST_HIGH)),
                                "bottom-center"),))

    return _above(
        (Part("gain foot", Box((SHELF, SHELF_DEEP, 0.06)), STEEL), Part("gain base", Box((SHELF, SHELF_DEEP, 0.06)), DARK_GREY),
         *(Part(f"gain post {side}", Box((0.1, 0.1, FOOT_Z)), STEEL) for side in ("left", "right")),
         Part("right gain", Box((WIDE, 0.3, 1.0)), COLOURS["muted"]), Part("gain", Box((WIDE, 0.3, 1.0)), COLOURS["second"]),
         Part("gain mark", Box((SHELF, 0.03, 0.02)), DARK_GREY)), shown,
        ((text("steady gain, right Q and R"), (-1.6, SHELF_Y, FOOT_Z + 0.4)), (text("gain now"), (1.15, SHELF_Y, FOOT_Z + 0.3))),
        text("Above the deck: the size of the gain, over that of the steady gain for the right Q and R"),
        PartName(text("gain now"), "gain", (0.9, -0.2, 0.4)), marks)


@lru_cache(maxsize=4)
def body_of(above: str, updated: bool) -> Body:
    """The deck under what is shown above it; `updated`: whether the sample has been taken in."""
    return {STEP: lambda: _step_body(updated), ERRORS: _errors_body, GAIN: _gain_body}[above]()
