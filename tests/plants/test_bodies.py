"""Bodies on the stage: poses that are finite and stay on it, ghosts, arrows, springs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plant_models import every_model

from observer_lab.plants import MODELS
from observer_lab.plants.bodies.body import Body, Spring, bound_displacement, pose_between


def turned(wxyz, vector) -> np.ndarray:
    """The vector after the rotation, by Rodrigues' formula."""
    w, axis = wxyz[0], np.array(wxyz[1:])
    return np.asarray(vector) + 2 * w * np.cross(axis, vector) + 2 * np.cross(axis, np.cross(axis, vector))


def end(pose) -> np.ndarray:
    """Where a spring or rod ends."""
    return np.array(pose.position) + turned(pose.wxyz, (0, 0, pose.scale[2]))


def states(m) -> list[list[float]]:
    n = m.plant.n
    signs = [(-1.0) ** i for i in range(n)]
    return [[0.0] * n, list(m.x0), list(m.kick), [1e6] * n, [1e6 * s for s in signs], [-1e300 * s for s in signs]]


@every_model
def test_body_poses_every_part_with_finite_numbers_and_unit_quaternions(m):
    body: Body = m.body
    for x in states(m):
        poses = body.pose(x, body.gain)
        assert set(poses) == {part.name for part in body.parts} and len(poses) == len(body.parts)
        for pose in poses.values():
            assert np.all(np.isfinite([*pose.position, *pose.scale])) and min(pose.scale) > 0
            assert math.hypot(*pose.wxyz) == pytest.approx(1, abs=1e-12)
            assert pose.colour is None or all(0 <= c <= 255 and isinstance(c, int) for c in pose.colour)


@every_model
def test_body_never_leaves_the_stage_when_a_run_diverges(m):
    body: Body = m.body
    stretched = {part.name for part in body.parts if isinstance(part.shape, Spring)}
    for x in states(m):
        poses = body.pose(x, body.gain)
        points = [pose.position for pose in poses.values()] + [tuple(end(poses[name])) for name in stretched]
        points += body.anchors(x, body.gain)
        points += [a.head for a in body.arrows(x, [1e9] * m.plant.m, body.gain)]
        for right, away, up in points:
            assert abs(right) < 3.0 and abs(away) < 1.5 and 0 <= up < 3.2


@every_model
def test_ghost_vanishes_into_the_body_when_the_estimate_is_right(m):
    body: Body = m.body
    ghost = [part.name for part in body.parts if part.twin]
    assert ghost
    rest, start = body.pose([0.0] * m.plant.n, body.gain), body.pose(list(m.x0), body.gain)
    assert any(math.dist(rest[name].position, start[name].position) > 0.02 for name in ghost)
    assert body.anchors(list(m.x0), body.gain) == body.anchors(tuple(np.array(m.x0)), body.gain)
    assert len(body.anchors(list(m.x0), body.gain)) == len(body.anchors(list(m.guess), body.gain)) >= 2


@every_model
def test_each_input_has_an_arrow_that_turns_with_its_sign(m):
    for i in range(m.plant.m):
        u = [0.0] * m.plant.m
        lengths = []
        for value in (0.0, 0.3 * m.u_max, -0.3 * m.u_max):
            u[i] = value
            arrows = m.body.arrows(list(m.x0), u, m.body.gain)
            lengths.append(np.sum([np.subtract(a.head, a.tail) * k for k, a in enumerate(arrows, 1)], axis=0))
        assert np.all(lengths[0] == 0) and np.abs(lengths[1]).max() > 0.05
        np.testing.assert_allclose(lengths[1], -lengths[2], atol=1e-12)


def test_positive_pitch_lifts_the_right_side_of_the_deck():
    left, _, right, _ = MODELS["deck"].body.anchors([0, 0, 0.005, 0, 0, 0], 20.0)
    assert right[2] > left[2] + 0.1


def test_deck_motion_of_two_millimetres_is_drawn_as_three_tenths():
    body = MODELS["deck"].body
    rise = body.pose([0, 0.0005, 0, 0, 0, 0], body.gain)["deck"].position[2] - body.pose([0] * 6, body.gain)[
        "deck"].position[2]
    assert 4 * rise == pytest.approx(0.3, rel=0.02)


@pytest.mark.parametrize("id", ["deck", "platform"])
def test_deck_springs_stay_fastened_to_the_deck(id):
    body, n = MODELS[id].body, MODELS[id].plant.n
    fastened = []
    for x in ([0.0] * n, [0.002, -0.001, 0.01, *[0.0] * (n - 3)], [-1.0, 1.0, -1.0, *[0.0] * (n - 3)]):
        poses = body.pose(x, body.gain)
        deck = poses["deck"]
        back = (deck.wxyz[0], *(-c for c in deck.wxyz[1:]))
        fastened.append([turned(back, end(poses[name]) - np.array(deck.position))
                         for name in ("spring left", "spring right", "spring across", "rod left", "rod right")])
    np.testing.assert_allclose(fastened[1], fastened[0], atol=1e-9)
    np.testing.assert_allclose(fastened[2], fastened[0], atol=1e-9)


def test_test_masses_of_the_platform_move_against_each_other_on_the_stage():
    body = MODELS["platform"].body
    rest = body.pose([0.0] * 10, body.gain)
    apart = body.pose([0, 0, 0, 5e-4, -5e-4, 0, 0, 0, 0, 0], body.gain)
    for side, up in (("left", 1), ("right", -1)):
        rise = apart[f"test mass {side}"].position[2] - rest[f"test mass {side}"].position[2]
        assert rise * up > 0.04
    assert apart["deck"] == rest["deck"]


def test_pole_leans_to_the_right_for_a_positive_angle():
    body = MODELS["cart-pendulum"].body
    poses = body.pose([0.0, 0.3, 0.0, 0.0], 1.0)
    assert poses["ball"].position[0] > poses["cart"].position[0] + 0.3
    np.testing.assert_allclose(end(poses["pole"]), poses["ball"].position, atol=1e-12)


def test_hotter_chip_stands_higher_and_glows_lighter():
    body = MODELS["chip"].body
    cold, hot = body.pose([0.0, 0.0], 1.0), body.pose([40.0, 10.0], 1.0)
    assert hot["core level"].position[2] > hot["case level"].position[2] > cold["case level"].position[2]
    die, air = hot["die"].colour, cold["die"].colour
    assert die is not None and air is not None and min(die) > max(air) + 25


coordinate = st.floats(-5, 5)
point = st.tuples(coordinate, coordinate, coordinate)


@given(point, point)
def test_a_spring_reaches_exactly_from_one_point_to_the_other(start, finish):
    pose = pose_between(start, finish)
    np.testing.assert_allclose(end(pose), finish, atol=2e-6)
    assert math.hypot(*pose.wxyz) == pytest.approx(1, abs=1e-12)


@given(st.floats(allow_nan=False), st.floats(1e-3, 10))
def test_bounded_motion_stays_within_its_limit_and_keeps_its_sign(value, limit):
    drawn = bound_displacement(value, limit)
    assert abs(drawn) <= limit * (1 + 1e-12)
    assert drawn * value >= 0
    if abs(value) < 0.01 * limit:
        assert drawn == pytest.approx(value, rel=1e-3, abs=1e-300)
