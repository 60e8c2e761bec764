"""Lesson 8: the valley between two noises, its bottom, the peak, and runs against Lyapunov."""

from __future__ import annotations

import control
import numpy as np
import pytest
from lesson_checks import carried
from scipy.linalg import expm, solve_continuous_lyapunov
from scipy.optimize import minimize
from scipy.stats import chi2

from observer_lab.engine import error_parts
from observer_lab.lessons.noise.block import ray_of
from observer_lab.lessons.noise.job import RUN_COUNT
from observer_lab.lessons.noise.knobs import SPRING_PLANT
from observer_lab.lessons.noise.lesson import LESSON

W, V = 0.04, 4e-4


def outcome(**changes):
    return LESSON.compute(LESSON.apply(LESSON.start(), changes))


def variances_of(gain) -> np.ndarray:
    """Lyapunov by python-control, for any stabilising gain."""
    L = np.reshape(gain, (2, 1))
    return control.lyap(SPRING_PLANT.A - L @ SPRING_PLANT.C, W * SPRING_PLANT.B @ SPRING_PLANT.B.T + V * L @ L.T)


@pytest.mark.parametrize("weights", [(1.0, 0.0), (0.0, 1.0), (1.0, 0.3)])
def test_the_minimum_over_gains_is_the_kalman_gain_whatever_is_judged(weights):
    """Searched without any Riccati equation, from a gain far away."""
    found = minimize(lambda g: float(np.dot(weights, np.diag(variances_of(g)))), [2.0, 2.0], method="Nelder-Mead",
                     options={"xatol": 1e-9, "fatol": 1e-14, "maxiter": 2000})
    o = outcome()
    assert np.allclose(found.x, o.gains["L_kalman"][:, 0], rtol=2e-3)
    assert found.fun == pytest.approx(float(np.dot(weights, np.diag(o.study.kalman.solution))), rel=1e-8)


def test_the_valley_touches_the_floor_at_kalmans_speed_only():
    ray = outcome(speed=1.0).study.sweep
    floor = np.diag(outcome().study.kalman.solution)
    ratio = (ray.process + ray.sensor) / floor
    assert (ratio >= 1 - 1e-12).all()
    for i in range(2):
        assert ray.along[np.argmin(ratio[:, i])] == pytest.approx(101 ** 0.25, rel=0.06)  # a step of the grid
        assert (np.diff(np.sign(np.diff(ratio[:, i]))) != 0).sum() >= 1
    assert outcome(speed=1.0).metrics["variance_ratio"] == pytest.approx(1.0, abs=1e-9)


def test_kalmans_speed_is_the_fourth_root_that_spectral_factorisation_gives():
    for w, v in ((0.04, 4e-4), (0.5, 2e-4), (0.01, 1e-2)):
        assert outcome(w=w, v=v).metrics["kalman_speed"] == pytest.approx((1 + w / v) ** 0.25, rel=1e-9)


def test_the_ray_equals_one_lyapunov_equation_after_another():
    pattern = (-3 - 1j, -3 + 1j)
    ray = ray_of(SPRING_PLANT, pattern, np.array([0.5, 4.0, 60.0]), W, V)
    for k, speed in enumerate(ray.along):
        q = np.array(pattern) / np.sqrt(10) * speed
        L = control.place(SPRING_PLANT.A.T, SPRING_PLANT.C.T, q).T
        assert np.allclose(ray.process[k] + ray.sensor[k], np.diag(variances_of(L)), rtol=1e-8)
        parts = error_parts(SPRING_PLANT, L, SPRING_PLANT.B, W, V)
        assert np.allclose(ray.sensor[k], np.diag(parts.sensor), rtol=1e-8)


@pytest.mark.parametrize("pattern", [(-2 - 3j, -2 + 3j), (-2.0, -2.0), (-1.0, -7.0)])
def test_the_peak_is_that_of_the_matrix_exponential(pattern):
    speed = float(np.sqrt(abs(pattern[0] * pattern[1])))
    peak = ray_of(SPRING_PLANT, pattern, np.array([speed]), W, V).peak[0]
    l1 = -np.real(sum(pattern)) - 0.5
    L = np.array([[l1], [np.real(pattern[0] * pattern[1]) - 1 - 0.5 * l1]])
    F = SPRING_PLANT.A - L @ SPRING_PLANT.C
    assert peak == pytest.approx(max(abs(expm(F * t)[1, 0]) for t in np.linspace(0, 5, 4001)), rel=1e-5)


def test_fast_observers_scale_as_the_text_says():
    """σ of the velocity with the power 3/2 of the speed, of the position with 1/2, the peak in proportion."""
    slow, fast = outcome(speed=5.0).metrics, outcome(speed=10.0).metrics
    assert slow["velocity_rms"] == pytest.approx(0.73, abs=5e-3) and fast["velocity_rms"] == pytest.approx(2.12, abs=5e-3)
    assert fast["velocity_rms"] / slow["velocity_rms"] == pytest.approx(2**1.5, rel=0.03)
    assert fast["position_rms"] / slow["position_rms"] == pytest.approx(2**0.5, rel=0.02)
    assert fast["peak"] / slow["peak"] == pytest.approx(2.0, rel=0.03)
    assert (round(slow["peak"], 1), round(fast["peak"], 1)) == (2.1, 4.4)
    assert outcome(speed=1.0).metrics["velocity_rms"] == pytest.approx(0.117, abs=5e-4)


def test_only_the_ratio_of_the_noises_chooses_the_gain():
    one, ten = outcome(speed=1.0), outcome(speed=1.0, w=0.4, v=4e-3)
    assert np.allclose(one.gains["L"], ten.gains["L"], rtol=1e-9)
    assert ten.metrics["velocity_rms"] / one.metrics["velocity_rms"] == pytest.approx(np.sqrt(10), rel=1e-9)


def test_slow_and_fast_twins_have_opposite_causes():
    slow, fast = outcome(speed=0.3).metrics, outcome(speed=1.77).metrics
    assert slow["velocity_rms"] == pytest.approx(0.162, abs=5e-4)
    assert fast["velocity_rms"] == pytest.approx(slow["velocity_rms"], rel=0.02)
    assert slow["sensor_share"] < 0.01 and 0.7 < fast["sensor_share"] < 0.8


@pytest.mark.slow
@pytest.mark.parametrize("speed, seed", [(1.0, 1), (5.0, 2), (0.3, 3)])
def test_lyapunov_is_the_variance_of_many_runs(speed, seed):
    """At single instants the mean square over independent runs is exactly χ²: 99.99 % bands, no tuning."""
    *_, (fraction, done) = LESSON.job.outcomes(outcome(speed=speed, seed=seed))
    trials, promised = done.study.trials, np.diagonal(done.study.grown, axis1=1, axis2=2)
    assert fraction == 1.0 and trials.count == RUN_COUNT
    low, high = chi2.ppf([5e-5, 1 - 5e-5], RUN_COUNT) / RUN_COUNT
    for k in (20, 100, 250, -1):
        assert (low < trials.square[k] / promised[k]).all() and (trials.square[k] / promised[k] < high).all()
    settled = np.diag(done.study.parts.total)
    if speed >= 1:
        assert np.allclose(promised[-1], settled, rtol=0.03)  # holding v over a step costs little here
    assert promised[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.slow
def test_runs_carry_over_to_another_view_of_the_same_design_only():
    *_, (_, done) = LESSON.job.outcomes(outcome())
    assert carried(LESSON, done.design, done.study.trials, outcome(watch="position")).study.trials is done.study.trials
    assert carried(LESSON, done.design, done.study.trials, outcome(w=0.05)).study.trials is None


@pytest.mark.parametrize("kick", [-1.0, 1.0])
def test_a_peak_names_its_causes(kick: float) -> None:
    caption = next(f for f in LESSON.figures(outcome(kick=kick)) if f.id == "peaks").caption("en")
    assert ("and the kick" in caption) == (kick >= 0)


def test_the_bottom_is_reached_by_the_poles_and_not_by_the_noises() -> None:
    """The first poles are the best ones for other noises; that is no solution."""
    task = next(t for t in LESSON.tasks if t.id == "by-hand")
    cheat = outcome(method="poles", w=1.0, v=1e-4)
    assert cheat.metrics["worst_ratio"] < 1.01 and not task.check(cheat).solved


def test_sensor_noise_falls_with_speed_left_of_the_blocks_own_pace() -> None:
    """What the text says of the valley's left side."""
    none = error_parts(SPRING_PLANT, np.zeros((2, 1)), SPRING_PLANT.B, [[0.04]], [[4e-4]]).total
    slow, turn, fast = (outcome(speed=v) for v in (0.1, 0.4, 1.0))
    sensor = [o.study.parts.sensor[1, 1] for o in (slow, turn, fast)]
    assert sensor[0] > sensor[1] < sensor[2]
    assert slow.gains["L"][1, 0] < 0 and np.all(np.diag(slow.study.parts.total) > np.diag(none))


@pytest.mark.parametrize("v", [1e-4, 4e-4, 1.6e-3])
def test_the_stage_shows_the_last_readings_and_their_standard_deviation(v: float) -> None:
    """A ball for each of the last twelve readings, drawn from the block's own map of metres; σ is that of all readings of the run."""
    o = outcome(v=v)
    stage, run, k = o.stage, o.run, 300
    poses = stage.body.pose(stage.x[k].tolist(), stage.body.gain)
    for back in range(12):
        block = stage.body.pose([float(run.y[k - back, 0]), *stage.x[k, 1:].tolist()], stage.body.gain)["block"]
        assert poses[f"reading {back}"].position[0] == pytest.approx(block.position[0], abs=1e-12)
    assert stage.x[k, 2] == pytest.approx(float(np.std(run.y[:, 0] - run.x[:, 0])), rel=0.1)
    band, edge = poses["noise band"], [stage.body.pose([stage.x[k, 0] + s * stage.x[k, 2], *stage.x[k, 1:].tolist()], stage.body.gain)
                                       ["block"].position[0] for s in (-1, 1)]
    assert [band.position[0] - band.scale[0], band.position[0] + band.scale[0]] == pytest.approx(edge)


@pytest.mark.parametrize("speed", [1.0, 5.0, 10.0])
def test_the_bars_on_the_stage_are_the_velocities_of_block_and_ghost(speed: float) -> None:
    """0.2 stage units for 1 m/s, bent so that none is longer than 1.4."""
    o = LESSON.compute(LESSON.apply(LESSON.start(), {"method": "speed", "speed": speed}))
    stage, run = o.stage, o.run
    assert stage is not None and stage.xhat is not None and run is not None
    for k in range(0, len(run.t), 50):
        for states, velocity in ((stage.x, run.x[k, 1]), (stage.xhat, run.xhat[k, 1])):
            poses = stage.body.pose(states[k].tolist(), stage.body.gain)
            bar = poses["velocity"]
            assert bar.scale[2] == pytest.approx(max(1.4 * abs(np.tanh(0.2 * velocity / 1.4)), 1e-6), abs=1e-6)
            assert bar.position[0] == pytest.approx(poses["block"].position[0], abs=1e-9)


@pytest.mark.parametrize("speed, v", [(1.0, 4e-4), (5.0, 4e-4), (10.0, 1e-4)])
def test_the_bar_above_the_readings_is_the_estimate_and_three_standard_deviations_to_either_side(speed: float, v: float) -> None:
    """At the end of a run P has settled: FP + PFᵀ + BWBᵀ + LVLᵀ = 0 with F = A − LC. Its ends stand where the block would."""
    o = outcome(method="speed", speed=speed, v=v)
    stage, L, w = o.stage, o.gains["L"], o.design["w"]
    A, B, C = np.array([[0.0, 1.0], [-1.0, -0.5]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])
    P = solve_continuous_lyapunov(A - L @ C, -(w * B @ B.T + v * L @ L.T))
    poses = stage.body.pose(stage.xhat[-1].tolist(), stage.body.gain)
    assert stage.x[-1, 3] == pytest.approx(3 * np.sqrt(P[0, 0]), rel=2e-2)
    for name, times in (("estimate low", -3), ("estimated position", 0), ("estimate high", 3)):
        at = float(o.run.xhat[-1, 0]) + times * stage.x[-1, 3] / 3
        block = stage.body.pose([at, *stage.x[-1, 1:].tolist()], stage.body.gain)["block"]
        assert poses[name].position[0] == pytest.approx(block.position[0], abs=1e-9)
    _, name, *_ = stage.body.marks(stage.x[-1].tolist(), stage.xhat[-1].tolist(), stage.body.gain).words
    assert name[0] == "ŷ ± 3σ" and name[1][0] > poses["estimate high"].position[0]
