"""Compute the corners of a body's parts over a run, and how far they reach."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from ...course.lesson import Stage
from ...plants.bodies.body import Ball, Box, Cylinder, Pose, Shape

MOMENTS = 8  # of a run that are looked at
BASE_TOP = 0.2  # stage units: what a plant stands on is no higher
SIGNS = np.array(list(product((-1.0, 1.0), repeat=3)))  # of a box's corners


def _half_and_middle(shape: Shape) -> tuple[np.ndarray, float]:
    """Half the size of the box around a shape, and how high its middle is above the part's position."""
    if isinstance(shape, Box):
        return np.array(shape.size) / 2, 0.0
    if isinstance(shape, Cylinder):
        return np.array((shape.radius, shape.radius, shape.height / 2)), 0.0
    if isinstance(shape, Ball):
        return np.full(3, shape.radius), 0.0
    return np.array((shape.radius, shape.radius, 0.5)), 0.5  # springs and rods are one unit long from the position on


def _corners(shapes: Sequence[Shape], poses: Sequence[Pose]) -> np.ndarray:
    """The eight corners of the box around each part as it stands (8 k, 3)."""
    boxes = [_half_and_middle(shape) for shape in shapes]
    half, lift = np.array([half for half, _ in boxes]), np.array([(0.0, 0.0, middle) for _, middle in boxes])
    points = (SIGNS[:, None] * half + lift) * np.array([pose.scale for pose in poses])
    turn = np.array([pose.wxyz for pose in poses])
    turn /= np.linalg.norm(turn, axis=1, keepdims=True)
    across = np.cross(turn[:, 1:], points)
    points += 2 * turn[:, :1] * across + 2 * np.cross(turn[:, 1:], across) + np.array([pose.position for pose in poses])
    return points.reshape(-1, 3)


def body_corners(stage: Stage, moments: int) -> np.ndarray:
    """The corners (k, 3) of all parts above the floor at some moments of the run, where the plant is and where its estimate is."""
    body, found = stage.body, []
    for i in np.unique(np.linspace(0, len(stage.t) - 1, moments).astype(int)):
        for states in (stage.x, stage.xhat):
            if states is None:
                continue
            poses = body.pose(states[i].tolist(), body.gain)
            parts = [part for part in body.parts if (part.twin if states is stage.xhat else not part.unseen)]
            if parts:
                found.append(_corners([part.shape for part in parts], [poses[part.name] for part in parts]))
    points = np.concatenate(found)
    return points[points[:, 2] >= -0.01]  # what lies below is put away


def reach(stage: Stage) -> tuple[float, float]:
    """How far to either side and how high a body reaches in its run with the words on it, in stage units."""
    points = body_corners(stage, MOMENTS)
    return float(np.abs(points[:, 0]).max()), max(float(points[:, 2].max()), *(at[2] for _, at in stage.body.labels), 0.0)


def front_corner(stage: Stage) -> tuple[float, float]:
    """Where the base of a body ends on the right and in front, in stage units."""
    points = body_corners(stage, 1)
    base = points[points[:, 2] < BASE_TOP]
    return float(base[:, 0].max()), float(base[:, 1].min())
