"""The filter that loses measurements: exact means, bounds of the mean, and the share that may be lost."""

from __future__ import annotations

from itertools import product

import control
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are

from observer_lab.engine import Belief, EngineError, KalmanFilter, RiccatiError, critical_loss
from observer_lab.engine.network import intermittent_covariances, lossy_growth, mare, mean_bounds, mean_lower_limit, riccati_step

Model = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
TWO: Model = (np.array([[1.25, 0.0], [1.0, 1.1]]), np.array([[1.0, 1.0]]), 20 * np.eye(2), np.array([[2.5]]))
SAFE, LOST = 1 / (1.25 * 1.1) ** 2, 1 / 1.25**2


def scalar(a: float, q: float = 1.0, r: float = 1.0) -> Model:
    return np.array([[a]]), np.eye(1), q * np.eye(1), r * np.eye(1)


def exact_means(model: Model, P0: np.ndarray, loss: float, steps: int) -> np.ndarray:
    """E P[k|k−1], k = 0 … steps, from all 2^steps records with their probabilities."""
    heard = np.array(list(product((False, True), repeat=steps)))
    weight = np.prod(np.where(heard, 1 - loss, loss), axis=1)
    assert weight.sum() == pytest.approx(1)
    return np.einsum("r,rkij->kij", weight, intermittent_covariances(*model, P0, heard))


def ordered(smaller: np.ndarray, larger: np.ndarray) -> bool:
    """smaller ≤ larger as covariances, to rounding."""
    return bool(np.linalg.eigvalsh(larger - smaller)[..., 0].min() >= -1e-10 * np.abs(larger).max())


# --- a realisation ---------------------------------------------------------------------------------------------------
def test_a_record_with_gaps_has_the_covariances_of_the_filter_that_is_given_nan() -> None:
    rng = np.random.default_rng(1)
    A, C, Q, R = rng.normal(size=(3, 3)) / 1.3, rng.normal(size=(2, 3)), np.diag([1.0, 0.5, 0.1]), np.diag([1.0, 3.0])
    heard = rng.random(40) > 0.4
    kf = KalmanFilter(A, np.zeros((3, 1)), C, Q, R)
    record = np.where(heard[:, None], rng.normal(size=(40, 2)), np.nan)
    track = kf.run(Belief(np.zeros(3), np.eye(3)), record)
    ours = intermittent_covariances(A, C, Q, R, np.eye(3), heard)
    assert ours[:40] == pytest.approx(track.prior_covariances, rel=1e-10)


@settings(max_examples=60, derandomize=True, database=None)
@given(seed=st.integers(0, 10_000), n=st.integers(1, 4), p=st.integers(1, 3), loss=st.floats(0, 1), more=st.floats(0, 1))
def test_covariances_stay_covariances_and_losing_more_never_helps(seed: int, n: int, p: int, loss: float, more: float) -> None:
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    A *= 1.2 / np.abs(np.linalg.eigvals(A)).max()
    half = rng.normal(size=(n, n))
    C, R, chance = rng.normal(size=(p, n)), np.diag(rng.uniform(0.1, 2.0, p)), rng.random(25)
    records = np.stack([chance >= loss, chance >= max(loss, more)])
    P = intermittent_covariances(A, C, half @ half.T, R, np.eye(n), records)
    assert np.array_equal(P[:, 1:], np.swapaxes(P, -1, -2)[:, 1:])
    assert np.linalg.eigvalsh(P).min() >= -1e-10 * np.abs(P).max()
    for few, many in zip(P[0], P[1], strict=True):
        assert ordered(few, many)


# --- its mean --------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("model", [scalar(1.3), scalar(1.05, 0.2, 4.0), TWO], ids=["scalar", "slow", "two modes"])
@pytest.mark.parametrize("loss", [0.1, 0.5, 0.8])
def test_the_exact_mean_over_all_records_lies_between_the_bounds(model: Model, loss: float) -> None:
    P0, steps = np.eye(len(model[0])), 11
    mean = exact_means(model, P0, loss, steps)
    lower, upper = mean_bounds(*model, P0, loss, steps)
    for k in range(steps + 1):
        assert ordered(lower[k], mean[k]) and ordered(mean[k], upper[k])
    assert upper[-1, 0, 0] > mean[-1, 0, 0] > lower[-1, 0, 0]  # none of the bounds is the mean itself


@pytest.mark.parametrize("a", [1.05, 1.3, 2.0])
def test_scalar_the_mean_is_bounded_below_one_over_a_squared_and_diverges_above(a: float) -> None:
    """Below, the upper bound stays under a number for ever; above, the lower bound grows by loss·a² a step for ever."""
    model, edge = scalar(a), 1 / a**2
    assert critical_loss(model[0], model[1]).exact
    assert critical_loss(model[0], model[1]).lost == pytest.approx(edge, rel=1e-12)
    ceiling = mare(*model, 0.98 * edge)
    _, upper = mean_bounds(*model, np.zeros((1, 1)), 0.98 * edge, 2000)
    assert np.all(upper <= ceiling * (1 + 1e-9)) and upper[-1] == pytest.approx(ceiling, rel=1e-6)
    above = min(1.05 * edge, 1.0)
    lower, _ = mean_bounds(*model, np.eye(1), above, 400)
    assert lower[400, 0, 0] / lower[399, 0, 0] == pytest.approx(above * a**2, rel=1e-3)
    assert lower[400, 0, 0] > 1e6 * lower[0, 0, 0]
    with pytest.raises(RiccatiError):
        mare(*model, above)
    with pytest.raises(RiccatiError):
        mean_lower_limit(model[0], model[2], above)


def test_scalar_monte_carlo_agrees_with_both_bounds_below_and_runs_away_above() -> None:
    a, runs, steps = 1.1, 20_000, 60
    chance = np.random.default_rng(0).random((runs, steps))
    below, above = 0.6, 0.95  # the edge is 0.826
    P = {p: intermittent_covariances(*scalar(a), np.eye(1), chance >= p)[:, :, 0, 0] for p in (below, above)}
    lower, upper = mean_bounds(*scalar(a), np.eye(1), below, steps)
    late = P[below][:, 40:].mean()
    assert mean_lower_limit(np.array([[a]]), np.eye(1), below).item() < late < mare(*scalar(a), below).item()
    assert lower[-1, 0, 0] < late < upper[-1, 0, 0]
    lower, upper = mean_bounds(*scalar(a), np.eye(1), above, steps)
    means = P[above].mean(axis=0)
    assert np.all(means > 0.85 * lower[:, 0, 0]) and np.all(means < 1.15 * upper[:, 0, 0])
    assert means[60] > 20 * means[30] > 100 * means[5]


def test_above_the_edge_the_typical_run_looks_harmless() -> None:
    """The mean is carried by rare long gaps: half of all runs stay small, and a sample of runs misses the mean."""
    chance = np.random.default_rng(0).random((4000, 80))
    last = intermittent_covariances(*scalar(1.5), np.eye(1), chance >= 0.6)[:, -1, 0, 0]
    lower, _ = mean_bounds(*scalar(1.5), np.eye(1), 0.6, 80)
    assert np.median(last) < 20
    assert last.mean() < 1e-3 * lower[-1, 0, 0]


@pytest.mark.parametrize(("a", "q", "r", "loss"), [(1.2, 1.0, 1.0, 0.5), (1.5, 0.3, 2.0, 0.4), (0.9, 1.0, 1.0, 0.95)])
def test_scalar_limits_of_both_bounds_by_hand(a: float, q: float, r: float, loss: float) -> None:
    # X(1 − a²)(X + R) + (1 − p)a²X² = Q(X + R): a quadratic in X.
    k, b = 1 - loss * a**2, q + r * (a**2 - 1)
    by_hand = (b + np.sqrt(b**2 + 4 * k * q * r)) / (2 * k)
    assert mare(*scalar(a, q, r), loss).item() == pytest.approx(by_hand, rel=1e-10)
    assert mean_lower_limit(np.array([[a]]), q * np.eye(1), loss).item() == pytest.approx(q / k, rel=1e-12)


def test_without_loss_the_modified_equation_is_the_riccati_equation() -> None:
    A, C, Q, R = TWO
    scipy_says = solve_discrete_are(A.T, C.T, Q, R)
    control_says = control.dlqe(A, np.eye(2), C, Q, R)[1]
    assert mare(*TWO, 0.0) == pytest.approx(scipy_says, rel=1e-9)
    assert mare(*TWO, 0.0) == pytest.approx(np.asarray(control_says), rel=1e-9)


@pytest.mark.parametrize("loss", [0.0, 0.2, 0.45, 0.52])
def test_the_solution_is_a_fixed_point_and_rises_with_the_loss(loss: float) -> None:
    X = mare(*TWO, loss)
    assert riccati_step(X, *TWO, 1 - loss) == pytest.approx(X, rel=1e-11)
    assert ordered(X, mare(*TWO, loss + 0.005))
    assert ordered(mean_lower_limit(TWO[0], TWO[2], loss), X)


# --- how much may be lost ----------------------------------------------------------------------------------------------
@pytest.mark.slow
def test_two_unstable_modes_and_one_sensor_leave_a_gap_between_the_bounds() -> None:
    edge = critical_loss(TWO[0], TWO[1])
    assert (edge.safe, edge.lost) == pytest.approx((SAFE, LOST), rel=1e-12) and not edge.exact
    mare(*TWO, SAFE - 1e-3)
    with pytest.raises(RiccatiError):
        mare(*TWO, SAFE + 1e-3)
    assert lossy_growth(TWO[0], TWO[1], SAFE - 1e-3) < 1 < lossy_growth(TWO[0], TWO[1], SAFE + 1e-3)
    assert lossy_growth(TWO[0], TWO[1], SAFE) == pytest.approx(1, abs=1e-6)  # power iteration against the closed form


def test_a_sensor_that_sees_all_unstable_modes_at_once_closes_the_gap() -> None:
    edge = critical_loss(TWO[0], [[1.0, 1.0], [0.0, 1.0]])
    assert edge.exact and edge.lost == pytest.approx(LOST)
    assert np.isfinite(mare(TWO[0], np.array([[1.0, 1.0], [0.0, 1.0]]), TWO[2], np.eye(2), LOST - 1e-3)).all()


@pytest.mark.slow
def test_two_sensors_for_three_unstable_modes_lie_between() -> None:
    A = np.array([[1.3, 0.2, 0.0], [0.0, 1.2, 0.1], [0.0, 0.0, 1.15]])
    C = np.array([[1.0, 0.4, -0.3], [0.2, -1.0, 0.5]])
    edge = critical_loss(A, C)
    assert 1 / (1.3 * 1.2 * 1.15) ** 2 < edge.safe < edge.lost == pytest.approx(1 / 1.69)
    model = (A, C, np.eye(3), np.eye(2))
    assert np.isfinite(mare(*model, edge.safe - 2e-3)).all()
    with pytest.raises(RiccatiError):
        mare(*model, edge.safe + 2e-3)


def test_stable_modes_do_not_count_and_hidden_unstable_ones_are_refused() -> None:
    assert critical_loss(np.diag([0.9, -0.5]), [[1.0, 0.0]]).safe == 1.0
    assert critical_loss(np.diag([1.2, 0.99, 0.3]), [[1.0, 2.0, 3.0]]) == critical_loss([[1.2]], [[1.0]])
    with pytest.raises(EngineError, match="hidden"):
        critical_loss(np.diag([1.2, 0.5]), [[0.0, 1.0]])


@pytest.mark.parametrize("A, C, known", [
    (np.diag([1.25, 1.1]), [[1.0, 1.0]], True),  # two moduli
    (np.diag([1.25, -1.25]), [[1.0, 1.0]], False),  # one modulus, one sensor: every other reading alone tells them apart
    (np.diag([1.25, -1.25]), [[1.0, 1.0], [0.0, 1.0]], True),
    (np.array([[1.2, 1.0], [0.0, 1.2]]), [[1.0, 0.0]], False),  # too few eigenvectors
    (1.1 * np.array([[0.0, -1.0], [1.0, 0.0]]), [[1.0, 0.0]], False),  # a quarter turn a sample
    (np.array([[1.3, 0.2, 0.0], [0.0, 1.2, 0.1], [0.0, 0.0, 1.15]]), [[1.0, 0.4, -0.3], [0.2, -1.0, 0.5]], True),
])
def test_the_critical_loss_is_known_where_modes_of_one_modulus_are_seen_apart(A: object, C: object, known: bool) -> None:
    edge = critical_loss(A, C)
    assert edge.critical == (edge.lost if known else None)
    between = (edge.safe + edge.lost) / 2
    assert edge.bounded(edge.safe - 1e-3) is True and edge.bounded(edge.lost + 1e-3) is False
    if not edge.exact:
        assert edge.bounded(between) is (True if known else None)


def test_a_loss_is_a_probability() -> None:
    for loss in (-0.1, 1.1, np.nan):
        with pytest.raises(EngineError, match=r"loss|probability"):
            mean_bounds(*TWO, np.eye(2), loss, 3)


def test_perfect_sensors_have_a_solution_and_a_singular_innovation_is_named() -> None:
    """R = 0 ended in the library's error or in NaN, because the recursion began at P = 0."""
    A, Q = np.array([[1.2]]), np.eye(1)
    assert mare(A, np.eye(1), Q, 0.0, 0.1) == pytest.approx(1 / (1 - 0.1 * 1.44))  # P = loss a² P + q
    two = mare(TWO[0], np.eye(2), np.eye(2), 0.0, 0.1)
    assert two == pytest.approx(0.1 * TWO[0] @ two @ TWO[0].T + np.eye(2))
    for C in (np.eye(1), np.ones((2, 1))):
        with pytest.raises(EngineError, match="innovation is singular"):
            intermittent_covariances(A, C, Q, 0.0, 0.0, [True, True])


def test_a_blind_sensor_leaves_the_growth_of_the_plant() -> None:
    assert lossy_growth(np.diag([1.2, 1.1]), np.zeros((2, 2)), 0.3) == pytest.approx(1.44)


def test_a_record_of_packets_is_zeros_and_ones() -> None:
    for heard in ([0.0, np.nan], [2.0], 1.0):
        with pytest.raises(EngineError, match=r"record of packets|heard"):
            intermittent_covariances(*TWO, np.eye(2), heard)
