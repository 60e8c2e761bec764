"""Filters in a batch are the single filters run by run; consistency of EKF and UKF on the literature's cases."""

from itertools import pairwise

import numpy as np
import pytest

from observer_lab.engine import Belief, EngineError, ExtendedKalmanFilter, KalmanFilter, ShapeError, UnscentedKalmanFilter, chi2_band, nees
from observer_lab.engine.filters import (
    Beliefs,
    Experiment,
    LinearisedFilter,
    PrintedUnscentedFilter,
    Steering,
    errors_squared,
    simulate_filters,
)
from observer_lab.plants import cart_pendulum, growth

RUNS, STEPS = 6, 12
Q, R = np.diag([1e-5, 2e-5, 4e-4, 9e-4]), np.diag([4e-4, 9e-4])


def pendulum():
    plant = cart_pendulum.nonlinear_plant(sensor="both")
    flow = plant.flow(0.05, parts=2)
    rng = np.random.default_rng(5)
    P0 = np.diag([0.1, 0.2, 0.1, 0.3])**2
    x0 = np.sqrt(P0) @ rng.standard_normal((4, RUNS))
    inputs = rng.standard_normal((STEPS, 1))
    return plant, flow, Beliefs.alike(np.zeros(4), P0, RUNS), x0, inputs


def recorded(filters, steering=None, seed=1):
    plant, flow, start, x0, inputs = pendulum()
    experiment = Experiment(flow, plant.output, Q, R, x0, start, inputs, filters, steering)
    return list(simulate_filters(experiment, np.random.default_rng(seed)))


def test_each_run_of_a_batch_is_the_single_filter_on_that_run():
    plant, flow, start, _, _ = pendulum()
    weights = {"alpha": 0.6, "beta": 1.5, "kappa": -1.0}
    many = {"EKF": ExtendedKalmanFilter(flow, plant.output, Q, R, h_expand=plant.observe),
            "stepped": ExtendedKalmanFilter(lambda x, u: flow(x, u), plant.output, Q, R),
            "UKF": UnscentedKalmanFilter(flow, plant.output, Q, R, **weights)}
    ekf = ExtendedKalmanFilter(flow, plant.output, Q, R)
    single = {"EKF": ekf, "stepped": ekf, "UKF": UnscentedKalmanFilter(flow, plant.output, Q, R, **weights)}
    samples = recorded(many)
    for name, one in single.items():
        for run in range(RUNS):
            y, u = np.array([s.y[:, run] for s in samples]), np.array([s.u[:, 0] for s in samples])
            track = one.run(Belief(np.zeros(4), start.covariance[0]), y, u)
            for k, s in enumerate(samples):
                step = s.corrections[name]
                np.testing.assert_allclose(step.beliefs.mean[:, run], track.means[k], rtol=1e-9, atol=1e-11)
                np.testing.assert_allclose(step.beliefs.covariance[run], track.covariances[k], rtol=1e-8, atol=1e-12)
                np.testing.assert_allclose(step.S[run], track.S[k], rtol=1e-9, atol=1e-15)
                np.testing.assert_allclose(step.innovation[:, run], track.innovations[k], rtol=1e-7, atol=1e-10)


def linear(seed=0, n=4, m=2, p=3):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A *= 0.95 / np.abs(np.linalg.eigvals(A)).max()
    B, C = rng.standard_normal((n, m)), rng.standard_normal((p, n))
    W, V = rng.standard_normal((n, n)), rng.standard_normal((p, p))
    return KalmanFilter(A, B, C, W @ W.T, V @ V.T + 0.1 * np.eye(p))


def on_linear(kinds, runs=5, steps=25, seed=0):
    kf = linear(seed)
    f, h = (lambda x, u: kf.A @ x + kf.B @ u), (lambda x, u: kf.C @ x)
    rng = np.random.default_rng(seed)
    start = Beliefs.alike(np.zeros(4), 2 * np.eye(4), runs)
    filters = {name: make(f, h, kf.Q, kf.R) for name, make in kinds.items()}
    e = Experiment(f, h, kf.Q, kf.R, np.sqrt(2) * rng.standard_normal((4, runs)), start, rng.standard_normal((steps, 2)), filters)
    return kf, list(simulate_filters(e, rng))


KINDS = {
    "linear": lambda f, h, Q, R: LinearisedFilter(f, h, Q, R, np.ones(4), np.ones(2)),
    "extended": ExtendedKalmanFilter,
    "unscented": UnscentedKalmanFilter,
    "unscented, alpha 0.3": lambda *a: UnscentedKalmanFilter(*a, alpha=0.3),
}


@pytest.mark.parametrize("seed", range(3))
def test_on_a_linear_plant_all_of_them_are_the_kalman_filter(seed):
    kf, samples = on_linear(KINDS, seed=seed)
    for run in range(5):
        y, u = np.array([s.y[:, run] for s in samples]), np.array([s.u[:, 0] for s in samples])
        track = kf.run(Belief(np.zeros(4), 2 * np.eye(4)), y, u)
        for name in KINDS:
            for k, s in enumerate(samples):
                P = s.corrections[name].beliefs.covariance
                np.testing.assert_allclose(s.corrections[name].beliefs.mean[:, run], track.means[k], rtol=1e-8, atol=1e-9)
                np.testing.assert_allclose(P[min(run, len(P) - 1)], track.covariances[k], rtol=1e-8, atol=1e-9)


def test_the_printed_algorithm_is_not_the_kalman_filter_on_a_linear_plant():
    """Each run takes C F P Fᵀ (C F P Fᵀ Cᵀ + R)⁻¹, Q left out, for its gain; the gap to the right filter is no rounding."""
    kf, samples = on_linear({"right": UnscentedKalmanFilter, "printed": PrintedUnscentedFilter})
    first, second = samples[:2]
    for run in range(5):
        before = first.corrections["printed"].beliefs
        mean, moved = kf.A @ before.mean[:, run] + kf.B @ first.u[:, 0], kf.A @ before.covariance[run] @ kf.A.T
        S = kf.C @ moved @ kf.C.T + kf.R
        M = moved @ kf.C.T @ np.linalg.inv(S)
        after = second.corrections["printed"].beliefs
        np.testing.assert_allclose(after.mean[:, run], mean + M @ (second.y[:, run] - kf.C @ mean), rtol=1e-9, atol=1e-10)
        np.testing.assert_allclose(after.covariance[run], moved + kf.Q - M @ S @ M.T, rtol=1e-9, atol=1e-10)
    gaps = [np.abs(s.corrections["printed"].beliefs.mean - s.corrections["right"].beliefs.mean).max() for s in samples]
    assert gaps[0] < 1e-12 and min(gaps[1:]) > 0.05


def test_steering_uses_the_named_estimate_and_its_limits():
    plant, flow, _, _, _ = pendulum()
    filters = {"EKF": ExtendedKalmanFilter(flow, plant.output, Q, R), "UKF": UnscentedKalmanFilter(flow, plant.output, Q, R)}
    K = np.array([[-1.0, -30.0, -2.0, -8.0]])
    inputs = pendulum()[-1]
    samples = recorded(filters, Steering("UKF", K, np.array([3.0])))
    for s in samples:
        wanted = np.clip(inputs[s.k][:, None] - K @ s.corrections["UKF"].beliefs.mean, -3.0, 3.0)
        np.testing.assert_allclose(s.u, wanted)
    assert any((np.abs(s.u) == 3.0).any() for s in samples)


def test_a_kick_reaches_the_plant_and_no_filter_is_told():
    plant, flow, start, x0, inputs = pendulum()
    filters = {"EKF": ExtendedKalmanFilter(flow, plant.output, Q, R)}
    both = [list(simulate_filters(Experiment(flow, plant.output, Q, R, x0, start, inputs, filters, None, kicks),
                                  np.random.default_rng(1)))
            for kicks in ((), ((4, np.array([0.0, 0.0, 0.0, 1.0])),))]
    np.testing.assert_array_equal(both[0][3].x, both[1][3].x)
    np.testing.assert_allclose(both[1][4].x[3] - both[0][4].x[3], 1.0)
    assert np.abs(both[1][4].corrections["EKF"].beliefs.mean - both[0][4].corrections["EKF"].beliefs.mean).max() < 1e-12
    assert np.abs(both[1][5].corrections["EKF"].innovation - both[0][5].corrections["EKF"].innovation).max() > 0.01


def test_squared_errors_are_those_of_nees_and_survive_a_covariance_that_is_none():
    rng = np.random.default_rng(0)
    e, L = rng.standard_normal((5, 9, 3)), rng.standard_normal((5, 9, 3, 3))
    P = L @ L.swapaxes(-1, -2) + 0.1 * np.eye(3)
    ours = errors_squared(e, P)
    np.testing.assert_allclose(ours.mean(axis=0), nees(e, np.zeros_like(e), P).values, rtol=1e-10)
    P[2, 4] = np.diag([1.0, 1.0, -1.0])
    broken = errors_squared(e, P)
    assert np.isnan(broken[2, 4])
    good = np.ones((5, 9), dtype=bool)
    good[2, 4] = False
    np.testing.assert_allclose(broken[good], ours[good], rtol=1e-9)
    np.testing.assert_allclose(errors_squared(e[..., :1], P[..., :1, :1]), e[..., 0]**2 / P[..., 0, 0])


def test_a_filter_that_loses_its_numbers_is_given_up_and_said_to_be():
    def explode(x, u):
        return np.where(np.abs(x) > 3, np.inf, 2 * x)

    rng = np.random.default_rng(0)
    e = Experiment(lambda x, u: 0.5 * x, lambda x, u: x, np.eye(1), np.eye(1), rng.standard_normal((1, 8)),
                   Beliefs.alike([0.0], [[1.0]], 8), np.zeros((20, 0)),
                   {"bad": UnscentedKalmanFilter(explode, lambda x, u: x, 0.01 * np.eye(1), np.eye(1), alpha=0.2)})
    samples = list(simulate_filters(e, rng))
    assert len(samples) == 20 and not samples[0].lost["bad"].any() and samples[-1].lost["bad"].any()
    for s in samples:
        assert np.isfinite(s.corrections["bad"].beliefs.mean).all()
    for before, after in pairwise(samples):
        assert (after.lost["bad"] >= before.lost["bad"]).all()


def test_semidefinite_beliefs_have_sigma_points():
    ukf = UnscentedKalmanFilter(lambda x, u: x, lambda x, u: x[:1], np.zeros((2, 2)), np.array([[1.0]]))
    after = ukf.predict(Beliefs.alike([1.0, 2.0], np.diag([1.0, 0.0]), 3), np.zeros((0, 1)))
    np.testing.assert_allclose(after.covariance, np.repeat(np.diag([1.0, 0.0])[None], 3, axis=0), atol=1e-11)


@pytest.mark.parametrize("alpha, kappa, low, high", [(0.5, 2.0, 86.0, 89.6), (1.0, 0.0, 68.5, 76.5)])
def test_growth_model_gives_the_mean_squares_of_the_toolbox(alpha, kappa, low, high):
    """Hartikainen, Solin and Särkkä: 87.9242 for their unscented filter (α = ½, β = 2, κ = 2), 72.3755 for the cubature one."""
    beta = 2.0 if alpha < 1 else 0.0
    ukf = UnscentedKalmanFilter(growth.step, growth.seen, np.eye(1), np.eye(1), alpha, beta, kappa)
    for seed in range(3):
        assert low < growth_errors(ukf, seed)[0] < high


def growth_errors(filter_, seed, runs=100, steps=500):
    """Mean square error and mean NEES."""
    rng = np.random.default_rng(seed)
    inputs = np.array([[growth.drive(k + 1)] for k in range(1, steps)] + [[0.0]])
    x1 = growth.step(np.full((1, runs), growth.X0), np.array([[growth.drive(1)]])) + rng.standard_normal((1, runs))
    start = filter_.predict(Beliefs.alike([growth.X0], [[growth.P0]], runs), np.array([[growth.drive(1)]]))
    e = Experiment(growth.step, growth.seen, np.eye(1), np.eye(1), x1, start, inputs, {"one": filter_})
    squares, scaled = [], []
    for s in simulate_filters(e, rng):
        error = s.x - s.corrections["one"].beliefs.mean
        squares.append(np.mean(error**2))
        scaled.append(np.mean(errors_squared(error.T, s.corrections["one"].beliefs.covariance)))
    return float(np.mean(squares)), float(np.mean(scaled))


@pytest.mark.slow
def test_growth_model_makes_the_extended_filter_overconfident_for_every_seed_and_not_the_unscented():
    ekf = ExtendedKalmanFilter(growth.step, growth.seen, np.eye(1), np.eye(1), growth.step_expanded, growth.seen_expanded)
    ukf = UnscentedKalmanFilter(growth.step, growth.seen, np.eye(1), np.eye(1))
    for seed in range(5):
        high = chi2_band(1, count=100 * 500)[1]
        assert growth_errors(ekf, seed)[1] > 30 * high
        assert growth_errors(ukf, seed)[1] < high  # cautious: about a half


@pytest.mark.parametrize("call, sentence", [
    (lambda: UnscentedKalmanFilter(np.sin, np.sin, np.eye(2), np.eye(1), alpha=1e-3), "between 0.1 and 1"),
    (lambda: UnscentedKalmanFilter(np.sin, np.sin, np.eye(2), np.eye(1), kappa=-2.0), "larger than"),
    (lambda: UnscentedKalmanFilter(np.sin, np.sin, -np.eye(2), np.eye(1)), "negative eigenvalue"),
    (lambda: ExtendedKalmanFilter(np.sin, np.sin, np.eye(2), np.eye(2)).predict(Beliefs.alike([0.0], [[1.0]], 2), np.zeros((0, 1))),
     "1 states but Q is 2×2"),
    (lambda: ExtendedKalmanFilter(np.sin, np.sin, np.eye(2), np.eye(2)).predicted(
        Beliefs.alike([0.0, 0.0], np.eye(2), 1), np.zeros((2, 1, 1))), "call predict"),
    (lambda: next(simulate_filters(Experiment(np.sin, np.sin, np.eye(1), np.eye(1), np.zeros((1, 3)),
                                              Beliefs.alike([0.0], [[1.0]], 2),
                                   np.zeros((2, 0)), {}), np.random.default_rng(0))), "true states are"),
    (lambda: list(simulate_filters(Experiment(lambda x, u: x * 1e8, lambda x, u: x, np.eye(1), np.eye(1),
                                              np.ones((1, 2)),
                                   Beliefs.alike([0.0], [[1.0]], 2), np.zeros((9, 0)), {}), np.random.default_rng(0))),
     "left the region"),
])
def test_bad_batches_get_one_sentence(call, sentence):
    with pytest.raises((EngineError, ShapeError), match=sentence):
        call()


def test_a_run_is_not_touched_by_the_breakdown_of_another():
    """One covariance without a Cholesky factor changed the sigma points of all runs beside it."""
    rng = np.random.default_rng(2)
    P = np.array([[2.0, 0.9, 0.3], [0.9, 1.0, 0.1], [0.3, 0.1, 0.5]])
    ukf = UnscentedKalmanFilter(lambda x, u: np.sin(x) + x**3, lambda x, u: x[:1]**2, 0.01 * np.eye(3), np.eye(1))
    mean = rng.standard_normal((3, 2))
    alone = ukf.predict(Beliefs(mean[:, :1], P[None]), np.zeros((0, 1)))
    for broken in (np.diag([1.0, 1.0, 0.0]), np.diag([1.0, -1e-3, 1.0]), np.full((3, 3), np.nan)):
        beside = ukf.predict(Beliefs(mean, np.stack([P, broken])), np.zeros((0, 1)))
        np.testing.assert_allclose(beside.mean[:, 0], alone.mean[:, 0], rtol=1e-13)
        np.testing.assert_allclose(beside.covariance[0], alone.covariance[0], rtol=1e-12)


@pytest.mark.parametrize("kind", [ExtendedKalmanFilter, UnscentedKalmanFilter])
def test_measurements_that_fit_neither_h_nor_R_are_told_in_a_sentence(kind):
    start = Beliefs.alike([0.0, 0.0], np.eye(2), 3)
    for rows, R, words in ((2, np.eye(1), "a row for each output of h"), (1, np.eye(2), "h must return 2 rows")):
        with pytest.raises(ShapeError, match=words):
            kind(lambda x, u: x, lambda x, u: x[:1], np.eye(2), R).correct(start, np.zeros((rows, 3)), np.zeros((0, 1)))


def test_a_direct_path_of_the_input_is_counted_with():
    """The filter expanded once left D u out of the reading it expected."""
    kf = linear(4)
    D = np.random.default_rng(1).standard_normal((3, 2))
    through = KalmanFilter(kf.A, kf.B, kf.C, kf.Q, kf.R, D)
    f, h = (lambda x, u: kf.A @ x + kf.B @ u), (lambda x, u: kf.C @ x + D @ u)
    filters = {name: make(f, h, kf.Q, kf.R) for name, make in KINDS.items()}
    e = Experiment(f, h, kf.Q, kf.R, np.ones((4, 2)), Beliefs.alike(np.zeros(4), np.eye(4), 2),
                   np.random.default_rng(2).standard_normal((15, 2)), filters)
    samples = list(simulate_filters(e, np.random.default_rng(3)))
    y, u = np.array([s.y[:, 1] for s in samples]), np.array([s.u[:, 0] for s in samples])
    means = through.run(Belief(np.zeros(4), np.eye(4)), y, u).means
    for name in KINDS:
        found = np.array([s.corrections[name].beliefs.mean[:, 1] for s in samples])
        np.testing.assert_allclose(found, means, rtol=1e-8, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("bad", [np.inf, np.nan, -1.0])
def test_a_covariance_that_is_none_gives_no_number_and_spoils_no_other(bad: float) -> None:
    P = np.stack([np.eye(3)] * 4)
    P[1, 0, 0] = P[2, 0, 1] = P[2, 1, 0] = bad
    P[2, 1, 1] = bad
    squares = errors_squared(np.ones((4, 3)), P)
    assert np.isnan(squares[1:3]).all() and np.allclose(squares[[0, 3]], 3.0)
