"""LQG on a computer: the sampled cost and gains against python-control, the recursive filter against the steady one."""

import control
import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.linalg import expm

from observer_lab.engine import Belief, EngineError, Plant, balanced_truncation, noisy_loop, sampled_lqg
from observer_lab.engine.sampled import sampled_cost
from observer_lab.plants.platform import lqg_weights, model
from observer_lab.plants.platform.channels import T_y

DT = 1e-3


def report(V: float, dt: float = DT, plant: Plant | None = None):
    p = model.plant() if plant is None else plant
    w = lqg_weights.Weights(v0=V)
    return sampled_lqg(lqg_weights.coils(p), w.Q(p), w.R, w.W, w.V, dt, G=lqg_weights.ground(p))


def suppression(loop) -> np.ndarray:
    p = model.plant()
    f = np.unique(np.concatenate([np.geomspace(0.01, 100, 400), np.linspace(0.9, 1.6, 1500)]))
    free = noisy_loop(lqg_weights.coils(p), None, lqg_weights.ground(p), 1e-12)
    return 10 * np.log10(free.psd(f, free.outputs(T_y[:3])).max(axis=0) / loop.psd(f, loop.outputs(T_y[:3])).max(axis=0))


def test_the_sampled_cost_is_the_integral_of_the_continuous_one() -> None:
    rng = np.random.default_rng(2)
    plant = Plant(rng.standard_normal((3, 3)), rng.standard_normal((3, 2)), np.eye(3))
    Q, R, dt = np.diag([1.0, 2.0, 0.5]), np.diag([0.3, 1.0]), 0.4
    M = np.zeros((5, 5))
    M[:3, :3], M[:3, 3:] = plant.A, plant.B
    weight = np.diag([1.0, 2.0, 0.5, 0.3, 1.0])
    whole, _ = quad_vec(lambda s: expm(M * s).T @ weight @ expm(M * s), 0, dt, epsrel=1e-12)
    Qd, Rd, Nd = sampled_cost(plant, Q, R, dt)
    assert np.block([[Qd, Nd], [Nd.T, Rd]]) == pytest.approx(whole, rel=1e-10)


def test_gains_equal_those_of_python_control() -> None:
    rng = np.random.default_rng(4)
    plant = Plant(rng.standard_normal((3, 3)), rng.standard_normal((3, 1)), rng.standard_normal((1, 3)))
    s = sampled_lqg(plant, np.eye(3), np.eye(1), np.eye(1), 0.1, 0.1)
    Qd, Rd, Nd = sampled_cost(plant, np.eye(3), np.eye(1), 0.1)
    K, _, _ = control.dlqr(s.plant.A, s.plant.B, Qd, Rd, Nd)
    assert np.abs(s.K - K).max() < 1e-8 * np.abs(K).max()
    L, _, _ = control.dlqe(s.plant.A, np.eye(3), s.plant.C, s.filter.Q, s.filter.R)
    assert np.abs(s.filter.steady.predictor_gain - L).max() < 1e-8 * np.abs(L).max()


def test_a_fast_computer_gives_the_continuous_loop() -> None:
    assert suppression(report(1e-9).loop(readings=1e-18 / DT)) == pytest.approx(np.array([31.2, 11.0, 27.2]), abs=0.1)


def test_the_literal_design_at_1_khz_loses_what_its_sampling_cannot_carry() -> None:
    """In continuous time 110/96/113 dB; a computer that answers a sample late keeps 73/87/76 or a little more."""
    s = report(1e-18)
    assert suppression(s.loop()) == pytest.approx(np.array([81.0, 91.7, 83.9]), abs=0.3)
    late = noisy_loop(s.plant, s.late_controller, np.eye(10), s.filter.Q, V=s.filter.R)
    assert late.stable
    assert suppression(late) == pytest.approx(np.array([73, 87, 76]), abs=1.3)


@pytest.mark.slow
def test_after_convergence_the_recursive_filter_closes_the_same_loop_at_1_khz() -> None:
    """Joseph's recursion from the covariance of the open loop; the gain meets the Riccati one to 1e-6."""
    s = report(1e-10)
    p = model.plant()
    belief = Belief(np.zeros(10), noisy_loop(lqg_weights.coils(p), None, lqg_weights.ground(p), 1e-12).covariance)
    M, gap, k = s.filter.steady.filter_gain, np.inf, 0
    first = np.abs(s.schedule(belief.covariance, 2).gains[0] - M).max() / np.abs(M).max()
    while gap > 1e-6 and k < 20:  # 5 s at a time
        found = s.filter.schedule(belief, 5000)
        gap = float(np.abs(found.gains[-1] - M).max() / np.abs(M).max())
        belief = Belief(np.zeros(10), found.posterior[-1])
        belief = s.filter.predict(belief)
        k += 1
    assert first > 1.0  # there was something to converge
    assert gap <= 1e-6
    steady, recursive = (noisy_loop(s.plant, c, np.eye(10), s.filter.Q, V=s.filter.R)
                         for c in (s.controller, s.controller_with(found.gains[-1])))
    assert np.abs(recursive.A - steady.A).max() <= 1e-6 * np.abs(steady.A).max()
    f = np.geomspace(0.05, 400, 60)
    rows = steady.outputs(T_y[:3])
    assert recursive.psd(f, rows) == pytest.approx(steady.psd(f, rows), rel=1e-5)
    assert recursive.variance(steady.inputs()) == pytest.approx(steady.variance(steady.inputs()), rel=1e-5)


@pytest.mark.slow
def test_on_one_seed_both_filters_run_into_each_other() -> None:
    """The same noise, other starts of the covariance: after the transient the velocities agree to 1e-4 of their size."""
    s = report(1e-11, 5e-3)
    p = model.plant()
    P0 = 4 * noisy_loop(lqg_weights.coils(p), None, lqg_weights.ground(p), 1e-12).covariance
    steps = 12_000
    gains = s.schedule(P0, steps)
    noise = s.draw(steps, 3)
    a, b = (s.run(np.zeros(10), *noise, gains=g) for g in (None, gains))
    size = np.abs(a.y[-2000:]).max(axis=0)
    early = np.abs(a.x[:200] @ s.plant.C.T - b.x[:200] @ s.plant.C.T).max(axis=0) / size
    late = np.abs(a.x[-2000:] @ s.plant.C.T - b.x[-2000:] @ s.plant.C.T).max(axis=0) / size
    assert early.max() > 1e-2 and late.max() < 1e-4


def test_a_run_is_the_loop_of_its_controller() -> None:
    """One step at a time by the filter's own predict and update, against the run's matrices."""
    s = report(1e-9, 0.01)
    P0 = np.diag([1e-6] * 5 + [1e-4] * 5)
    gains = s.schedule(P0, 40)
    run = s.run(1e-3 * np.ones(10), *s.draw(40, 5), gains=gains)
    belief = Belief(np.zeros(10), P0)
    for k in range(40):
        belief = s.filter.update(belief, run.y[k])
        assert belief.mean == pytest.approx(run.xhat[k], rel=1e-6, abs=1e-12)
        assert run.u[k] == pytest.approx(-s.K @ belief.mean, rel=1e-6, abs=1e-12)
        belief = s.filter.predict(belief, run.u[k])


def test_a_run_settles_into_the_variance_of_its_loop_and_a_wrong_truth_can_break_it() -> None:
    plant = Plant([[0.5]], [[1.0]], [[1.0]])
    s = sampled_lqg(plant, [[1.0]], [[1.0]], 1.0, 0.1, 0.1)
    run = s.run([0.0], *s.draw(200_000, 1))
    loop = s.loop()
    assert np.var(run.x) == pytest.approx(loop.variance()[0], rel=0.03)
    assert np.var(run.u) == pytest.approx(loop.variance(loop.inputs())[0], rel=0.03)
    weak = Plant(s.plant.A, 0.2 * s.plant.B, s.plant.C, None, 0.1)
    silent = np.zeros((400, 1))
    assert abs(s.run([1.0], silent, silent).x[-1, 0]) < 1e-6
    assert abs(s.run([1.0], silent, silent, truth=weak).x[-1, 0]) > 1e2


def test_the_reduced_plant_gets_the_same_loop() -> None:
    """The report designs on eight states; its loop with the full plant is the one designed on ten."""
    p = model.plant()
    cut = balanced_truncation(p, 8).plant
    peaks = []
    for plant in (p, cut):
        d = lqg_weights.lqg(plant)
        loop = noisy_loop(lqg_weights.coils(p), d.controller, lqg_weights.ground(p), 1e-12, V=1e-18)
        assert loop.stable
        peaks.append(suppression(loop))
    assert peaks[0] == pytest.approx(peaks[1], abs=0.1)


def test_other_periods_and_direct_paths_are_refused() -> None:
    plant = Plant([[-1.0]], [[1.0]], [[1.0]], [[1.0]])
    with pytest.raises(EngineError, match="direct path"):
        sampled_lqg(plant, [[1.0]], [[1.0]], 1.0, 1.0, 0.1)
    with pytest.raises(EngineError, match="sampled every"):
        sampled_lqg(Plant([[0.5]], [[1.0]], [[1.0]], None, 0.1), [[1.0]], [[1.0]], 1.0, 1.0, 0.2)
