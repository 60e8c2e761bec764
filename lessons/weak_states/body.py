"""Draw the platform with springs and sensors, one mode slowly, and singular values as columns."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from observer_lab.colours import COLOURS, rgb
from observer_lab.course.lesson import Stage
from observer_lab.plants.bodies.body import (
    BENCH,
    DARK_GREY,
    Arrow,
    Body,
    Box,
    ErrorMarks,
    Part,
    PartName,
    Pose,
    Rod,
    Vector,
    bound_displacement,
    pose_between,
)
from observer_lab.plants.bodies.deck_body import STAGE_SCALE, platform_body
from observer_lab.plants.bodies.score_board import with_score_board
from observer_lab.plants.platform.model import Parameters
from observer_lab.text import Text, format_number, text

from .balanced_platform import STATE_COUNT, Motion, Platform, believed, relative
from .study import RELATIVE, Ranks

NOMINAL = Parameters()
COLUMNS_FROM = STATE_COUNT + 4  # of a record
SWING_S, SWING_COUNT, FRAMES = 1.5, 4, 240  # s that one swing takes on the stage, swings, samples
REST, TRAVEL, LARGER = 0.55, 0.42, 1.3  # stage units of a test mass above its base plate, and how far it may swing; how large it is drawn
MAX_DRAWN_MOTION = np.array([3.6e-3, 3.6e-3, 16e-3, 2.2e-3, 2.2e-3])  # m, m, rad, m, m: how far a motion is drawn
PARTS = text("across"), text("height"), text("tilt"), text("left mass"), text("right mass")  # as `relative` has them
MOTION, LONG, LEAST_SHARE = "second", 0.62, 0.08  # the role of its arrows, stage units of the longest; a share that is drawn
ACROSS_AT, HEIGHT_AT, TILT_AT = (0.0, -0.3, 2.62), (-0.5, -0.8, 0.72), (1.5, -0.8, 1.42)  # where arrows begin; of tilt at both ends
NAMES_BESIDE = (0.0, 0.3), (-1.0, 0.0), (1.0, 0.06), (-1.0, 0.06), (1.0, 0.06)  # which side of its arrow and how high a name is
ASIDE, NAME_ASIDE = 0.34, 0.34  # stage units from a mass to its arrow, and from an arrow to its name
LOWEST = -18.0  # decades below the largest singular value: a column without height
HIGH, THICK = 0.62, 0.07  # stage units of the largest value's column, and its radius
BEGIN, PITCH = -0.9, 0.3  # x of the first column, and to the next
ROWS = ((-1.1, 0.4), (-1.4, 0.14))  # y of a row and the height of its step: controllability, observability
DEEP, LEFT, RIGHT = 0.3, -2.5, 2.1  # of a step
ROLES = ("force", "plant")  # of columns that count
NAMES = text("controllability"), text("observability")
BELOW = rgb(COLOURS["muted"])  # a column that does not count
PLATE = 0.02
FULL_ERROR = 2e-4  # of a full bar of the board
ERRORS_AT = text("at 0.01 Hz"), text("at the last pair")  # its rows: the lowest frequency, and that of the weakest motion
MARK_ABOVE, MARK_ON_DECK = 0.24, (0.0, -0.75, 1.34)  # stage units from a test mass to its question mark; that of the deck


@lru_cache(maxsize=256)
def _placed(a: float, s: float, h: float) -> Body:
    return platform_body(a, NOMINAL.b, s, h)


def _pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
    a, s, h, mu = x[STATE_COUNT:COLUMNS_FROM]
    poses = dict(_placed(a, s, h).pose(x[:STATE_COUNT], gain))
    size = LARGER * min(max((mu / NOMINAL.mu) ** (1 / 3), 0.6), 1.4)
    for side, sign, place in (("left", -1.0, x[3]), ("right", 1.0, x[4])):
        foot, ball = poses[f"servo {side}"].position, poses[f"test mass {side}"]
        apart = [b - f for b, f in zip(ball.position, foot, strict=True)]
        rise = bound_displacement((place - x[1] - sign * s * x[2]) * STAGE_SCALE * gain, TRAVEL)
        longer = (REST + rise) / math.hypot(*apart)
        there = (foot[0] + longer * apart[0], foot[1] + longer * apart[1], foot[2] + longer * apart[2])
        poses[f"test mass {side}"] = replace(ball, position=there, scale=(size, size, size))
        poses[f"servo {side}"] = pose_between(foot, there)
    return {**poses, **rank_poses(x[COLUMNS_FROM:])} if len(x) > COLUMNS_FROM else poses


_BASE = _placed(NOMINAL.a, NOMINAL.s, NOMINAL.h)
BODY = Body(
    tuple(replace(part, colour=DARK_GREY) if part.name.startswith("test mass") else part for part in _BASE.parts),
    _pose,
    lambda x, u, gain: (),
    lambda x, gain: _placed(*x[STATE_COUNT : STATE_COUNT + 3]).anchors(x[:STATE_COUNT], gain),
    20.0,
    text("Deck with its sensors; the dark balls are their test masses"),
    names=(PartName(text("test mass of a sensor"), "test mass left", (-0.4, -0.2, 0.6)),
           PartName(text("deck"), "deck", (0.3, -0.2, -0.4), at=(0.0, -0.65, 0.0)),
           PartName(text("ghost: the smaller model"), "payload lid", (0.9, -0.3, 0.4), True)),
    ghost="dimmed",
)


def motion_shares(p: Parameters, motion: Motion) -> np.ndarray:
    """How far and which way each part swings (5,), the farthest 1, in the order of PARTS."""
    return shares_of(p, _begun(p, motion))


def shares_of(p: Parameters, states: np.ndarray) -> np.ndarray:
    """How far and which way each part is from its rest (5,), in shares of MAX_DRAWN_MOTION, in the order of PARTS."""
    return np.real(relative(p, states) / MAX_DRAWN_MOTION)


def _begun(p: Parameters, motion: Motion) -> np.ndarray:
    """The motion's shape as the stage begins it: its largest part, the first of equals on every machine, at MAX_DRAWN_MOTION."""
    parts = relative(p, motion.shape) / MAX_DRAWN_MOTION
    return motion.shape / parts[np.argmax(np.abs(parts) > 0.999 * np.abs(parts).max())]


def _beside_masses(record: Sequence[float]) -> tuple[Vector, Vector]:
    """Where the arrows of the test masses begin: outside each of them as it rests."""
    poses = _pose([0.0] * STATE_COUNT + list(record), 1.0)
    left, right = (poses[f"test mass {side}"].position for side in ("left", "right"))
    return (left[0] - ASIDE, left[1], left[2]), (right[0] + ASIDE, right[1], right[2])


def _arrows(shares: Sequence[float], record: Sequence[float]) -> tuple[tuple[Arrow, ...], ...]:
    """The arrows of each part, as long as its share and pointing where it goes at one moment."""
    across, height, tilt, left, right = (LONG * share for share in shares)
    def along(at: Vector, x: float, z: float) -> Arrow:
        return Arrow(at, (at[0] + x, at[1], at[2] + z), MOTION)
    beside = _beside_masses(record)
    return ((along(ACROSS_AT, across, 0.0),), (along(HEIGHT_AT, 0.0, height),),
            tuple(along((side * TILT_AT[0], *TILT_AT[1:]), 0.0, side * tilt) for side in (-1.0, 1.0)),
            (along(beside[0], 0.0, left),), (along(beside[1], 0.0, right),))


def _marked(p: Parameters, motion: Motion, columns: bool) -> Body:
    """The body with a name and an arrow for each part that swings in the motion; columns before it if they are wanted.

    An arrow is as long as its part is far from its rest, and points that way.
    """
    record = (p.a, p.s, p.h, p.mu)
    swings = np.abs(motion_shares(p, motion)) > LEAST_SHARE

    def arrows(x: Sequence[float], u: Sequence[float], gain: float) -> tuple[Arrow, ...]:
        now = shares_of(p, np.asarray(x[:STATE_COUNT], dtype=float))
        return tuple(arrow for each in _arrows(np.where(swings, now, 0.0).tolist(), record) for arrow in each)
    tails = [each[-1].tail for each in _arrows((0.0,) * len(PARTS), record)]
    labels = tuple((name, (tail[0] + side * NAME_ASIDE, tail[1], tail[2] + up))
                   for name, tail, swinging, (side, up) in zip(PARTS, tails, swings, NAMES_BESIDE, strict=True) if swinging)
    before, names = (rank_parts(STATE_COUNT), rank_labels()) if columns else ((), ())
    return replace(BODY, parts=(*BODY.parts, *before), arrows=arrows, labels=(*labels, *names))


def _asked(p: Parameters) -> Body:
    """The body at rest with a question mark at each test mass and at the deck."""
    poses = _pose([0.0] * STATE_COUNT + [p.a, p.s, p.h, p.mu], 1.0)
    above = ((x, y, z + MARK_ABOVE) for x, y, z in (poses[f"test mass {side}"].position for side in ("left", "right")))
    asked = ErrorMarks((), tuple(("?", at, "bottom-center") for at in (*above, MARK_ON_DECK)))
    return replace(BODY, marks=lambda x, xhat, gain: asked)


def _measured(body: Body) -> Body:
    """The body behind a board with the error of the smaller model at two frequencies."""
    return with_score_board(body, COLUMNS_FROM, ERRORS_AT, text("error of the smaller model; full bar: 2·10⁻⁴"),
                            lambda error: format_number(error, ".3g"), 0.02)


def slower(motion: Motion) -> float:
    """How many times slower the stage draws the motion than it is."""
    return motion.frequency * SWING_S


def swing(s: Platform, motion: Motion, order: int, columns: np.ndarray, errors: Sequence[float] = (), rest: bool = False) -> Stage:
    """The motion undamped, one swing in SWING_S seconds; its largest part begins at MAX_DRAWN_MOTION. The ghost is the model's.

    `columns` are the singular values and tolerances before the deck, none if it is empty. `errors` are those of the model on a board,
    if any. At `rest` the deck stands still and asks what moves.
    """
    p = s.parameters
    shape = (0.0 if rest else 1.0) * _begun(p, motion)
    t = np.linspace(0.0, SWING_S * SWING_COUNT, FRAMES + 1)
    turning = np.exp(2j * np.pi * t / SWING_S)[:, None]
    shares = [] if not len(errors) else [*(each / FULL_ERROR for each in errors), *errors]
    fixed = np.tile([p.a, p.s, p.h, p.mu, *columns, *shares], (len(t), 1))
    true, guess = (np.real(turning * v) for v in (shape, believed(s, order, shape)))
    body = _asked(p) if rest else _marked(p, motion, len(columns) > 0)
    return Stage(_measured(body) if len(errors) else body, t, np.hstack([true, fixed]), np.hstack([guess, fixed]), np.zeros((len(t), 1)))


def share(s: Platform, motion: Motion, order: int) -> float:
    """How much of the motion a model of `order` states holds: 1 if all of it."""
    p, held = s.parameters, believed(s, order, motion.shape)
    true, guess = (relative(p, v) / MAX_DRAWN_MOTION for v in (motion.shape, held))
    return float(np.linalg.norm(guess) / np.linalg.norm(true))


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
