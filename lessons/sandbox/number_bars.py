"""Lay bars before a plant: gain, disk margin and error, each beside that at the start."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from observer_lab.colours import COLOURS
from observer_lab.course.lesson import Stage
from observer_lab.plants import Model
from observer_lab.plants.bodies.body import STEEL, Body
from observer_lab.plants.bodies.front_bars import Bar, with_bars
from observer_lab.text import same, text

from .analyses import Refusal, attempt, margins

OCTAVES = -6.0, 3.0  # of the bars: from so many halvings to so many doublings of what is at the start
MARKS = tuple((name, (power - OCTAVES[0]) / (OCTAVES[1] - OCTAVES[0]))
              for name, power in ((same("× 1/64"), -6), (same("× 1/8"), -3), (text("× 1, at the start"), 0), (same("× 8"), 3)))
MARGIN_STATES = 6  # of a plant whose disk margin is drawn; that of a larger one takes too long for a hand on a knob
BARS = (Bar(text("largest |L|"), STEEL), Bar(text("disk margin"), COLOURS["force"]), Bar(text("error now"), COLOURS["error"]))
BEHIND, UP = 0.62, 0.36  # stage units that the plant moves back and up
NAME_DROP = 0.2  # stage units that a name is lifted less than the lamp of the first row is high


@lru_cache(maxsize=16)
def body_of(model: Model) -> Body:
    """The plant's body behind the bars, its names high on the tubes."""
    body = model.body
    top = body.pose([0.0] * model.plant.n, body.gain)["lamp 0"].position[2]
    high = replace(body, labels=tuple((name, (x, y, z + top - NAME_DROP)) for name, (x, y, z) in body.labels))
    return with_bars(high, model.plant.n, BARS, MARKS, BEHIND, UP)


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


def with_numbers(stage: Stage, model: Model, K: np.ndarray, L: np.ndarray) -> Stage:
    """The stage with these bars before its plant."""
    if stage.xhat is None:
        return stage
    error = np.linalg.norm(np.nan_to_num(stage.xhat - stage.x), axis=1)
    numbers = np.tile(times_the_start(model, K, L), (len(error), 1))
    shares = np.column_stack([numbers, error / (float(error[0]) or float(error.max()) or 1.0)])
    low, high = OCTAVES
    bars = np.clip((np.log2(np.clip(shares, 2.0 ** low, 2.0 ** high)) - low) / (high - low), 0.0, 1.0)
    return replace(stage, body=body_of(model), x=np.hstack([stage.x, bars]), xhat=np.hstack([stage.xhat, bars]), plain=stage)
