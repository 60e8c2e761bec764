"""Kalman filters: against 60-digit arithmetic and the Riccati solution; the laws of all filters are in test_laws.py."""

import mpmath
import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov, solve_discrete_are

from observer_lab.engine import Belief, EngineError, KalmanFilter, Plant, ShapeError, SquareRootFilter
from observer_lab.engine.filters import RootBelief, joseph, short_form
from observer_lab.plants.platform import model as platform

BOTH = pytest.mark.parametrize("kind", [KalmanFilter, SquareRootFilter])


def model(seed, n=3, m=2, p=2):
    """Matrices of a random stable filter problem with D, full covariances and cross-correlated noise."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A *= 0.95 / np.abs(np.linalg.eigvals(A)).max()
    Q, R = rng.standard_normal((n, n)), rng.standard_normal((p, p))
    return (A, rng.standard_normal((n, m)), rng.standard_normal((p, n)), Q @ Q.T, R @ R.T + 0.1 * np.eye(p),
            rng.standard_normal((p, m)))


def start_of(seed, n=3):
    rng = np.random.default_rng(seed + 100)
    half = rng.standard_normal((n, n))
    return Belief(rng.standard_normal(n), half @ half.T + np.eye(n))


def exact_update(P, C, R):
    """The a-posteriori covariance and gain in 60 digits."""
    with mpmath.workdps(60):
        P, C, R = (mpmath.matrix(M.tolist()) for M in (P, C, R))
        M = P * C.T * (C * P * C.T + R) ** -1
        after = P - M * C * P
        return np.array(after.tolist(), dtype=float), np.array(M.tolist(), dtype=float)


def test_two_nearly_equal_sensors_with_noise_1e_18_survive_in_roots_alone():
    """Sensors 1e-9 apart, R = 1e-18: S is singular to double precision, its root is not."""
    P, C, R = np.eye(3), np.array([[1.0, 1.0, 1.0], [1.0, 1.0, 1.0 + 1e-9]]), 1e-18 * np.eye(2)
    true, gain = exact_update(P, C, R)
    arguments = (np.eye(3), np.zeros((3, 1)), C, np.zeros((3, 3)), R)
    step = SquareRootFilter(*arguments).correct(Belief(np.zeros(3), P), [0.0, 0.0])
    np.testing.assert_allclose(step.belief.covariance, true, atol=1e-6)
    assert np.allclose(step.gain, gain, rtol=1e-5)

    def plain():
        return KalmanFilter(*arguments).update(Belief(np.zeros(3), P), [0.0, 0.0]).covariance

    try:
        assert np.abs(plain() - true).max() > 0.05
    except EngineError as refusal:  # S exactly singular
        assert "square-root" in str(refusal)


def test_roots_stay_right_over_many_steps_where_the_short_form_turns_negative() -> None:
    """How far rounding throws the short form depends on the processor: over many sensors it turns negative with some."""
    Q, R, lowest = 1e-12 * np.eye(3), 1e-18, []
    for seed in range(12):
        twice = np.random.default_rng(seed).uniform(0.5, 1.5, 3)
        arguments = (np.eye(3), np.zeros((3, 1)), np.array([twice, twice * [1, 1, 1 + 1e-7]]), Q, R)
        plain, roots = KalmanFilter(*arguments), SquareRootFilter(*arguments)
        short, safe = Belief(np.zeros(3), np.eye(3)), RootBelief.of(np.zeros(3), np.eye(3))
        for _ in range(40):
            safe = roots.predict(roots.update(safe, [0, 0]))
            short = plain.predict(plain.short_update(short, [0, 0]))
            lowest.append(np.linalg.eigvalsh((short.covariance + short.covariance.T) / 2)[0])
            assert np.linalg.eigvalsh(safe.covariance)[0] > 0
        assert np.isfinite(safe.covariance).all()
    assert min(lowest) < -1e-3


@pytest.mark.parametrize("size", [np.float32, np.float64])
def test_both_updates_stay_in_the_precision_given(size: type):
    """A comparison of rounding is one only if no form borrows digits."""
    P, C, R, M = (np.asarray(part, dtype=size) for part in (np.diag([2.0, 3.0]), [[1.0, 1.0]], [[1.0]], [[0.3], [0.5]]))
    assert joseph(P, C, R, M).dtype == short_form(P, C, M).dtype == size


def test_joseph_forgives_a_gain_that_is_a_little_wrong_and_the_short_form_does_not():
    P, C, R = np.diag([4.0, 1.0]), np.array([[1.0, 0.5]]), np.array([[0.5]])
    best = P @ C.T / (C @ P @ C.T + R)
    right = short_form(P, C, best)
    np.testing.assert_allclose(joseph(P, C, R, best), right, rtol=1e-13)
    wrong = best * (1 + 1e-4)
    assert 0 < np.trace(joseph(P, C, R, wrong) - right) < 1e-7  # second order, and never below the optimum
    assert np.trace(right - short_form(P, C, wrong)) > 1e-4  # first order, and it claims to be better


@BOTH
def test_gain_settles_on_the_riccati_solution_and_the_long_record_equals_one_by_one(kind):
    A, B, C, Q, R, D = model(3)
    filter_ = kind(A, B, C, Q, R, D)
    rng = np.random.default_rng(0)
    y, u = rng.standard_normal((500, 2)), rng.standard_normal((500, 2))
    track = filter_.run(start_of(3), y, u)
    assert track.settled is not None and 0 < track.settled < 200
    P = solve_discrete_are(A.T, C.T, Q, R)
    np.testing.assert_allclose(track.prior_covariances[-1], P, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(track.gains[-1], P @ C.T @ np.linalg.inv(C @ P @ C.T + R), atol=1e-9)
    belief = start_of(3)
    for k in range(500):
        np.testing.assert_allclose(track.predicted[k], belief.mean, rtol=1e-6, atol=1e-7)
        belief = filter_.update(belief, y[k], u[k])
        np.testing.assert_allclose(track.means[k], belief.mean, rtol=1e-6, atol=1e-7)
        belief = filter_.predict(belief, u[k])
    assert track.covariances.shape == (500, 3, 3) and track.S.shape == (500, 2, 2)


def test_a_filter_that_never_settles_says_so():
    """A constant measured without process noise: P = 1/(1 + k) for ever."""
    walk = KalmanFilter([[1.0]], [[0.0]], [[1.0]], 0.0, 1.0)
    track = walk.run(Belief([0.0], [[1.0]]), np.arange(300.0))
    assert track.settled is None
    np.testing.assert_allclose(track.variances[:, 0], 1 / (2 + np.arange(300)), rtol=1e-11)
    np.testing.assert_allclose(track.means[-1, 0], np.arange(300).sum() / 301, rtol=1e-12)


def test_a_schedule_serves_many_records():
    filter_, start = KalmanFilter(*model(5)), start_of(5)
    schedule = filter_.schedule(start, 60)
    rng = np.random.default_rng(5)
    for _ in range(3):
        y = rng.standard_normal((60, 2))
        np.testing.assert_array_equal(filter_.run(start, y, schedule=schedule).means, filter_.run(start, y).means)
    with pytest.raises(ShapeError, match="60"):
        filter_.run(start, np.zeros((50, 2)), schedule=schedule)


def test_discretisation_of_a_plant_is_exact_and_v_is_a_density():
    plant = Plant([[-2.0]], [[3.0]], [[1.0]])
    filter_ = KalmanFilter.from_plant(plant, 5.0, 0.2, dt=0.1)
    assert filter_.A.item() == pytest.approx(np.exp(-0.2), rel=1e-14)
    assert filter_.B.item() == pytest.approx(1.5 * (1 - np.exp(-0.2)), rel=1e-13)
    assert filter_.Q.item() == pytest.approx(9 * 5 * (1 - np.exp(-0.4)) / 4, rel=1e-12)  # w through B
    assert filter_.R.item() == pytest.approx(2.0, rel=1e-14)


def test_predicting_for_ever_gives_the_stationary_covariance_of_the_continuous_plant():
    A, G, W = np.array([[0.0, 1.0], [-9.0, -0.4]]), np.array([[0.0], [1.0]]), 2.0
    filter_ = KalmanFilter.from_plant(Plant(A, G, [[1.0, 0.0]]), W, 1.0, dt=0.37, G=G)
    belief = Belief(np.zeros(2), np.zeros((2, 2)))
    for _ in range(400):
        belief = filter_.predict(belief)
    np.testing.assert_allclose(belief.covariance, solve_continuous_lyapunov(A, -W * G @ G.T), atol=1e-12)


def test_sampled_plant_is_taken_as_it_is():
    plant = Plant([[0.9]], [[1.0]], [[1.0]], dt=0.1)
    filter_ = KalmanFilter.from_plant(plant, 2.0, 3.0)
    assert (filter_.A.item(), filter_.Q.item(), filter_.R.item(), filter_.dt) == (0.9, 2.0, 3.0, 0.1)
    with pytest.raises(EngineError, match=r"every 0\.1 s"):
        KalmanFilter.from_plant(plant, 2.0, 3.0, dt=0.2)


def test_platform_filter_started_steady_is_the_steady_observer():
    """The recursive filter and the steady-state gain are one filter, to 1e-6 and better."""
    plant = platform.plant()
    filter_ = KalmanFilter.from_plant(plant, 1e-12, 1e-12, dt=1e-3, G=plant.B[:, 3:])
    steady = filter_.steady
    track = filter_.run(Belief(np.zeros(10), steady.solution),
                        1e-6 * np.random.default_rng(2).standard_normal((400, 4)))
    assert track.settled == 0
    every = filter_.schedule(Belief(np.zeros(10), steady.solution), 50, seen=np.ones((50, 4), dtype=bool))
    np.testing.assert_allclose(every.gains[-1], steady.filter_gain, rtol=1e-6, atol=1e-9 * np.abs(every.gains).max())


@pytest.mark.slow
def test_critical_loss_of_a_scalar_plant():
    """E P⁺ = a²(1 − λ)E P … grows without bound when more than 1/a² of the packets are lost, and not when fewer."""
    a, steps, runs = 1.5, 60, 400
    filter_, start = KalmanFilter([[a]], [[0.0]], [[1.0]], 1.0, 1.0), Belief([0.0], [[1.0]])

    def mean_of_largest(loss):
        rng, priors = np.random.default_rng(8), np.empty(runs)
        for i in range(runs):
            seen = rng.random((steps, 1)) >= loss
            priors[i] = np.log(filter_.schedule(start, steps, seen=seen).prior[:, 0, 0]).max()
        return np.mean(priors > np.log(1e4))

    assert mean_of_largest(0.9) > 0.9 and mean_of_largest(0.2) < 0.01


@pytest.mark.parametrize("change, sentence", [
    ({"Q": np.diag([1.0, -1.0, 1.0])}, "negative eigenvalue"),
    ({"R": np.array([[1.0, 2.0], [0.0, 1.0]])}, "symmetric"),
    ({"R": np.eye(3)}, "R must be 2×2"),
    ({"C": np.eye(2)}, "C must have 3 columns"),
    ({"A": np.full((3, 3), np.nan)}, "NaN"),
])
def test_bad_matrices_get_one_sentence(change, sentence):
    A, B, C, Q, R, D = model(0)
    with pytest.raises(EngineError, match=sentence):
        KalmanFilter(**{**{"A": A, "B": B, "C": C, "Q": Q, "R": R, "D": D}, **change})


def test_two_perfect_equal_sensors_are_refused():
    doubled = (np.eye(1), np.zeros((1, 1)), np.ones((2, 1)), np.eye(1), np.zeros((2, 2)))
    for kind in (KalmanFilter, SquareRootFilter):
        with pytest.raises(EngineError, match="some noise R"):
            kind(*doubled).update(Belief([0.0], [[1.0]]), [1.0, 1.0])


def test_beliefs_are_immutable_and_copied():
    mean = np.zeros(2)
    belief = Belief(mean, np.eye(2))
    mean[0] = 5
    assert belief.mean[0] == 0
    with pytest.raises(ValueError):
        belief.mean[0] = 1
    with pytest.raises(ShapeError):
        Belief(np.zeros(2), np.eye(3))


@BOTH
def test_an_unknown_input_does_not_pass_for_a_missing_one(kind):
    filter_, belief = kind([[1.2]], [[1.0]], [[1.0]], 1.0, 1.0), Belief([0.0], [[1.0]])
    with pytest.raises(EngineError, match="u holds NaN"):
        filter_.update(belief, [1.0], [np.nan])
    with pytest.raises(EngineError, match="u holds NaN"):
        filter_.predict(belief, [np.nan])
