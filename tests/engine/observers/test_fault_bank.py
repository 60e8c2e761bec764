"""Banks: white residuals, exact decoupling, thresholds that let through what they promise, and the one quiet member."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import ncx2

from observer_lab.engine import EngineError, KalmanFilter, Plant, ShapeError, innovation_test, residual_generator
from observer_lab.engine.observers import (
    FaultBank,
    alarm_probability,
    binomial_band,
    isolate,
    needed_noncentrality,
    residual_threshold,
    window_energy,
    window_mean,
)

RNG = np.random.default_rng(4)
A = np.array([[0.9, 0.2, 0.0, 0.0], [-0.2, 0.9, 0.1, 0.0], [0.0, 0.0, 0.8, 0.3], [0.1, 0.0, -0.3, 0.7]])
B = np.array([[1.0, 0.0], [0.0, 0.5], [0.5, 1.0], [0.0, 1.0]])
C = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0.5], [0, 0, 1.0, 0], [0.3, 0, 0, 1.0]])
Q = 0.02 * np.diag([1.0, 2.0, 1.0, 3.0])
R = 0.1 * np.array([[1.0, 0.3, 0, 0], [0.3, 2.0, 0, 0], [0, 0, 1.0, 0.2], [0, 0, 0.2, 0.5]])
MODEL = KalmanFilter(A, B, C, Q, R, dt=0.1)


def members():
    sensors = tuple(residual_generator(MODEL, name=f"y{i}", outputs=[j for j in range(4) if j != i]) for i in range(4))
    return sensors + tuple(residual_generator(MODEL, name=f"u{j}", outputs=None, E=B[:, [j]]) for j in range(2))


BANK = FaultBank(MODEL, members())


def record(seed, steps, missing=None, fault=None):
    """y, u and x(0) of the model; `missing` (steps, 2) is what the actuators do not deliver, `fault` is added to y."""
    rng = np.random.default_rng(seed)
    w, v = (rng.standard_normal((steps, 4)) @ np.linalg.cholesky(M).T for M in (Q, R))
    u, x = np.sin(0.3 * np.arange(steps))[:, None] * [1.0, 2.0], 3 * rng.standard_normal(4)
    x0, y = x, np.empty((steps, 4))
    for k in range(steps):
        y[k] = C @ x + v[k]
        x = A @ x + B @ (u[k] - (0 if missing is None else missing[k])) + w[k]
    return y + (0 if fault is None else fault), u, x0, rng


def residuals(seed, steps, **faults):
    y, u, x0, rng = record(seed, steps, **faults)
    return BANK.run(y, u, BANK.start(x0, rng=rng))[0]


def test_every_residual_is_white_with_unit_covariance():
    rho = residuals(1, 20_000)
    for i in range(len(BANK.members)):
        assert innovation_test(rho[:, i], np.eye(3), level=0.999).passed, BANK.members[i].name
        assert np.allclose(np.cov(rho[:, i].T), np.eye(3), atol=0.04)


@pytest.mark.slow
def test_the_first_residual_is_already_as_the_last():
    """Errors drawn from the steady covariance: no transient, so that rates hold from the first window on."""
    first = np.stack([residuals(seed, 2)[0] for seed in range(2000)])
    for i in range(len(BANK.members)):
        assert np.allclose(np.cov(first[:, i].T), np.eye(3), atol=0.15)


def test_without_unknown_input_it_is_the_kalman_filter():
    plain = residual_generator(MODEL)
    assert np.allclose(plain.F, A - MODEL.steady.predictor_gain @ C, atol=1e-12)
    assert np.allclose(plain.whiten @ plain.S @ plain.whiten.T, np.eye(4), atol=1e-12)
    assert plain.size == 4 and plain.dof == 4 and np.allclose(plain.G, B)


@pytest.mark.parametrize("j", range(2))
def test_it_is_the_kalman_filter_that_believes_the_unknown_input_infinitely_large(j):
    """Oracle: a plain filter with Q + κ E Eᵀ, κ huge, whose innovation loses one direction; what is left must agree."""
    E, member = B[:, [j]], BANK.members[4 + j]
    loud = KalmanFilter(A, B, C, Q + 1e7 * E @ E.T, R, dt=0.1)
    S = C @ loud.steady.solution @ C.T + R
    left = member.N  # rows orthogonal to C E
    assert np.abs(left @ C @ E).max() < 1e-12
    assert np.allclose(left @ S @ left.T, member.S, rtol=1e-5)
    y, u, x0, _ = record(7, 300)
    rho, _ = FaultBank(MODEL, (member,)).run(y, u, member.project @ x0)
    z, nu = x0.copy(), []
    for yk, uk in zip(y, u, strict=True):
        nu.append(left @ (yk - C @ z))
        z = A @ z + B @ uk + loud.steady.predictor_gain @ (yk - C @ z)
    assert np.allclose(rho[50:, 0], (np.array(nu) @ member.whiten.T)[50:], atol=1e-4)


@settings(max_examples=25, derandomize=True)
@given(seed=st.integers(0, 1000), j=st.integers(0, 1), size=st.floats(1.0, 1e4))
def test_an_unknown_input_leaves_its_own_member_untouched(seed, j, size):
    missing = np.zeros((200, 2))
    missing[50:, j] = size * np.random.default_rng(seed).standard_normal(150)
    quiet, loud = residuals(seed, 200), residuals(seed, 200, missing=missing)
    change = np.abs(loud - quiet).max(axis=(0, 2))
    assert change[4 + j] <= 1e-9 * size
    assert np.all(np.delete(change, 4 + j) > 0.1 * size)


@pytest.mark.parametrize("i", range(4))
def test_a_lying_sensor_leaves_its_own_member_untouched(i):
    fault = np.zeros((200, 4))
    fault[50:, i] = 5.0
    quiet, loud = residuals(3, 200), residuals(3, 200, fault=fault)
    change = np.abs(loud - quiet).max(axis=(0, 2))
    assert change[i] == 0.0 and np.all(np.delete(change, i) > 0.5)


def test_signature_and_response_say_what_the_runs_do():
    assert np.array_equal(BANK.signature, ~np.eye(6, dtype=bool))
    fault = np.zeros((4000, 4))
    fault[:, 2] = 1.0
    quiet, loud = residuals(3, 4000), residuals(3, 4000, fault=fault)
    assert np.allclose((loud - quiet)[-1], BANK.response(1.0).real[:, :, 2], atol=1e-6)
    missing = np.zeros((4000, 2))
    missing[:, 1] = 1.0
    assert np.allclose((residuals(3, 4000, missing=missing) - quiet)[-1], BANK.response(1.0).real[:, :, 5], atol=1e-6)


@pytest.mark.parametrize("window, dof", [(1, 3), (10, 30), (25, 75)])
def test_false_alarms_come_as_often_as_designed(window, dof):
    """Windows that do not overlap are independent: their alarms count as binomial, within its 99 % band."""
    rho = residuals(11, 40_000)
    for alpha in (0.1, 0.01):
        for statistic, freedom in ((window_energy, dof), (window_mean, 3)):
            values = statistic(rho, window)[::window]
            low, high = binomial_band(len(values), alpha, level=1 - 0.01 / 6)  # six members at once
            share = (values > residual_threshold(freedom, alpha)).mean(axis=0)
            assert np.all((share >= low) & (share <= high)), (alpha, statistic.__name__, share)


def test_thresholds_are_the_printed_quantiles():
    printed = {(1, 0.05): 3.841, (3, 0.01): 11.345, (10, 0.001): 29.588, (30, 0.05): 43.773, (100, 0.01): 135.807}
    for (dof, alpha), value in printed.items():
        assert residual_threshold(dof, alpha) == pytest.approx(value, abs=5e-4)


def test_the_probability_of_an_alarm_is_the_noncentral_chi_square():
    lam = np.array([0.0, 0.5, 5.0, 40.0, 300.0])
    for dof, alpha in ((3, 0.01), (75, 0.001)):
        ours = alarm_probability(lam, dof, alpha)
        assert ours[0] == alpha
        assert np.allclose(ours[1:], ncx2.sf(residual_threshold(dof, alpha), dof, lam[1:]), atol=1e-9)
        needed = needed_noncentrality(dof, alpha, 0.99)
        assert alarm_probability(needed, dof, alpha) == pytest.approx(0.99, abs=1e-6)
    assert alarm_probability(1e9, 3, 0.01) == 1.0


def test_windows_are_plain_sums():
    rho = RNG.standard_normal((40, 2, 3))
    for window in (1, 7, 40):
        energy, mean = window_energy(rho, window), window_mean(rho, window)
        assert energy.shape == mean.shape == (41 - window, 2)
        k = len(energy) - 1
        assert np.allclose(energy[k], (rho[k:k + window]**2).sum(axis=(0, 2)))
        assert np.allclose(mean[k], (rho[k:k + window].sum(axis=0)**2).sum(axis=-1) / window)


def test_the_quiet_member_names_the_culprit():
    signature = ~np.eye(3, dtype=bool)
    alarms = [[0, 0, 0], [0, 1, 1], [1, 0, 1], [1, 1, 1], [0, 0, 1]]
    assert isolate(alarms, signature).tolist() == [-1, 0, 1, -2, -2]


def test_the_binomial_band_holds_what_it_says():
    low, high = binomial_band(1000, 0.01, level=0.99)
    draws = np.random.default_rng(2).binomial(1000, 0.01, 20_000) / 1000
    assert 0.99 <= np.mean((draws >= low) & (draws <= high)) < 0.997


def test_a_mode_that_nothing_shows_is_left_out():
    """Velocity of a mass on a spring, its force unknown: a constant force is invisible, at z = 1."""
    from observer_lab.engine.systems import discretise

    plant = discretise(Plant([[0, 1, 0], [-4, -0.1, 0], [0, 0, -1]], [[0], [1], [0]], [[0, 1, 0], [0, 1, 1]]), 0.1)
    model = KalmanFilter(plant.A, plant.B, plant.C, 0.01 * np.eye(3), 0.1 * np.eye(2), dt=0.1)
    member = residual_generator(model, name="force", outputs=None, E=plant.B)
    assert np.allclose(member.hidden[-1], 1.0) and member.dof == 1
    assert np.all(np.abs(member.poles) < 1)


def test_what_cannot_be_built_is_said():
    with pytest.raises(ShapeError, match="different numbers from 0 to 3"):
        residual_generator(MODEL, outputs=[0, 0])
    with pytest.raises(EngineError, match="nothing is left to compare"):
        residual_generator(MODEL, outputs=[0], E=B[:, [0]])
    with pytest.raises(EngineError, match="is less than rank"):
        residual_generator(MODEL, outputs=[1, 3], E=[[0.0], [0], [1.0], [0]])
    with pytest.raises(ShapeError, match="at least one"):
        FaultBank(MODEL, ())
    with pytest.raises(ShapeError, match="same number"):
        FaultBank(MODEL, (residual_generator(MODEL), BANK.members[0]))
    with pytest.raises(EngineError, match="between 0 and 1"):
        residual_threshold(3, 1.0)
    with pytest.raises(EngineError, match="larger than the false-alarm rate"):
        needed_noncentrality(3, 0.1, 0.05)
    with pytest.raises(EngineError, match="negative"):
        alarm_probability(-1.0, 3, 0.1)
    with pytest.raises(ShapeError, match="window of 50"):
        window_energy(np.zeros((10, 3)), 50)
    with pytest.raises(ShapeError, match="Alarms must be"):
        isolate([[True, False]], ~np.eye(3, dtype=bool))
    with pytest.raises(EngineError, match="from 1 to"):
        binomial_band(0, 0.1)


def test_a_large_fault_or_a_gap_leaves_no_trace_in_later_windows():
    """A running total kept the rounding of a fault of 1e9 σ (and a NaN) for ever: later alarms were lost."""
    rho = np.random.default_rng(0).standard_normal((400, 2))
    rho[50:100] *= 1e10
    rho[200] = np.nan
    for window in (1, 7, 20, 400):
        plain = np.array([(rho[k:k + window]**2).sum() for k in range(401 - window)])
        summed = np.array([(rho[k:k + window].sum(axis=0)**2).sum() / window for k in range(401 - window)])
        assert np.allclose(window_energy(rho, window), plain, rtol=1e-12, equal_nan=True)
        assert np.allclose(window_mean(rho, window), summed, rtol=1e-9, equal_nan=True)


def test_records_and_weights_that_do_not_fit_are_told_in_a_sentence():
    silent = KalmanFilter(A, B, C, Q, np.diag([0.0, 1.0, 1.0, 1.0]), dt=0.1)
    with pytest.raises(EngineError, match="symmetric and positive definite"):
        residual_generator(silent, E=B[:, [0]])
    start = np.zeros(BANK.system.n)
    for y, u, s in ((np.zeros((9, 3)), np.zeros((9, 2)), start), (np.zeros((9, 4)), np.zeros((8, 2)), start),
                    (np.zeros((9, 4)), np.zeros((9, 2)), start[1:])):
        with pytest.raises(ShapeError):
            BANK.run(y, u, s)
    with pytest.raises(ShapeError, match="x0 must have 4"):
        BANK.start([1.0, 2.0])
    still = KalmanFilter(np.eye(1), np.eye(1), np.eye(1), np.eye(1), np.eye(1), dt=0.1)
    with pytest.raises(EngineError, match="z = 1 is a pole"):
        FaultBank(still, (residual_generator(still),)).response(1.0)
