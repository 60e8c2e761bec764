"""The H∞ filter: without a bound it is Kalman's, and the bound that is asked for holds at every frequency."""

from __future__ import annotations

import numpy as np
import pytest

from observer_lab.engine import EngineError, Plant, h_infinity, lqe

CASES = range(12)


def plant(seed: int) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(seed)
    n, q, p = rng.integers(1, 5), rng.integers(1, 3), rng.integers(1, 3)
    W, V = (M @ M.T + 0.1 * np.eye(k) for k in (q, p) for M in [rng.standard_normal((k, k))])
    return rng.standard_normal((n, n)), rng.standard_normal((n, q)), rng.standard_normal((p, n)), W, V


def peak(A: np.ndarray, G: np.ndarray, C: np.ndarray, W: np.ndarray, V: np.ndarray, L: np.ndarray, Z: np.ndarray) -> float:
    """The largest gain from unit noises to Z e, ė = (A − LC) e + G W^½ w − L V^½ v, by bisection on its Hamiltonian matrix."""
    F, B = A - L @ C, np.hstack([G @ np.linalg.cholesky(W), -L @ np.linalg.cholesky(V)])
    low, high = 0.0, 1e6
    while high - low > 1e-6 * high:
        middle = (low * high) ** 0.5 if low else high / 2
        H = np.block([[F, B @ B.T / middle**2], [-Z.T @ Z, -F.T]])
        crosses = np.abs(np.linalg.eigvals(H).real).min() < 1e-9 * np.linalg.norm(H)
        low, high = (middle, high) if crosses else (low, middle)
    return high


def test_without_a_bound_it_is_the_kalman_bucy_filter() -> None:
    for seed in CASES:
        data = plant(seed)
        kalman = lqe(*data)
        np.testing.assert_array_equal(h_infinity(*data, gamma=np.inf).gain, kalman.gain)
        np.testing.assert_allclose(h_infinity(*data, gamma=1e5).gain, kalman.gain, rtol=1e-4, atol=1e-4 * np.abs(kalman.gain).max())


def test_the_bound_holds_and_kalman_exceeds_it() -> None:
    """Half-way between what Kalman's filter reaches and what no filter does there is a filter, and it keeps its bound."""
    exceeded = 0
    for seed in CASES:
        data = plant(seed)
        Z = np.eye(len(data[0]))[:1]
        kalman = peak(*data, lqe(*data).gain, Z)
        gamma = kalman
        for share in (1.05, 0.95, 0.8):
            try:
                found = h_infinity(*data, gamma=share * kalman, Z=Z)
            except EngineError:
                break
            gamma = share * kalman
            assert peak(*data, found.gain, Z) <= gamma * (1 + 1e-5)
            assert found.poles.real.max() < 0 and np.linalg.eigvalsh(found.solution)[0] >= -1e-9
        exceeded += gamma < kalman
    assert exceeded > len(CASES) // 2  # so the bound below Kalman's own peak was tried


def test_a_bound_that_no_filter_keeps_is_refused() -> None:
    with pytest.raises(EngineError, match="No filter keeps"):
        h_infinity([[1.0]], [[1.0]], [[1.0]], [[1.0]], [[1.0]], gamma=1e-3)
    scalar = [[-1.0]], [[1.0]], [[1.0]], [[1.0]], [[1.0]]  # 2P + (1 − γ⁻²)P² = 1: solvable for γ⁻² ≤ 2
    h_infinity(*scalar, gamma=2**-0.5 * 1.001)
    with pytest.raises(EngineError, match="No filter keeps"):
        h_infinity(*scalar, gamma=2**-0.5 * 0.999)


def test_a_plant_stands_where_its_matrices_stand() -> None:
    A, B, C = [[0.0, 1.0], [-2.0, -3.0]], [[0.0], [1.0]], [[1.0, 0.0]]
    np.testing.assert_array_equal(h_infinity(Plant(A, B, C), [[1.0]], [[1.0]], gamma=2.0),  # type: ignore[call-arg]
                                  h_infinity(A, B, C, [[1.0]], [[1.0]], gamma=2.0))
