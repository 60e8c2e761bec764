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
    BENCH,
    GHOST_NAME,
    METAL,
    PLANT_COLOUR,
    STEEL,
    Body,
    Box,
    ErrorMarks,
    Part,
    PartName,
    Pose,
    Quaternion,
    Vector,
    bound_displacement,
)
from observer_lab.plants.bodies.front_bars import BEGIN, FIRST_Y, FLOOR, LONG, PITCH, STEP, THICK, Bar, share_of_decades, with_bars
from observer_lab.plants.bodies.gain_lanes import moved_back
from observer_lab.plants.bodies.own_body import rows_of
from observer_lab.plants.examples import example
from observer_lab.plants.own_plant import plant_of
from observer_lab.plants.signal_names import signal_name
from observer_lab.text import same, text

from .analyses import Refusal, Trial, attempt, margins

DECADES = -1, 1  # of the bars
START = -DECADES[0] / (DECADES[1] - DECADES[0])  # the share of a bar of 1
MARKS = ((same("0.1"), 0.0), (text("1: as at the start, as expected"), START), (same("10"), 1.0))
MARGIN_STATES = 6  # of a plant whose disk margin is drawn; that of a larger one takes too long for a hand on a knob
BARS = (Bar(text("largest |L|"), STEEL), Bar(text("disk margin"), COLOURS["force"]), Bar(text("mean NIS"), COLOURS["error"]))
BEHIND, UP, ALL_BACK = 0.62, 0.36, 0.4  # stage units that the plant moves back and up, and then all of it back
NAME_DROP = 0.2  # stage units that a name is lifted less than the lamp of the first row is high
AROUND, PLATE_Y, PLATE = 0.34, 0.3, 0.04  # stage units of the plate beside the tubes, from them back to it, its thickness
AIRCRAFT_Z, STEEPEST = 2.5, 0.7  # height of the aircraft before it moves up; rad of the largest angle in its tube
SIDESLIP, BANK = 0, 3  # of its states


@lru_cache(maxsize=16)
def body_of(model: Model) -> Body:
    """The plant's body behind the bars, its names high on the tubes, a plate behind them, the aircraft's above them."""
    body = model.body
    poses = body.pose([0.0] * model.plant.n, body.gain)
    top = poses["lamp 0"].position[2]
    tails = [arrow.tail for arrow in body.arrows([0.0] * model.plant.n, [1.0] * model.plant.m, body.gain)]
    inputs = tuple((signal_name(model.plant, name), (x, y, z - 0.02))
                   for name, (x, y, z) in zip(model.plant.input_names, tails, strict=False))
    high = replace(body, labels=(*((name, (x, y, z + top - NAME_DROP)) for name, (x, y, z) in body.labels), *inputs))
    high = _with_plate(high, poses, top) if len(rows_of(model.plant.n)) == 1 else high
    barred = with_bars(with_aircraft(high) if is_aircraft(model) else high, model.plant.n, BARS, MARKS, BEHIND, UP, decades=DECADES)
    fixed = {f"start {k}": Pose((BEGIN + LONG * START / 2, FIRST_Y - PITCH * k, FLOOR + STEP * (len(BARS) - 1 - k) + THICK))
             for k in range(len(BARS))}
    pale = tuple(Part(name, Box((LONG * START, 2.4 * THICK, 2.2 * THICK)), COLOURS["muted"], opacity=0.35) for name in fixed)
    return _set_back(replace(barred, pose=lambda x, gain: {**barred.pose(x, gain), **fixed}, parts=(*barred.parts, *pale)), ALL_BACK)


def _set_back(body: Body, by: float) -> Body:
    """The body with all that belongs to it, farther from the viewer: its foot is in sight on a phone."""
    marks = body.marks
    assert marks is not None

    def words(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        found = marks(x, xhat, gain)
        return ErrorMarks(tuple((moved_back(a, by), moved_back(b, by)) for a, b in found.bars),
                          tuple((word, moved_back(at, by), side) for word, at, side in found.words))

    return replace(
        body, marks=words, labels=tuple((word, moved_back(at, by)) for word, at in body.labels),
        pose=lambda x, gain: {name: replace(each, position=moved_back(each.position, by)) for name, each in body.pose(x, gain).items()},
        arrows=lambda x, u, gain: tuple(replace(each, tail=moved_back(each.tail, by), head=moved_back(each.head, by))
                                        for each in body.arrows(x, u, gain)),
        anchors=lambda x, gain: tuple(moved_back(at, by) for at in body.anchors(x, gain)))


def _with_plate(body: Body, poses: Mapping[str, Pose], top: float) -> Body:
    """The body with a plate behind its tubes, on which the glass is seen."""
    places = [pose.position for name, pose in poses.items() if name.startswith("tube ")]
    low, high, y = min(x for x, *_ in places) - AROUND, max(x for x, *_ in places) + AROUND, places[0][1] + PLATE_Y
    plate = Pose(((low + high) / 2, y, top / 2))
    return replace(body, parts=(*body.parts, Part("plate", Box((high - low, PLATE, top)), BENCH)),
                   pose=lambda x, gain: {**body.pose(x, gain), "plate": plate})


# --- the aircraft ------------------------------------------------------------------------------------------------------
AIRFRAME = (  # name, size and place in it, seen from behind: right, ahead, up
    ("fuselage", (0.17, 1.2, 0.17), (0.0, 0.0, 0.0), METAL), ("wings", (2.1, 0.32, 0.05), (0.0, 0.1, 0.05), PLANT_COLOUR),
    ("tailplane", (0.74, 0.2, 0.04), (0.0, -0.5, 0.04), PLANT_COLOUR), ("fin", (0.05, 0.26, 0.4), (0.0, -0.48, 0.24), PLANT_COLOUR))


def is_aircraft(model: Model) -> bool:
    """Whether the plant is the aircraft that the lesson opens with."""
    first, plant = plant_of(example("aircraft")), model.plant
    return plant.state_names == first.state_names and np.array_equal(plant.A, first.A)


def with_aircraft(body: Body) -> Body:
    """The tubes below a small aircraft, seen from behind: it has the bank angle, and its nose the sideslip, at the scale of their tubes."""
    def attitude(x: Sequence[float], gain: float) -> tuple[float, float]:
        rest, now = body.pose([0.0] * 4, gain), body.pose(x, gain)

        def angle(k: int) -> float:
            away = now[f"collar {k}"].position[2] - rest[f"collar {k}"].position[2]
            return STEEPEST * bound_displacement(away / (0.75 * rest["tube 0"].position[2]), 1.5)
        return angle(SIDESLIP), angle(BANK)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        turn = _turned(*attitude(x, gain))
        return {**body.pose(x, gain), **{name: Pose(_moved(at, turn), turn) for name, _, at, _ in AIRFRAME}}

    named = (*(name for name in body.names if not name.ghost), PartName(GHOST_NAME, "wings", (1.3, -0.2, 0.3), True))
    return replace(body, parts=(*body.parts, *(Part(name, Box(size), colour, twin=True) for name, size, _, colour in AIRFRAME)), pose=pose,
                   names=named)


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


def times_the_start(model: Model, K: np.ndarray, L: np.ndarray) -> tuple[float, float]:
    """The largest entry of L and the disk margin, over those of the gains that the page has begun with; 0 where one is not known."""
    assert model.controller is not None and model.observer is not None  # a person's own plant begins with both
    first, margin = float(np.abs(model.observer.gain).max()), margin_of(model, model.controller.gain, model.observer.gain)
    return (float(np.abs(L).max()) / first if first > 0 else 0.0, margin_of(model, K, L) / margin if margin > 0 else 0.0)


def nis_over_expected(found: Trial | Refusal) -> float:
    """The mean NIS of the record over the expected one, the number of outputs; 0 where there is none."""
    return 0.0 if isinstance(found, Refusal) else float(found.test.mean / found.test.dof)


def with_numbers(stage: Stage, model: Model, K: np.ndarray, L: np.ndarray, nis: float) -> Stage:
    """The stage with these bars before its plant; `nis` as `nis_over_expected` gives it."""
    if stage.xhat is None:
        return stage
    numbers = (*times_the_start(model, K, L), nis)
    bars = np.tile(share_of_decades(np.array(numbers), *DECADES), (len(stage.t), 1))
    return replace(stage, body=body_of(model), x=np.hstack([stage.x, bars]), xhat=np.hstack([stage.xhat, bars]), plain=stage)
