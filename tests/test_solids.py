"""Solid parts are closed and face outwards, and none has the ghost's orange, in any lesson and at any moment of its run."""

from __future__ import annotations

import colorsys
from collections import Counter

import numpy as np
import pytest
from laws import each

from observer_lab.colours import COLOURS, rgb
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.page.stage.meshes import Mesh, bevelled_box, bevelled_cylinder

ORANGES, LEAST_SATURATION = (5 / 360, 42 / 360), 0.5  # hues from vermillion to amber; below it a colour reads as grey or brown
ESTIMATES = {"cloud", "estimate", "prediction", "z1 level"}  # parts that show an estimate, as the ghost does
STATED = {  # parts of a lesson that show what its filter states of its estimate
    "nonlinear": {"bar 0"}, "network": {"gate left", "gate right", "gate top"},
    "noise": {"estimate bar", "estimated position", "estimate low", "estimate high"}}
MOMENTS = 8


def is_orange(colour: tuple[int, int, int]) -> bool:
    """Whether a body of this colour would be taken for a ghost."""
    hue, saturation, value = colorsys.rgb_to_hsv(*(part / 255 for part in colour))
    return ORANGES[0] <= hue <= ORANGES[1] and saturation >= LEAST_SATURATION and value > 0.4


def test_the_ghost_is_orange() -> None:
    assert is_orange(rgb(COLOURS["estimate"])) and is_orange(rgb(COLOURS["disturbance"]))
    assert not any(is_orange(rgb(COLOURS[role])) for role in ("plant", "coil", "steel", "metal", "dark"))


@each("lesson", LESSONS.values())
def test_orange_shows_an_estimate_and_nothing_else(lesson: Lesson) -> None:
    stage = lesson.compute(lesson.start()).stage
    assert stage is not None
    body = stage.body
    assert {part.name for part in body.parts if not part.unseen and is_orange(rgb(part.colour))} <= ESTIMATES | STATED.get(lesson.id, set())
    for k in np.linspace(0, len(stage.x) - 1, MOMENTS).astype(int):
        poses = body.pose(stage.x[k].tolist(), body.gain)
        assert not [name for name, pose in poses.items() if pose.colour is not None and is_orange(pose.colour)]


@pytest.mark.parametrize(("mesh", "volume"), [
    (bevelled_box((2.0, 1.0, 0.5)), 1.0), (bevelled_box((0.05, 0.14, 0.012)), 0.05 * 0.14 * 0.012),
    (bevelled_cylinder(0.3, 0.0, 1.0), np.pi * 0.09), (bevelled_cylinder(0.3, -0.02, 0.02), np.pi * 0.09 * 0.04),
], ids=["box", "mark", "rod", "disc"])
def test_a_bevelled_part_is_closed_faces_outwards_and_fills_its_place(mesh: Mesh, volume: float) -> None:
    vertices, faces = mesh[0].astype(float), mesh[1]
    edges = Counter((a, b) for face in faces.tolist() for a, b in zip(face, face[1:] + face[:1], strict=True))
    assert set(edges.values()) == {1} and all(edges[b, a] == 1 for a, b in edges)  # each edge is passed once each way
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert 0.9 * volume < np.einsum("ij,ij->", np.cross(a, b), c) / 6 < volume
