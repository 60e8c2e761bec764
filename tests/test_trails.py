"""Trails: a ghost's goes back along its own way, fades, costs no node, and is gone where calm is asked for; a pole's is the hand's."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from observer_lab.colours import palette, rgb
from observer_lab.course.lesson import Lesson, Stage
from observer_lab.lessons import LESSONS
from observer_lab.page.stage.trails import (
    ERROR_NODE,
    HIDDEN_SEGMENT,
    SEGMENTS,
    TRAIL_STEP,
    ErrorLines,
    PoleTrail,
    faded,
    ghostly,
)

RED, WHITE = (200, 40, 10), (250, 250, 250)


class Scene:
    """Keeps the nodes that are added to it."""

    def __init__(self) -> None:
        self.nodes: dict[str, Any] = {}

    def add_line_segments(self, name: str, points: np.ndarray, colors: Any, thickness: float) -> Any:
        self.nodes[name] = SimpleNamespace(points=points, colors=colors, visible=True)
        return self.nodes[name]


def stage_of(lesson: Lesson) -> Stage:
    stage = lesson.compute(lesson.start()).stage
    assert stage is not None and stage.xhat is not None
    return stage


def lines(stage: Stage, sample: int, calm: bool) -> tuple[np.ndarray, int]:
    """The lines of a ghost (N, 2, 3) at a sample, and how many of them are the error's."""
    scene, frame, body = Scene(), {}, stage.body
    assert stage.xhat is not None
    drawn = ErrorLines(cast(Any, scene), stage, True, False)
    true, believed = (body.anchors(x[sample].tolist(), body.gain) for x in (stage.x, stage.xhat))
    drawn.place(sample, true, believed, calm, frame)
    points = np.array(frame[ERROR_NODE, "points"]).reshape(-1, 2, 3)
    assert list(scene.nodes) == [ERROR_NODE] and scene.nodes[ERROR_NODE].colors.shape == points.shape
    return points, len(true)


@pytest.mark.parametrize("lesson", [LESSONS[name] for name in ("separation", "hidden-modes", "virtual-sensor")], ids=lambda it: it.id)
def test_a_trail_goes_back_along_the_ghosts_own_way(lesson: Lesson) -> None:
    stage, body = stage_of(lesson), stage_of(lesson).body
    assert stage.xhat is not None
    way = np.array([body.anchors(x.tolist(), body.gain) for x in stage.xhat])  # (samples, anchors, 3)
    seen = 0
    for sample in (0, 1, len(way) // 20, len(way) // 3, len(way) - 1):
        points, errors = lines(stage, sample, False)
        for trail in points[errors:].reshape(-1, SEGMENTS, 2, 3):
            there = trail[~np.all(trail == HIDDEN_SEGMENT, axis=(1, 2))]
            if not len(there):
                continue
            seen += len(there)
            assert np.array_equal(there[1:, 0], there[:-1, 1]), "its pieces hang together"
            anchor = int(np.argmin(np.linalg.norm(way[sample] - there[0, 0], axis=1)))
            assert np.allclose(way[sample, anchor], there[0, 0]), "it begins where the ghost is"
            earlier = way[:sample + 1, anchor]
            assert all(np.linalg.norm(earlier - point, axis=1).min() < 1e-9 for point in there[:, 1]), "it has been where the ghost was"
    assert seen > SEGMENTS


def test_where_calm_is_asked_for_there_is_no_trail() -> None:
    stage = stage_of(LESSONS["separation"])
    points, errors = lines(stage, len(stage.t) // 10, True)
    assert np.all(points[errors:] == HIDDEN_SEGMENT) and not np.all(points[:errors] == HIDDEN_SEGMENT)


def test_a_trail_fades_from_its_colour_towards_that_of_the_ground() -> None:
    ends = faded(RED, WHITE).astype(int)
    assert tuple(ends[0, 0]) == RED and np.abs(ends[-1, 1] - WHITE).max() < 0.35 * 250
    assert np.all(np.diff(ends.reshape(-1, 3).sum(axis=1)) >= 0) and np.array_equal(ends[1:, 0], ends[:-1, 1])


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_a_ghosts_trail_stands_out_from_its_ground(dark: bool) -> None:
    """Contrasts as WCAG defines them: 3 where the trail begins, 1.7 in its middle, 1.3 at its end."""
    def light(colour: Any) -> float:
        parts = np.asarray(colour) / 255
        return float(np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4) @ (0.2126, 0.7152, 0.0722)) + 0.05
    ground = light(rgb(palette(dark)["horizon"]))
    ratios = [max(light(end), ground) / min(light(end), ground) for end in ghostly(dark)[:, 0]]
    assert ratios[0] >= 3.0 and ratios[SEGMENTS // 2] >= 1.7 and ratios[-1] >= 1.3, ratios


def test_the_trail_of_a_pole_is_the_way_of_the_hand_and_its_mirror_image() -> None:
    scene = Scene()
    trail = PoleTrail(cast(Any, scene), "/trail", RED, WHITE, lambda s, lift: (s.real, -lift, s.imag))
    trail.draw()
    assert not scene.nodes, "no node before a hand comes"
    way = [complex(2 * TRAIL_STEP * k, 1.0) for k in range(3 * SEGMENTS)]
    trail.begin(way[0])
    for pole in way:
        trail.reach(pole)
    trail.draw()
    points = scene.nodes["/trail"].points
    assert points.shape == (2 * SEGMENTS, 2, 3) and scene.nodes["/trail"].visible
    assert np.allclose(points[0, 0, [0, 2]], (way[-1].real, 1.0)) and np.allclose(points[SEGMENTS:, :, 2], -points[:SEGMENTS, :, 2])
    trail.end()
    trail.draw()
    assert not scene.nodes["/trail"].visible
