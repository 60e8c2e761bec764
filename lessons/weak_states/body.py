"""The platform whose springs and sensors stand where the knobs put them, and one of its motions drawn slowly.

The record that the stage plays is (ten states, a, s, h, μ).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from app.lesson.lesson import Stage
from app.plants.body import Body, Pose, between, bounded
from app.plants.deck_body import MASS_REST, STAGE, platform_body
from app.plants.platform import Parameters
from app.text import text

from .system import STATES, Motion, System, believed, relative

NOMINAL = Parameters()
PERIOD, PERIODS, FRAMES = 1.5, 4, 240  # s that one swing takes on the stage, swings, samples
TRAVEL, SMALLER = 0.17, 0.75  # how far a test mass may swing on the stage, and its drawn size: the ghost must not hide in it
REACH = np.array([2.0e-3, 2.0e-3, 9e-3, 1.2e-3, 1.2e-3])  # m, m, rad, m, m: how far a motion is drawn


@lru_cache(maxsize=256)
def _placed(a: float, s: float, h: float) -> Body:
    return platform_body(a, NOMINAL.b, s, h)


def _pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
    a, s, h, mu = x[STATES:]
    poses = dict(_placed(a, s, h).pose(x[:STATES], gain))
    size = SMALLER * min(max((mu / NOMINAL.mu) ** (1 / 3), 0.6), 1.4)
    for side, sign, place in (("left", -1.0, x[3]), ("right", 1.0, x[4])):
        foot, ball = poses[f"servo {side}"].position, poses[f"test mass {side}"]
        apart = [b - f for b, f in zip(ball.position, foot, strict=True)]
        rise = bounded((place - x[1] - sign * s * x[2]) * STAGE * gain, TRAVEL)
        longer = (MASS_REST + rise) / math.hypot(*apart)
        there = (foot[0] + longer * apart[0], foot[1] + longer * apart[1], foot[2] + longer * apart[2])
        poses[f"test mass {side}"] = replace(ball, position=there, scale=(size, size, size))
        poses[f"servo {side}"] = between(foot, there)
    return poses


_BASE = _placed(NOMINAL.a, NOMINAL.s, NOMINAL.h)
BODY = Body(
    _BASE.parts, _pose, lambda x, u, gain: (), lambda x, gain: _placed(*x[STATES:STATES + 3]).anchors(x[:STATES], gain), 20.0,
    text("Deck with its sensors; the copper balls are their test masses"))


def slower(motion: Motion) -> float:
    """How many times slower the stage draws the motion than it is."""
    return motion.frequency * PERIOD


def swing(s: System, motion: Motion, order: int) -> Stage:
    """The motion undamped, one swing in PERIOD seconds that begins with its largest part at REACH; the ghost is what the model holds."""
    p = s.parameters
    parts = relative(p, motion.shape) / REACH
    shape = motion.shape / parts[np.argmax(np.abs(parts) > 0.999 * np.abs(parts).max())]  # the first of equals, on every machine
    t = np.linspace(0.0, PERIOD * PERIODS, FRAMES + 1)
    turning = np.exp(2j * np.pi * t / PERIOD)[:, None]
    fixed = np.tile([p.a, p.s, p.h, p.mu], (len(t), 1))
    true, guess = (np.real(turning * v) for v in (shape, believed(s, order, shape)))
    return Stage(BODY, t, np.hstack([true, fixed]), np.hstack([guess, fixed]))


def share(s: System, motion: Motion, order: int) -> float:
    """How much of the motion a model of `order` states holds: 1 if all of it."""
    p, held = s.parameters, believed(s, order, motion.shape)
    true, guess = (relative(p, v) / REACH for v in (motion.shape, held))
    return float(np.linalg.norm(guess) / np.linalg.norm(true))
