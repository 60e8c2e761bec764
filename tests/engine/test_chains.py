"""Chains of many states beside SciPy: a heated rod, masses on springs, an advected line."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from observer_lab.engine import (
    Plant,
    balanced_truncation,
    closed_loop,
    compensator,
    frequency_response,
    gramians,
    hankel_singular_values,
    lqe,
    lqr,
    noisy_loop,
    observability,
)


def rod(n: int) -> np.ndarray:
    """Heat along a rod, ends kept cold."""
    return 0.01 * (n + 1) ** 2 * (np.eye(n, k=1) + np.eye(n, k=-1) - 2 * np.eye(n))


def masses(n: int) -> np.ndarray:
    """Half as many masses on springs, positions first."""
    K = 2 * np.eye(n // 2) - np.eye(n // 2, k=1) - np.eye(n // 2, k=-1)
    return np.block([[np.zeros_like(K), np.eye(n // 2)], [-K, -0.1 * np.eye(n // 2) - 0.01 * K]])


def line(n: int) -> np.ndarray:
    """What flows along a line, in steps."""
    return n * (np.eye(n, k=-1) - np.eye(n))


CHAINS = {"rod": rod, "masses": masses, "line": line}


def chain(kind: str, n: int) -> Plant:
    """Driven at its beginning, seen at its end."""
    B, C = np.zeros((n, 1)), np.zeros((1, n))
    B[n // 2 if kind == "masses" else 0] = n if kind == "line" else 0.01 * (n + 1) ** 2 if kind == "rod" else 1.0
    C[0, n // 2 - 1 if kind == "masses" else -1] = 1.0
    return Plant(CHAINS[kind](n), B, C)


def missed(P: Plant, S: np.ndarray) -> float:
    """Relative residual of the Riccati equation with Q = I, R = 1."""
    SA, quadratic = S @ P.A, S @ P.B @ P.B.T @ S
    return float(np.linalg.norm(SA + SA.T + np.eye(P.n) - quadratic) / (2 * np.linalg.norm(SA) + np.linalg.norm(quadratic)))


@pytest.mark.slow
@pytest.mark.parametrize("n", [50, 100])
@pytest.mark.parametrize("kind", CHAINS)
def test_a_chain_of_many_states_is_answered_as_scipy_answers(kind: str, n: int) -> None:
    P, one = chain(kind, n), np.eye(1)
    K, L = lqr(P.A, P.B, np.eye(n), one), lqe(P.A, P.B, P.C, one, one)
    assert missed(P, K.solution) <= 10 * missed(P, solve_continuous_are(P.A, P.B, np.eye(n), one))
    loop = closed_loop(P, K.gain, L.gain)
    assert loop.stable
    variance = noisy_loop(P, compensator(P, K.gain, L.gain), P.B, one, V=one).variance()
    assert np.isfinite(variance).all() and variance.min() > 0
    found = gramians(P)
    for A, W, G in ((P.A, found.controllability, P.B), (P.A.T, found.observability, P.C.T)):
        assert np.linalg.norm(A @ W + W @ A.T + G @ G.T) <= 1e-12 * np.linalg.norm(A @ W)
    sigma, cut = hankel_singular_values(P), balanced_truncation(P, 6)
    omega = np.concatenate([[0.0], np.logspace(-3, 3, 60)])
    error = frequency_response(P.A, P.B, P.C, P.D, omega) - frequency_response(cut.plant.A, cut.plant.B, cut.plant.C, cut.plant.D, omega)
    assert sigma[6] * (1 - 1e-6) <= cut.error_bound and np.abs(error).max() <= cut.error_bound * (1 + 1e-9)
    assert observability(P).rank == n


def test_two_hundred_states_have_a_rank_and_a_stable_loop() -> None:
    P = chain("line", 200)
    assert observability(P).observable
    K = np.zeros((1, 200))
    K[0, 0] = 0.5
    assert closed_loop(P, K, np.zeros((200, 1))).stable
