"""Extended and unscented filters: derivatives exact, honest where EKF is not; on linear plants test_laws.py has them."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from observer_lab.engine import Belief, EngineError, ExtendedKalmanFilter, KalmanFilter, ShapeError, UnscentedKalmanFilter, nees
from observer_lab.engine.filters import Beliefs, PrintedUnscentedFilter
from observer_lab.engine.systems import each_column, slopes


def test_without_the_redraw_the_printed_algorithm_is_not_the_kalman_filter():
    """Algorithm 3 leaves Q out of P_xy: its gain is C F P Fᵀ/(… + R), not C (F P Fᵀ + Q)/(…)."""
    kalman = KalmanFilter([[0.5]], [[0.0]], [[1.0]], 3.0, 1.0)
    ukf = UnscentedKalmanFilter(lambda x, u: 0.5 * x, lambda x, u: x, np.array([[3.0]]), np.array([[1.0]]))
    start = Belief([0.0], [[4.0]])
    right = kalman.update(kalman.predict(start), [1.0])
    assert ukf.update(ukf.predict(start), [1.0]).mean.item() == pytest.approx(right.mean.item(), rel=1e-14)
    assert right.mean.item() == pytest.approx(4 / 5, rel=1e-14)  # P⁻ = 0.25·4 + 3 = 4
    as_printed = PrintedUnscentedFilter(ukf.f, ukf.h, ukf.Q, ukf.R)
    printed = as_printed.correct(as_printed.predict(Beliefs.alike([0.0], [[4.0]], 1)), np.ones((1, 1))).beliefs
    assert printed.mean.item() == pytest.approx(1 / 2, rel=1e-14)  # P_xy = 1, S = 1 + 1
    assert printed.covariance.item() == pytest.approx(4 - 0.5, rel=1e-14)  # it also believes 3.5 instead of 0.8


@settings(max_examples=50)
@given(a=st.floats(-3, 3), b=st.floats(-3, 3), u=st.floats(-2, 2))
def test_complex_step_is_exact_to_rounding(a, b, u):
    def f(x, u):
        return np.stack([np.sin(x[0]) * np.exp(x[1] / 3) + u[0] * x[0], x[1] ** 3 / (2 + np.cos(x[0]))])

    values, each = slopes(f, np.array([[a], [b]]), np.array([[u]]), name="f", rows=2)
    value, slope = values[:, 0], each[0]
    with mpmath.workdps(40):
        def exact(i):
            def g(x, y):
                sine = mpmath.sin(x) * mpmath.exp(y / 3) + u * x
                return sine if i == 0 else y**3 / (2 + mpmath.cos(x))
            return g
        for i in range(2):
            assert value[i] == pytest.approx(float(exact(i)(mpmath.mpf(a), mpmath.mpf(b))), rel=1e-14, abs=1e-14)
            for j, order in enumerate(((1, 0), (0, 1))):
                true = float(mpmath.diff(exact(i), (mpmath.mpf(a), mpmath.mpf(b)), order))
                assert slope[i, j] == pytest.approx(true, rel=1e-13, abs=1e-13)


def test_given_slopes_and_the_complex_step_agree():
    def f(x, u):
        return np.stack([x[0] + 0.1 * x[1], x[1] - 0.1 * np.sin(x[0]) + 0.1 * u[0]])

    def f_expand(x, u):
        return f(x, u), np.array([[[1, 0.1], [-0.1 * np.cos(angle), 1]] for angle in x[0]])

    def h(x, u):
        return x[:1] ** 2

    def h_expand(x, u):
        return h(x, u), np.array([[[2 * position, 0.0]] for position in x[0]])

    Q, R = 1e-3 * np.eye(2), np.array([[0.1]])
    rng = np.random.default_rng(0)
    y, u, start = rng.standard_normal((30, 1)), rng.standard_normal((30, 1)), Belief([0.5, 0.1], 0.1 * np.eye(2))
    by_step = ExtendedKalmanFilter(f, h, Q, R).run(start, y, u)
    by_hand = ExtendedKalmanFilter(f, h, Q, R, f_expand, h_expand).run(start, y, u)
    np.testing.assert_allclose(by_step.means, by_hand.means, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(by_step.covariances, by_hand.covariances, rtol=1e-11, atol=1e-14)


@pytest.mark.parametrize("lossy", [lambda x, u: np.abs(x), lambda x, u: x.astype(float)])  # no imaginary part comes back
def test_a_map_that_loses_the_complex_step_has_the_slope_of_its_differences(lossy):
    P = np.array([[0.2, 0.1], [0.1, 0.3]])
    led = ExtendedKalmanFilter(lossy, lambda x, u: x, np.zeros((2, 2)), np.eye(2)).predict(Belief(np.array([1.0, -1.0]), P))
    S = np.diag(lossy(np.array([[1.0], [-1.0]]), None)[:, 0] * [1.0, -1.0])
    np.testing.assert_allclose(led.covariance, S @ P @ S, rtol=1e-8)


def test_a_map_that_mixes_its_columns_is_refused_not_believed():
    def wrong(x, u):
        return np.stack([float(v) for v in x[:, 0]])[:, None] * np.ones((1, x.shape[1]))
    with pytest.raises(EngineError, match="give its slope"):
        ExtendedKalmanFilter(wrong, lambda x, u: x, np.eye(2), np.eye(2)).predict(Belief(np.ones(2), np.eye(2)))


def test_unscented_moments_of_a_square_are_exact():
    """x ~ N(m, P): E x² = m² + P, Var x² = 4 m² P + 2 P², with κ = 2, β = 0 (fourth moment) and with α = 1, β = 2."""
    m, P = 1.3, 0.7
    for weights in ({"kappa": 2.0, "beta": 0.0}, {}):
        ukf = UnscentedKalmanFilter(lambda x, u: x**2, lambda x, u: x, np.array([[0.0]]), np.array([[1.0]]), **weights)
        after = ukf.predict(Belief([m], [[P]]))
        assert after.mean.item() == pytest.approx(m**2 + P, rel=1e-13)
        assert after.covariance.item() == pytest.approx(4 * m**2 * P + 2 * P**2, rel=1e-13)
    ekf = ExtendedKalmanFilter(lambda x, u: x**2, lambda x, u: x, np.array([[0.0]]), np.array([[1.0]]))
    assert ekf.predict(Belief([m], [[P]])).mean.item() == pytest.approx(m**2, rel=1e-14)  # what the expansion misses


def test_polar_measurement_makes_the_extended_filter_overconfident_and_not_the_unscented():
    """Range and bearing of a distant point, bearing poor: the classic of Julier and Uhlmann, judged by NEES."""
    Q, R = np.zeros((2, 2)), np.diag([0.02, np.deg2rad(15.0)]) ** 2

    def h(x, u):
        return np.stack([np.sqrt(x[0] ** 2 + x[1] ** 2), 2 * np.arctan(x[1] / (x[0] + np.sqrt(x[0]**2 + x[1]**2)))])

    def keep(x, u):
        return x

    rng, prior = np.random.default_rng(4), np.diag([0.15, 0.25]) ** 2
    filters = ExtendedKalmanFilter(keep, h, Q, R), UnscentedKalmanFilter(keep, h, Q, R)
    true = np.array([1.0, 0.0]) + rng.standard_normal((300, 2)) @ np.sqrt(prior)
    means, spreads = np.empty((2, 300, 1, 2)), np.empty((2, 300, 1, 2, 2))
    for i, x in enumerate(true):
        y = h(x[:, None], None)[:, 0] + rng.standard_normal(2) @ np.sqrt(R)
        for j, filter_ in enumerate(filters):
            after = filter_.update(Belief([1.0, 0.0], prior), y)
            means[j, i, 0], spreads[j, i, 0] = after.mean, after.covariance
    extended, unscented = (nees(true[:, None, :], means[j], spreads[j]) for j in range(2))
    assert extended.verdict == "overconfident" and extended.mean > 4  # 2 is right
    assert unscented.mean < 0.6 * extended.mean and unscented.mean < 2.6


def test_functions_of_one_state_are_wrapped():
    def f(x, u):
        return np.array([x[1], -x[0] + u[0]]) if x.real.sum() < 100 else x

    wrapped = each_column(f)
    Q, R, start = 0.1 * np.eye(2), np.eye(2), Belief([1.0, 2.0], np.eye(2))
    for kind in (ExtendedKalmanFilter, UnscentedKalmanFilter):
        after = kind(wrapped, each_column(lambda x, u: x), Q, R).predict(start, [3.0])
        np.testing.assert_allclose(after.mean, [2.0, 2.0], atol=1e-14)
        np.testing.assert_allclose(after.covariance, 1.1 * np.eye(2), atol=1e-14)


def test_semidefinite_beliefs_have_sigma_points():
    ukf = UnscentedKalmanFilter(lambda x, u: x, lambda x, u: x[:1], np.zeros((2, 2)), np.array([[1.0]]))
    after = ukf.predict(Belief([1.0, 2.0], np.diag([1.0, 0.0])))
    np.testing.assert_allclose(after.covariance, np.diag([1.0, 0.0]), atol=1e-14)


@pytest.mark.parametrize("call, sentence", [
    (lambda: UnscentedKalmanFilter(np.sin, np.sin, np.eye(2), np.eye(1), alpha=1e-3), "between 0.1 and 1"),
    (lambda: UnscentedKalmanFilter(np.sin, np.sin, np.eye(2), np.eye(1), kappa=-2.0), "larger than"),
    (lambda: UnscentedKalmanFilter(np.sin, np.sin, -np.eye(2), np.eye(1)), "negative eigenvalue"),
    (lambda: UnscentedKalmanFilter(lambda x, u: x[:1], np.sin, np.eye(2), np.eye(1)).predict(Belief([0, 0], np.eye(2))),
     "f must return 2 rows"),
    (lambda: UnscentedKalmanFilter(lambda x, u: x / 0.0 * 0, np.sin, np.eye(1), np.eye(1)).predict(Belief([0], [[1]])),
     "left the region"),
    (lambda: ExtendedKalmanFilter(lambda x, u: x, lambda x, u: x, np.eye(2), np.eye(2), lambda x, u: (x, np.eye(3)[None]))
     .predict(Belief([0, 0], np.eye(2))), "Jacobian of f must be 2×2"),
    (lambda: ExtendedKalmanFilter(lambda x, u: x, lambda x, u: x, np.eye(2), np.eye(2)).update(
        Belief([0, 0], np.eye(2)), [1.0]), "y must hold 2"),
    (lambda: ExtendedKalmanFilter(lambda x, u: x, lambda x, u: x, np.eye(2), np.eye(2)).predict(
        Belief([0], [[1.0]])), "1 states but Q is 2×2"),
])
def test_bad_filters_get_one_sentence(call, sentence):
    with np.errstate(all="ignore"), pytest.raises((EngineError, ShapeError), match=sentence):
        call()


@pytest.mark.parametrize("sensors", [1, 20])
def test_a_reading_whose_square_overflows_is_taken_in(sensors: int) -> None:
    ekf = ExtendedKalmanFilter(lambda x, u: x, lambda x, u: np.repeat(x, sensors, axis=0), np.eye(1), np.eye(sensors))
    mean = ekf.update(Belief([0], [[1]]), np.full(sensors, 1e200)).mean
    np.testing.assert_allclose(mean, 1e200 * sensors / (sensors + 1), rtol=1e-12)
