"""Functional observers: coprime factors, conditions on random plants, what J and the gains measure."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from paper_examples import ONE, TWO, two

from observer_lab.engine import EngineError, Plant, PoleError, ShapeError, functional_observer, simulate_functional
from observer_lab.engine.observers import (
    criterion,
    error_index,
    error_transfer,
    every_entry,
    peak_gain,
    perturbations,
    vertices,
    worst_error_gain,
)
from observer_lab.engine.structure import coprime_factors
from observer_lab.plants.duan import EXAMPLE_1, EXAMPLE_2, outer_input


def plant_of(seed, n, p, m=1):
    rng = np.random.default_rng(seed)
    return Plant(rng.standard_normal((n, n)), rng.standard_normal((n, m)), rng.standard_normal((p, n)),
                 rng.standard_normal((p, m)))


def spread_poles(seed, order, pairs):
    rng = np.random.default_rng(seed)
    real = -0.6 - np.arange(order - 2 * pairs) - rng.uniform(0, 0.4, order - 2 * pairs)
    upper = -rng.uniform(0.5, 3, pairs) + 1j * (0.7 + np.arange(pairs) + rng.uniform(0, 0.4, pairs))
    return np.concatenate([upper, upper.conj(), real])


# --- coprime factors -----------------------------------------------------------------------------------------------
@pytest.mark.parametrize("n", [4, 12, 20])
def test_exact_factors_at_a_point_have_no_error_of_the_coefficients(n):
    """A row of states k² apart in stiffness, as a beam's: Horner's sum is far from rounding there, and the rows of T with it."""
    A = np.zeros((n, n))
    for k in range(0, n, 2):
        A[k, k + 1], A[k + 1, k] = 1.0, -36.0 * (1 + k / 2) ** 4
    plant = Plant(A, np.zeros((n, 1)), np.random.default_rng(1).choice([-1.0, 1.0], (2, n)))
    f = coprime_factors(plant)
    for s in (-3.0, -200.0, -20.0 + 50j):
        H, L = f.exact_at(A, plant.C, s)
        left, right = (s * np.eye(n) - A.T) @ H, plant.C.T @ L
        size = np.abs(s * np.eye(n) - A.T) @ np.abs(H) + np.abs(plant.C.T) @ np.abs(L)
        assert np.all(np.abs(left - right) <= 1e-12 * size)
        np.testing.assert_allclose(H, f.H_at(s), rtol=0, atol=1e-6 * np.abs(H).max())


def test_factors_of_example_1():
    f = coprime_factors(ONE)
    np.testing.assert_allclose(f.H[:, :, 0], [[1, 0], [0, 1]], atol=1e-14)  # H(s) = [1; s]
    np.testing.assert_allclose(f.L.ravel(), [3, 4, 1], atol=1e-14)  # L(s) = s² + 4s + 3


@settings(max_examples=50)
@given(st.integers(0, 10**6), st.integers(1, 7), st.integers(1, 3), st.complex_numbers(max_magnitude=4))
def test_factors_are_coprime_and_of_degree_n(seed, n, p, s):
    p = min(n, p)
    plant = plant_of(seed, n, p)
    f = coprime_factors(plant)
    assert sum(f.indices) == n
    left, right = (s * np.eye(n) - plant.A.T) @ f.H_at(s), plant.C.T @ f.L_at(s)
    assert np.linalg.norm(left - right) < 1e-8 * (np.linalg.norm(f.H_at(s)) * (abs(s) + 5) + np.linalg.norm(right))
    # det L is the characteristic polynomial up to its constant, compared at two points
    ratio = [np.linalg.det(f.L_at(z)) / np.linalg.det(z * np.eye(n) - plant.A) for z in (9.0, 7.0 + 3j)]
    assert abs(ratio[0] - ratio[1]) < 1e-6 * abs(ratio[0])
    for pole in plant.poles:  # coprime: no common right divisor where L loses rank
        stack = np.vstack([f.H_at(pole), f.L_at(pole)])
        stack = stack / np.linalg.norm(stack, axis=0)
        assert np.linalg.svd(stack, compute_uv=False)[-1] > 1e-9


def test_hidden_modes_are_refused():
    with pytest.raises(EngineError, match="unobservable modes"):
        functional_observer(Plant(np.diag([-1.0, -2.0]), np.ones((2, 1)), [[1.0, 0.0]]), [[1, 1]], 1, poles=[-3])


# --- the observer conditions on any plant --------------------------------------------------------------------------
@settings(max_examples=80)
@given(st.integers(0, 10**6), st.integers(2, 6), st.integers(1, 3), st.integers(1, 2), st.integers(0, 2))
def test_observer_conditions_hold_on_random_plants(seed, n, p, r, pairs):
    p = min(p, n - 1)
    order = n - p
    poles = spread_poles(seed, order, min(pairs, order // 2))
    plant, K = plant_of(seed, n, p), np.random.default_rng(seed + 1).standard_normal((r, n))
    o = functional_observer(plant, K, order, poles=poles)
    TA, FT, LC = o.T @ plant.A, o.F @ o.T, o.L @ plant.C
    assert np.linalg.norm(TA - FT - LC) <= 1e-9 * np.linalg.norm(TA)
    assert np.linalg.norm(K - o.N @ o.T - o.M @ plant.C) <= 1e-9 * np.linalg.norm(K)
    characteristic = np.poly(o.F)
    np.testing.assert_allclose(characteristic, np.real(np.poly(poles)), rtol=1e-9, atol=1e-9)
    assert o.dynamics_residual < 1e-9 and o.output_residual < 1e-9


@settings(max_examples=30)
@given(st.integers(0, 10**6))
def test_the_error_obeys_its_own_equation_from_the_definitions(seed):
    """ε = z − T x: ε̇ = F ε for any u, with a direct term D, and the estimate errs by N ε."""
    rng = np.random.default_rng(seed)
    plant, K = plant_of(seed, 5, 2, 2), rng.standard_normal((2, 5))
    o = functional_observer(plant, K, 3, poles=[-1, -2 + 1j, -2 - 1j])
    x, z, u = rng.standard_normal(5), rng.standard_normal(3), rng.standard_normal(2)
    y = plant.C @ x + plant.D @ u
    dx = plant.A @ x + plant.B @ u
    dz = o.F @ z + o.L @ (y - plant.D @ u) + o.TB @ u
    np.testing.assert_allclose(dz - o.T @ dx, o.F @ (z - o.T @ x), atol=1e-9 * np.abs(o.T).max() * np.abs(dx).max())
    estimate = o.N @ z + o.M @ (y - plant.D @ u)
    size = np.linalg.norm(o.N) * np.linalg.norm(o.T) * np.linalg.norm(x)
    np.testing.assert_allclose(estimate - K @ x, o.N @ (z - o.T @ x), atol=1e-12 * size + 1e-9)


def test_one_functional_needs_fewer_states_than_a_reduced_observer():
    """Largest observability index less one: 2 of 6 states with three outputs of index 2 would need 3 the usual way."""
    plant, K = plant_of(3, 6, 3), np.random.default_rng(4).standard_normal((1, 6))
    o = functional_observer(plant, K, 1, poles=[-2])
    assert o.output_residual < 1e-12 and o.dynamics_residual < 1e-12 and plant.n - plant.p == 3


def test_free_parameter_moves_N_and_M_along_the_dependence():
    o = functional_observer(ONE, EXAMPLE_1.K, 2, poles=[-2, -4])
    moved = functional_observer(ONE, EXAMPLE_1.K, 2, poles=[-2, -4], free=[[3.0]])  # m + p − r* = 1 + 2 − 2 columns
    assert np.abs(moved.N - o.N).max() > 0.01 and moved.output_residual < 1e-13
    with pytest.raises(ShapeError, match="1×1"):
        functional_observer(ONE, EXAMPLE_1.K, 2, poles=[-2, -4], free=[[3.0, 1.0]])


def test_given_directions_are_used():
    plant, K = plant_of(8, 4, 2), np.random.default_rng(9).standard_normal((1, 4))
    g = np.array([[1, 2], [1, -1]])
    o = functional_observer(plant, K, 2, poles=[-1, -2], directions=g)
    f = coprime_factors(plant)
    np.testing.assert_allclose(o.T[0], f.H_at(-1) @ g[0], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(o.L[1], -f.L_at(-2) @ g[1], rtol=1e-9, atol=1e-12)
    with pytest.raises(EngineError, match="conjugate"):
        functional_observer(plant, K, 2, poles=[-1 + 1j, -1 - 1j], directions=[[1, 1j], [1, 1j]])


def test_sampled_plants_have_sampled_poles():
    plant = Plant([[1.1, 0.2], [0, 0.9]], [[0], [1]], [[1, 0]], dt=0.1)
    o = functional_observer(plant, [[1, 2]], 1, poles=[0.3])
    assert o.dynamics_residual < 1e-15
    run = simulate_functional(o, None, x0=[1, -1], z0=[0.0], horizon=2.0)
    law = (o.T @ [1, -1]).item() * o.N.item() * 0.3 ** np.arange(21)  # e_u = −N ε
    np.testing.assert_allclose(run.e_u[:, 0], law, atol=1e-12)
    with pytest.raises(PoleError, match="not stable"):
        functional_observer(plant, [[1, 2]], 1, poles=[-1.3])


@pytest.mark.parametrize(("request_", "error", "word"), [
    ({"poles": [1.0]}, PoleError, "not stable"),
    ({"poles": [-1, -2]}, PoleError, "1, not 2"),
    ({"order": 0}, EngineError, "between 1 and 3"),
    ({"poles": [-1.0]}, EngineError, "raise the order"),
    ({"K": [[1, 2]]}, ShapeError, "3 columns"),
    ({"K": [[0, 0, 0]]}, EngineError, "zero"),
    ({"norm": 3, "order": 2, "poles": [-1, -4]}, EngineError, "norm"),
    ({"W": [[1, 1], [1, 1]], "order": 2, "poles": [-1, -4]}, EngineError, "singular"),
    ({"directions": [[1, 2]], "order": 1, "poles": [-1]}, ShapeError, "1 finite"),
])
def test_requests_that_make_no_sense_get_one_sentence(request_, error, word):
    given_ = {"plant": TWO, "K": EXAMPLE_2.K, "order": 1, "poles": None} | request_
    with pytest.raises(error, match=word):
        functional_observer(**given_)


# --- measures ------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("norm", [1, 2, "inf"])
def test_criterion_is_the_sum_of_numpy_norms(norm):
    rng = np.random.default_rng(5)
    plant = plant_of(2, 4, 2)
    dA, dC = rng.standard_normal((3, 4, 4)), rng.standard_normal((2, 2, 4))
    alpha, beta, gamma = rng.uniform(0, 2, 3), rng.uniform(0, 2, 2), rng.uniform(0, 2, 2)
    T, L, M = rng.standard_normal((2, 4)), rng.standard_normal((2, 2)), rng.standard_normal((3, 2))
    order = np.inf if norm == "inf" else norm
    by_hand = sum(a * np.linalg.norm(T @ d, order) for a, d in zip(alpha, dA, strict=True))
    by_hand += sum(b * np.linalg.norm(L @ d, order) + c * np.linalg.norm(M @ d, order)
                   for b, c, d in zip(beta, gamma, dC, strict=True))
    assert criterion(T, L, M, perturbations(plant, A=dA, C=dC, alpha=alpha, beta=beta, gamma=gamma),
                     norm=norm) == pytest.approx(by_hand)


def test_every_entry_adds_up_to_the_matrices():
    w = every_entry(TWO)
    np.testing.assert_array_equal(w.A.sum(0), TWO.A)
    np.testing.assert_array_equal(w.C.sum(0), TWO.C)
    assert len(w.A) == 4 and len(vertices(EXAMPLE_1.wrong, (0.1, 0.4), (0.05,))) == 8


def test_error_index_bounds_the_error_transfer():
    o, omega = two(-4, -3), np.geomspace(1e-3, 1e3, 500)
    rng = np.random.default_rng(0)
    for _ in range(20):
        a, c = rng.uniform(-1, 1, 2), rng.uniform(-1, 1, 1)
        response = error_transfer(o, omega, dA=np.tensordot(a, o.wrong.A, 1), dC=np.tensordot(c, o.wrong.C, 1))
        assert np.linalg.norm(response, 2, axis=(1, 2)).max() <= error_index(o) * (1 + 1e-9)


@pytest.mark.parametrize("zeta", [0.01, 0.1, 0.5])
def test_peak_gain_of_a_resonance(zeta):
    A, B, C = np.array([[0, 1], [-1, -2 * zeta]]), np.array([[0], [1.0]]), np.array([[1.0, 0]])
    level, at = peak_gain(A, B, C, np.zeros((1, 1)))
    assert level == pytest.approx(1 / (2 * zeta * np.sqrt(1 - zeta**2)), rel=1e-8)
    assert at == pytest.approx(np.sqrt(1 - 2 * zeta**2), rel=1e-3)


@pytest.mark.parametrize("seed", range(12))
def test_peak_gain_is_that_of_a_fine_grid(seed):
    """Also where the gain at rest is high and a peak stands beside it: the crossing at ω = 0 is easily lost."""
    rng, n = np.random.default_rng(seed), 2 + seed % 4
    A = rng.standard_normal((n, n))
    A -= (np.linalg.eigvals(A).real.max() + 10 ** rng.uniform(-1.5, 0.5)) * np.eye(n)
    B, C, D = rng.standard_normal((n, 1)), rng.standard_normal((1, n)), rng.standard_normal((1, 1)) * (seed % 2)
    w = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 3000), np.abs(np.linalg.eigvals(A).imag)])
    seen = np.abs(C @ np.linalg.solve(1j * w[:, None, None] * np.eye(n) - A, B[None] + 0j) + D).max()
    assert seen * (1 - 1e-9) <= peak_gain(A, B, C, D)[0] <= 1.01 * seen


def test_peak_gain_beside_a_high_gain_at_rest():
    """3 s/(s + 1)² + (0.01/(s + 0.01))²: the gain at rest is 1, a peak of 1.5 stands at ω = 1."""
    k, w = 3.0, np.geomspace(1e-3, 1e2, 20_000)
    A = np.block([[np.array([[-2.0, -1.0], [1.0, 0.0]]), np.zeros((2, 2))], [np.zeros((2, 2)), np.array([[-0.02, -1e-4], [1.0, 0.0]])]])
    B, C = np.array([[1.0], [0.0], [1.0], [0.0]]), np.array([[k, 0.0, 0.0, 1e-4]])
    seen = np.abs(k * 1j * w / (1j * w + 1) ** 2 + 1e-4 / (1j * w + 0.01) ** 2).max()
    assert peak_gain(A, B, C, np.zeros((1, 1)))[0] == pytest.approx(seen, rel=1e-6)


def test_peak_gain_at_infinity_and_of_an_unstable_plant():
    assert peak_gain(-np.eye(1), np.eye(1), -np.eye(1), np.eye(1)) == (1.0, np.inf)  # s/(s+1)
    assert peak_gain(np.eye(1), np.eye(1), np.eye(1), np.eye(1))[0] == np.inf


def test_a_loop_that_runs_away_is_cut_off():
    o = functional_observer(ONE, EXAMPLE_1.K, 1, poles=[-5])
    run = simulate_functional(o, outer_input, x0=EXAMPLE_1.x0, z0=EXAMPLE_1.z0, horizon=40.0, dA=np.diag([30.0, 30.0]))
    assert run.diverged_at is not None and np.isfinite(run.e_u).all()


def test_indices_of_continuous_time_refuse_a_sampled_plant():
    """The poles of a sampled plant were read as continuous ones: every stable loop counted as unstable."""
    plant = Plant([[0.5, 1, 0], [0, 0.2, 1], [0, 0, 0.3]], [[0], [0], [1]], [[1.0, 0, 0]], dt=1.0)
    observer = functional_observer(plant, [[1.0, 1, 1]], 2)
    with pytest.raises(EngineError, match="continuous plants"):
        error_index(observer)
    with pytest.raises(EngineError, match="continuous plants"):
        worst_error_gain(observer, [(0.01 * np.eye(3), np.zeros((1, 3)))])
