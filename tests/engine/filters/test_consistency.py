"""Consistency tests pass tuned filters at the level they claim, and name what is wrong with the others."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import trapezoid
from scipy.linalg import cholesky, solve_discrete_lyapunov
from scipy.stats import chi2, kstest

from observer_lab.engine import Belief, EngineError, KalmanFilter, ShapeError, chi2_band, innovation_test, nees, nis, psd
from observer_lab.engine.filters import AdcNoise, independent_errors, whiteness, with_coloured_noise

A, C = np.array([[0.95, 0.1], [-0.1, 0.9]]), np.eye(2)
Q, R = np.array([[0.3, 0.1], [0.1, 0.2]]), np.diag([1.0, 2.0])
TRUE = KalmanFilter(A, np.zeros((2, 1)), C, Q, R)


def record(seed, steps, noise=None):
    """States and measurements of the true model, started from the steady state's own spread."""
    rng = np.random.default_rng(seed)
    w = rng.standard_normal((steps, 2)) @ cholesky(Q)
    v = rng.standard_normal((steps, 2)) @ np.sqrt(R) if noise is None else noise
    x = np.zeros((steps, 2))
    for k in range(1, steps):
        x[k] = A @ x[k - 1] + w[k - 1]
    return x, x + v


def innovations(filter_, seed, steps=1200, noise=None, cut=200):
    track = filter_.run(Belief(np.zeros(filter_.n), filter_.steady.solution), record(seed, steps, noise)[1])
    return track.innovations[cut:], track.S[cut:]


def test_bands_are_the_published_ones():
    """Platform report, four sensors: one step [0.484, 11.143], the mean over 1000 in [3.827, 4.177]."""
    np.testing.assert_allclose(chi2_band(4), (0.484, 11.143), atol=5e-4)
    np.testing.assert_allclose(chi2_band(4, count=1000), (3.827, 4.177), atol=5e-4)


@settings(max_examples=30)
@given(dof=st.integers(1, 20), level=st.floats(0.5, 0.999))
def test_band_holds_its_probability(dof, level):
    low, high = chi2_band(dof, count=1, level=level)
    assert chi2.cdf(low, dof) == pytest.approx((1 - level) / 2, rel=1e-9)
    assert chi2.sf(high, dof) == pytest.approx((1 - level) / 2, rel=1e-9)


def test_nis_is_the_quadratic_form_and_chi_squared():
    nu, S = innovations(TRUE, 0)
    result = nis(nu, S)
    by_hand = [float(v @ np.linalg.inv(M) @ v) for v, M in zip(nu, S, strict=True)]
    np.testing.assert_allclose(result.values, by_hand, rtol=1e-10)
    assert result.dof == 2 and result.independent == 1000 and result.verdict == "consistent"
    np.testing.assert_allclose(result.mean_band, chi2_band(2, count=1000))
    assert result.inside == pytest.approx(0.95, abs=0.025)
    np.testing.assert_allclose(nis(nu, S[-1]).mean, result.mean, rtol=1e-6)
    assert kstest(result.values, chi2(2).cdf).pvalue > 0.01


def test_nis_does_not_depend_on_the_units_of_the_sensors():
    nu, S = innovations(TRUE, 1)
    unit = np.array([1e-9, 1e6])
    np.testing.assert_allclose(nis(nu * unit, S * np.outer(unit, unit)).values, nis(nu, S).values, rtol=1e-9)


def test_rows_without_a_measurement_are_left_out():
    nu, S = innovations(TRUE, 1)
    nu = nu.copy()
    nu[::4, 0] = np.nan
    result = nis(nu, S)
    assert result.independent == 750 and np.isnan(result.values[::4]).all()
    assert result.mean == pytest.approx(nis(nu[np.isfinite(nu[:, 0])], S[0]).mean, rel=1e-6)


@pytest.mark.parametrize("change, failure", [
    (KalmanFilter(A, np.zeros((2, 1)), C, Q, R / 4), "overconfident"),
    (KalmanFilter(A, np.zeros((2, 1)), C, Q, R * 3), "cautious"),
    (KalmanFilter(A, np.zeros((2, 1)), C, Q / 100, R), "coloured"),
])
def test_detuned_filters_are_flagged_by_name(change, failure):
    test = innovation_test(*innovations(change, 3))
    assert not test.passed and failure in test.failures


def test_a_constant_offset_is_flagged_as_bias_however_small_it_looks():
    """Report: means of 5e-10 'near zero' with σ = 1e-9 are tens of standard deviations off."""
    rng = np.random.default_rng(1)
    nu = 1e-9 * rng.standard_normal((20_000, 4)) + np.array([6.45e-12, -5.44e-10, -6.19e-12, -5.46e-10])
    test = innovation_test(nu, 1e-18 * np.eye(4))
    assert "biased" in test.failures
    assert (np.abs(test.scores[[1, 3]]) > 50).all() and (np.abs(test.scores[[0, 2]]) < 5).all()


@pytest.mark.slow
def test_tuned_filter_passes_as_often_as_the_level_says():
    passed = [innovation_test(*innovations(TRUE, seed, 700), lags=10, level=0.9).passed for seed in range(120)]
    assert 0.8 < np.mean(passed) < 0.98  # 0.9 ± 3 · 0.027


def test_ljung_box_of_a_known_series():
    """One channel by the textbook formula, written out; and Hosking's test reduces to it."""
    nu = np.sin(np.arange(50.0) ** 1.5)
    away = nu - nu.mean()
    r = np.array([away[k:] @ away[:50 - k] / (away @ away) for k in (1, 2, 3)])
    by_hand = 50 * 52 * (r**2 / (50 - np.array([1, 2, 3]))).sum()
    result = whiteness(nu, lags=3)
    np.testing.assert_allclose(result.correlation[:, 0], r, rtol=1e-12)
    factor = 52 / 50  # Ljung and Box use N (N + 2), Hosking N²
    np.testing.assert_allclose(result.statistics[0], by_hand, rtol=1e-12)
    np.testing.assert_allclose(result.joint * factor, by_hand, rtol=1e-12)
    assert result.p_values[0] == pytest.approx(chi2.sf(by_hand, 3), rel=1e-9)


def test_correlation_between_channels_is_seen_by_the_joint_test_alone():
    white = np.random.default_rng(2).standard_normal(2001)
    result = whiteness(np.column_stack([white[1:], white[:-1]]), lags=5)  # one channel is the other, a step later
    assert result.p_values.min() > 0.01 and result.p_value < 1e-9 and not result.white


def test_nees_over_runs_is_n_and_its_band_shrinks_with_the_runs():
    runs, steps = 40, 60
    true, mean, cov = np.empty((runs, steps, 2)), np.empty((runs, steps, 2)), None
    for i in range(runs):
        true[i], y = record(1000 + i, steps)
        track = TRUE.run(Belief(np.zeros(2), 1e-6 * np.eye(2)), y)
        mean[i], cov = track.means, track.covariances
    result = nees(true, mean, cov)
    assert result.dof == 2 and result.verdict == "consistent"
    np.testing.assert_allclose(result.band, chi2_band(2, count=runs))
    assert result.inside > 0.85
    assert 40 < result.independent <= 2400
    assert nees(true, mean, cov / 4).verdict == "overconfident"
    assert nees(true, mean, cov * 4).verdict == "cautious"


def test_neighbouring_errors_do_not_count_as_independent():
    """AR(1) errors with ρ = 0.95: ε = e² has ρ² as its own correlation, time (1 + ρ²)/(1 − ρ²)."""
    rng, rho, steps = np.random.default_rng(0), 0.95, 60_000
    e = np.zeros(steps)
    for k in range(1, steps):
        e[k] = rho * e[k - 1] + np.sqrt(1 - rho**2) * rng.standard_normal()
    result = nees(e[:, None], np.zeros((steps, 1)), [[1.0]])
    assert steps / result.independent == pytest.approx((1 + rho**2) / (1 - rho**2), rel=0.25)
    assert result.verdict == "consistent"


# --- the noise of a converter --------------------------------------------------------------------------------------
ADC = AdcNoise(sigma=1e-9, corner=5.0, lowest=0.05, dt=0.002)


def test_flicker_and_floor_are_equal_at_the_corner_and_fall_like_one_over_f_below():
    floor = 2 * 1e-18 * 0.002
    for f in (0.2, 0.5, 1.0, 5.0):
        assert ADC.density(f) == pytest.approx(floor * (1 + 5.0 / f), rel=0.12)
    assert ADC.density(100.0) == pytest.approx(floor, rel=0.06)


@pytest.mark.slow
def test_area_under_the_density_is_the_variance():
    f = np.linspace(0, 250, 2_000_001)
    area = trapezoid(ADC.density(f), f)
    assert area == pytest.approx(ADC.variance, rel=1e-5)


def test_draws_have_the_density():
    noise = ADC.draw(200_000, 2, np.random.default_rng(0))
    assert noise.shape == (200_000, 2)
    spectrum = psd(noise, 500.0, segment=20_000)
    for low, high in ((0.1, 0.4), (1, 3), (20, 60), (100, 240)):
        band = (spectrum.frequency > low) & (spectrum.frequency < high)
        ratio = spectrum.density[band].mean() / ADC.density(spectrum.frequency[band]).mean()
        assert ratio == pytest.approx(1, abs=0.25 if low < 1 else 0.08)
    first = ADC.draw(1, 2000, np.random.default_rng(5))
    assert first.var() == pytest.approx(ADC.variance, rel=0.12)  # stationary at once


def test_quantisation_adds_a_twelfth_of_a_step_squared():
    adc = AdcNoise(1.0, 0.0, 0.0, 0.01, step=0.8)
    y = np.random.default_rng(0).uniform(-50, 50, 100_000)
    error = adc.quantise(y) - y
    assert np.abs(error).max() <= 0.4 + 1e-12
    assert error.var() == pytest.approx(adc.variance - 1.0, rel=0.02)
    assert np.array_equal(ADC.quantise(y), y)


def test_coloured_noise_fails_the_plain_filter_and_passes_the_one_that_carries_it():
    adc = AdcNoise(sigma=1.0, corner=40.0, lowest=0.5, dt=0.005)
    noise = adc.draw(4200, 2, np.random.default_rng(3))
    plain = KalmanFilter(A, np.zeros((2, 1)), C, Q, np.eye(2) * adc.variance, dt=0.005)
    told = with_coloured_noise(plain, adc)
    assert told.n == 2 + 2 * len(adc.relaxations[0])
    assert "coloured" in innovation_test(*innovations(plain, 6, 4200, noise)).failures
    assert innovation_test(*innovations(told, 6, 4200, noise)).passed


@pytest.mark.parametrize("call, sentence", [
    (lambda: chi2_band(0), "degree of freedom"),
    (lambda: chi2_band(4, count=1, level=1.0), "between 0 and 1"),
    (lambda: nis(np.zeros((5, 2)), np.eye(3)), "S must be 2×2"),
    (lambda: nis(np.zeros((5, 2)), np.ones((2, 2))), "not positive definite"),
    (lambda: nis(np.zeros((5, 2)), np.diag([1.0, 0.0])), "zero or negative"),
    (lambda: nis(np.full((5, 1), np.nan), [[1.0]]), "Not one complete sample"),
    (lambda: nis(np.full((5, 1), np.inf), [[1.0]]), "infinity"),
    (lambda: nees(np.zeros((5, 2)), np.zeros((4, 2)), np.eye(2)), "must both be"),
    (lambda: nees(np.full((5, 1), np.nan), np.zeros((5, 1)), np.eye(1)), "NaN or infinity"),
    (lambda: whiteness(np.zeros((50, 1)), lags=5), "constant"),
    (lambda: whiteness(np.arange(10.0), lags=6), "between 1 and 5"),
    (lambda: whiteness(np.outer(np.sin(np.arange(50.0)), [1, -1]), lags=5), "copies of each other"),
    (lambda: AdcNoise(-1.0, 0.0, 0.0, 0.1), "at least 0"),
    (lambda: AdcNoise(1.0, 1.0, 2.0, 0.1), "lowest frequency"),
    (lambda: with_coloured_noise(KalmanFilter(A, np.zeros((2, 1)), C, Q, R, dt=0.1), ADC), "every 0.1 s"),
])
def test_bad_input_gets_one_sentence(call, sentence):
    with pytest.raises((EngineError, ShapeError), match=sentence):
        call()


# --- how many independent errors a record holds ----------------------------------------------------------------------------
def test_independent_errors_of_a_scalar_have_a_closed_form():
    """AR(1): cov(ε₀, ε_l) = 2 a^(2l), so N′ = N/(1 + 2Σ(1 − l/N) a^(2l))."""
    a, N = 0.8, 200
    lags = np.arange(1, N)
    expected = N / (1 + 2 * ((1 - lags / N) * a ** (2 * lags)).sum())
    assert independent_errors([[a]], [[3.0]], N) == pytest.approx(expected)
    assert independent_errors([[0.0]], [[3.0]], N) == pytest.approx(N)  # white errors: every sample counts
    assert independent_errors([[a]], [[3.0]], 1) == pytest.approx(1)


def test_the_variance_of_the_mean_of_nees_is_what_independent_errors_says():
    """5000 drawn records of a two-state error with correlated parts, and of one combination of the states."""
    Phi = np.array([[0.9, 0.3], [-0.2, 0.8]])
    P = solve_discrete_lyapunov(Phi, np.diag([1.0, 0.25]))
    rng, N, runs = np.random.default_rng(5), 60, 5000
    e = rng.multivariate_normal(np.zeros(2), P, runs)
    record = [e]
    for _ in range(N - 1):
        e = e @ Phi.T + rng.normal(size=(runs, 2)) * [1.0, 0.5]
        record.append(e)
    errors = np.stack(record, axis=1)
    for T in (np.eye(2), np.array([[1.0, -2.0]])):
        part, cov = errors @ T.T, T @ P @ T.T
        means = np.einsum("rki,ij,rkj->rk", part, np.linalg.inv(cov), part).mean(axis=1)
        count = independent_errors(Phi, P, N, T=T)
        assert means.var() == pytest.approx(2 * len(T) / count, rel=0.1)
        low, high = chi2_band(len(T), count=count)
        assert ((means < low) | (means > high)).mean() == pytest.approx(0.05, abs=0.02)  # Satterthwaite


def test_nees_takes_the_count_that_it_is_told():
    rng = np.random.default_rng(6)
    e = rng.normal(size=(3, 40, 2))
    told = nees(e, np.zeros_like(e), np.eye(2), independent=10.0)
    assert told.independent == pytest.approx(30) and told.mean_band == pytest.approx(chi2_band(2, count=30))
    with pytest.raises(EngineError, match="above 0"):
        nees(e, np.zeros_like(e), np.eye(2), independent=0.0)


@pytest.mark.parametrize("arguments, words", [
    ((np.eye(2), np.eye(3), 5), "n×n"), ((np.eye(2), np.eye(2), 0), "from 1 to"),
    ((1.1 * np.eye(2), np.eye(2), 5), "do not settle"),
    ((np.eye(2), np.zeros((2, 2)), 5), "positive definite"), ((np.eye(2), -np.eye(2), 5), "positive definite"),
])
def test_independent_errors_refuses_nonsense(arguments, words):
    with pytest.raises(EngineError, match=words):
        independent_errors(*arguments)


def test_a_constant_channel_is_constant_whatever_its_value():
    """The mean of a hundred times 0.1 is not quite 0.1; what was left over was tested for whiteness."""
    for value in (0.1, 1e9 / 3, 0.0):
        with pytest.raises(EngineError, match="is constant"):
            whiteness(np.full(100, value))
    with pytest.raises(EngineError, match="finite number"):
        chi2_band(np.nan)
