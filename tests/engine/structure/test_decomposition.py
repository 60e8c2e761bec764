"""Laws of the Kalman decomposition: block sizes, exact zeros, the minimal part's transfer function."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from observer_lab.engine import EngineError, Plant, controllability, kalman_decomposition, observability
from observer_lab.engine.structure import reachable_subspace, unobservable_subspace

SEEDS = st.integers(0, 2**32 - 1)
SIZES = st.tuples(*[st.integers(0, 3)] * 4).filter(lambda sizes: sum(sizes) > 0)
# which blocks may be non-zero in the order (reached and seen, reached, seen, neither)
ALLOWED = np.array([[1, 0, 1, 0], [1, 1, 1, 1], [0, 0, 1, 0], [0, 0, 1, 1]])


def canonical(rng, sizes):
    """A plant in Kalman's form with random non-zero blocks."""
    n = sum(sizes)
    kind = np.repeat(np.arange(4), sizes)
    A = rng.standard_normal((n, n)) * ALLOWED[np.ix_(kind, kind)]
    B = rng.standard_normal((n, 2)) * (kind < 2)[:, None]
    C = rng.standard_normal((2, n)) * (kind % 2 == 0)
    return A, B, C


def response(A, B, C, D, s):
    return C @ np.linalg.solve(s * np.eye(A.shape[0]) - A, B) + D


def scattered(seed, sizes):
    """A canonical plant in random coordinates of condition at most about 30."""
    rng = np.random.default_rng(seed)
    A, B, C = canonical(rng, sizes)
    n = A.shape[0]
    U, V = (np.linalg.qr(rng.standard_normal((n, n)))[0] for _ in range(2))
    T = U * rng.uniform(0.3, 10, n) @ V
    return Plant(T @ A @ np.linalg.inv(T), T @ B, C @ np.linalg.inv(T), rng.standard_normal((2, 2)))


@given(SEEDS, SIZES)
@settings(max_examples=120)
def test_sizes_of_the_four_parts_are_recovered(seed, sizes):
    assert kalman_decomposition(scattered(seed, sizes)).sizes == sizes


@given(SEEDS, SIZES)
@settings(max_examples=80)
def test_minimal_part_has_the_plants_transfer_function(seed, sizes):
    plant = scattered(seed, sizes)
    minimal = kalman_decomposition(plant).minimal
    assert minimal.n == sizes[0]
    for s in (20j, 15 + 3j, 100):
        np.testing.assert_allclose(response(minimal.A, minimal.B, minimal.C, minimal.D, s),
                                   response(plant.A, plant.B, plant.C, plant.D, s), rtol=1e-6, atol=1e-6)


@given(SEEDS, SIZES)
@settings(max_examples=80)
def test_the_new_coordinates_describe_the_same_plant_with_exact_zeros(seed, sizes):
    plant = scattered(seed, sizes)
    d = kalman_decomposition(plant)
    size = np.linalg.norm(plant.A) * np.linalg.cond(d.T) + np.linalg.norm(plant.B) + np.linalg.norm(plant.C)
    np.testing.assert_allclose(plant.A @ d.T, d.T @ d.A, atol=1e-8 * size)
    np.testing.assert_allclose(plant.B, d.T @ d.B, atol=1e-8 * size)
    np.testing.assert_allclose(plant.C @ d.T, d.C, atol=1e-8 * size)
    np.testing.assert_allclose(np.linalg.norm(d.T, axis=0), 1)
    kind = np.repeat(np.arange(4), d.sizes)
    assert np.all(d.A[ALLOWED[np.ix_(kind, kind)] == 0] == 0)
    assert np.all(d.B[kind >= 2] == 0) and np.all(d.C[:, kind % 2 == 1] == 0)


@given(SEEDS, SIZES)
@settings(max_examples=60)
def test_the_four_parts_carry_all_poles_and_their_own_lights(seed, sizes):
    plant = scattered(seed, sizes)
    d = kalman_decomposition(plant)
    assert [0 if part is None else part.n for part in d.parts] == list(sizes)
    coefficients = np.array([1.0])
    for i, part in enumerate(d.parts):
        if part is None:
            continue
        coefficients = np.convolve(coefficients, np.real(np.poly(part.A)))
        assert controllability(part).controllable == (i < 2)
        assert observability(part).observable == (i % 2 == 0)
    expected = np.real(np.poly(plant.A))
    np.testing.assert_allclose(coefficients, expected, atol=1e-7 * np.abs(expected).max())


@given(SEEDS, SIZES)
@settings(max_examples=60)
def test_subspaces_agree_with_the_null_space_and_range_of_the_matrices(seed, sizes):
    """Peer: for these small, well-scaled plants the SVD of O and of [B, AB, …] is trustworthy."""
    rng = np.random.default_rng(seed)
    A, B, C = canonical(rng, sizes)
    A /= max(1.0, np.linalg.norm(A, 2))
    n = A.shape[0]
    T, r = reachable_subspace(A, B)
    reach = np.hstack([np.linalg.matrix_power(A, k) @ B for k in range(n)])
    assert np.linalg.norm(T[:, r:].T @ reach) < 1e-9
    T, h = unobservable_subspace(A, C)
    O = np.vstack([C @ np.linalg.matrix_power(A, k) for k in range(n)])
    assert np.linalg.norm(O @ T[:, n - h:]) < 1e-9
    assert (r, h) == (sizes[0] + sizes[1], sizes[1] + sizes[3])
    np.testing.assert_allclose(T.T @ T, np.eye(n), atol=1e-12)


def test_a_minimal_plant_stays_whole():
    d = kalman_decomposition(Plant([[1, 2], [3, 4]], [[0], [1]], [[1, 0]]))
    assert d.sizes == (2, 0, 0, 0)
    np.testing.assert_allclose(d.T.T @ d.T, np.eye(2), atol=1e-12)


def test_pole_and_zero_that_cancel_leave_one_state():
    """(s+1)/((s+1)(s+2)) in companion form is 1/(s+2)."""
    minimal = kalman_decomposition(Plant([[0, 1], [-2, -3]], [[0], [1]], [[1, 1]])).minimal
    np.testing.assert_allclose(minimal.A, [[-2]], atol=1e-12)
    np.testing.assert_allclose(minimal.C @ minimal.B, [[1]], atol=1e-12)


def test_nothing_connected_leaves_only_the_feedthrough():
    d = kalman_decomposition(Plant([[-1]], [[0]], [[0]], [[3]]))
    assert d.sizes == (0, 0, 0, 1) and d.minimal.n == 0
    np.testing.assert_array_equal(d.minimal.D, [[3]])


def test_hidden_and_reached_may_meet_obliquely():
    """R = span(1, 0), N = span(1, δ): T is oblique, the sizes are right."""
    delta = 1e-3
    T = np.array([[1, 1], [0, delta]])
    A = T @ np.diag([-1.0, -2.0]) @ np.linalg.inv(T)
    d = kalman_decomposition(Plant(A, T[:, :1], np.linalg.inv(T)[:1]))
    assert d.sizes == (1, 0, 0, 1)
    np.testing.assert_allclose(np.abs(d.T[:, 1]), np.abs(T[:, 1]) / np.linalg.norm(T[:, 1]), atol=1e-9)


def test_names_of_signals_stay_and_names_of_states_go():
    plant = Plant(np.diag([-1, -2]), [[1], [0]], [[1, 1]], dt=0.5, state_names=("p", "q"), input_names=("F",),
                  output_names=("z",), units={"F": "N", "p": "m"}, name="cart")
    minimal = kalman_decomposition(plant).minimal
    assert (minimal.input_names, minimal.output_names, minimal.dt) == (("F",), ("z",), 0.5)
    assert minimal.state_names == ("x1",) and minimal.units == (("F", "N"),)


def test_a_larger_tolerance_hides_what_is_barely_seen():
    plant = Plant(np.diag([-1.0, -1.001]), [[1], [1]], [[1, 1]])
    assert kalman_decomposition(plant).sizes == (2, 0, 0, 0)
    assert kalman_decomposition(plant, rtol=1e-2).sizes[0] == 1


def test_absurd_tolerance_is_refused():
    with pytest.raises(EngineError, match="rtol"):
        kalman_decomposition(Plant([[-1]], [[1]], [[1]]), rtol=2)
