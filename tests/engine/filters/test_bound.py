"""The posterior Cramér–Rao bound: the Kalman filter where nothing bends, and below the least error of all where something does."""

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.special import ndtri

from observer_lab.engine import Belief, EngineError, KalmanFilter, ShapeError
from observer_lab.engine.filters import posterior_bound

RUNS, STEPS = 5, 7


def drawn(rng, n, rank=None):
    """A covariance n×n of a rank, its units apart."""
    T = np.diag(10 ** rng.uniform(-4, 4, n)) @ rng.standard_normal((n, n if rank is None else rank))
    return T @ T.T


def test_on_a_linear_plant_it_is_the_covariance_of_the_kalman_filter():
    rng = np.random.default_rng(0)
    for seed, rank in enumerate((3, 2, 1, 0)):
        n, p = 3, 1 + seed % 2
        A, C, Q, P = rng.standard_normal((n, n)), rng.standard_normal((p, n)), drawn(rng, n, rank), drawn(rng, n)
        R = np.diag(np.diag(C @ P @ C.T) * 10 ** rng.uniform(-4, 2, p))
        kalman = KalmanFilter(A, np.zeros((n, 1)), C, Q, R).run(Belief(np.zeros(n), P), np.zeros((STEPS, p))).covariances
        spread = np.sqrt(np.diagonal(kalman, axis1=1, axis2=2))
        for unknown in ("states", "noise"):
            found = posterior_bound(np.tile(A, (STEPS - 1, RUNS, 1, 1)), np.tile(C, (STEPS, RUNS, 1, 1)), Q, R, P, unknown=unknown)
            np.testing.assert_allclose(found / spread[:, None] / spread[:, :, None], kalman / spread[:, None] / spread[:, :, None],
                                       atol=1e-8, err_msg=unknown)


def test_it_is_the_last_block_of_the_inverse_information_of_all_states_together():
    """What the recursion leaves out one by one: the information of x[0] … x[k], block by block, inverted whole."""
    rng = np.random.default_rng(1)
    n, p, mean = 2, 1, (0,)
    F, H = rng.standard_normal((STEPS - 1, RUNS, n, n)), rng.standard_normal((STEPS, RUNS, p, n))
    Q, R, P = (M @ M.T + 0.1 * np.eye(len(M)) for M in (rng.standard_normal((k, k)) for k in (n, p, n)))
    Qi, Ri = np.linalg.inv(Q), np.linalg.inv(R)
    found, whole = posterior_bound(F, H, Q, R, P), np.linalg.inv(P)
    for k in range(STEPS):
        if k:
            f = F[k - 1]
            whole = block_diag(whole, Qi)
            whole[-2 * n:-n, -2 * n:-n] += np.mean(f.swapaxes(1, 2) @ Qi @ f, axis=mean)
            whole[-2 * n:-n, -n:] -= np.mean(f, axis=mean).T @ Qi
            whole[-n:, -2 * n:-n] -= Qi @ np.mean(f, axis=mean)
        whole[-n:, -n:] += np.mean(H[k].swapaxes(1, 2) @ Ri @ H[k], axis=mean)
        np.testing.assert_allclose(found[k], np.linalg.inv(whole)[-n:, -n:], rtol=1e-9, atol=1e-12)


def bent(x):
    return x + 0.5 * np.sin(2 * x)


def seen(x):
    return x + 0.2 * x**2


def bell(away, variance):
    return np.exp(-away**2 / (2 * variance)) / np.sqrt(2 * np.pi * variance)


@pytest.mark.parametrize("q, unknown", [(0.3, "states"), (0.3, "noise"), (0.0, "noise")])
def test_no_filter_of_a_scalar_plant_errs_less_and_the_best_one_not_much_more(q, unknown):
    """The mean square error of E(x | y), the least of all, by integration over x[0], x[1], y[0] and y[1] on grids."""
    P, r, runs = 0.6, 0.2, 80
    normal = ndtri((np.arange(runs) + 0.5) / runs)
    x0 = np.repeat(np.sqrt(P) * normal, runs)
    x1 = bent(x0) + np.tile(np.sqrt(q) * normal, runs)
    slope = (1 + np.cos(2 * x0)).reshape(1, -1, 1, 1)
    H = np.stack([1 + 0.4 * x for x in (x0, x1)])[:, :, None, None]
    bound = posterior_bound(slope, H, *(v * np.eye(1) for v in (q, r, P)), unknown=unknown)[:, 0, 0]
    first, y = np.linspace(-5, 5, 501), np.linspace(-6, 12, 721)
    second = np.linspace(-6, 6, 481) if q else first
    start = bell(first, P)[:, None] * bell(y - seen(first)[:, None], r) * (first[1] - first[0])  # x[0], y[0]
    if q:
        joint, at = bell(second - bent(first)[:, None], q).T @ start * (second[1] - second[0]), second
    else:
        joint, at = start, bent(first)
    told = bell(y - seen(at)[:, None], r)
    least = []
    for states, weights, reading in ((first, start, np.ones((len(first), 1))), (at, joint, told)):
        mass, mean, square = (weights.T @ (states[:, None]**k * reading) for k in range(3))
        area = (y[1] - y[0]) ** (2 if reading is told else 1)
        least.append(float(np.sum(square - mean**2 / np.maximum(mass, 1e-300)) * area))
    assert np.all(bound <= np.array(least) * (1 + 2e-3)) and np.all(bound > 0.6 * np.array(least)), (bound, least)


def test_noise_is_needed_where_slopes_vary_and_nowhere_else():
    F = np.array([[[[1.0, 0.1], [-k, 0.9]] for k in (0.1, 0.3)]] * 4)
    H, one = np.tile([[1.0, 0.0]], (5, 2, 1, 1)), np.eye(1)
    driven = posterior_bound(F, H, np.diag([0.0, 1.0]), one, np.eye(2))
    np.testing.assert_allclose(driven, posterior_bound(F, H, np.diag([1e-13, 1.0]), one, np.eye(2)), rtol=1e-9, atol=1e-9)
    with pytest.raises(EngineError, match="Q is singular where"):
        posterior_bound(F, H, np.diag([1.0, 0.0]), one, np.eye(2))
    assert np.isfinite(posterior_bound(F, H, np.diag([1.0, 0.0]), one, np.eye(2), unknown="noise")).all()
    with pytest.raises(EngineError, match="unknown together"):
        posterior_bound(np.ones((2000, 1, 1, 1)), np.ones((2001, 1, 1, 1)), one, one, one, unknown="noise")
    with pytest.raises(ShapeError, match="one sample more"):
        posterior_bound(F, H[:-1], np.eye(2), one, np.eye(2))
    with pytest.raises(EngineError, match="R must be positive definite"):
        posterior_bound(F, H, np.eye(2), 0.0, np.eye(2))
