"""Draw the block with its sensor, and above it gains as tiles or a pair as bars."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from observer_lab.colours import COLOURS, rgb
from observer_lab.course.lesson import Stage
from observer_lab.plants.bodies.body import (
    DARK_GREY,
    PLANT_COLOUR,
    STEEL,
    Body,
    Box,
    Cylinder,
    ErrorMarks,
    Part,
    PartName,
    Pose,
    Quaternion,
    Rod,
    Vector,
    pose_between,
)
from observer_lab.plants.bodies.front_bars import share_of_decades, size_words
from observer_lab.plants.spring_damper import BLOCK_EDGE
from observer_lab.text import format_number, text, text_in

from .dual_quantities import Twins
from .knobs import BOTH, DUAL, MODEL, NOTHING, PAIR

DIAL, FACE, HAND = (1.86, 0.0, 0.98), -0.08, 0.25  # the middle of the dial, how far before it the pointer is, its length
BEAM_Z, POST_FOOT = 0.6, 0.12
FACING: Quaternion = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)  # turns an upright cylinder toward the viewer
SENSOR_PARTS = (
    Part("sensor post", Box((0.12, 0.14, DIAL[2] - POST_FOOT)), STEEL),
    Part("sensor dial", Cylinder(0.28, 0.08), DARK_GREY),
    Part("sensor pointer", Rod(0.045), COLOURS["lit"]),
    Part("sensor beam", Rod(0.016), COLOURS["lit"]),
)
STATES = 3  # of a record before all else: q, v and the sensor's angle
SIZE, TILE_PITCH, THIN = 0.58, 0.66, 0.08  # edge of a tile, from one to the next, its thickness
TOP, TILE_Y = 2.32, 0.5  # z of the upper tile of a column, y of the tiles
MIDDLE = TOP - TILE_PITCH / 2  # z of a row, and of the middle of a column
PLATE_BACK, PLATE_WIDE, PLATE_FOOT, PLATE_PAST = 0.07, 3.7, 1.18, 0.14  # behind the tiles; its width, z of its foot, past the tiles
ROW_AT, COLUMN_AT = -0.78, 1.22  # x of the first tile of a row, and of a column
BRACKET, LINE, BRACKET_TIP = 0.08, 0.035, 0.13  # from tiles to a bracket around them, its thickness, how long its tips are
NAME_BEFORE = 0.06  # from a bracket to the sign before it
HOP, BEHIND, UNSEEN = 0.15, 0.004, -9.0  # how far tiles come forward on their way, how far behind others they begin; out of sight
HALF_TURN_DEG = 45.0  # from which angle on a turning row is called a column
PAIR_DECADES = -2, 1  # of the bars of the pair
BAR_AT, BAR_LONG, BAR_PITCH, THICK = -0.5, 1.9, 0.4, 0.09  # where bars begin, three decades of them, to the next row; radius
BAR_TOP, NAME_AT, LEAST = 2.29, -0.62, 0.004  # z of the first bar; where the names of bars end; the least share that is drawn
PAIR_BARS = ((text("error, forward"), COLOURS["error"]), (text("dual state, backward"), COLOURS["second"]),
             (text("size of the product"), COLOURS["muted"]))
AS_K, AS_L = rgb(PLANT_COLOUR), rgb(COLOURS["estimate"])


def with_sensor(body: Body) -> Body:
    """The block with its sensor. After the two states a record holds the sensor's angle in rad: 0 measures q, a right angle v."""
    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        poses, turn = body.pose(x, gain), float(x[2])
        face = poses["block"].position[0] + BLOCK_EDGE / 2
        across, _, up = DIAL
        hub, tip = (across, FACE, up), (across + HAND * math.cos(turn), FACE, up + HAND * math.sin(turn))
        return {**poses, "sensor post": Pose((across, 0.0, (POST_FOOT + up) / 2)), "sensor dial": Pose(DIAL, FACING),
                "sensor pointer": pose_between(hub, tip), "sensor beam": pose_between((across, 0.0, BEAM_Z), (face, 0.0, BEAM_Z))}
    return replace(body, parts=(*body.parts, *SENSOR_PARTS), pose=pose,
                   labels=(("q", (DIAL[0] + 0.38, FACE, DIAL[2] + 0.08)), ("v", (DIAL[0], FACE, DIAL[2] + 0.46))),
                   names=(*body.names, PartName(text_in("stage", "sensor"), "sensor dial", (0.1, -0.6, -0.75))))


BODY = with_sensor(MODEL.body)
Tile = tuple[float, Vector, tuple[int, int, int]]  # its number, its place, its colour
Tiles = Callable[[Sequence[float]], tuple[Tile, ...]]
ROW: tuple[Vector, Vector] = ((ROW_AT, TILE_Y, MIDDLE), (ROW_AT + TILE_PITCH, TILE_Y, MIDDLE))
COLUMN: tuple[Vector, Vector] = ((COLUMN_AT, TILE_Y, TOP), (COLUMN_AT, TILE_Y, TOP - TILE_PITCH))


def _with_tiles(body: Body, tiles: Tiles, row: str, empty: bool = False) -> Body:
    """The body below a row in brackets, named `row`, and a column, which is L; the places of its tiles are pale while it is `empty`."""
    body, brackets, pale = _with_plate(body), {**_brackets("row", ROW), **_brackets("column", COLUMN)}, COLUMN if empty else ()
    fixed = {name: pose for name, (pose, _) in brackets.items()} | {f"place {k}": Pose(at) for k, at in enumerate(pale)}

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        found = {f"tile {k}": Pose(at, colour=colour) for k, (_, at, colour) in enumerate(tiles(x[STATES:]))}
        return {**body.pose(x, gain), **fixed, **found}

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        assert body.marks is not None
        before, drawn = body.marks(x, xhat, gain), tiles(x[STATES:])
        numbers = ((format_number(value, ".3g"), (at[0], at[1] - THIN, at[2] if _seen(at, drawn[:k]) else UNSEEN), "center-center")
                   for k, (value, at, _) in enumerate(drawn))
        signs = ((f"{name} =", (first[0] - SIZE / 2 - BRACKET - NAME_BEFORE, TILE_Y - THIN, MIDDLE), "center-right")
                 for name, (first, _) in ((row, ROW), ("L", COLUMN)))
        return ErrorMarks(before.bars, (*before.words, *signs, *numbers))

    parts = (*body.parts, *(Part(name, Box(size), DARK_GREY) for name, (_, size) in brackets.items()),
             *(Part(f"place {k}", Box((SIZE, THIN / 2, SIZE)), COLOURS["muted"], opacity=0.35) for k in range(len(pale))),
             *(Part(f"tile {k}", Box((SIZE, THIN, SIZE)), PLANT_COLOUR) for k in range(len(ROW) + len(COLUMN))))
    return replace(body, parts=parts, pose=pose, marks=marks)


def _seen(at: Vector, before: Sequence[Tile]) -> bool:
    """Whether no other tile lies before one."""
    return all(math.dist(at, other) > SIZE / 2 for _, other, _ in before)


def _brackets(name: str, tiles: Sequence[Vector]) -> dict[str, tuple[Pose, Vector]]:
    """The pieces of the brackets on both sides of tiles, each with its size."""
    high, low = (side(at[2] for at in tiles) + sign * (SIZE / 2 + LINE) for side, sign in ((max, 1), (min, -1)))
    found = dict[str, tuple[Pose, Vector]]()
    for end, (edge, sign) in {"left": (min(at[0] for at in tiles), -1), "right": (max(at[0] for at in tiles), 1)}.items():
        across = edge + sign * (SIZE / 2 + BRACKET)
        found[f"{name} {end}"] = Pose((across, TILE_Y, (low + high) / 2)), (LINE, LINE, high - low)
        for tip, z in (("top", high), ("foot", low)):
            found[f"{name} {end} {tip}"] = Pose((across - sign * (BRACKET_TIP - LINE) / 2, TILE_Y, z)), (BRACKET_TIP, LINE, LINE)
    return found


def _turning(tail: Sequence[float]) -> tuple[Tile, ...]:
    """The two entries of K_d and an angle in degrees. Their copies go from the row to the column as it grows to a right angle."""
    entries, turn = [float(v) for v in tail[:2]], math.radians(float(tail[2]))
    colour, gone = AS_L if float(tail[2]) >= HALF_TURN_DEG else AS_K, math.sin(turn)
    x, z = ROW_AT + (COLUMN_AT - ROW_AT) * gone, MIDDLE + (TOP - MIDDLE) * gone
    y = TILE_Y + BEHIND * math.cos(turn) - HOP * math.sin(2 * turn)
    second = x + TILE_PITCH * math.cos(turn), y, z - TILE_PITCH * math.sin(turn)
    return (*((v, at, AS_K) for v, at in zip(entries, ROW, strict=True)), (entries[0], (x, y, z), colour), (entries[1], second, colour))


def _both(tail: Sequence[float]) -> tuple[Tile, ...]:
    """K as a row and L as a column."""
    return tuple((float(v), at, colour) for v, at, colour in zip(tail, (*ROW, *COLUMN), (AS_K, AS_K, AS_L, AS_L), strict=False))


def _with_plate(body: Body) -> Body:
    """The body below an upright plate on a post."""
    high = TOP - PLATE_FOOT + SIZE / 2 + PLATE_PAST
    fixed = {"plate": Pose((0.0, TILE_Y + PLATE_BACK, PLATE_FOOT + high / 2)),
             "plate post": Pose((0.0, TILE_Y + 2 * PLATE_BACK, TOP / 2))}
    parts = Part("plate", Box((PLATE_WIDE, 0.04, high)), COLOURS["paper"]), Part("plate post", Box((0.1, 0.06, TOP)), STEEL)
    return replace(body, parts=(*body.parts, *parts), pose=lambda x, gain: {**body.pose(x, gain), **fixed})


def _pair_body() -> Body:
    """Bars on the plate: after the states come the shares of the decades now, then those at the start, which are pale."""
    body, count, rows = _with_plate(BODY), len(PAIR_BARS), [BAR_TOP - BAR_PITCH * k for k in range(len(PAIR_BARS))]

    def bars(name: str, shares: Sequence[float]) -> Mapping[str, Pose]:
        return {f"{name} {k}": pose_between((BAR_AT, TILE_Y, z), (BAR_AT + BAR_LONG * max(float(share), LEAST), TILE_Y, z))
                for k, (z, share) in enumerate(zip(rows, shares, strict=True))}

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        return {**body.pose(x, gain), **bars("bar", x[STATES:STATES + count]), **bars("begun", x[STATES + count:])}

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        assert body.marks is not None
        before = body.marks(x, xhat, gain)
        farther = [max(float(now), float(then)) for now, then in zip(x[STATES:STATES + count], x[STATES + count:], strict=True)]
        sizes = ((size_words(float(share), *PAIR_DECADES), (BAR_AT + BAR_LONG * end + 0.12, TILE_Y - THIN, z), "center-left")
                 for share, end, z in zip(x[STATES:], farther, rows, strict=False))
        names = ((name, (NAME_AT, TILE_Y - THIN, z), "center-right") for (name, _), z in zip(PAIR_BARS, rows, strict=True))
        return ErrorMarks(before.bars, (*before.words, *names, *sizes))

    return replace(body, pose=pose, marks=marks, parts=(
        *body.parts, *(Part(f"bar {k}", Rod(THICK), colour) for k, (_, colour) in enumerate(PAIR_BARS)),
        *(Part(f"begun {k}", Rod(1.25 * THICK), colour, opacity=0.3) for k, (_, colour) in enumerate(PAIR_BARS))))


@lru_cache(maxsize=8)
def body_of(tiles: str, turned: bool) -> Body:
    """The block with its sensor and what is shown beside it; `turned`: whether the row of K_d has become a column."""
    if tiles == DUAL:
        return _with_tiles(BODY, _turning, "K_d", not turned)
    if tiles == BOTH:
        return _with_tiles(BODY, _both, "K")
    return _pair_body() if tiles == PAIR else BODY


def shown_stage(stage: Stage, twins: Twins) -> Stage:
    """The stage of a run with the sensor as it is turned, and what the design shows beside the block."""
    design = twins.design
    tiles, degrees = design["tiles"], float(design["transposed"])
    constant = [math.radians(design["sensor"])]
    if tiles == DUAL:
        constant += [*twins.K_dual.ravel().tolist(), degrees]
    elif tiles == BOTH:
        constant += [*twins.K.ravel().tolist(), *twins.L.ravel().tolist()]
    if tiles == PAIR:  # both loops run over a window of their own
        stage = _until(stage, float(twins.pair.t[-1]))
    tail = np.tile(constant, (len(stage.t), 1))
    if tiles == PAIR:
        sizes = np.column_stack([np.linalg.norm(twins.pair.e, axis=1), np.linalg.norm(twins.pair.z, axis=1), np.abs(twins.pairing)])
        shares = share_of_decades(np.column_stack([np.interp(stage.t, twins.pair.t, size) for size in sizes.T]), *PAIR_DECADES)
        tail = np.hstack([tail, shares, np.tile(shares[0], (len(stage.t), 1))])
    return replace(stage, body=body_of(tiles if tiles in (DUAL, BOTH, PAIR) else NOTHING, tiles == DUAL and degrees >= HALF_TURN_DEG),
                   x=np.hstack([stage.x, tail]), xhat=None if stage.xhat is None else np.hstack([stage.xhat, tail]))


def _until(stage: Stage, end: float) -> Stage:
    """The stage of the run up to a time."""
    kept = slice(0, max(int(np.searchsorted(stage.t, end + 1e-9)), 2))
    return replace(stage, t=stage.t[kept], x=stage.x[kept], xhat=None if stage.xhat is None else stage.xhat[kept],
                   u=None if stage.u is None else stage.u[kept])
