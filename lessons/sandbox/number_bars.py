"""Lay bars of gain, disk margin and NIS before a plant, an aircraft above it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from observer_lab.colours import COLOURS
from observer_lab.course.lesson import Stage
from observer_lab.plants import Model
from observer_lab.plants.bodies.body import (
    DARK_GREY,
    GHOST_NAME,
    METAL,
    PLANT_COLOUR,
    Ball,
    Body,
    Box,
    ErrorMarks,
    Part,
    PartName,
    Pose,
    Quaternion,
    Shape,
    Vector,
    bound_displacement,
)
from observer_lab.plants.bodies.front_bars import BEGIN, FIRST_Y, FLOOR, LONG, PITCH, STEP, THICK, Bar, share_of_decades, with_bars
from observer_lab.plants.bodies.gain_lanes import moved_back
from observer_lab.plants.bodies.own_body import LIT_COLOUR, rows_of
from observer_lab.plants.examples import example
from observer_lab.plants.own_plant import plant_of
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import format_number, same, text

from .analyses import Refusal, Trial, attempt, margins, trial
from .rank_columns import with_columns

LEAST_DECADES, ROOM, MOST_MARKS = (-1, 2), 3.0, 4  # of the bars, at least; times the start that has room; marks below them at most
RING = 0.05, 0.3  # along a bar and across it: the flat ring that shows where the bar ended at the start
RINGS_SAID, RINGS_SAID_AT = text("grey: before"), (-2.12, 0.08)  # across, and before the steps
FIRST_SENSOR, FIRST_BELIEF, FIRST_SEED = 0.01, 1.0, 1  # of the record of the start
MARGIN_STATES = 6  # of a plant whose disk margin is drawn; that of a larger one takes too long for a hand on a knob
BARS = (Bar(text("largest |L|"), COLOURS["second"]),
        Bar(text("disk margin"), COLOURS["force"]),
        Bar(text("NIS / expected"), COLOURS["error"]))
BEHIND, UP, ALL_BACK = 0.62, 0.36, 0.4  # stage units that the plant moves back and up, and then all of it back
NAMES_UP = 0.16, 0.1, 0.03  # stage units that the names of bars are lifted: on a phone there is room for all
NAME_DROP = 0.2  # stage units that a name is lifted less than the lamp of the first row is high
AROUND, ABOVE, PLATE_Y, PLATE = 0.34, 0.32, 0.3, 0.04  # stage units of the plate beside tubes and above lamps, back to it, its thickness
APART, MOST_APART, INPUT_NAME = 1.65, 1.22, 0.28  # stage units to which outer tubes move apart, at most so many times; from lamps to names
AIRCRAFT_Z, STEEPEST, BEND = 2.58, 0.7, 0.62  # height of the aircraft before it moves up; rad at the end of a tube, were it not bent
SIDESLIP, BANK = 0, 3  # of its states
ONE: Vector = (1.0, 1.0, 1.0)


@lru_cache(maxsize=16)
def body_of(model: Model) -> Body:
    """The plant's body behind the bars, its names high on the tubes, a plate behind them, the aircraft's above them."""
    low, high = decades_of(model)
    step = -(-(high - low) // (MOST_MARKS - 1))
    marks = tuple((same(format_number(10.0 ** k, ".3g")), (k - low) / (high - low)) for k in range(low, high + 1, step))
    barred = with_bars(_plant(model), model.plant.n, BARS, marks, BEHIND, UP, decades=(low, high))
    front = FIRST_Y - PITCH * (len(BARS) - 0.5)
    rings = {f"start {k}": Pose((BEGIN + LONG * share, FIRST_Y - PITCH * k, FLOOR + STEP * (len(BARS) - 1 - k) + THICK))
             for k, share in enumerate(share_of_decades(np.array(numbers_at_the_start(model)), low, high).tolist())}
    states, words = model.plant.n, barred.marks
    assert words is not None

    def sizes(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        """The numbers with three digits, where a bar does not end at either end of the scale."""
        found = words(x, xhat, gain).words
        exact = (format_number(10.0 ** (low + share * (high - low)), ".3g") if 0.0 < share < 1.0 else "" for share in x[states:])
        return ErrorMarks((), (*((size or word, at, side) for size, (word, at, side) in zip(exact, found, strict=False)),
                               *found[len(BARS):]))
    higher = {bar.name: up for bar, up in zip(BARS, NAMES_UP, strict=True)}
    barred = replace(barred, labels=(*((name, moved_back(at, 0.0, higher.get(name, 0.0))) for name, at in barred.labels),
                                     (RINGS_SAID, (RINGS_SAID_AT[0], front - RINGS_SAID_AT[1], 0.0))))
    pale = tuple(Part(name, Box((RING[0], RING[1], RING[1])), COLOURS["muted"], opacity=0.8) for name in rings)
    return _set_back(replace(barred, pose=lambda x, gain: {**barred.pose(x, gain), **rings}, parts=(*barred.parts, *pale),
                             marks=sizes), ALL_BACK)


@lru_cache(maxsize=16)
def ranked_body_of(model: Model) -> Body:
    """The singular values of the observability matrix in place of the plant, below the aircraft where it is one."""
    plant = _set_back(_plant(model), BEHIND + ALL_BACK)
    return with_columns(plant, model.plant.n, tuple(name for name, *_ in AIRFRAME), UP)


def _plant(model: Model) -> Body:
    """The plant's body with its names high on the tubes, a plate behind one row of them, and the aircraft where it is one."""
    body = model.body
    poses = body.pose([0.0] * model.plant.n, body.gain)
    top = poses["lamp 0"].position[2]
    tails = [arrow.tail for arrow in body.arrows([0.0] * model.plant.n, [1.0] * model.plant.m, body.gain)]
    inputs = tuple((signal_name(model.plant, name), (x, y, top + INPUT_NAME))
                   for name, (x, y, _) in zip(model.plant.input_names, tails, strict=False))
    high = replace(body, labels=(*((name, (x, y, z + top - NAME_DROP)) for name, (x, y, z) in body.labels), *inputs))
    if len(rows_of(model.plant.n)) == 1:
        high = _with_plate(_apart(high, poses), top + ABOVE)
    return with_aircraft(high) if is_aircraft(model) else high


def _apart(body: Body, poses: Mapping[str, Pose]) -> Body:
    """The body with few tubes farther apart, and lamps that are lit in a stronger colour."""
    outer = max(pose.position[0] for pose in poses.values())
    times = min(max(APART / outer, 1.0), MOST_APART) if outer > 0 else 1.0

    def aside(at: Vector) -> Vector:
        return times * at[0], at[1], at[2]

    lamps = tuple(replace(part, colour=COLOURS["lamp"]) if part.colour == LIT_COLOUR else part for part in body.parts)
    return replace(
        body, parts=lamps, labels=tuple((word, aside(at)) for word, at in body.labels),
        pose=lambda x, gain: {name: replace(each, position=aside(each.position)) for name, each in body.pose(x, gain).items()},
        arrows=lambda x, u, gain: tuple(replace(each, tail=aside(each.tail), head=aside(each.head)) for each in body.arrows(x, u, gain)),
        anchors=lambda x, gain: tuple(aside(at) for at in body.anchors(x, gain)))


def _set_back(body: Body, by: float) -> Body:
    """The body with all that belongs to it, farther from the viewer: its foot is in sight on a phone."""
    marks = body.marks

    def words(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        found = ErrorMarks((), ()) if marks is None else marks(x, xhat, gain)
        return ErrorMarks(tuple((moved_back(a, by), moved_back(b, by)) for a, b in found.bars),
                          tuple((word, moved_back(at, by), side) for word, at, side in found.words))

    return replace(
        body, marks=words, labels=tuple((word, moved_back(at, by)) for word, at in body.labels),
        pose=lambda x, gain: {name: replace(each, position=moved_back(each.position, by)) for name, each in body.pose(x, gain).items()},
        arrows=lambda x, u, gain: tuple(replace(each, tail=moved_back(each.tail, by), head=moved_back(each.head, by))
                                        for each in body.arrows(x, u, gain)),
        anchors=lambda x, gain: tuple(moved_back(at, by) for at in body.anchors(x, gain)))


def _with_plate(body: Body, top: float) -> Body:
    """The body with a dark plate behind its tubes, on which the glass is seen."""
    poses = body.pose([0.0] * len([part for part in body.parts if part.name.startswith("tube ")]), body.gain)
    places = [pose.position for name, pose in poses.items() if name.startswith("tube ")]
    low, high, y = min(x for x, *_ in places) - AROUND, max(x for x, *_ in places) + AROUND, places[0][1] + PLATE_Y
    plate = Pose(((low + high) / 2, y, top / 2))
    return replace(body, parts=(*body.parts, Part("plate", Box((high - low, PLATE, top)), COLOURS["grey"])),
                   pose=lambda x, gain: {**body.pose(x, gain), "plate": plate})


# --- the aircraft ------------------------------------------------------------------------------------------------------
AIRFRAME: tuple[tuple[str, Shape, Vector, Vector, str], ...] = (  # name, shape, its scale, place in it from behind: right, ahead, up
    ("fuselage", Ball(0.2), (1.0, 4.9, 1.0), (0.0, 0.0, 0.0), METAL), ("wings", Box((3.3, 0.5, 0.1)), ONE, (0.0, 0.15, 0.06), PLANT_COLOUR),
    ("tailplane", Box((1.05, 0.28, 0.07)), ONE, (0.0, -0.82, 0.54), PLANT_COLOUR),
    ("fin", Box((0.08, 0.38, 0.5)), ONE, (0.0, -0.78, 0.32), PLANT_COLOUR),
    ("canopy", Ball(0.13), (0.9, 2.2, 1.0), (0.0, 0.4, 0.14), DARK_GREY),
    ("left engine", Ball(0.13), (1.0, 2.4, 1.0), (-0.75, 0.2, -0.06), METAL),
    ("right engine", Ball(0.13), (1.0, 2.4, 1.0), (0.75, 0.2, -0.06), METAL))
GHOSTLY = ("fuselage", "wings")  # parts that the estimate has too


def is_aircraft(model: Model) -> bool:
    """Whether the plant is the aircraft that the lesson opens with."""
    first, plant = plant_of(example("aircraft")), model.plant
    return plant.state_names == first.state_names and np.array_equal(plant.A, first.A)


def with_aircraft(body: Body) -> Body:
    """The tubes below an aircraft, seen from behind: it has the bank angle, and its nose the sideslip, at the scale of their tubes."""
    def attitude(x: Sequence[float], gain: float) -> tuple[float, float]:
        rest, now = body.pose([0.0] * 4, gain), body.pose(x, gain)

        def angle(k: int) -> float:
            away = now[f"collar {k}"].position[2] - rest[f"collar {k}"].position[2]
            return STEEPEST * bound_displacement(away / (0.75 * rest["tube 0"].position[2]), BEND)
        return angle(SIDESLIP), angle(BANK)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        turn = _turned(*attitude(x, gain))
        return {**body.pose(x, gain), **{name: Pose(_moved(at, turn), turn, scale) for name, _, scale, at, _ in AIRFRAME}}

    named = (*(name for name in body.names if not name.ghost), PartName(GHOST_NAME, "wings", (0.4, -0.2, 0.35), True, (1.2, 0.0, 0.0)))
    airframe = tuple(Part(name, shape, colour, twin=name in GHOSTLY) for name, shape, _, _, colour in AIRFRAME)
    return replace(body, parts=(*body.parts, *airframe), pose=pose, names=named)


def _turned(sideslip: float, bank: float) -> Quaternion:
    """The turn of the nose to the left by the sideslip after the roll, right wing down, by the bank angle."""
    c, s, d, t = math.cos(sideslip / 2), math.sin(sideslip / 2), math.cos(bank / 2), math.sin(bank / 2)
    return (c * d, -s * t, c * t, s * d)


def _moved(at: Vector, turn: Quaternion) -> Vector:
    """Where a point of the aircraft is."""
    w, x, y, z = turn
    u, v = np.array([x, y, z]), np.array(at)
    across, ahead, up = (v + 2 * np.cross(u, np.cross(u, v) + w * v)).tolist()
    return across, ahead, up + AIRCRAFT_Z


@lru_cache(maxsize=64)
def _margin(model: Model, K: bytes, L: bytes) -> float:
    n, m, p = model.plant.n, model.plant.m, model.plant.p
    found = attempt(lambda: margins(model.plant, np.frombuffer(K).reshape(m, n), np.frombuffer(L).reshape(n, p), False))
    return 0.0 if isinstance(found, Refusal) else found.together


def margin_of(model: Model, K: np.ndarray, L: np.ndarray) -> float:
    """The disk margin of a small plant's loop, 0 where none is known."""
    return _margin(model, np.ascontiguousarray(K, float).tobytes(), np.ascontiguousarray(L, float).tobytes()) \
        if model.plant.n <= MARGIN_STATES else 0.0


def numbers_at_the_start(model: Model) -> tuple[float, float, float]:
    """The largest entry of the gain L that the page has begun with, the disk margin and the NIS over the expected one then."""
    assert model.controller is not None and model.observer is not None  # a person's own plant begins with both
    K, L = model.controller.gain, model.observer.gain
    small = model.plant.n <= MARGIN_STATES
    nis = nis_over_expected(attempt(lambda: trial(model, FIRST_SENSOR, FIRST_BELIEF, FIRST_SEED))) if small else 0.0
    return float(np.abs(L).max()), margin_of(model, K, L), nis


@lru_cache(maxsize=16)
def decades_of(model: Model) -> tuple[int, int]:
    """The powers of ten between which the bars of a plant lie: there is room about what it begins with."""
    low, high = LEAST_DECADES
    found = [size for size in numbers_at_the_start(model) if size > 0] or [1.0]
    return min(low, math.floor(math.log10(min(found) / ROOM))), max(high, math.ceil(math.log10(max(found) * ROOM)))


def nis_over_expected(found: Trial | Refusal) -> float:
    """The mean NIS of the record over the expected one, the number of outputs; 0 where there is none."""
    return 0.0 if isinstance(found, Refusal) else float(found.test.mean / found.test.dof)


def with_numbers(stage: Stage, model: Model, K: np.ndarray, L: np.ndarray, nis: float, ranked: np.ndarray | None = None) -> Stage:
    """The stage with these bars before its plant; `nis` as `nis_over_expected` gives it. `ranked`: columns instead of them."""
    if stage.xhat is None:
        return stage
    if ranked is not None:
        return _before(stage, ranked_body_of(model), ranked)
    numbers = float(np.abs(L).max()), margin_of(model, K, L), nis
    return _before(stage, body_of(model), share_of_decades(np.array(numbers), *decades_of(model)))


def _before(stage: Stage, body: Body, shares: np.ndarray) -> Stage:
    assert stage.xhat is not None
    more = np.tile(shares, (len(stage.t), 1))
    return replace(stage, body=body, x=np.hstack([stage.x, more]), xhat=np.hstack([stage.xhat, more]), plain=stage)
