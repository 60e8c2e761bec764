"""Dominance and static mixing: small matrices by hand, laws for random ones, the platform's channels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import differential_evolution

from observer_lab.engine import EngineError, Plant, ShapeError, frequency_response
from observer_lab.engine.structure import best_mixing, coupling, dominance, dominance_of, mixing_matrix, relative_gains

G2 = np.array([[[2.0, 1.0], [-0.5, 4.0]], [[1.0j, 3.0], [0.0, -2.0]]])


def random_response(seed: int, n: int = 20, k: int = 3) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(n, k, k)) + 1j * rng.normal(size=(n, k, k)) + 3 * np.eye(k)


def test_ratios_by_hand() -> None:
    found = dominance_of(np.array([1.0, 2.0]), G2)
    assert found.row == pytest.approx(np.array([[0.5, 0.125], [3.0, 0.0]]))
    assert found.column == pytest.approx(np.array([[0.25, 0.25], [0.0, 1.5]]))
    assert found.scaled == pytest.approx([np.sqrt(1 / 16), 0.0], abs=1e-9)
    assert dominance_of(np.array([1.0]), np.array([[[0.0, 1.0], [1.0, 1.0]]])).row[0, 0] == np.inf


def test_relative_gains_sum_to_one_and_ignore_units() -> None:
    G, rng = random_response(1), np.random.default_rng(2)
    gains = relative_gains(G)
    assert np.allclose(gains.sum(axis=1), 1) and np.allclose(gains.sum(axis=2), 1)
    left, right = np.diag(rng.uniform(0.1, 9, 3)), np.diag(rng.uniform(0.1, 9, 3))
    assert np.allclose(relative_gains(left @ G @ right), gains)
    assert relative_gains(np.array([[2.0, 1.0], [1.0, 2.0]])) == pytest.approx(np.array([[4, -1], [-1, 4]]) / 3)
    with pytest.raises(EngineError, match="singular"):
        relative_gains(np.ones((2, 2)))


def test_a_relative_gain_is_the_ratio_of_open_to_closed() -> None:
    """λ₁₁ = g₁₁ over the gain from u₁ to y₁ with the other outputs held at zero."""
    G = random_response(5, 1)[0]
    held = G[0, 0] - G[0, 1:] @ np.linalg.solve(G[1:, 1:], G[1:, 0])
    assert relative_gains(G)[0, 0] == pytest.approx(G[0, 0] / held)


@settings(max_examples=40, derandomize=True, database=None)
@given(seed=st.integers(0, 10_000))
def test_no_scaling_beats_the_perron_root(seed: int) -> None:
    G, rng = random_response(seed, 1), np.random.default_rng(seed + 1)
    least = dominance_of(np.array([1.0]), G).scaled[0]
    for _ in range(20):
        scaled = G * rng.uniform(0.05, 20, (1, 3))
        assert dominance_of(np.array([1.0]), scaled).row.max() >= least * (1 - 1e-9)
    off = np.abs(G[0]) / np.abs(np.diag(G[0]))[:, None] * (1 - np.eye(3))
    values, vectors = np.linalg.eig(off)
    best = np.abs(vectors[:, values.real.argmax()])
    assert dominance_of(np.array([1.0]), G * best).row.max() == pytest.approx(least, rel=1e-6)


def test_dominance_of_a_plant_is_that_of_its_response() -> None:
    plant = Plant(np.diag([-1.0, -2.0]), np.eye(2), [[1.0, 0.5], [0.0, 3.0]])
    w = np.array([0.1, 1.0])
    found = dominance(plant, w)
    right = dominance_of(w, frequency_response(plant.A, plant.B, plant.C, plant.D, w))
    assert np.array_equal(found.row, right.row)
    with pytest.raises(ShapeError, match="square"):
        dominance(Plant([[-1.0]], [[1.0]], [[1.0], [2.0]]), w)


# --- mixing --------------------------------------------------------------------------------------------------------
def direct(G: np.ndarray, a: float, b: float) -> float:
    """Eq. (21) as it is printed, from G' = G S."""
    H = G @ np.array([[1, b], [a, 1]])
    return float((np.abs(H[:, 0, 1] / H[:, 0, 0])**2 + np.abs(H[:, 1, 0] / H[:, 1, 1])**2).sum())


@settings(max_examples=60, derandomize=True, database=None)
@given(seed=st.integers(0, 10_000), a=st.floats(-2, 2), b=st.floats(-2, 2))
def test_the_index_is_that_of_the_mixed_matrix(seed: int, a: float, b: float) -> None:
    G = random_response(seed, 15, 2)
    J = coupling(G)
    if abs(1 - a * b) < 1e-3:
        assert J(a, b) == np.inf
        return
    assert J(a, b) == pytest.approx(direct(G, a, b), rel=1e-8)
    assert J.map(np.array([a, 0.0]), np.array([b]))[0] == pytest.approx([direct(G, a, b), direct(G, 0, b)], rel=1e-8)


def test_a_constant_coupling_is_taken_out_whole() -> None:
    """G = diag(d(jω)) S⁻¹: the mixing S leaves nothing, and the closed form is already near."""
    d = 1 / (1 + 1j * np.geomspace(0.1, 10, 30))
    S = np.array([[1, 0.1], [-0.3, 1]])
    G = np.array([np.diag([v, 3 * v**2]) @ np.linalg.inv(S) for v in d])
    found = best_mixing(G)
    assert (found.a, found.b) == pytest.approx((-0.3, 0.1), abs=1e-5)
    assert found.J < 1e-8 < found.plain_J and found.start_J < found.plain_J
    assert found.start == pytest.approx((-0.3, 0.1), rel=1e-9)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_optimum_is_that_of_a_global_search(seed: int) -> None:
    rng = np.random.default_rng(seed)
    G = np.array([[[3, 0.4], [-0.5, 2]]]) + 0.1 * (rng.normal(size=(25, 2, 2)) + 1j * rng.normal(size=(25, 2, 2)))
    found = best_mixing(G)
    peer = differential_evolution(lambda x: min(direct(G, *x), 1e9), [(-0.9, 0.9)] * 2, seed=1, tol=1e-12)
    assert abs(found.J / peer.fun - 1) < 1e-6
    assert min(found.start_J, found.plain_J) >= found.J


def test_other_channels_of_a_larger_matrix() -> None:
    G = random_response(9, 12, 3)
    assert coupling(G, channels=(1, 2))(0.2, -0.1) == pytest.approx(direct(G[:, 1:, 1:], 0.2, -0.1))
    S = mixing_matrix(0.2, -0.1, size=3, channels=(1, 2))
    assert np.array_equal(S, [[1, 0, 0], [0, 1, -0.1], [0, 0.2, 1]])
    with pytest.raises(EngineError, match="singular"):
        mixing_matrix(2.0, 0.5)
    with pytest.raises(ShapeError):
        coupling(G, channels=(1, 5))
    with pytest.raises(EngineError, match="diagonal"):
        coupling(np.zeros((3, 2, 2)))


def test_the_index_has_no_unit_however_small_or_large_the_response() -> None:
    G = np.random.default_rng(1).standard_normal((5, 2, 2)) + 2 * np.eye(2)
    plain = best_mixing(G)
    for scale in (1e-200, 1e200):
        assert np.isclose(best_mixing(scale * G).J, plain.J, rtol=1e-9)
    with pytest.raises(ShapeError, match="two different channels"):
        coupling(G, channels=(0, -2))


def test_channels_that_are_not_there_and_responses_on_a_pole_are_refused() -> None:
    for channels in ((0, 0), (0, 5), (0, -1)):  # (0, 0) gave a diagonal matrix that mixes nothing
        with pytest.raises(ShapeError, match="two different channels"):
            mixing_matrix(0.1, 0.2, size=2, channels=channels)
    with pytest.raises(EngineError, match="NaN or infinity"):
        relative_gains(np.full((2, 2), np.nan))


def test_the_best_mixing_is_one_point_however_the_response_is_rounded():
    """Newton once gave up where rounding of J, small beside its terms, hid that it falls: a and b then moved in the ninth digit."""
    rng = np.random.default_rng(3)
    for _ in range(40):
        G = rng.standard_normal((40, 2, 2)) + 1j * rng.standard_normal((40, 2, 2))
        G[:, [0, 1], [1, 0]] *= 10**rng.uniform(-6, 0)
        G[:, [0, 1], [0, 1]] += 3
        G = G @ np.linalg.inv([[1, rng.uniform(-0.3, 0.3)], [rng.uniform(-0.3, 0.3), 1]])
        one, other = best_mixing(G), best_mixing(G * (1 + 2e-16 * rng.integers(-2, 3, G.shape)))
        assert max(abs(one.a - other.a), abs(one.b - other.b)) < 1e-12
