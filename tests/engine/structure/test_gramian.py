"""Closed forms and laws of Gramians, Hankel values and balanced truncation."""

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad_vec
from scipy.linalg import expm, solve_continuous_lyapunov, solve_discrete_lyapunov

from observer_lab.engine import EngineError, Plant, balanced_truncation, gramians, hankel_singular_values
from observer_lab.engine.structure import observability_gramian, reachability_gramian, split_stable
from observer_lab.engine.systems.lyapunov import settled_factor, settled_factors

SEEDS = st.integers(0, 2**32 - 1)
ZETA, OMEGA = st.floats(1e-3, 0.9), st.floats(1e-2, 1e3)


def stable(rng, n, m=2, p=2, dt=0.0):
    A = rng.standard_normal((n, n))
    poles = np.linalg.eigvals(A)
    A = A / (1.1 * np.abs(poles).max()) if dt > 0 else A - (poles.real.max() + 0.2) * np.eye(n)
    return Plant(A, rng.standard_normal((n, m)), rng.standard_normal((p, n)), rng.standard_normal((p, m)), dt)


def response(plant, s):
    return plant.C @ np.linalg.solve(s * np.eye(plant.n) - plant.A, plant.B) + plant.D


def vibration_platform():
    """The reconstructed platform: deck on springs, two sensors with test masses, four velocity outputs."""
    m, J, kz, cz, kx, cx, a, h = 12, 0.48, 533, 0.658, 475.74, 0.90826, 0.158, 0.014978
    b, s, mu, kp, cp = 0.20, 0.072391, 0.050, 1800, 0.479852
    left, right, across = np.array([[0, 1, -a, 0, 0], [0, 1, a, 0, 0], [1, 0, h, 0, 0]])
    masses = np.array([[0, 1, -s, -1, 0], [0, 1, s, 0, -1]])

    def springs(z, x, sensor):
        return (z * (np.outer(left, left) + np.outer(right, right)) + x * np.outer(across, across)
                + sensor * masses.T @ masses)

    inverse = np.diag(1 / np.array([m, m, J, mu, mu]))
    force = np.array([[0, 1, -b, 0, 0], [0, 1, b, 0, 0], across, kz * (left + right), kx * across]).T
    S = np.array([[0, 1, -s, 0, 0], [1, 0, h, 0, 0], [0, 1, s, 0, 0], [-1, 0, -h, 0, 0]])
    A = np.block([[np.zeros((5, 5)), np.eye(5)], [-inverse @ springs(kz, kx, kp), -inverse @ springs(cz, cx, cp)]])
    return Plant(A, np.vstack([np.zeros((5, 5)), inverse @ force]), np.hstack([np.zeros((4, 5)), S]))


@given(ZETA, OMEGA)
@settings(max_examples=60)
def test_velocity_output_has_two_equal_hankel_values(zeta, omega):
    plant = Plant([[0, 1], [-omega**2, -2 * zeta * omega]], [[0], [1]], [[0, 1]])
    np.testing.assert_allclose(hankel_singular_values(plant), [1 / (4 * zeta * omega)] * 2, rtol=1e-10)


@given(ZETA, OMEGA)
@settings(max_examples=60)
def test_position_output_has_the_closed_form(zeta, omega):
    plant = Plant([[0, 1], [-omega**2, -2 * zeta * omega]], [[0], [1]], [[1, 0]])
    exact = (np.sqrt(1 + zeta**2) + np.array([zeta, -zeta])) / (4 * zeta * omega**2)
    np.testing.assert_allclose(hankel_singular_values(plant), exact, rtol=1e-9)


def test_published_list_of_the_platform():
    found = hankel_singular_values(vibration_platform())
    np.testing.assert_allclose(found[:6], [572.7760, 572.7760, 360.3035, 360.2847, 43.0561, 43.0313], atol=6e-5)
    np.testing.assert_allclose(found[6:8], [0.053902, 0.053898], atol=6e-7)
    np.testing.assert_allclose(found[8:], [0.0000885] * 2, atol=6e-8)
    report = [572.7565, 572.7565, 360.3040, 360.2852, 43.0552, 43.0305]
    np.testing.assert_allclose(found[:6], report, rtol=1e-4)


def test_platform_cut_to_eight_errs_as_published():
    plant = vibration_platform()
    cut = balanced_truncation(plant, 8)
    assert cut.error_bound == pytest.approx(3.541e-4, rel=2e-4)
    assert np.all(cut.plant.poles.real < 0) and cut.kept == 0
    hertz = np.concatenate([np.geomspace(0.01, 1000, 200), np.linspace(29.8, 30.6, 401)])
    errors = [np.linalg.norm(response(plant, 2j * np.pi * f) - response(cut.plant, 2j * np.pi * f), 2) for f in hertz]
    assert max(errors) == pytest.approx(1.771e-4, rel=2e-3)
    assert hertz[int(np.argmax(errors))] == pytest.approx(30.2, abs=0.05)


def test_smallest_hankel_values_do_not_drown_in_rounding():
    """Poles −1 … −10, B = C = 1: Wc = Wo is a Cauchy matrix, σ its eigenvalues; √eig(Wc Wo) loses all below 1e-8."""
    poles = np.arange(1, 11)
    with mpmath.workdps(50):
        W = mpmath.matrix([[mpmath.mpf(1) / int(a + b) for b in poles] for a in poles])
        exact = sorted((float(value) for value in mpmath.eigsy(W, eigvals_only=True)), reverse=True)
    assert exact[-1] / exact[0] < 1e-12
    found = hankel_singular_values(Plant(-np.diag(poles.astype(float)), np.ones((10, 1)), np.ones((1, 10))))
    np.testing.assert_allclose(found, exact, rtol=1e-9, atol=3e-15)


@pytest.mark.parametrize(("dt", "peer"), [(0.0, lambda A, Q: solve_continuous_lyapunov(A, -Q)),
                                          (0.1, solve_discrete_lyapunov)])
@given(seed=SEEDS, n=st.integers(1, 8))
@settings(max_examples=40)
def test_gramians_agree_with_the_lyapunov_solvers(dt, peer, seed, n):
    plant = stable(np.random.default_rng(seed), n, dt=dt)
    found = gramians(plant)
    for W, A, B in ((found.controllability, plant.A, plant.B), (found.observability, plant.A.T, plant.C.T)):
        exact = peer(A, B @ B.T)
        np.testing.assert_allclose(W, exact, atol=1e-9 * np.linalg.norm(exact))
        np.testing.assert_array_equal(W, W.T)


@given(SEEDS, st.integers(1, 6), st.sampled_from([0.0, 0.5]))
@settings(max_examples=40)
def test_hankel_values_do_not_depend_on_coordinates_or_direction(seed, n, dt):
    rng = np.random.default_rng(seed)
    plant = stable(rng, n, dt=dt)
    T = np.linalg.qr(rng.standard_normal((n, n)))[0] * 10.0 ** rng.uniform(-2, 2, n)
    moved = Plant(np.linalg.solve(T, plant.A @ T), np.linalg.solve(T, plant.B), plant.C @ T, dt=dt)
    values = hankel_singular_values(plant)
    np.testing.assert_allclose(hankel_singular_values(moved), values, atol=1e-8 * values[0])
    np.testing.assert_allclose(hankel_singular_values(plant.dual()), values, atol=1e-10 * values[0])


@given(SEEDS, st.integers(1, 7), st.integers(0, 7), st.sampled_from([0.0, 0.5]))
@settings(max_examples=60)
def test_truncation_is_stable_and_within_its_bound(seed, n, order, dt):
    plant = stable(np.random.default_rng(seed), n, dt=dt)
    values = hankel_singular_values(plant)
    order = min(order, n)
    assume(values[order - 1 if order else 0] > 1e-8 * values[0])
    cut = balanced_truncation(plant, order)
    assert cut.plant.n == order
    assert cut.error_bound == pytest.approx(2 * values[order:].sum(), rel=1e-6, abs=1e-9 * values[0])
    np.testing.assert_allclose(cut.left @ cut.T, np.eye(order), atol=1e-6)
    angles = np.geomspace(1e-3, np.pi, 60)
    points = np.exp(1j * angles) if dt else 1j * np.geomspace(1e-3, 1e3, 60)
    worst = max(np.linalg.norm(response(plant, s) - response(cut.plant, s), 2) for s in points)
    assert worst <= cut.error_bound * (1 + 1e-6) + 1e-6 * values[0]


@given(SEEDS, st.integers(2, 6))
@settings(max_examples=30)
def test_reduced_plant_is_balanced(seed, n):
    plant = stable(np.random.default_rng(seed), n)
    values = hankel_singular_values(plant)
    assume(values[-1] > 1e-6 * values[0])
    W = gramians(balanced_truncation(plant, n).plant)
    for gramian in (W.controllability, W.observability):
        np.testing.assert_allclose(gramian, np.diag(values), atol=1e-6 * values[0])


@pytest.mark.parametrize(("dt", "pole"), [(0.0, 2.0), (0.0, 0.0), (0.1, 1.0), (0.1, -1.3)])
def test_unstable_plants_have_no_infinite_gramian_and_say_why(dt, pole):
    plant = Plant(np.diag([-0.5, pole]), [[1], [1]], [[1, 1]], dt=dt)
    with pytest.raises(EngineError, match="finite horizon"):
        gramians(plant)
    with pytest.raises(EngineError, match="split_stable"):
        hankel_singular_values(plant)


@given(SEEDS, st.integers(1, 4), st.integers(1, 3), st.sampled_from([0.0, 0.5]))
@settings(max_examples=40)
def test_stable_and_unstable_parts_add_up(seed, n, k, dt):
    rng = np.random.default_rng(seed)
    good, bad = stable(rng, n, dt=dt), stable(rng, k, dt=dt)
    A = np.zeros((n + k, n + k))
    A[:n, :n], A[:n, n:] = good.A, rng.standard_normal((n, k))
    A[n:, n:] = np.linalg.inv(bad.A) if dt else -bad.A
    Q = np.linalg.qr(rng.standard_normal((n + k, n + k)))[0]
    plant = Plant(Q @ A @ Q.T, Q @ rng.standard_normal((n + k, 2)), rng.standard_normal((2, n + k)), good.D, dt)
    assume(np.linalg.norm(plant.A) < 1e3)
    split = split_stable(plant)
    assert (split.stable.n, split.unstable.n) == (n, k)
    for s in (3j, 1.7 + 0.4j):
        whole = response(plant, s)
        np.testing.assert_allclose(response(split.stable, s) + response(split.unstable, s), whole,
                                   atol=1e-6 * (1 + np.abs(whole).max()))
    cut = balanced_truncation(plant, n + k)
    assert cut.kept == k and cut.hankel.size == n
    with pytest.raises(EngineError, match="unstable states must stay"):
        balanced_truncation(plant, k - 1)


def test_truncating_an_unstable_plant_keeps_its_unstable_pole():
    plant = Plant(np.diag([3.0, -1.0, -50.0]), np.ones((3, 1)), np.ones((1, 3)))
    cut = balanced_truncation(plant, 2)
    assert cut.kept == 1 and cut.plant.poles[1] == pytest.approx(3)
    worst = max(abs(response(plant, 1j * w) - response(cut.plant, 1j * w))[0, 0] for w in np.geomspace(1e-3, 1e4, 99))
    assert worst <= cut.error_bound * (1 + 1e-9)


@pytest.mark.parametrize("order", [-1, 4, 1.5, True])
def test_absurd_orders_are_refused(order):
    with pytest.raises(EngineError, match="whole number"):
        balanced_truncation(Plant(-np.eye(3), np.ones((3, 1)), np.ones((1, 3))), order)


def test_hidden_states_cannot_be_balanced():
    with pytest.raises(EngineError, match="Only 1 stable"):
        balanced_truncation(Plant(np.diag([-1, -2]), [[1], [1]], [[1, 0]]), 2)


@given(SEEDS, st.integers(1, 5), st.floats(0.01, 3))
@settings(max_examples=25)
def test_finite_gramians_are_the_integral_for_any_poles(seed, n, horizon):
    rng = np.random.default_rng(seed)
    plant = Plant(rng.standard_normal((n, n)), rng.standard_normal((n, 2)), rng.standard_normal((1, n)))

    def reach(t):
        return expm(plant.A * t) @ plant.B @ plant.B.T @ expm(plant.A.T * t)

    def seen(t):
        return expm(plant.A.T * t) @ plant.C.T @ plant.C @ expm(plant.A * t)

    for found, integrand in ((reachability_gramian(plant, horizon), reach),
                             (observability_gramian(plant, horizon), seen)):
        exact = quad_vec(integrand, 0, horizon, epsrel=1e-11)[0]
        np.testing.assert_allclose(found, exact, atol=1e-9 * np.linalg.norm(exact))


@pytest.mark.parametrize("steps", [0, 1, 2, 7, 64, 1000])
def test_sampled_finite_gramian_is_the_sum(steps):
    A, C = np.array([[0.9, 0.3], [-0.3, 0.9]]), np.array([[1.0, 0.0]])
    exact = sum((np.linalg.matrix_power(A, k).T @ C.T @ C @ np.linalg.matrix_power(A, k) for k in range(steps)),
                np.zeros((2, 2)))
    found = observability_gramian(Plant(A, [[0], [1]], C, dt=0.1), 0.1 * steps)
    np.testing.assert_allclose(found, exact, rtol=1e-11, atol=1e-12)


def test_double_integrator_gramian_in_closed_form():
    """∫ [t; 1][t 1] dt = [T³/3 T²/2; T²/2 T]."""
    found = reachability_gramian(Plant([[0, 1], [0, 0]], [[0], [1]], [[1, 0]]), 3)
    np.testing.assert_allclose(found, [[9, 4.5], [4.5, 3]], rtol=1e-13)


def test_stiff_plants_do_not_overflow():
    """Van Loan's exponential over the whole horizon would need e^{+4e6}."""
    plant = Plant(np.diag([-4e5, -1.0]), np.ones((2, 1)), np.ones((1, 2)))
    exact = [[1 / 8e5, 1 / 400001], [1 / 400001, (1 - np.exp(-20)) / 2]]
    np.testing.assert_allclose(reachability_gramian(plant, 10), exact, rtol=1e-7)


def test_long_horizon_meets_the_infinite_gramian():
    plant = stable(np.random.default_rng(5), 4)
    np.testing.assert_allclose(observability_gramian(plant, 300), gramians(plant).observability, rtol=1e-9, atol=1e-9)


def test_growth_beyond_every_number_is_a_sentence():
    with pytest.raises(EngineError, match="shorten the horizon"):
        reachability_gramian(Plant([[100.0]], [[1]], [[1]]), 10)


@pytest.mark.parametrize("horizon", [-1, np.nan, np.inf])
def test_absurd_horizons_are_refused(horizon):
    with pytest.raises(EngineError, match="horizon"):
        observability_gramian(Plant([[-1.0]], [[1]], [[1]]), horizon)


def test_zero_horizon_shows_nothing():
    np.testing.assert_array_equal(observability_gramian(Plant([[-1.0]], [[1]], [[1]]), 0), [[0]])


def test_records_are_read_only():
    plant = Plant(np.diag([-1.0, -2.0]), np.ones((2, 1)), np.ones((1, 2)))
    cut, both = balanced_truncation(plant, 1), gramians(plant)
    for array in (cut.T, cut.left, cut.hankel, both.controllability, both.observability, split_stable(plant).T):
        assert not array.flags.writeable


@settings(max_examples=40)
@given(seed=SEEDS, n=st.integers(1, 12), dt=st.sampled_from([0.0, 0.1]), apart=st.floats(0, 4))
def test_both_gramians_in_one_schur_form_are_those_found_apart(seed, n, dt, apart):
    rng = np.random.default_rng(seed)
    plant, d = stable(rng, n, dt=dt), 10 ** (apart * rng.uniform(-1, 1, n))
    A, B, C = plant.A * d / d[:, None], plant.B / d[:, None], plant.C * d
    for R, (F, G) in zip(settled_factors(A, B, C, dt), ((A, B), (A.T, C.T)), strict=True):
        alone = settled_factor(F, G, dt)
        wanted = alone @ alone.T
        size = np.sqrt(np.diag(wanted))
        np.testing.assert_allclose(R @ R.T / size / size[:, None], wanted / size / size[:, None], atol=1e-8)
